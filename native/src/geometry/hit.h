/* One Embree query and what double precision makes of its answer. Everything here is scalar code. */
#ifndef BENT_GEOMETRY_HIT_H
#define BENT_GEOMETRY_HIT_H
#include "geometry/geometry.h"

/* The plane of a triangle in world space: normal = cross(edge1, edge2), not normalized. */
typedef struct triangle {
  vec3 v0, edge1, edge2, normal;
} triangle;

static inline triangle triangle_of(const geometry *g, int instance_index, int index)
{
  const vec3 v0 = geometry_vertex(g, instance_index, index, 0);
  const vec3 e1 = v3_sub(geometry_vertex(g, instance_index, index, 1), v0);
  const vec3 e2 = v3_sub(geometry_vertex(g, instance_index, index, 2), v0);
  return (triangle){v0, e1, e2, v3_cross(e1, e2)};
}

/* Barycentric weights of vertices 1 and 2 of a point in the triangle's plane. */
static inline void triangle_barycentric(const triangle *t, vec3 point, double out[2])
{
  const vec3 d = v3_sub(point, t->v0);
  const double scale = 1 / v3_dot(t->normal, t->normal);
  out[0] = v3_dot(v3_cross(d, t->edge2), t->normal) * scale;
  out[1] = v3_dot(v3_cross(t->edge1, d), t->normal) * scale;
}

/* The nearest point of the triangle in barycentric terms: weights made nonnegative and of sum 1. */
static inline void barycentric_clamp(double b[2])
{
  double w0 = 1 - b[0] - b[1], w1 = b[0], w2 = b[1];
  w0 = w0 > 0 ? w0 : 0, w1 = w1 > 0 ? w1 : 0, w2 = w2 > 0 ? w2 : 0;
  const double sum = w0 + w1 + w2;
  b[0] = w1 / sum, b[1] = w2 / sum;
}

static inline vec3 triangle_point(const triangle *t, const double b[2])
{
  return v3_mad(t->edge1, b[0], v3_mad(t->edge2, b[1], t->v0));
}

/* How far off, in world units, float32 arithmetic may see a point at `position` of an instance. */
static inline double float_error(const instance *i, vec3 position)
{
  const double coordinate = fmax(fabs(position.x), fmax(fabs(position.y), fabs(position.z)));
  return i->float_error_offset + i->float_error_scale * coordinate;
}
#endif
