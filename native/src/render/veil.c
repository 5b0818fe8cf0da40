/* Rays of the camera through veils: each round evaluates the material where rays have met one, and intersects what is left
 * of those rays behind it. */
#include "bentlight/veil.h"

#include <stdlib.h>

#include "geometry/geometry.h"
#include "light/frequency.h"
#include "light/surface.h"
#include "render/bsdf.h"
#include "scene/scene.h"

enum { SURFACES_MAX = 64 };

/* Rays that go on. */
typedef struct unfinished {
  bent_ray *rays;
  bent_hit *hits;
  size_t *of; /* the whole ray that each belongs to */
  closure *closures;
} unfinished;

static bent_status unfinished_new(unfinished *out, const bent_scene *scene, size_t n, bent_error *error)
{
  *out = (unfinished){malloc((n + 1) * sizeof *out->rays), malloc((n + 1) * sizeof *out->hits),
                     malloc((n + 1) * sizeof *out->of),
                     malloc((size_t)shading_lobe_max(scene->shading) * sizeof *out->closures)};
  return out->rays && out->hits && out->of && out->closures ? BENT_OK
                                                            : bent_fail(error, BENT_ERROR_MEMORY, "intersect: out of memory");
}

static void unfinished_free(unfinished *r)
{
  free(r->rays);
  free(r->hits);
  free(r->of);
  free(r->closures);
}

/* Adds a surface that a ray has met to what veils do to it. whole: of the way from where the ray starts. */
static void add_layer(const bent_scene *scene, const bent_ray *ray, const bent_hit *whole, closure *room, bent_veil *veil)
{
  surface surface;
  surface_at(scene, whole, whole->length, &surface);
  if (surface.see_through) return;
  const frequency_leg leg = {v3_from(ray->origin), v3_from(ray->direction), v3_from(whole->position),
                             v3_from(whole->direction), whole->swept};
  surface.point.ray = (ray_history){.kinds = RAY_CAMERA, .transparent = veil->layers};
  frequency_follow(scene->geometry, &leg, &surface.point.ray);
  closure_set set = {.closures = room};
  shading_evaluate(scene->shading, surface.material, &surface.point, &set);
  double chance;
  vec3 shines = set.emission, passes = bsdf_transparency(&set, &chance);
  if (scene->geometry->instances[whole->instance].visibility & BENT_HOLDOUT) shines = passes = v3(0, 0, 0);
  if (!v3_is_finite(shines)) shines = v3(0, 0, 0); /* broken input is black, as in a render */
  if (!v3_is_finite(passes)) passes = v3(0, 0, 0);
  const vec3 before = v3_from(veil->transmission);
  v3_to(veil->glow, v3_add(v3_from(veil->glow), v3_mul(before, shines)));
  v3_to(veil->transmission, v3_mul(before, passes));
  veil->layers += v3_max(shines) > 0 || passes.x != 1 || passes.y != 1 || passes.z != 1;
}

/* What is left of a ray behind a hit. */
static bent_ray behind(const bent_ray *ray, const bent_hit *whole)
{
  bent_ray rest = *ray;
  v3_to(rest.origin, v3_from(whole->position));
  v3_to(rest.direction, v3_from(whole->direction));
  rest.length_min = max2(ray->length_min - whole->length, 0), rest.length_max = max2(ray->length_max - whole->length, 0);
  rest.source_instance = whole->instance, rest.source_triangle = whole->triangle;
  return rest;
}

/* The hit of what is left of a ray as one of the whole ray. */
static bent_hit joined(const bent_hit *first, const bent_hit *then)
{
  bent_hit whole = *then;
  whole.length += first->length, whole.swept += first->swept;
  whole.error += first->error, whole.borders += first->borders;
  if (first->first_lens >= 0) whole.first_lens = first->first_lens;
  return whole;
}

/* A ray that has passed too many surfaces. */
static void give_up(bent_hit *hit)
{
  hit->fate = BENT_UNRESOLVED;
  hit->instance = hit->triangle = -1;
}

bent_status bent_scene_intersect_veiled(const bent_scene *scene, size_t n, const bent_ray *rays, const uint8_t *is_veil,
                                        bent_hit *hits, bent_veil *veils, bent_progress *progress, bent_error *error)
{
  bent_status status = bent_scene_intersect(scene, n, rays, hits, progress, error);
  if (status) return status;
  unfinished rest;
  status = unfinished_new(&rest, scene, n, error);
  size_t count = n;
  for (size_t i = 0; i < n && !status; i++) veils[i] = (bent_veil){.transmission = {1, 1, 1}}, rest.of[i] = i;
  for (int round = 0; count > 0 && !status; round++) {
    size_t left = 0;
    for (size_t k = 0; k < count; k++) {
      const size_t i = rest.of[k];
      if (hits[i].fate != BENT_HIT || !is_veil[hits[i].instance]) continue;
      add_layer(scene, &rays[i], &hits[i], rest.closures, &veils[i]);
      if (!(v3_max(v3_from(veils[i].transmission)) > 0)) continue;
      rest.rays[left] = behind(&rays[i], &hits[i]), rest.of[left++] = i;
    }
    count = left;
    if (round == SURFACES_MAX) {
      for (size_t k = 0; k < count; k++) give_up(&hits[rest.of[k]]);
      break;
    }
    status = bent_scene_intersect(scene, count, rest.rays, rest.hits, progress, error);
    for (size_t k = 0; k < count && !status; k++) hits[rest.of[k]] = joined(&hits[rest.of[k]], &rest.hits[k]);
  }
  unfinished_free(&rest);
  return status;
}
