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

/* Makes the weights those of the triangle's nearest point. */
static inline void triangle_clamp(const triangle *t, double b[2])
{
  const double corners[4][2] = {{0, 0}, {1, 0}, {0, 1}, {0, 0}};
  double nearest = INFINITY, best[2] = {b[0], b[1]};
  if (barycentric_outside(b) <= 0) return;
  for (int i = 0; i < 3; i++) {
    const double *a = corners[i], edge[2] = {corners[i + 1][0] - a[0], corners[i + 1][1] - a[1]};
    const vec3 along = v3_mad(t->edge1, edge[0], v3_scale(t->edge2, edge[1]));
    const vec3 to = v3_mad(t->edge1, b[0] - a[0], v3_scale(t->edge2, b[1] - a[1]));
    const double part = fmin(fmax(v3_dot(to, along) / v3_dot(along, along), 0), 1);
    const vec3 off = v3_mad(along, -part, to);
    if (!(v3_dot(off, off) < nearest)) continue;
    nearest = v3_dot(off, off);
    best[0] = a[0] + part * edge[0], best[1] = a[1] + part * edge[1];
  }
  b[0] = best[0], b[1] = best[1];
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
  const instance *inside; /* whose surface alone is met; NULL: that of all */
} query;

typedef struct found {
  int instance, triangle;
  double at;   /* s of the hit, as Embree sees it */
  double b[2]; /* barycentric weights, as Embree sees them */
} found;

/* The nearest hit of the piece; 0 if there is none. */
int geometry_query(const geometry *g, const query *q, found *out);

/* A triangle is as likely as not in main memory, from where it takes as long as a short query to come. So ask for several
 * rays first, then fetch all the triangles' indices, then the vertices that these lead to, and use them after that. */
static inline void found_fetch_indices(const geometry *g, const found *f)
{
  __builtin_prefetch(g->meshes[g->instances[f->instance].mesh].triangles[f->triangle]);
}

static inline void found_fetch_vertices(const geometry *g, const found *f)
{
  const mesh *m = &g->meshes[g->instances[f->instance].mesh];
  for (int corner = 0; corner < 3; corner++) __builtin_prefetch(m->vertices[m->triangles[f->triangle][corner]]);
}
#endif
