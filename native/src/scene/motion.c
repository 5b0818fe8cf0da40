/* See motion.h. */
#include "scene/motion.h"

#include <stdlib.h>
#include <string.h>

#include "geometry/geometry.h"
#include "render/camera.h"
#include "scene/scene.h"

/* The place of a triangle's point in world coordinates. */
static vec3 place_of(const mat4 *world_from_mesh, const float (*vertices)[3], const uint32_t corner[3],
                     const double barycentric[2])
{
  const double w[3] = {1 - barycentric[0] - barycentric[1], barycentric[0], barycentric[1]};
  vec3 sum = v3(0, 0, 0);
  for (int k = 0; k < 3; k++) {
    const float *v = vertices[corner[k]];
    sum = v3_mad(v3(v[0], v[1], v[2]), w[k], sum);
  }
  return mat4_point(world_from_mesh, sum);
}

vec3 moment_place(const moment *moment, const bent_scene *scene, int instance, int triangle, const double barycentric[2],
                  vec3 position)
{
  const struct instance *now = &scene->geometry->instances[instance];
  const mesh *m = &scene->geometry->meshes[now->mesh];
  const int is_known = (size_t)instance < moment->instance_count;
  const mat4 *matrix = is_known ? &moment->world_from_mesh[instance] : &now->world_from_mesh;
  const float(*moved)[3] = (size_t)now->mesh < moment->mesh_count ? (const float(*)[3])moment->vertices[now->mesh] : NULL;
  const float(*vertices)[3] = (const float(*)[3])m->vertices;
  const uint32_t *corner = m->triangles[triangle];
  /* The way from there to here, so that rounding of the hit does not count as motion. */
  const vec3 there = place_of(matrix, moved ? moved : vertices, corner, barycentric);
  return v3_add(position, v3_sub(there, place_of(&now->world_from_mesh, vertices, corner, barycentric)));
}

static int is_same_lens(const lens *a, const lens *b)
{
  const bent_spacetime *s = &a->spacetime, *r = &b->spacetime;
  return s->kind == r->kind && s->chart == r->chart && s->mass == r->mass && s->spin == r->spin &&
         s->throat_radius == r->throat_radius && a->radius == b->radius && a->flat == b->flat && a->exit == b->exit &&
         !memcmp(&a->world_from_spacetime, &b->world_from_spacetime, sizeof a->world_from_spacetime);
}

int moment_view_stands(const moment *moment, const bent_scene *scene)
{
  const geometry *a = moment->view->geometry, *b = scene->geometry;
  if (memcmp(&moment->view->camera->settings, &scene->camera->settings, sizeof scene->camera->settings) ||
      a->lens_count != b->lens_count)
    return 0;
  for (size_t i = 0; i < a->lens_count; i++)
    if (!is_same_lens(&a->lenses[i], &b->lenses[i])) return 0;
  return 1;
}

static void moment_clear(moment *m)
{
  for (size_t i = 0; m->vertices && i < m->mesh_count; i++) free(m->vertices[i]);
  free(m->vertices);
  free(m->world_from_mesh);
}

void motion_free(motion *motion)
{
  if (!motion) return;
  for (int k = 0; k < MOMENTS; k++) moment_clear(&motion->moments[k]);
  free(motion);
}

/* Copies one moment; returns 0 if there is no memory. Instances and meshes that the scene does not have are left out. */
static int moment_copy(const bent_scene *scene, const bent_moment *given, moment *out)
{
  const geometry *g = scene->geometry;
  out->view = given->view;
  out->instance_count = given->instance_count < g->instance_count ? given->instance_count : g->instance_count;
  const size_t meshes = given->mesh_count < g->mesh_count ? given->mesh_count : g->mesh_count;
  out->world_from_mesh = malloc((out->instance_count + 1) * sizeof *out->world_from_mesh);
  out->vertices = calloc(meshes + 1, sizeof *out->vertices);
  if (!out->world_from_mesh || !out->vertices) return 0;
  out->mesh_count = meshes;
  for (size_t i = 0; i < out->instance_count; i++)
    memcpy(&out->world_from_mesh[i], given->world_from_mesh[i], sizeof out->world_from_mesh[i]);
  for (size_t i = 0; i < meshes; i++) {
    const size_t size = g->meshes[i].vertex_count * sizeof *out->vertices[i];
    if (!given->vertices[i]) continue;
    if (!(out->vertices[i] = malloc(size + 1))) return 0;
    memcpy(out->vertices[i], given->vertices[i], size);
  }
  return 1;
}

bent_status bent_scene_set_motion(bent_scene *scene, const bent_moment moments[2], bent_error *error)
{
  motion *made = NULL;
  for (int k = 0; moments && k < MOMENTS; k++)
    if (!moments[k].view || !moments[k].view->committed || !moments[k].view->camera)
      return bent_fail(error, BENT_ERROR_STATE, "motion: the view of moment %d must have a camera and be committed", k);
  if (moments && !(made = calloc(1, sizeof *made))) return bent_fail(error, BENT_ERROR_MEMORY, "motion: out of memory");
  for (int k = 0; made && k < MOMENTS; k++)
    if (!moment_copy(scene, &moments[k], &made->moments[k])) {
      motion_free(made);
      return bent_fail(error, BENT_ERROR_MEMORY, "motion: out of memory");
    }
  motion_free(scene->motion);
  scene->motion = made;
  return BENT_OK;
}
