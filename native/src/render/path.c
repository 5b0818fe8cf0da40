/* See path.h. One vertex of a path: gather what the surface or sky emits, draw a lobe and a direction, go on.
 *
 * Lights are found by BSDF sampling alone for now: an escaped ray gathers sky and suns, a hit gathers emission. */
#include "render/path.h"

#include <stdlib.h>

#include "geometry/geometry.h"
#include "render/bsdf.h"
#include "render/describe.h"
#include "render/suns.h"
#include "render/surface.h"
#include "scene/scene.h"

/* Random sets of a path: the camera's, then two a vertex, of which the second is for sampling lights. */
enum { SET_CAMERA = 0, SET_VERTEX = 1, SETS_PER_VERTEX = 2 };
/* A path of more surfaces than this is cut: see-through ones are not limited by the settings. */
enum { VERTICES_MAX = 1 << 14 };
/* Rays after a diffuse scattering are traced this much more coarsely: what they see is blurred over the hemisphere. */
static const double DIFFUSE_COARSENESS = 10;
static const float NO_DEPTH = 1e10f; /* as Cycles */

bent_status path_block_new(path_block *out, const bent_scene *scene, int capacity, bent_error *error)
{
  const size_t n = (size_t)capacity, lobes = (size_t)shading_lobe_max(scene->shading);
  *out = (path_block){.capacity = capacity, .paths = malloc(n * sizeof *out->paths),
                      .rays = malloc(n * sizeof *out->rays), .hits = malloc(n * sizeof *out->hits),
                      .records = malloc(n * sizeof *out->records),
                      .closures = malloc(lobes * sizeof *out->closures)};
  if (out->paths && out->rays && out->hits && out->records && out->closures) return BENT_OK;
  path_block_free(out);
  return bent_fail(error, BENT_ERROR_MEMORY, "render: out of memory");
}

void path_block_free(path_block *block)
{
  free(block->paths);
  free(block->rays);
  free(block->hits);
  free(block->records);
  free(block->closures);
  *block = (path_block){0};
}

/* Angle of the image's central pixel; for orthographic cameras pixels have no angle and `tolerance` rules alone. */
static double pixel_angle(const bent_scene *scene, const bent_render_settings *s)
{
  if (scene->camera->settings.kind == BENT_CAMERA_ORTHOGRAPHIC) return INFINITY;
  camera_ray a, b;
  if (!camera_cast(scene->camera, 0.5, 0.5, &a) || !camera_cast(scene->camera, 0.5 + 1.0 / s->width, 0.5, &b))
    return INFINITY;
  return v3_length(v3_sub(a.direction, b.direction));
}

void tracer_init(tracer *t, const bent_scene *scene, const bent_render_settings *s)
{
  *t = (tracer){.scene = scene, .settings = s, .angle = s->tolerance};
  const double angle = 0.1 * pixel_angle(scene, s);
  if (angle > 0 && angle < t->angle) t->angle = angle;
  sampler_init(&t->sampler);
  filter_init(&t->filter, s->filter, s->filter_width);
}

/* Distance to the center of the nearest spacetime object; 1 where there is none and no ray is bent. */
static double distance_to_lens(const geometry *g, vec3 origin)
{
  double distance = INFINITY;
  for (size_t i = 0; i < g->lens_count; i++)
    if (!g->lenses[i].flat) distance = fmin(distance, v3_length(v3_sub(origin, g->lenses[i].center)));
  return isfinite(distance) ? distance : 1;
}

/* Points `ray`, whose visibility is set, away from a surface, or from the camera if that is NULL. */
static void set_ray(const tracer *t, bent_ray *ray, vec3 origin, vec3 direction, const bent_hit *surface)
{
  v3_to(ray->origin, origin);
  v3_to(ray->direction, direction);
  ray->angular_tolerance = ray->visibility == BENT_VISIBLE_DIFFUSE ? DIFFUSE_COARSENESS * t->angle : t->angle;
  ray->tolerance = ray->angular_tolerance * distance_to_lens(t->scene->geometry, origin);
  ray->source_instance = surface ? surface->instance : -1;
  ray->source_triangle = surface ? surface->triangle : -1;
}

/* Whether light can leave from a place: not from inside a horizon, nor from where rounding sees one. */
static int can_leave(const tracer *t, vec3 origin)
{
  const lens *lens = geometry_lens_at(t->scene->geometry, origin);
  if (!lens) return 1;
  double local[3];
  v3_to(local, mat4_point(&lens->spacetime_from_world, origin));
  return bent_spacetime_contains(&lens->spacetime, local);
}

/* Starts a path; returns 0 if the camera has no ray there. */
static int start(const tracer *t, const pixel_sample *wanted, path *p, bent_ray *ray, sample_record *record)
{
  *record = (sample_record){0};
  record->value[CHANNEL_DEPTH][0] = NO_DEPTH;
  const bent_render_settings *s = t->settings;
  const uint32_t key = sampler_pixel_key(s->seed, wanted->x, wanted->y);
  double u[SAMPLER_DIMENSIONS];
  sampler_draw(&t->sampler, key, wanted->sample, SET_CAMERA, u);
  const double x = (wanted->x + 0.5 + filter_offset(&t->filter, u[0])) / s->width;
  const double y = (wanted->y + 0.5 + filter_offset(&t->filter, u[1])) / s->height;
  camera_ray camera;
  if (!camera_cast(t->scene->camera, x, y, &camera) || !can_leave(t, camera.origin)) {
    record->value[CHANNEL_COMBINED][3] = 1; /* black and opaque, as Cycles */
    return 0;
  }
  *p = (path){.beta = {1, 1, 1}, .feature_beta = {1, 1, 1}, .alpha = 1, .pixel_key = key, .sample = wanted->sample,
              .depth_per_length = camera.depth_per_length};
  *ray = (bent_ray){.length_min = camera.length_min, .length_max = camera.length_max,
                    .visibility = BENT_VISIBLE_CAMERA};
  set_ray(t, ray, camera.origin, camera.direction, NULL);
  return 1;
}

/* Radiance that reaches the camera, limited if it was scattered more than once (Cycles: clamp indirect). */
static vec3 limited(const tracer *t, const path *p, vec3 radiance)
{
  const vec3 contribution = v3_mul(p->beta, radiance);
  const double limit = 3 * t->settings->clamp_indirect, sum = contribution.x + contribution.y + contribution.z;
  return p->bounces > 1 && limit > 0 && sum > limit ? v3_scale(contribution, limit / sum) : contribution;
}

/* The ray escaped: sky and suns. One sky surrounds both sides of a wormhole that has no exit. */
static void gather_sky(const tracer *t, path *p, const bent_ray *ray, const bent_hit *hit, sample_record *record)
{
  const vec3 direction = v3_from(hit->direction);
  const vec3 sky = v3_add(shading_sky(t->scene->shading, direction),
                          suns_radiance(t->scene->suns, direction, ray->visibility));
  const vec3 contribution = limited(t, p, sky);
  if (!p->featured) record_add(record, CHANNEL_DENOISING_ALBEDO, v3_mul(p->feature_beta, sky));
  if (p->bounces == 0) {
    record_add(record, CHANNEL_ENVIRONMENT, contribution);
    if (t->settings->film_transparent) {
      p->alpha -= v3_average(p->beta);
      return;
    }
  }
  p->radiance = v3_add(p->radiance, contribution);
}

static void gather_emission(const tracer *t, path *p, vec3 emission, sample_record *record)
{
  const vec3 contribution = limited(t, p, emission);
  p->radiance = v3_add(p->radiance, contribution);
  if (p->bounces == 0) record_add(record, CHANNEL_EMISSION, contribution);
}

/* Lets the ray go straight on behind the surface that it met; what is left of its clip range goes with it. */
static void pass_through(const tracer *t, path *p, bent_ray *ray, const bent_hit *hit)
{
  p->travelled += hit->length;
  ray->length_min = fmax(ray->length_min - hit->length, 0);
  ray->length_max -= hit->length;
  set_ray(t, ray, v3_from(hit->position), v3_from(hit->direction), hit);
}

/* Counts a scattering and says whether the next surface is the path's last. */
static void count_bounce(const bent_render_settings *s, path *p, bsdf_lobe lobe)
{
  p->bounces++;
  p->last |= p->bounces > s->max_bounces;
  if (lobe == LOBE_DIFFUSE) p->last |= ++p->diffuse > s->diffuse_bounces;
  if (lobe == LOBE_GLOSSY) p->last |= ++p->glossy > s->glossy_bounces;
  if (lobe == LOBE_TRANSMISSION) p->last |= ++p->transmission > s->transmission_bounces;
}

/* Russian roulette by the square root of the throughput, as Cycles: returns 0 if the path ends. */
static int survives(const bent_render_settings *s, path *p, double u)
{
  if (p->bounces < s->roulette_start) return 1;
  const double probability = sqrt(v3_max(p->beta));
  if (probability >= 1) return 1;
  if (!(u < probability)) return 0;
  p->beta = v3_scale(p->beta, 1 / probability);
  return 1;
}

/* Draws the next direction; returns 0 if the path ends here. */
static int scatter(const tracer *t, path *p, bent_ray *ray, const bent_hit *hit, const shade_point *point,
                   const closure_set *set)
{
  double u[SAMPLER_DIMENSIONS];
  sampler_draw(&t->sampler, p->pixel_key, p->sample, SET_VERTEX + SETS_PER_VERTEX * p->vertex, u);
  bsdf_sample drawn;
  if (!bsdf_draw(set, point, u, &drawn)) return 0;
  p->beta = v3_mul(p->beta, drawn.weight);
  if (!v3_is_finite(p->beta) || !(v3_max(p->beta) > 0)) return 0;
  if (!p->featured) p->feature_beta = v3_mul(p->feature_beta, v3_saturate(drawn.weight));
  if (drawn.lobe == LOBE_TRANSPARENT) {
    pass_through(t, p, ray, hit);
    return p->transparent++ < t->settings->transparent_bounces;
  }
  if (p->last) return 0;
  count_bounce(t->settings, p, drawn.lobe);
  if (!survives(t->settings, p, u[3])) return 0;
  ray->length_min = 0, ray->length_max = INFINITY;
  ray->visibility = (uint32_t)drawn.lobe;
  set_ray(t, ray, point->position, drawn.wi, hit);
  return 1;
}

/* Whether the camera meets a holdout here: black and see-through, whatever the film (as Cycles). */
static int is_holdout(const tracer *t, path *p, const bent_hit *hit)
{
  if (p->bounces || !(t->scene->geometry->instances[hit->instance].visibility & BENT_HOLDOUT)) return 0;
  p->alpha -= v3_average(p->beta);
  return 1;
}

/* One vertex. Returns 1 if the path goes on along *ray. `closures` is room for those of the surface. */
static int shade(const tracer *t, path *p, closure *closures, bent_ray *ray, const bent_hit *hit,
                 sample_record *record)
{
  if (p->bounces == 0) {
    p->winding += hit->swept / M_PI;
    p->error = hit->fate == BENT_UNRESOLVED || !isfinite(hit->error) ? M_PI : fmin(p->error + hit->error, M_PI);
    if (!p->described) record->value[CHANNEL_FATE][0] = hit->fate;
  }
  if (hit->fate == BENT_ESCAPED || hit->fate == BENT_ESCAPED_FAR) gather_sky(t, p, ray, hit, record);
  if (hit->fate != BENT_HIT || is_holdout(t, p, hit)) return 0;
  surface surface;
  surface_at(t->scene, hit, &surface);
  if (p->vertex >= VERTICES_MAX) return 0;
  int goes_on = 1;
  if (!can_leave(t, surface.point.position)) return 0;
  if (surface.see_through) {
    pass_through(t, p, ray, hit);
  } else if (p->last && !shading_may_be_transparent(t->scene->shading, surface.material)) {
    gather_emission(t, p, shading_emission(t->scene->shading, surface.material, &surface.point), record);
    goes_on = 0;
  } else {
    closure_set set = {.closures = closures};
    shading_evaluate(t->scene->shading, surface.material, &surface.point, &set);
    gather_emission(t, p, set.emission, record);
    if (p->bounces == 0) p->alpha -= v3_average(v3_mul(p->beta, set.holdout));
    if (p->bounces == 0) describe_surface(t, p, hit->length, record, &surface.point, &set);
    describe_features(t, p, record, &surface.point, &set);
    /* Geodesic light sampling belongs here: the rays that join this point to a light, each with its geometric factor and
     * weighed against BSDF sampling (whose pdf `scatter` knows), by random set SET_VERTEX + SETS_PER_VERTEX * vertex + 1. */
    goes_on = scatter(t, p, ray, hit, &surface.point, &set);
  }
  p->vertex++;
  return goes_on;
}

/* Writes what is known only at the end. A sample that broken input made NaN counts as black. */
static void finish(const path *p, sample_record *record, bent_render_statistics *statistics)
{
  const vec3 L = p->radiance;
  record_vec3(record, CHANNEL_COMBINED, L);
  record->value[CHANNEL_COMBINED][3] = (float)p->alpha;
  record->value[CHANNEL_WINDING][0] = (float)p->winding;
  record->value[CHANNEL_ERROR][0] = (float)p->error;
  int valid = 1;
  float *values = record->value[0];
  for (int i = 0; i < CHANNEL_COUNT * CHANNEL_COMPONENTS_MAX; i++)
    if (!isfinite(values[i])) values[i] = 0, valid = 0;
  statistics->invalid += !valid;
}

/* Intersects the block's first `count` rays, some at a time: looks for a cancel in between. At the finest tolerances a
 * curved ray takes thousands of chords, milliseconds. */
static bent_status intersect(const tracer *t, path_block *block, int count, bent_progress *progress, bent_error *error)
{
  const int at_a_time = t->angle < 1e-6 ? 16 : 256;
  for (int begin = 0; begin < count; begin += at_a_time) {
    if (progress && atomic_load_explicit(&progress->cancel, memory_order_relaxed))
      return bent_fail(error, BENT_CANCELLED, "render: cancelled");
    const int n = count - begin < at_a_time ? count - begin : at_a_time;
    const bent_status status =
        bent_scene_intersect(t->scene, (size_t)n, block->rays + begin, block->hits + begin, NULL, error);
    if (status) return status;
  }
  return BENT_OK;
}

bent_status path_trace(const tracer *t, path_block *block, int count, const pixel_sample *wanted,
                       bent_render_statistics *statistics, bent_progress *progress, bent_error *error)
{
  int alive = 0; /* paths[0 .. alive) live; rays[i] is the next ray of paths[i] */
  for (int i = 0; i < count; i++)
    if (start(t, &wanted[i], &block->paths[alive], &block->rays[alive], &block->records[i]))
      block->paths[alive++].record = i;
  while (alive > 0) {
    const bent_status status = intersect(t, block, alive, progress, error);
    if (status) return status;
    statistics->rays += (uint64_t)alive;
    int kept = 0;
    for (int i = 0; i < alive; i++) {
      path *p = &block->paths[i];
      statistics->unresolved += block->hits[i].fate == BENT_UNRESOLVED;
      if (shade(t, p, block->closures, &block->rays[i], &block->hits[i], &block->records[p->record])) {
        if (kept != i) block->paths[kept] = *p, block->rays[kept] = block->rays[i];
        kept++;
      } else {
        finish(p, &block->records[p->record], statistics);
      }
    }
    alive = kept;
  }
  return BENT_OK;
}
