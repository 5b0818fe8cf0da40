/* Straight rays. */
#ifndef BENT_GEOMETRY_FLAT_H
#define BENT_GEOMETRY_FLAT_H
#include "geometry/query.h"

/* Asks for the nearest hit of the straight line from `origin` in the unit `direction` at a length between `near` and `far`;
 * 0 if there is none. With `leaving` nonzero the line starts on the ray's source triangle. */
int flat_ask(const geometry *g, const bent_ray *ray, vec3 origin, vec3 direction, double near, double far, int leaving,
             found *out);
/* Puts what was found into instance, triangle, barycentric and position of `hit`, and returns its length. */
double flat_land(const geometry *g, const found *f, vec3 origin, vec3 direction, bent_hit *hit);
#endif
