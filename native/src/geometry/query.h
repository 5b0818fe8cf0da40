/* One Embree query along a straight piece of a ray, with care for rays that leave a surface. Scalar code. */
#ifndef BENT_GEOMETRY_QUERY_H
#define BENT_GEOMETRY_QUERY_H
#include "geometry/geometry.h"

/* A triangle in world space: normal = cross(edge1, edge2), not normalized. */
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

/* How far the weights lie outside the triangle: 0 or negative inside, NaN for NaN. */
static inline double barycentric_outside(const double b[2]) { return fmax(fmax(-b[0], -b[1]), b[0] + b[1] - 1); }

/* Weights made nonnegative and of sum 1: a point of the triangle near the given one. */
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

/* The straight piece start + s span, near <= s <= far. A query that begins where the ray leaves its source triangle names
 * the ray in `leaving`, and in `departure` the unit direction in which the true, curved ray is drawn there. */
typedef struct query {
  vec3 start, span;
  double near, far; /* near may be a little negative */
  uint32_t visibility;
  const bent_ray *leaving; /* NULL: it does not begin on a surface */
  vec3 departure;
} query;

typedef struct found {
  int instance, triangle;
  double at;   /* s of the hit, as Embree sees it */
  double b[2]; /* barycentric weights, as Embree sees them */
} found;

/* The nearest hit of the piece; 0 if there is none. The triangle's data are on their way into the cache when this returns:
 * they are as likely as not in main memory, which takes as long as a short query. So ask for several rays first, then
 * fetch for all, then use them. */
int geometry_query(const geometry *g, const query *q, found *out);

/* The second half of the way: the triangle's vertices, which its indices lead to. */
static inline void found_fetch(const geometry *g, const found *f)
{
  const mesh *m = &g->meshes[g->instances[f->instance].mesh];
  for (int corner = 0; corner < 3; corner++) __builtin_prefetch(m->vertices[m->triangles[f->triangle][corner]]);
}
#endif
