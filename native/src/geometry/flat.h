/* Straight rays. */
#ifndef BENT_GEOMETRY_FLAT_H
#define BENT_GEOMETRY_FLAT_H
#include "geometry/geometry.h"

/* The nearest hit of a straight ray, or its escape. */
void flat_intersect(const geometry *g, const bent_ray *ray, bent_hit *hit);

/* The nearest hit of the straight line from `origin` at a length between `near` and `far`. Returns its length and fills
 * instance, triangle, barycentric and position; INFINITY if there is none. With `source` nonzero the line starts on the
 * ray's source triangle, if it has one. */
double flat_segment(const geometry *g, const bent_ray *ray, vec3 origin, vec3 direction, double near, double far,
                    int source, bent_hit *hit);
#endif
