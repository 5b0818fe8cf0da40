/* Distances of triangles from a sphere: first boxes in the space of each mesh, where vertices are read as they are, then
 * what is left in the world, exactly. */
#include "geometry/clear.h"

#include <stdlib.h>

#include "geometry/query.h"

/* A box in mesh space. */
typedef struct box {
  float lower[3], upper[3];
} box;

/* The box of the ellipsoid that a world sphere is in mesh space, rounded outward. */
static box box_of_sphere(const instance *i, vec3 center, double radius)
{
  box b;
  double at[3];
  v3_to(at, mat4_point(&i->mesh_from_world, center));
  for (int k = 0; k < 3; k++) {
    const double *row = i->mesh_from_world.m[k];
    const double half = radius * v3_length(v3(row[0], row[1], row[2]));
    const double terms = fabs(row[0] * center.x) + fabs(row[1] * center.y) + fabs(row[2] * center.z) + fabs(row[3]);
    const double rounding = 0x1p-48 * (terms + half);
    b.lower[k] = nextafterf((float)(at[k] - half - rounding), -INFINITY);
    b.upper[k] = nextafterf((float)(at[k] + half + rounding), INFINITY);
  }
  return b;
}

static int is_apart(const box *b, const float lower[3], const float upper[3])
{
  int apart = 0;
  for (int k = 0; k < 3; k++) apart |= (upper[k] < b->lower[k]) | (lower[k] > b->upper[k]);
  return apart;
}

/* For every vertex the sides of the box beyond which it lies, a bit each; NULL without memory. A triangle all of whose
 * vertices share a bit is apart from the box: read so, a million take a few milliseconds. */
static uint8_t *sides_of_vertices(const mesh *m, const box *b)
{
  uint8_t *sides = malloc(m->vertex_count);
  for (size_t i = 0; sides && i < m->vertex_count; i++) {
    const float *v = m->vertices[i];
    unsigned bits = 0;
    for (int k = 0; k < 3; k++) bits |= (unsigned)(v[k] < b->lower[k]) << k | (unsigned)(v[k] > b->upper[k]) << (3 + k);
    sides[i] = (uint8_t)bits;
  }
  return sides;
}

/* Squared distance of the point `off`, taken from one end of an edge, from it. */
static double distance2_from_edge(vec3 off, vec3 edge)
{
  const double length2 = v3_dot(edge, edge);
  const vec3 to = v3_mad(edge, length2 > 0 ? -saturate(v3_dot(off, edge) / length2) : 0, off);
  return v3_dot(to, to);
}

/* Squared distance of a point from a triangle, degenerate ones included: from its edges, and from its plane above it. Where
 * rounding mistakes a point above a sliver for one beside it, its edges are as near. */
static double distance2_from_triangle(const triangle *t, vec3 point)
{
  const vec3 off0 = v3_sub(point, t->v0), off1 = v3_sub(off0, t->edge1), edge12 = v3_sub(t->edge2, t->edge1);
  const double nearest = min2(min2(distance2_from_edge(off0, t->edge1), distance2_from_edge(off0, t->edge2)),
                              distance2_from_edge(off1, edge12));
  const int above = v3_dot(v3_cross(t->edge1, off0), t->normal) >= 0 &&
                    v3_dot(v3_cross(off0, t->edge2), t->normal) >= 0 && v3_dot(v3_cross(edge12, off1), t->normal) >= 0;
  const double area2 = v3_dot(t->normal, t->normal), height = v3_dot(t->normal, off0);
  return above && area2 > 0 ? min2(nearest, height * height / area2) : nearest;
}

static int is_clear_of(const geometry *g, int index, vec3 center, double radius)
{
  const instance *i = &g->instances[index];
  const mesh *m = &g->meshes[i->mesh];
  const vec3 seen = v3_sub(center, g->origin);
  const double coordinate = fmax(fabs(seen.x), fmax(fabs(seen.y), fabs(seen.z))) + radius;
  const double reach = radius + i->float_error_offset + i->float_error_scale * coordinate;
  const box sphere = box_of_sphere(i, center, reach);
  embree_bounds bounds;
  embree()->get_scene_bounds(m->scene, &bounds);
  if (is_apart(&sphere, bounds.lower, bounds.upper)) return 1;
  uint8_t *sides = sides_of_vertices(m, &sphere);
  int clear = sides != NULL; /* without memory rays are marched */
  for (size_t k = 0; clear && k < m->triangle_count; k++) {
    const uint32_t *corner = m->triangles[k];
    if (sides[corner[0]] & sides[corner[1]] & sides[corner[2]]) continue;
    const triangle t = triangle_of(g, index, (int)k);
    clear = distance2_from_triangle(&t, center) > reach * reach; /* false for NaN */
  }
  free(sides);
  return clear;
}

int is_clear(const geometry *g, const lens *l)
{
  for (size_t i = 0; i < g->instance_count; i++)
    if (is_seen(g, &g->instances[i]) && !is_clear_of(g, (int)i, l->center, l->radius)) return 0;
  return 1;
}
