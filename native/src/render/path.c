/* See path.h. One vertex of a path: gather what the surface or sky emits, weighed against connections with it; join the
 * vertex with a light (direct.h); draw a lobe and a direction, go on. */
#include "render/path.h"

#include <stdlib.h>

#include "geometry/geometry.h"
#include "light/frequency.h"
#include "render/aperture.h"
#include "render/bsdf.h"
#include "render/describe.h"
#include "render/dimensions.h"
#include "render/direct.h"
#include "render/gather.h"
#include "render/portal.h"
#include "render/subsurface.h"
#include "render/bidirectional.h"
#include "render/light_path.h"
#include "render/motion_vector.h"
#include "render/occlusion.h"
#include "scene/scene.h"

/* A path of more surfaces than this is cut: see-through ones are not limited by the settings. */
enum { VERTICES_MAX = 1 << 14 };
/* Rays after a diffuse scattering are traced this much more coarsely: what they see is blurred over the hemisphere; and
 * shadows, which hide parts of lights. */
static const double DIFFUSE_COARSENESS = 10;
static const float NO_DEPTH = 1e10f; /* as Cycles */
/* Paths of less throughput than this may end. With 1, as in Cycles, what is saved on long paths is lost in the noise of
 * those that go on: rooms take up to 12 % more time to the same mean squared error. */
static const double ROULETTE_THROUGHPUT = 0.33;

bent_status path_block_new(path_block *out, const bent_scene *scene, const channel_layout *layout, int capacity,
                           bent_error *error)
{
  const size_t n = (size_t)capacity, lobes = (size_t)shading_lobe_max(scene->shading);
  *out = (path_block){.capacity = capacity, .lobes = (int)lobes};
  out->paths = malloc(n * sizeof *out->paths);
  out->rays = malloc(n * sizeof *out->rays);
  out->hits = malloc(n * sizeof *out->hits);
  out->goes_on = malloc(n * sizeof *out->goes_on);
  out->records = malloc(n * sizeof *out->records);
  out->closures = malloc(2 * DIRECT_BATCH * lobes * sizeof *out->closures);
  out->shadows = malloc(SHADOWS * sizeof *out->shadows);
  out->shadow_rays = malloc(SHADOWS * sizeof *out->shadow_rays);
  out->shadow_hits = malloc(SHADOWS * sizeof *out->shadow_hits);
  out->credits = layout->light ? malloc(SHADOWS * sizeof *out->credits) : NULL;
  out->lists = malloc((n * layout->list_total + 1) * sizeof *out->lists);
  const int has_vectors = layout->wanted[CHANNEL_VECTOR] && scene->motion;
  if (has_vectors) out->seen = malloc(n * sizeof *out->seen);
  const int has_lists = out->lists && (out->seen || !has_vectors) && (out->credits || !layout->light);
  if (has_lists && out->paths && out->rays && out->hits && out->goes_on && out->records && out->closures && out->shadows &&
      out->shadow_rays && out->shadow_hits)
    return BENT_OK;
  path_block_free(out);
  return bent_fail(error, BENT_ERROR_MEMORY, "render: out of memory");
}

void path_block_free(path_block *block)
{
  free(block->paths);
  free(block->rays);
  free(block->hits);
  free(block->goes_on);
  free(block->records);
  free(block->closures);
  free(block->shadows);
  free(block->shadow_rays);
  free(block->shadow_hits);
  free(block->credits);
  free(block->lists);
  free(block->seen);
  light_paths_free(block->light);
  *block = (path_block){0};
}

/* Size and angle of the image's central pixel; for orthographic cameras pixels have no angle. */
static void measure_pixel(tracer *t)
{
  camera_ray a, b;
  if (!t->scene->camera || !camera_cast(t->scene->camera, 0.5, 0.5, &a) ||
      !camera_cast(t->scene->camera, 0.5 + 1.0 / t->settings->width, 0.5, &b))
    return;
  t->pixel_size = v3_length(v3_sub(a.origin, b.origin));
  t->pixel_slope = v3_length(v3_sub(a.direction, b.direction));
}

double path_footprint(const tracer *t, vec3 position)
{
  return t->pixel_size + t->pixel_slope * v3_length(v3_sub(position, t->eye));
}

void tracer_init(tracer *t, const bent_scene *scene, const bent_render_settings *s, const channel_layout *layout)
{
  *t = (tracer){.scene = scene, .settings = s, .layout = layout, .angle = s->tolerance,
                .asks_scattering = shading_any_asks_scattering(scene->shading),
                .asks_frequency = shading_any_asks_frequency(scene->shading) || layout->wanted[CHANNEL_FREQUENCY_SHIFT],
                .joins_slowly = join_is_slow(scene->geometry),
                .filters_sky = s->sky_filter > 0 && shading_sky_has_levels(scene->shading)};
  measure_pixel(t);
  if (scene->camera) t->eye = mat4_point(&scene->camera->world_from_camera, v3(0, 0, 0));
  t->bidirectional = s->integrator == BENT_BIDIRECTIONAL && !bent_scene_bidirectional_obstacle(scene);
  const double angle = 0.1 * t->pixel_slope;
  if (angle > 0 && angle < t->angle) t->angle = angle;
  sampler_init(&t->sampler, s->sampling_pattern);
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

void path_set_ray(const tracer *t, bent_ray *ray, vec3 origin, vec3 direction, const bent_hit *surface)
{
  v3_to(ray->origin, origin);
  v3_to(ray->direction, direction);
  const int coarse = ray->visibility == BENT_VISIBLE_DIFFUSE || ray->visibility == BENT_SHADOW;
  ray->angular_tolerance = coarse ? DIFFUSE_COARSENESS * t->angle : t->angle;
  ray->tolerance = ray->angular_tolerance * distance_to_lens(t->scene->geometry, origin);
  ray->source_instance = surface ? surface->instance : -1;
  ray->source_triangle = surface ? surface->triangle : -1;
}

int path_can_leave(const tracer *t, vec3 origin)
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
  record_clear(t->layout, record);
  record->value[CHANNEL_DEPTH][0] = NO_DEPTH;
  if (t->layout->extras) record->value[CHANNEL_MIST][0] = 1;
  const bent_render_settings *s = t->settings;
  const sampler_pixel pixel = sampler_pixel_at(&t->sampler, s->seed, wanted->x, wanted->y);
  double u[SAMPLER_DIMENSIONS];
  sampler_draw(&t->sampler, pixel, wanted->sample, dimensions_camera(), u);
  const double x = (wanted->x + 0.5 + filter_offset(&t->filter, u[CAMERA_X])) / s->width;
  const double y = (wanted->y + 0.5 + filter_offset(&t->filter, u[CAMERA_Y])) / s->height;
  double lens[2];
  aperture_draw(&t->scene->camera->settings.aperture, &u[CAMERA_LENS_U], lens);
  camera_ray camera;
  if (!camera_cast_lens(t->scene->camera, x, y, lens, &camera) || !path_can_leave(t, camera.origin)) {
    record->value[CHANNEL_COMBINED][3] = 1; /* black and opaque, as Cycles */
    return 0;
  }
  *p = (path){.scattered = {.position = camera.origin, .direction = camera.direction, .join_chance = 1,
                            .first_lens = -1},
              .beta = {1, 1, 1}, .feature_beta = {1, 1, 1}, .alpha = 1, .least_pdf = INFINITY,
              .ray = {.kinds = RAY_CAMERA}, .pixel = pixel, .sample = wanted->sample,
              .depth_per_length = camera.depth_per_length, .image = {x, y}, .lens = {lens[0], lens[1]},
              .sky_filter = t->filters_sky ? s->sky_filter / sqrt(wanted->multiple) : 0};
  if (t->bidirectional) p->chain = bidirectional_start(t, camera.direction);
  *ray = (bent_ray){.length_min = camera.length_min, .length_max = camera.length_max,
                    .visibility = BENT_VISIBLE_CAMERA};
  path_set_ray(t, ray, camera.origin, camera.direction, NULL);
  return 1;
}

/* Lets the ray go straight on behind the surface that it met; what is left of its clip range goes with it. */
static void pass_through(const tracer *t, path *p, bent_ray *ray, const bent_hit *hit)
{
  p->travelled += hit->length;
  p->scattered.swept += hit->swept;
  p->scattered.borders += hit->borders;
  p->scattered.length += hit->length;
  if (p->scattered.first_lens < 0) p->scattered.first_lens = hit->first_lens;
  ray->length_min = fmax(ray->length_min - hit->length, 0);
  ray->length_max -= hit->length;
  path_set_ray(t, ray, v3_from(hit->position), v3_from(hit->direction), hit);
}

ray_history path_scattered(ray_history ray, const closure_set *set, bsdf_lobe lobe, int sharp)
{
  ray.kinds = bsdf_ray_kinds(set, lobe) | (sharp ? RAY_SINGULAR : 0);
  ray.bounces++;
  ray.diffuse += lobe == LOBE_DIFFUSE;
  ray.glossy += lobe == LOBE_GLOSSY;
  ray.transmission += lobe == LOBE_TRANSMISSION;
  return ray;
}

int path_is_last(const bent_render_settings *s, const ray_history *ray)
{
  return ray->bounces > s->max_bounces || ray->diffuse > s->diffuse_bounces || ray->glossy > s->glossy_bounces ||
         ray->transmission > s->transmission_bounces;
}

/* Russian roulette by the square root of the throughput: returns 0 if the path ends. */
static int survives(const bent_render_settings *s, path *p, double u)
{
  if (p->ray.bounces < s->roulette_start) return 1;
  const double probability = sqrt(v3_average(p->beta) / ROULETTE_THROUGHPUT);
  if (probability >= 1) return 1;
  if (!(u < probability)) return 0;
  p->beta = v3_scale(p->beta, 1 / probability);
  return 1;
}

/* How a vertex draws its next direction. */
static void set_mix(const tracer *t, const path *p, lit_vertex *v)
{
  const shade_point *point = &v->surface.point;
  v->mix.chance = v->mix.count = 0, v->mix.known = NULL;
  if (t->settings->portal_sampling && t->scene->portals && !p->last)
    v->mix = portal_mix_at(t->scene, point->position, direct_normal(point, &v->set), &v->set);
}

/* What a batch of paths shares while it is shaded. Paths that come out from below a surface have two vertices: the second
 * of each path is in the second list. A vertex is made behind the end of its list, and stays there if its light is wanted. */
typedef struct batch {
  path_block *block;
  reach reach[DIRECT_BATCH];
  lit_vertex vertices[2][DIRECT_BATCH];
  int vertex_count[2];
  bent_hit exits[DIRECT_BATCH];
  closure *closures; /* room for a view, if light subpaths are traced */
} batch;

/* Room for one path of a batch: closures of its vertices, and where it comes out from below a surface. */
typedef struct room {
  closure *closures[2];
  bent_hit *exit;
} room;

static lit_vertex *new_vertex(batch *b, int list) { return &b->vertices[list][b->vertex_count[list]]; }

/* Keeps the new vertex of a list to be joined with a light, unless it could not scatter the light. */
static void want_light(const tracer *t, batch *b, int list, path *p, const arrival *at, double chance)
{
  lit_vertex *v = new_vertex(b, list);
  if (p->last || v->set.count == v->set.delta_count || !lights_any(t->scene->lights) ||
      t->settings->light_sampling == BENT_LIGHTS_SCATTERING)
    return;
  double u[SAMPLER_DIMENSIONS];
  sampler_draw(&t->sampler, p->pixel, p->sample, dimensions_light(p->vertex), u);
  if (!(u[LIGHT_IMAGES] < chance)) return;
  v->path = p, v->hit = at->hit, v->beta = p->beta, v->chance = chance, v->vertex = p->vertex;
  if (t->bidirectional) v->chain = at->chain;
  for (int i = 0; i < SAMPLER_DIMENSIONS; i++) v->u[i] = u[i];
  v->u[LIGHT_IMAGES] /= chance;
  b->vertex_count[list]++;
}

/* Where a path comes out from below a surface: a white diffuse lobe, whose normal is that of the subsurface lobes there. */
static void diffuse_exit(const tracer *t, const surface *surface, closure_set *set)
{
  shading_evaluate(t->scene->shading, surface->material, &surface->point, set);
  vec3 normal = v3(0, 0, 0);
  for (int i = 0; i < set->count; i++)
    if (set->closures[i].kind == CLOSURE_SUBSURFACE)
      normal = v3_mad(set->closures[i].tangent, set->closures[i].share, normal);
  set->count = set->delta_count = 0;
  closure_add_diffuse(set, &surface->point, v3_splat(1), v3_splat(1), 0, normal);
  closure_set_finish(set);
}

static int leave_vertex(const tracer *t, batch *b, int list, path *p, const room *room, bent_ray *ray,
                        const arrival *at);

/* Below the surface to another place on it, which scatters the light that has come there; returns 0 if the path ends. */
static int walk_below(const tracer *t, batch *b, path *p, const room *room, bent_ray *ray, const bent_hit *hit,
                      const shade_point *point, const bsdf_sample *drawn)
{
  if (!subsurface_walk(t, p, drawn->entered, point->normal, hit, drawn->wi, &p->beta, room->exit)) return 0;
  lit_vertex *v = new_vertex(b, 1);
  surface *surface = &v->surface;
  surface_at(t->scene, room->exit, v3_length(v3_sub(point->position, v3_from(room->exit->position))), surface);
  if (!path_can_leave(t, surface->point.position)) return 0;
  surface->point.ray = point->ray;
  surface->point.footprint = point->footprint;
  v->set.closures = room->closures[1];
  diffuse_exit(t, surface, &v->set);
  p->vertex++;
  arrival out = {.hit = room->exit};
  if (t->bidirectional) out.chain = bidirectional_begin(t, surface->point.position);
  return leave_vertex(t, b, 1, p, room, ray, &out);
}

/* Draws the next direction; returns 0 if the path ends here. */
static int scatter(const tracer *t, batch *b, path *p, const room *room, bent_ray *ray,
                   const arrival *at, const lit_vertex *v, double join_chance)
{
  const bent_hit *hit = at->hit;
  const shade_point *point = &v->surface.point;
  const closure_set *set = &v->set;
  double u[SAMPLER_DIMENSIONS];
  sampler_draw(&t->sampler, p->pixel, p->sample, dimensions_scattering(p->vertex), u);
  bsdf_sample drawn;
  if (!portal_draw(&v->mix, set, point, u, &drawn)) return 0;
  p->beta = v3_mul(p->beta, drawn.weight);
  if (t->asks_scattering) p->beta = v3_mul(p->beta, bsdf_kind_weight(set, point, &drawn));
  if (!v3_is_finite(p->beta) || !(v3_max(p->beta) > 0)) return 0;
  if (!p->featured) /* of mirrors and glass the weight times the chance of the way is the albedo, which is at most 1 */
    p->feature_beta = v3_mul(p->feature_beta, drawn.pdf > 0 ? v3_saturate(drawn.weight) : drawn.weight);
  if (drawn.lobe == LOBE_TRANSPARENT) {
    pass_through(t, p, ray, hit);
    return p->ray.transparent++ < t->settings->transparent_bounces;
  }
  if (p->last) return 0;
  if (t->layout->light && p->ray.bounces == 0) {
    credit parts;
    parts_of_scattering(set, point, &drawn, t->asks_scattering ? (uint32_t)drawn.lobe : UINT32_MAX, &parts);
    p->diffuse_part = parts.diffuse, p->glossy_part = parts.glossy;
  }
  if (drawn.lobe == LOBE_SUBSURFACE) return walk_below(t, b, p, room, ray, hit, point, &drawn);
  p->ray = path_scattered(point->ray, set, drawn.lobe, drawn.pdf == 0);
  p->last = path_is_last(t->settings, &p->ray);
  if (drawn.pdf > 0) p->least_pdf = min2(p->least_pdf, drawn.lobes_pdf);
  if (!survives(t->settings, p, u[SCATTER_SURVIVAL])) return 0;
  if (t->bidirectional) {
    p->chain = at->chain;
    bidirectional_leave(t, &p->chain, hit, point, &drawn, b->closures);
  }
  p->scattered = (scattering){point->position, direct_normal(point, set), drawn.wi, drawn.pdf,
                              join_chance, t->scene->geometry->instances[hit->instance].receiver_set, 0, -1, 0, 0};
  ray->length_min = 0, ray->length_max = INFINITY;
  ray->visibility = (uint32_t)drawn.lobe;
  path_set_ray(t, ray, point->position, drawn.wi, hit);
  return 1;
}

/* Asks for light at the new vertex of a list, and goes on from there; returns 0 if the path ends. */
static int leave_vertex(const tracer *t, batch *b, int list, path *p, const room *room, bent_ray *ray,
                        const arrival *at)
{
  lit_vertex *v = new_vertex(b, list);
  set_mix(t, p, v);
  const double join_chance = direct_chance(t, p);
  want_light(t, b, list, p, at, join_chance);
  return scatter(t, b, p, room, ray, at, v, join_chance);
}

/* Whether the camera meets a holdout here: black and see-through, whatever the film (as Cycles). */
static int is_holdout(const tracer *t, path *p, const bent_hit *hit)
{
  if (p->ray.bounces || !(t->scene->geometry->instances[hit->instance].visibility & BENT_HOLDOUT)) return 0;
  p->alpha -= v3_average(p->beta);
  return 1;
}

/* The camera ray has ended: what the channels say of it as a whole. */
static void describe_ray(const tracer *t, path *p, const bent_hit *hit, sample_record *record)
{
  p->winding += hit->swept / M_PI;
  p->error = hit->fate == BENT_UNRESOLVED || !isfinite(hit->error) ? M_PI : fmin(p->error + hit->error, M_PI);
  if (p->described) return;
  record->value[CHANNEL_FATE][0] = hit->fate;
  if (t->layout->wanted[CHANNEL_IMAGE_ORDER] && isfinite(p->winding))
    record->value[CHANNEL_IMAGE_ORDER][0] = (float)floor(p->winding);
}

/* An immaterial surface, where the ray gathers light and goes on; returns 1 if it does. */
static int shine_through(const tracer *t, path *p, const arrival *at, const surface *surface, bent_ray *ray,
                         sample_record *record)
{
  const vec3 emission = shading_emission(t->scene->shading, surface->material, &surface->point);
  gather_emission(t, p, at, emission, record);
  pass_through(t, p, ray, at->hit);
  return !(v3_max(emission) > 0) || p->ray.transparent++ < t->settings->transparent_bounces;
}

/* Cycles' Filter Glossy: what is seen after a blurry bounce is made rougher, the more so the blurrier the bounce was. */
static void blur(const tracer *t, const path *p, const shade_point *point, closure_set *set)
{
  if (!(t->settings->blur_glossy > 0) || t->bidirectional) return;
  const double pdf = p->least_pdf / t->settings->blur_glossy;
  if (pdf < 1) closure_set_blur(set, point, 0.5 * sqrt(1 - pdf));
}

/* The history of a path that has come to a surface. */
static ray_history arrived_history(const tracer *t, const path *p, const bent_hit *hit)
{
  ray_history ray = p->ray;
  if (!t->asks_frequency) return ray;
  const frequency_leg leg = {p->scattered.position, p->scattered.direction, v3_from(hit->position), v3_from(hit->direction),
                             p->scattered.swept + hit->swept};
  frequency_follow(t->scene->geometry, &leg, &ray);
  return ray;
}

/* A surface. Returns 1 if the path goes on along *ray. */
static int shade_surface(const tracer *t, batch *b, path *p, const reach *reach, const room *room, bent_ray *ray,
                         const bent_hit *hit, sample_record *record)
{
  lit_vertex *v = new_vertex(b, 0);
  surface *surface = &v->surface;
  surface_at(t->scene, hit, p->scattered.length + hit->length, surface);
  surface->point.ray = arrived_history(t, p, hit);
  if (p->ray.kinds & RAY_DIFFUSE && !t->bidirectional) { /* paths to caustics: a diffuse surface sees a light in a mirror or through glass */
    surface->point.no_reflection = !t->settings->caustics_reflective;
    surface->point.no_refraction = !t->settings->caustics_refractive;
  }
  p->way += hit->length;
  surface->point.footprint = t->bidirectional ? path_footprint(t, surface->point.position)
                                             : t->pixel_size + t->pixel_slope * p->way;
  arrival here = {.reach = reach, .hit = hit}, *const at = &here;
  if (t->bidirectional) here.chain = bidirectional_arrive(t, p, &surface->point, reach->spread);
  if (p->vertex >= VERTICES_MAX || !path_can_leave(t, surface->point.position)) return 0;
  int goes_on = 1;
  describe_way(t, p, hit->length, record);
  if (surface->see_through) {
    pass_through(t, p, ray, hit);
  } else if (t->scene->geometry->instances[hit->instance].visibility & BENT_IMMATERIAL) {
    goes_on = shine_through(t, p, at, surface, ray, record);
  } else if (p->last && !shading_may_be_transparent(t->scene->shading, surface->material)) {
    const vec3 emission = shading_emission(t->scene->shading, surface->material, &surface->point);
    gather_emission(t, p, at, emission, record);
    goes_on = 0;
  } else {
    closure_set *set = &v->set;
    set->closures = room->closures[0];
    const aov_sink aovs = describe_aovs(t, record);
    surface->point.aovs = aovs.count && p->ray.bounces == 0 && !p->described ? &aovs : NULL;
    shading_evaluate(t->scene->shading, surface->material, &surface->point, set);
    surface->point.aovs = NULL;
    blur(t, p, &surface->point, set);
    gather_emission(t, p, at, set->emission, record);
    if (p->ray.bounces == 0) p->alpha -= v3_average(v3_mul(p->beta, set->holdout));
    if (p->ray.bounces == 0) describe_surface(t, p, hit->length, record, surface, set);
    describe_features(t, p, record, &surface->point, set);
    if (t->layout->wanted[CHANNEL_AMBIENT_OCCLUSION] && p->ray.bounces == 0)
      occlusion_add(t, b->block, p, hit, &surface->point, set);
    goes_on = leave_vertex(t, b, 0, p, room, ray, at);
  }
  p->vertex++;
  return goes_on;
}

/* One vertex. Returns 1 if the path goes on along *ray. */
static int shade(const tracer *t, batch *b, path *p, const footprint *footprint, const reach *reach, const room *room,
                 bent_ray *ray, const bent_hit *hit, sample_record *record)
{
  if (p->ray.bounces == 0) describe_ray(t, p, hit, record);
  if (hit->fate == BENT_ESCAPED || hit->fate == BENT_ESCAPED_FAR) gather_sky(t, p, ray, hit, footprint, reach, record);
  if (hit->fate != BENT_HIT || is_holdout(t, p, hit)) return 0;
  return shade_surface(t, b, p, reach, room, ray, hit, record);
}

/* Writes what is known only at the end. A sample that broken input made NaN counts as black. */
static void finish(const tracer *t, const path *p, sample_record *record, bent_render_statistics *statistics)
{
  const vec3 L = p->radiance;
  record_vec3(record, CHANNEL_COMBINED, L);
  record->value[CHANNEL_COMBINED][3] = (float)p->alpha;
  record->value[CHANNEL_WINDING][0] = (float)p->winding;
  record->value[CHANNEL_ERROR][0] = (float)p->error;
  if (!record_make_finite(t->layout, record)) statistics->invalid++;
}

/* At the finest tolerances a curved ray takes thousands of chords, milliseconds. */
bent_status path_intersect(const tracer *t, int n, const bent_ray *rays, bent_hit *hits, bent_progress *progress,
                           bent_error *error)
{
  const int at_a_time = t->angle < 1e-6 ? 16 : 256;
  for (int begin = 0; begin < n; begin += at_a_time) {
    if (progress && atomic_load_explicit(&progress->cancel, memory_order_relaxed))
      return bent_fail(error, BENT_CANCELLED, "render: cancelled");
    const int count = n - begin < at_a_time ? n - begin : at_a_time;
    const bent_status status =
        bent_scene_intersect(t->scene, (size_t)count, rays + begin, hits + begin, NULL, error);
    if (status) return status;
  }
  return BENT_OK;
}

/* Shades the paths first .. first + count - 1, and lights them. */
static bent_status shade_batch(const tracer *t, path_block *block, int first, int count,
                               bent_render_statistics *statistics, bent_progress *progress, bent_error *error)
{
  if (block->shadow_count + 2 * DIRECT_BATCH * (DIRECT_SHADOWS_MAX + 1) > SHADOWS) {
    const bent_status status = direct_trace(t, block, statistics, progress, error);
    if (status) return status;
  }
  footprint footprints[DIRECT_BATCH];
  const bent_status measured = footprint_measure(t, count, block->paths + first, block->hits + first, footprints, progress, error);
  if (measured) return measured;
  batch b;
  b.block = block;
  b.vertex_count[0] = b.vertex_count[1] = 0;
  b.closures = t->bidirectional ? block->light->closures : NULL;
  direct_reach(t, count, block->paths + first, block->hits + first, b.reach);
  for (int k = 0; k < count; k++) {
    const int i = first + k;
    path *p = &block->paths[i];
    statistics->unresolved += block->hits[i].fate == BENT_UNRESOLVED;
    const room room = {{block->closures + k * block->lobes, block->closures + (DIRECT_BATCH + k) * block->lobes},
                       &b.exits[k]};
    block->goes_on[i] = (uint8_t)shade(t, &b, p, &footprints[k], &b.reach[k], &room, &block->rays[i], &block->hits[i],
                                       &block->records[p->record]);
  }
  for (int list = 0; list < 2; list++) direct_draw(t, block, b.vertex_count[list], b.vertices[list], statistics);
  return BENT_OK;
}

bent_status path_run(const tracer *t, path_block *block, int count, bent_render_statistics *statistics,
                     bent_progress *progress, bent_error *error)
{
  int alive = count; /* paths[0 .. alive) live; rays[i] is the next ray of paths[i] */
  block->shadow_count = block->credit_count = 0;
  while (alive > 0) {
    bent_status status = path_intersect(t, alive, block->rays, block->hits, progress, error);
    statistics->rays += (uint64_t)alive;
    for (int first = 0; first < alive && !status; first += DIRECT_BATCH)
      status = shade_batch(t, block, first, alive - first < DIRECT_BATCH ? alive - first : DIRECT_BATCH, statistics,
                           progress, error);
    if (!status) status = direct_trace(t, block, statistics, progress, error);
    if (status) return status;
    for (int i = alive - 1; i >= 0; i--) { /* the last one takes the place of one that ends */
      path *p = &block->paths[i];
      if (block->goes_on[i]) continue;
      finish(t, p, &block->records[p->record], statistics);
      if (i < --alive) *p = block->paths[alive], block->rays[i] = block->rays[alive];
    }
  }
  return BENT_OK;
}

bent_status path_trace(const tracer *t, path_block *block, int count, const pixel_sample *wanted,
                       bent_render_statistics *statistics, bent_progress *progress, bent_error *error)
{
  int alive = 0;
  if (t->bidirectional) {
    const bent_status status = light_paths_trace(t, block, count, wanted, statistics, progress, error);
    if (status) return status;
  }
  for (int i = 0; i < count; i++) block->records[i].lists = block->lists + (size_t)i * t->layout->list_total;
  for (int i = 0; i < count; i++) {
    if (block->seen) block->seen[i].kind = SEEN_NOTHING;
    path *p = &block->paths[alive];
    if (!start(t, &wanted[i], p, &block->rays[alive], &block->records[i])) continue;
    p->record = i;
    if (block->seen && motion_is_asked(t, p->sample)) motion_begin(&block->seen[i], p);
    alive++;
  }
  const bent_status status = path_run(t, block, alive, statistics, progress, error);
  if (!status && block->seen) motion_write(t, (size_t)count, block->seen, block->records);
  return status;
}
