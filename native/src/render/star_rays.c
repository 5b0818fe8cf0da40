/* See star_rays.h. */
#include "render/star_rays.h"

#include <stdlib.h>

#include "geometry/geometry.h"
#include "render/direct.h"
#include "scene/scene.h"

bent_status star_view_check(const bent_scene *scene, const bent_star_view *v, bent_error *error)
{
  if (!scene->camera) return bent_fail(error, BENT_ERROR_STATE, "stars: the scene has no camera");
  if (!scene->committed) return bent_fail(error, BENT_ERROR_STATE, "stars: the scene has edits without a commit");
  if (!bent_scene_shows_stars(scene))
    return bent_fail(error, BENT_ERROR_ARGUMENT, "stars: an orthographic camera sees no single directions");
  if (v->width < 1 || v->height < 1 || v->width > 1u << 16 || v->height > 1u << 16)
    return bent_fail(error, BENT_ERROR_ARGUMENT, "stars: the picture must be 1 to 65536 pixels wide and high, got %u x %u",
                     v->width, v->height);
  if (!(v->margin >= 0 && v->margin <= 1000))
    return bent_fail(error, BENT_ERROR_ARGUMENT, "stars: margin must lie in [0, 1000] pixels, got %g", v->margin);
  if (!(v->tolerance > 0 && v->tolerance <= 0.1))
    return bent_fail(error, BENT_ERROR_ARGUMENT, "stars: tolerance must lie in (0, 0.1] radians, got %g", v->tolerance);
  return BENT_OK;
}

star_tracer *star_tracer_new(const bent_scene *scene, const bent_star_view *view, bent_error *error)
{
  star_tracer *t = malloc(sizeof *t);
  closure *closures = malloc(((size_t)shading_lobe_max(scene->shading) + 1) * sizeof *closures);
  if (!t || !closures) {
    free(t);
    free(closures);
    bent_fail(error, BENT_ERROR_MEMORY, "stars: out of memory");
    return NULL;
  }
  t->settings = (bent_render_settings){.width = view->width, .height = view->height, .tolerance = view->tolerance,
                                       .filter = BENT_FILTER_BOX, .filter_width = 1};
  t->transparent_bounces = view->transparent_bounces;
  t->closures = closures;
  tracer_init(&t->tracer, scene, &t->settings, &NO_CHANNELS);
  return t;
}

void star_tracer_free(star_tracer *t)
{
  if (t) free(t->closures);
  free(t);
}

star_ray star_ray_of(const star_tracer *t, const camera_ray *cast, vec3 direction, star_sky sky)
{
  star_ray r = {.sky = sky, .throughput = v3_splat(1), .history = {.kinds = RAY_CAMERA}};
  r.ray = (bent_ray){.length_min = cast->length_min, .length_max = cast->length_max, .visibility = BENT_VISIBLE_CAMERA};
  path_set_ray(&t->tracer, &r.ray, cast->origin, direction, NULL);
  return r;
}

/* A surface in front of a star: returns 1 if some of its light goes on along the ray. */
static int pass(const star_tracer *t, star_ray *r, const bent_hit *hit)
{
  const bent_scene *scene = t->tracer.scene;
  if (scene->geometry->instances[hit->instance].visibility & BENT_HOLDOUT) return 0;
  r->length += hit->length;
  r->throughput = v3_mul(r->throughput, direct_transmitted(scene, hit, r->length, &r->history, t->closures));
  if (!(v3_max(r->throughput) > 0) || r->history.transparent++ >= t->transparent_bounces) return 0;
  r->ray.length_min = max2(r->ray.length_min - hit->length, 0);
  r->ray.length_max -= hit->length;
  path_set_ray(&t->tracer, &r->ray, v3_from(hit->position), v3_from(hit->direction), hit);
  return r->ray.length_max > 0;
}

static int is_there(star_sky sky, const bent_hit *hit)
{
  return (hit->fate == BENT_ESCAPED && sky != STAR_SKY_FAR) || (hit->fate == BENT_ESCAPED_FAR && sky != STAR_SKY_NEAR);
}

bent_status star_rays_trace(star_tracer *t, int count, star_ray *rays, bent_progress *progress, bent_error *error)
{
  int left = count;
  for (int i = 0; i < count; i++) t->under_way[i] = i, rays[i].arrived = 0;
  while (left > 0) {
    for (int i = 0; i < left; i++) t->rays[i] = rays[t->under_way[i]].ray;
    const bent_status status = path_intersect(&t->tracer, left, t->rays, t->hits, progress, error);
    if (status) return status;
    const int traced = left;
    left = 0;
    for (int i = 0; i < traced; i++) {
      star_ray *r = &rays[t->under_way[i]];
      if (t->hits[i].fate == BENT_HIT && pass(t, r, &t->hits[i])) t->under_way[left++] = t->under_way[i];
      else r->arrived = is_there(r->sky, &t->hits[i]);
    }
  }
  return BENT_OK;
}
