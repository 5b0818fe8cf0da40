/* Straight rays. */
#ifndef BENT_GEOMETRY_FLAT_H
#define BENT_GEOMETRY_FLAT_H
#include "geometry/geometry.h"

/* The nearest hit of the straight line from `origin` in the unit `direction` at a length between `near` and `far`. Returns
 * its length and fills instance, triangle, barycentric and position of `hit`; INFINITY if there is none. With `leaving`
 * nonzero the line starts on the ray's source triangle, if it has one. */
double flat_nearest(const geometry *g, const bent_ray *ray, vec3 origin, vec3 direction, double near, double far,
                    int leaving, bent_hit *hit);
#endif
