/* Builds the Embree scenes: one per mesh, refitted when its vertices move a little, and one of instances on top. */
#include <stdlib.h>
#include <string.h>

#include "geometry/cross.h"
#include "geometry/geometry.h"
#include "geometry/jump.h"
#include "geometry/mesh.h"

bent_status geometry_new(geometry **out, bent_error *error)
{
  *out = calloc(1, sizeof **out);
  if (!*out) return bent_fail(error, BENT_ERROR_MEMORY, "scene: out of memory");
  (*out)->radius = -1;
  return BENT_OK;
}

void geometry_free(geometry *g)
{
  if (!g) return;
  if (g->top) embree()->release_scene(g->top);
  for (size_t i = 0; i < g->mesh_count; i++) mesh_clear(&g->meshes[i]);
  for (size_t i = 0; i < g->instance_count; i++) instance_clear(&g->instances[i]);
  free(g->meshes);
  free(g->instances);
  lenses_free(g->lenses, g->lens_count);
  free(g);
}

static bool keep_going(void *user, double done)
{
  (void)done;
  return !atomic_load(&((bent_progress *)user)->cancel);
}

static void commit_scene(embree_scene scene, bent_progress *progress)
{
  const embree_table *e = embree();
  if (progress) e->set_scene_progress(scene, keep_going, progress);
  e->commit_scene(scene);
  if (progress) e->set_scene_progress(scene, NULL, NULL); /* the cell belongs to this call only */
}

static void mesh_release(mesh *m)
{
  const embree_table *e = embree();
  if (m->triangle) e->release_geometry(m->triangle);
  if (m->scene) e->release_scene(m->scene);
  m->triangle = NULL, m->scene = NULL;
}

/* A refitted tree keeps its topology, so it is as good as new only while neighbors stay neighbors. A quarter of the
 * bounding box is where a rebuild (about ten times a refit) begins to pay for itself in slower rays. */
static int has_moved_far(const mesh *m)
{
  float lower[3] = {INFINITY, INFINITY, INFINITY}, upper[3] = {-INFINITY, -INFINITY, -INFINITY};
  double largest = 0, diagonal = 0;
  for (size_t i = 0; i < m->vertex_count; i++) {
    double moved = 0;
    for (int k = 0; k < 3; k++) {
      const float v = m->built[i][k], d = m->vertices[i][k] - v;
      lower[k] = v < lower[k] ? v : lower[k], upper[k] = v > upper[k] ? v : upper[k];
      moved += (double)d * d;
    }
    largest = fmax(largest, moved);
  }
  for (int k = 0; k < 3; k++) diagonal += ((double)upper[k] - lower[k]) * ((double)upper[k] - lower[k]);
  return !(16 * largest <= diagonal);
}

static void mesh_build(mesh *m, int flags, bent_progress *progress)
{
  const embree_table *e = embree();
  mesh_release(m);
  m->scene = e->new_scene(e->device);
  e->set_scene_flags(m->scene, flags | EMBREE_SCENE_ROBUST);
  m->triangle = e->new_geometry(e->device, EMBREE_TRIANGLE);
  e->set_shared_geometry_buffer(m->triangle, EMBREE_BUFFER_INDEX, 0, EMBREE_UINT3, m->triangles, 0,
                                sizeof *m->triangles, m->triangle_count);
  e->set_shared_geometry_buffer(m->triangle, EMBREE_BUFFER_VERTEX, 0, EMBREE_FLOAT3, m->vertices, 0,
                                sizeof *m->vertices, m->vertex_count);
  e->set_geometry_mask(m->triangle, UINT32_MAX); /* visibility is the instance's */
  e->set_geometry_build_quality(m->triangle, EMBREE_QUALITY_MEDIUM);
  e->commit_geometry(m->triangle);
  e->attach_geometry_by_id(m->scene, m->triangle, 0);
  commit_scene(m->scene, progress);
}

/* A still mesh gets Embree's static tree. One that is seen to move gets a dynamic tree once, refitted from then on. */
static bent_status mesh_commit(mesh *m, bent_progress *progress, bent_error *error)
{
  const embree_table *e = embree();
  if (!m->scene) {
    mesh_build(m, 0, progress);
  } else if (m->moved) {
    if (m->refittable && !has_moved_far(m)) {
      e->set_geometry_build_quality(m->triangle, EMBREE_QUALITY_REFIT);
      e->update_geometry_buffer(m->triangle, EMBREE_BUFFER_VERTEX, 0);
      e->commit_geometry(m->triangle);
      commit_scene(m->scene, progress);
    } else {
      mesh_build(m, EMBREE_SCENE_DYNAMIC, progress);
      m->refittable = 1;
      if (m->built) memcpy(m->built, m->vertices, m->vertex_count * sizeof *m->vertices);
    }
  }
  const bent_status status = embree_check("building a mesh", error);
  if (status) mesh_release(m); /* a half-built tree must not be traced; the next commit starts anew */
  else m->moved = 0;
  return status;
}

/* Embree takes world points x, less the origin, into mesh space as A x + b and intersects there, all in float32 (A =
 * mesh_from_world). An error e there is |A^-1| e here. Each of the few roundings is at most 2^-24 of the largest term; 8
 * of them bound it. */
static void bound_float_error(instance *i, vec3 origin)
{
  const double unit = 8 * 0x1p-24;
  double forward = 0, backward = 0; /* max-norms of A and of A^-1 */
  for (int r = 0; r < 3; r++) {
    double a = 0, w = 0;
    for (int c = 0; c < 3; c++) {
      a += fabs(i->mesh_from_world.m[r][c]);
      w += fabs(i->world_from_mesh.m[r][c]);
    }
    forward = fmax(forward, a), backward = fmax(backward, w);
  }
  const vec3 b = mat4_point(&i->mesh_from_world, origin);
  i->float_error_scale = unit * fmax(1, forward * backward);
  i->float_error_offset = unit * backward * fmax(fabs(b.x), fmax(fabs(b.y), fabs(b.z)));
}

static void instance_attach(geometry *g, size_t index)
{
  const embree_table *e = embree();
  instance *i = &g->instances[index];
  const double origin[3] = {g->origin.x, g->origin.y, g->origin.z};
  embree_geometry geometry = e->new_geometry(e->device, EMBREE_INSTANCE);
  float matrix[3][4];
  for (int r = 0; r < 3; r++)
    for (int c = 0; c < 4; c++) matrix[r][c] = (float)(i->world_from_mesh.m[r][c] - (c == 3 ? origin[r] : 0));
  bound_float_error(i, g->origin);
  e->set_geometry_instanced_scene(geometry, g->meshes[i->mesh].scene);
  e->set_geometry_transform(geometry, 0, EMBREE_FLOAT3X4_ROW_MAJOR, matrix);
  e->set_geometry_mask(geometry, instance_mask(i));
  e->commit_geometry(geometry);
  e->attach_geometry_by_id(g->top, geometry, (unsigned)index);
  e->release_geometry(geometry);
}

/* The sphere around the box of all that can be met, a little larger than float32 rounding; and Embree's origin: its
 * center where the world's own is outside of it. */
static void bound(geometry *g)
{
  double lower[3] = {INFINITY, INFINITY, INFINITY}, upper[3] = {-INFINITY, -INFINITY, -INFINITY};
  for (size_t index = 0; index < g->instance_count; index++) {
    const instance *i = &g->instances[index];
    embree_bounds box;
    if (!is_seen(g, i)) continue;
    embree()->get_scene_bounds(g->meshes[i->mesh].scene, &box);
    if (!(box.lower[0] <= box.upper[0])) continue; /* no triangle in it is sound */
    for (int r = 0; r < 3; r++) {
      const double *row = i->world_from_mesh.m[r];
      double center = row[3], half = 0;
      for (int c = 0; c < 3; c++) {
        center += row[c] * 0.5 * ((double)box.lower[c] + box.upper[c]);
        half += fabs(row[c]) * 0.5 * ((double)box.upper[c] - box.lower[c]);
      }
      lower[r] = fmin(lower[r], center - half), upper[r] = fmax(upper[r], center + half);
    }
  }
  g->radius = -1;
  g->center = g->origin = v3(0, 0, 0);
  if (!(lower[0] <= upper[0])) return;
  const vec3 low = v3_from(lower), high = v3_from(upper);
  g->center = v3_scale(v3_add(low, high), 0.5);
  g->radius = 0.5 * v3_length(v3_sub(high, low)) + 0x1p-20 * fmax(v3_length(low), v3_length(high));
  if (v3_length(g->center) > g->radius) g->origin = g->center;
}

static bent_status rebuild(geometry *g, bent_progress *progress, bent_error *error)
{
  bent_status status = BENT_OK;
  if (!embree() && (status = bent_embree_load(0, NULL, error))) return status;
  for (size_t i = 0; i < g->instance_count; i++) {
    mesh *m = &g->meshes[g->instances[i].mesh];
    if (m->triangle_count && (status = mesh_commit(m, progress, error))) return status;
  }
  const embree_table *e = embree();
  if (g->top) e->release_scene(g->top);
  g->top = e->new_scene(e->device);
  e->set_scene_flags(g->top, EMBREE_SCENE_ROBUST);
  bound(g);
  for (size_t i = 0; i < g->instance_count; i++)
    if (is_seen(g, &g->instances[i])) instance_attach(g, i);
  commit_scene(g->top, progress);
  if ((status = embree_check("building the scene", error))) return status;
  for (size_t i = 0; i < g->lens_count; i++) g->lenses[i].clearness = CLEARNESS_UNKNOWN;
  g->changed = 0;
  return BENT_OK;
}

bent_status geometry_commit(geometry *g, bent_progress *progress, bent_error *error)
{
  bent_status status = BENT_OK;
  for (size_t i = 0; i < g->lens_count; i++)
    if ((status = jump_commit(&g->lenses[i], error))) return status;
  if ((!g->top || g->changed) && (status = rebuild(g, progress, error))) return status;
  return cross_commit(g, error);
}
