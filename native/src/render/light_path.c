/* See light_path.h. */
#include "render/light_path.h"

#include <stdlib.h>

#include "geometry/geometry.h"
#include "light/frequency.h"
#include "render/aperture.h"
#include "render/dimensions.h"
#include "render/direct.h"
#include "scene/scene.h"

/* A subpath on its way. */
struct light_walk {
  vec3 flux;        /* before the first scattering: what transparent surfaces leave of it */
  double reference; /* the largest component of the flux that it started with, which roulette compares with */
  chain chain;
  light_sample start;
  double chance; /* of the lamp */
  joint_trace trace; /* since the last scattering */
  double length;     /* since then */
  vec3 from;
  ray_history history; /* as in light_vertex */
  sampler_pixel pixel;
  uint32_t sample, vertex, scatterings;
  int index; /* of the sample in its batch */
};

/* Subpaths have random numbers of their own. */
static const uint32_t SEED_SALT = 0x6c8e9cf5u;
enum { VERTICES_MAX = 1 << 14 }; /* as of camera paths */

light_paths *light_paths_new(int capacity, int lobes)
{
  const size_t n = (size_t)capacity;
  light_paths *paths = calloc(1, sizeof *paths);
  if (!paths) return NULL;
  paths->last = malloc(n * sizeof *paths->last);
  paths->length = malloc(n * sizeof *paths->length);
  paths->walks = malloc(n * sizeof *paths->walks);
  paths->rays = malloc(n * sizeof *paths->rays);
  paths->hits = malloc(n * sizeof *paths->hits);
  paths->closures = malloc(LIGHT_VIEWS * (size_t)lobes * sizeof *paths->closures);
  if (paths->last && paths->length && paths->walks && paths->rays && paths->hits && paths->closures) return paths;
  light_paths_free(paths);
  return NULL;
}

void light_paths_free(light_paths *paths)
{
  if (!paths) return;
  free(paths->list);
  free(paths->last);
  free(paths->length);
  free(paths->walks);
  free(paths->rays);
  free(paths->hits);
  free(paths->closures);
  free(paths);
}

/* ---- The image ---- */

void light_image_add(const tracer *t, const double image[2], vec3 light)
{
  const bent_render_settings *s = t->settings;
  const double x = image[0] * s->width, y = image[1] * s->height, reach = t->filter.half_width;
  const double colors[3] = {light.x, light.y, light.z};
  const int left = (int)max2(ceil(x - reach - 0.5), 0), right = (int)min2(floor(x + reach - 0.5), s->width - 1.0);
  const int low = (int)max2(ceil(y - reach - 0.5), 0), high = (int)min2(floor(y + reach - 0.5), s->height - 1.0);
  for (int j = low; j <= high; j++) {
    for (int i = left; i <= right; i++) {
      const double weight = filter_density(&t->filter, x - i - 0.5) * filter_density(&t->filter, y - j - 0.5);
      int64_t *pixel = t->light[(size_t)j * s->width + (size_t)i];
      for (int k = 0; k < 3; k++) {
        const double value = min2(weight * colors[k] / BENT_LIGHT_UNIT, 0x1p62);
        if (value > 0) __atomic_fetch_add(&pixel[k], (int64_t)(value + 0.5), __ATOMIC_RELAXED);
      }
    }
  }
}

/* ---- Vertices ---- */

chain light_vertex_chain(const tracer *t, const light_vertex *v, const view *seen)
{
  chain c = v->chain;
  if (v->first) {
    const vec3 normal = direct_normal(&seen->point, &seen->set);
    c.once *= chain_squared(lights_place_probability(t->scene->lights, &v->start, seen->point.position, normal));
  }
  return c;
}

int light_path_allowed(const tracer *t, ray_history camera, const light_vertex *v, const view *seen, double u)
{
  ray_history all = camera;
  all.bounces += v->history.bounces;
  all.diffuse += v->history.diffuse;
  all.glossy += v->history.glossy;
  all.transmission += v->history.transmission;
  bsdf_sample drawn;
  if (!v->first) {
    if (!bsdf_drawn(&seen->set, &seen->point, v3_scale(v3_from(v->hit.direction), -1), u, &drawn)) return 0;
    all = path_scattered(all, &seen->set, drawn.lobe, 0);
  }
  return !path_is_last(t->settings, &all) && all.bounces <= lights_start_bounces(t->scene, &v->start) &&
         camera.transparent + v->history.transparent <= t->settings->transparent_bounces;
}

/* Returns 0 only when out of memory. */
static int push(light_paths *paths, const light_vertex *v, int sample)
{
  if (paths->count == paths->capacity) {
    const size_t capacity = paths->capacity ? 2 * paths->capacity : 1024;
    light_vertex *list = realloc(paths->list, capacity * sizeof *list);
    if (!list) return 0;
    paths->list = list;
    paths->capacity = capacity;
  }
  light_vertex *added = &paths->list[paths->count];
  *added = *v;
  added->previous = paths->last[sample];
  paths->last[sample] = (int)paths->count++;
  paths->length[sample]++;
  return 1;
}

/* ---- Joining with the camera ---- */

/* The numbers that a vertex is joined by. */
typedef struct joining {
  double images; /* how many of them */
  double lobe;   /* a kind of it */
  double lens[2];
} joining;

static joining joining_at(const tracer *t, const light_walk *w, const double u[SAMPLER_DIMENSIONS])
{
  joining j = {.images = u[0], .lobe = u[1]};
  const bent_aperture *aperture = &t->scene->camera->settings.aperture;
  if (aperture->radius == 0) return j;
  double place[SAMPLER_DIMENSIONS];
  sampler_draw(&t->sampler, w->pixel, w->sample, dimensions_subpath_lens(w->vertex), place);
  aperture_draw(aperture, place, j.lens);
  return j;
}

/* What one joint brings from a light vertex to a place on the lens, and where in the image; 0 if nothing. */
static vec3 light_to_camera(const tracer *t, const light_paths *paths, const light_vertex *v, const joint *j, double u,
                            const double lens[2], double image[2], camera_ray *ray)
{
  const vec3 dark = v3(0, 0, 0);
  const camera *camera = t->scene->camera;
  double solid_angle;
  if (!camera_project(camera, lens, j->launch, image, &solid_angle)) return dark;
  const double margin = t->filter.half_width;
  if (fabs(image[0] - 0.5) * t->settings->width > 0.5 * t->settings->width + margin ||
      fabs(image[1] - 0.5) * t->settings->height > 0.5 * t->settings->height + margin ||
      !camera_cast_lens(camera, image[0], image[1], lens, ray))
    return dark;
  view seen;
  const vec3 wi = v3_scale(v3_from(v->hit.direction), -1);
  view_at(t, &v->hit, v3_scale(j->arrival, -1), paths->closures, &seen);
  if (seen.see_through) return dark;
  double pdf;
  const vec3 value = bsdf_evaluate(&seen.set, &seen.point, wi, UINT32_MAX, &pdf);
  if (!(v3_max(value) > 0) || !light_path_allowed(t, (ray_history){.kinds = 0}, v, &seen, u)) return dark;
  const double cosine = view_cosine(&seen.point, j->arrival);
  const chain c = light_vertex_chain(t, v, &seen);
  const double density = cosine / (solid_angle * j->spread); /* with which the camera's rays come here, by area */
  const double rivals = chain_squared(density / j->chance) * chain_sum(&c, (chain_back){portal_pdf(&seen.mix, wi, pdf), 1});
  const double weight = density / (v->cosine * j->chance * (1 + rivals));
  const vec3 light = path_limited(t, v->history.bounces + 2 - (uint32_t)v->first, v3_mul(v->flux, v3_scale(value, weight)));
  return v3_is_finite(light) ? light : dark;
}

/* Joins the vertices from number `first` on, at most DIRECT_BATCH, with the camera, each with a place on the lens of its own. */
static void join_camera(const tracer *t, path_block *block, size_t first, const joining *u,
                        bent_render_statistics *statistics)
{
  const light_paths *paths = block->light;
  vec3 from[DIRECT_BATCH], to[DIRECT_BATCH];
  double images[DIRECT_BATCH];
  joints found[DIRECT_BATCH];
  const size_t count = paths->count - first;
  if (!camera_has_inverse(t->scene->camera)) return;
  for (size_t i = 0; i < count; i++) {
    from[i] = camera_lens_position(t->scene->camera, u[i].lens);
    to[i] = v3_from(paths->list[first + i].hit.position);
    images[i] = u[i].images;
  }
  join_points(t->scene->geometry, count, from, to, images, found);
  direct_count_joins(statistics, count, found);
  for (size_t i = 0; i < count; i++) {
    const light_vertex *v = &paths->list[first + i];
    const uint32_t visibility = t->scene->geometry->instances[v->hit.instance].visibility;
    if (!(visibility & BENT_VISIBLE_CAMERA) || visibility & BENT_HOLDOUT) continue;
    for (int k = 0; k < found[i].count; k++) {
      const joint *j = &found[i].list[k];
      camera_ray camera;
      double image[2];
      vec3 light = light_to_camera(t, paths, v, j, u[i].lobe, u[i].lens, image, &camera);
      const double chance = min2(v3_max(light) / t->settings->light_threshold, 1); /* faint light by roulette */
      if (!(v3_max(light) > 0) || found[i].rest >= chance) continue;
      light = v3_scale(light, 1 / chance);
      const double length = join_length(t->scene->geometry, from[i], to[i], j);
      if (length < camera.length_min || length > camera.length_max) continue;
      const shadow s = {.credit = CREDIT_NONE, .path = -1, .image = {image[0], image[1]}, .kind = LIGHT_TRIANGLE, .target = to[i],
                        .instance = v->hit.instance, .triangle = v->hit.triangle, .swept = j->swept,
                        .borders = j->borders, .straight = joint_is_straight(j), .light = v3_scale(light, 1 / j->way_chance), .blockers = UINT64_MAX,
                        .from = from[i], .ray = v->history};
      bent_ray *ray = direct_add_shadow(t, block, &s, BENT_VISIBLE_CAMERA, j->launch, NULL);
      ray->length_min = camera.length_min;
      ray->length_max = joint_is_straight(j) ? length : camera.length_max;
    }
  }
}

/* ---- Walks ---- */

static void start(const tracer *t, const pixel_sample *wanted, int index, light_walk *w, bent_ray *ray)
{
  const lights *lights = t->scene->lights;
  const sampler_pixel pixel = sampler_pixel_at(&t->sampler, t->settings->seed ^ SEED_SALT, wanted->x, wanted->y);
  double place[SAMPLER_DIMENSIONS], towards[SAMPLER_DIMENSIONS];
  sampler_draw(&t->sampler, pixel, wanted->sample, dimensions_start_place(), place);
  sampler_draw(&t->sampler, pixel, wanted->sample, dimensions_start_direction(), towards);
  *w = (light_walk){.flux = {1, 1, 1}, .pixel = pixel, .sample = wanted->sample, .index = index};
  w->chance = lights_draw_start(lights, t->scene, place, &w->start);
  const vec3 direction = lights_draw_direction(lights, &w->start, towards);
  w->from = w->start.target;
  w->trace = (joint_trace){direction, 0, -1, 0};
  const bent_hit lamp = {.instance = w->start.kind == LIGHT_TRIANGLE ? w->start.index : -1,
                         .triangle = w->start.kind == LIGHT_TRIANGLE ? w->start.triangle : -1};
  *ray = (bent_ray){.length_max = INFINITY, .visibility = BENT_VISIBLE_DIFFUSE};
  path_set_ray(t, ray, w->from, direction, &lamp);
}

/* How the camera sees what shines, by whatever path: without spin the shift of frequency is one of the two places. */
static ray_history seen_from_camera(const tracer *t, vec3 place, vec3 direction)
{
  ray_history ray = RAY_SCATTERED;
  const frequency_leg leg = {.from = t->eye, .launch = direction, .to = place, .arrival = direction};
  if (t->asks_frequency) ray.frequency = frequency_ratio(t->scene->geometry, &leg);
  return ray;
}

/* What the lamp sends towards the first vertex, so far away, becomes the subpath's flux, and the chain begins. Returns 0 if nothing. */
static int shine(const tracer *t, light_walk *w, double length)
{
  const vec3 out = w->trace.launch;
  const double pdf = lights_direction_pdf(t->scene->lights, &w->start, out);
  double cosine = 1, area = 1;
  vec3 light;
  const ray_history seen = seen_from_camera(t, w->start.target, out);
  if (w->start.kind == LIGHT_LAMP) {
    const lamp *lamp = &t->scene->lamps->list[w->start.index];
    light = lamp_intensity(t->scene, lamp, out, length, &seen);
  } else {
    area = v3_length(w->start.area);
    cosine = fabs(v3_dot(w->start.area, out)) / area;
    light = lights_radiance(t->scene, &w->start, length, v3_scale(out, -1), &seen);
  }
  const double density = w->chance / area; /* of the place */
  const vec3 flux = v3_scale(light, cosine / (density * pdf));
  w->reference = v3_max(flux);
  w->flux = v3_mul(w->flux, flux);
  w->chain = (chain){.pdf = pdf, .frequency = frequency_at(t->scene->geometry, w->from),
                     .carried = w->start.kind == LIGHT_LAMP ? 0 : chain_squared(cosine / density)};
  return w->reference > 0 && isfinite(w->reference) && pdf > 0;
}

/* Lets the subpath go straight on behind a surface. */
static void pass_through(const tracer *t, light_walk *w, bent_ray *ray, const bent_hit *hit)
{
  w->length += hit->length;
  w->trace.swept += hit->swept;
  w->trace.borders += hit->borders;
  if (w->trace.first_lens < 0) w->trace.first_lens = hit->first_lens;
  path_set_ray(t, ray, v3_from(hit->position), v3_from(hit->direction), hit);
}

/* Whether a drawn transparent surface lets the subpath through, as the camera sees it from the other side. */
static int is_let_through(const tracer *t, light_walk *w, const bent_hit *hit, const view *in, closure *closures)
{
  view out;
  double chance, unused;
  view_at(t, hit, v3_from(hit->direction), closures, &out);
  bsdf_transparency(&in->set, &chance);
  w->flux = v3_mul(w->flux, v3_scale(bsdf_transparency(&out.set, &unused), 1 / ((1 - in->mix.chance) * chance)));
  return v3_is_finite(w->flux) && v3_max(w->flux) > 0 && w->history.transparent++ < t->settings->transparent_bounces;
}

/* An event by a lobe: flux, chain and history. `in` is the view from the last vertex. Returns 0 if the camera does not see
 * such an event. */
static int scatter(const tracer *t, light_walk *w, const bent_hit *hit, const view *in, const bsdf_sample *drawn,
                   double cosine, double u, closure *closures)
{
  view out;
  const vec3 wi = v3_scale(v3_from(hit->direction), -1);
  view_at(t, hit, drawn->wi, closures, &out);
  if (out.see_through) return 0;
  const double cosine_out = view_cosine(&out.point, drawn->wi);
  const int sharp = !(drawn->pdf > 0);
  bsdf_lobe lobe;
  vec3 flux;
  chain_back back = {1, 0};
  if (sharp) {
    const bsdf_sharp seen = bsdf_evaluate_sharp(&out.set, &out.point, wi);
    const bsdf_sharp own = bsdf_evaluate_sharp(&in->set, &in->point, drawn->wi);
    if (!(seen.chance > 0 && own.chance > 0)) return 0;
    flux = v3_scale(seen.flux, 1 / (own.chance * (1 - in->mix.chance)));
    lobe = seen.through ? LOBE_TRANSMISSION : LOBE_GLOSSY;
  } else {
    bsdf_sample seen;
    if (!bsdf_drawn(&out.set, &out.point, wi, u, &seen)) return 0;
    flux = v3_scale(seen.weight, seen.pdf / drawn->pdf);
    lobe = seen.lobe;
    back = (chain_back){portal_pdf(&out.mix, wi, seen.pdf), 1};
  }
  const int first = w->scatterings++ == 0;
  chain c = w->chain;
  if (first && !sharp) {
    const light_vertex v = {.chain = w->chain, .start = w->start, .first = 1};
    c = light_vertex_chain(t, &v, &out);
  }
  chain_leave(&c, sharp ? 1 : drawn->pdf, cosine_out, sharp, back);
  w->chain = c;
  if (!first) w->history = path_scattered(w->history, &out.set, lobe, sharp);
  w->flux = v3_mul(w->flux, v3_scale(flux, cosine_out / cosine));
  return v3_is_finite(w->flux) && v3_max(w->flux) > 0 && cosine_out > 0;
}

static int survives(const tracer *t, light_walk *w, double u)
{
  if (w->scatterings < t->settings->roulette_start) return 1;
  const double probability = sqrt(v3_max(w->flux) / w->reference);
  if (probability >= 1) return 1;
  if (!(u < probability)) return 0;
  w->flux = v3_scale(w->flux, 1 / probability);
  return 1;
}

/* Arrival at a surface that scatters. Returns 0 if no light arrives. */
static int arrive(const tracer *t, light_walk *w, const bent_hit *hit, double spread, double cosine)
{
  const vec3 position = v3_from(hit->position);
  const double frequency = frequency_at(t->scene->geometry, position);
  const int first = w->scatterings == 0;
  if (first && !shine(t, w, w->length + hit->length)) return 0;
  w->flux = v3_scale(w->flux, chain_squared(w->chain.frequency / frequency));
  w->chain = chain_arrive(&w->chain, frequency, cosine, first ? spread / w->chance : spread);
  return 1;
}

/* Goes on along a drawn direction. */
static int go_on(const tracer *t, light_walk *w, bent_ray *ray, const bent_hit *hit, vec3 direction)
{
  w->from = v3_from(hit->position);
  w->trace = (joint_trace){direction, 0, -1, 0};
  w->length = 0;
  path_set_ray(t, ray, w->from, direction, hit);
  return 1;
}

/* What one round asks of a surface: the spread of the arc there, and where to note numbers for joining with the camera. */
typedef struct meeting {
  const bent_hit *hit;
  double spread;
  joining *joinings; /* of the vertices that the round adds */
  size_t first;      /* the first such vertex */
} meeting;

/* A surface that scatters. Returns 1 if the subpath goes on along *ray, -1 when out of memory. */
static int meet_scatterer(const tracer *t, light_paths *paths, int lobes, light_walk *w, bent_ray *ray, const meeting *m)
{
  view in;
  const bent_hit *hit = m->hit;
  const vec3 travel = v3_from(hit->direction);
  view_at(t, hit, v3_scale(travel, -1), paths->closures, &in);
  const double cosine = view_cosine(&in.point, travel);
  light_walk arrived = *w;
  if (in.see_through || !(cosine > 0) || !arrive(t, &arrived, hit, m->spread, cosine)) return 0;
  double u[SAMPLER_DIMENSIONS], v[SAMPLER_DIMENSIONS];
  sampler_draw(&t->sampler, w->pixel, w->sample, dimensions_subpath(w->vertex), u);
  sampler_draw(&t->sampler, w->pixel, w->sample, dimensions_subpath_joints(w->vertex), v);
  if (in.set.count > in.set.delta_count) {
    const light_vertex vertex = {.hit = *hit, .flux = arrived.flux, .cosine = cosine, .chain = arrived.chain,
                                 .start = w->start, .history = w->history, .first = w->scatterings == 0};
    if (!push(paths, &vertex, w->index)) return -1;
    m->joinings[paths->count - 1 - m->first] = joining_at(t, w, v);
  }
  bsdf_sample drawn;
  closure *room = paths->closures + lobes;
  if (!portal_draw(&in.mix, &in.set, &in.point, u, &drawn)) return 0;
  if (drawn.lobe == LOBE_TRANSPARENT) {
    pass_through(t, w, ray, hit);
    return is_let_through(t, w, hit, &in, room);
  }
  if (drawn.lobe == LOBE_SUBSURFACE) return 0; /* such ways are left to the camera's paths */
  *w = arrived;
  return scatter(t, w, hit, &in, &drawn, cosine, v[2], room) && survives(t, w, u[3]) && go_on(t, w, ray, hit, drawn.wi);
}

/* One surface or end; returns as meet_scatterer. */
static int meet(const tracer *t, light_paths *paths, int lobes, light_walk *w, bent_ray *ray, const meeting *m)
{
  const bent_hit *hit = m->hit;
  if (hit->fate != BENT_HIT || w->vertex >= VERTICES_MAX) return 0;
  if (!path_can_leave(t, v3_from(hit->position)) || path_is_last(t->settings, &w->history)) return 0;
  const instance *instance = &t->scene->geometry->instances[hit->instance];
  const int immaterial = instance->visibility & BENT_IMMATERIAL;
  int goes_on;
  view back; /* as the camera's ray meets it on the way back */
  if (instance->one_sided || immaterial) view_at(t, hit, v3_from(hit->direction), paths->closures, &back);
  if (immaterial || (instance->one_sided && back.see_through)) {
    pass_through(t, w, ray, hit);
    const int counts = !back.see_through && v3_max(back.set.emission) > 0;
    goes_on = !counts || w->history.transparent++ < t->settings->transparent_bounces;
  } else {
    goes_on = meet_scatterer(t, paths, lobes, w, ray, m);
  }
  w->vertex++;
  return goes_on;
}

/* The spreads of the arcs that so many subpaths have traced, times their chance; 0 where no joint is known for one. */
static void find_spreads(const tracer *t, int count, const light_walk *walks, const bent_hit *hits, double *out)
{
  vec3 from[DIRECT_BATCH], to[DIRECT_BATCH];
  joint_trace traces[DIRECT_BATCH];
  joint found[DIRECT_BATCH];
  int which[DIRECT_BATCH], n = 0;
  for (int i = 0; i < count; i++) {
    const bent_hit *hit = &hits[i];
    const light_walk *w = &walks[i];
    out[i] = 0;
    if (hit->fate != BENT_HIT || w->chain.sharp) continue;
    from[n] = w->from, to[n] = v3_from(hit->position);
    traces[n] = (joint_trace){w->trace.launch, w->trace.swept + hit->swept,
                              w->trace.first_lens < 0 ? hit->first_lens : w->trace.first_lens,
                              w->trace.borders + hit->borders};
    which[n++] = i;
  }
  join_traced(t->scene->geometry, (size_t)n, from, to, 0, 0, traces, found);
  for (int k = 0; k < n; k++) out[which[k]] = found[k].spread > 0 ? found[k].spread * found[k].chance : 0;
}

/* The subpaths first .. first + count - 1 of those in flight; goes_on[i] says which live. */
static bent_status meet_batch(const tracer *t, path_block *block, int first, int count, uint8_t *goes_on,
                              bent_render_statistics *statistics, bent_progress *progress, bent_error *error)
{
  light_paths *paths = block->light;
  double spreads[DIRECT_BATCH];
  joining joinings[DIRECT_BATCH];
  const size_t before = paths->count;
  find_spreads(t, count, paths->walks + first, paths->hits + first, spreads);
  for (int k = 0; k < count; k++) {
    const int i = first + k;
    const meeting m = {&paths->hits[i], spreads[k], joinings, before};
    const int fate = meet(t, paths, block->lobes, &paths->walks[i], &paths->rays[i], &m);
    if (fate < 0) return bent_fail(error, BENT_ERROR_MEMORY, "render: out of memory");
    goes_on[i] = (uint8_t)fate;
    statistics->unresolved += paths->hits[i].fate == BENT_UNRESOLVED;
  }
  join_camera(t, block, before, joinings, statistics);
  return direct_trace(t, block, statistics, progress, error);
}

bent_status light_paths_trace(const tracer *t, path_block *block, int count, const pixel_sample *wanted,
                              bent_render_statistics *statistics, bent_progress *progress, bent_error *error)
{
  light_paths *paths = block->light;
  int alive = 0;
  paths->count = 0;
  block->shadow_count = 0;
  for (int i = 0; i < count; i++) {
    paths->last[i] = -1, paths->length[i] = 0;
    if (!lights_any_start(t->scene->lights)) continue;
    start(t, &wanted[i], i, &paths->walks[alive], &paths->rays[alive]);
    alive++;
  }
  while (alive > 0) {
    bent_status status = path_intersect(t, alive, paths->rays, paths->hits, progress, error);
    statistics->rays += (uint64_t)alive;
    for (int first = 0; first < alive && !status; first += DIRECT_BATCH)
      status = meet_batch(t, block, first, alive - first < DIRECT_BATCH ? alive - first : DIRECT_BATCH, block->goes_on,
                          statistics, progress, error);
    if (status) return status;
    int kept = 0;
    for (int i = 0; i < alive; i++) {
      if (!block->goes_on[i]) continue;
      if (kept != i) paths->walks[kept] = paths->walks[i], paths->rays[kept] = paths->rays[i];
      kept++;
    }
    alive = kept;
  }
  return BENT_OK;
}
