/* See direct.h. */
#include "render/direct.h"

#include "light/frequency.h"
#include "render/bidirectional.h"
#include "render/bsdf.h"
#include "render/describe.h"
#include "render/dimensions.h"
#include "render/light_path.h"
#include "scene/scene.h"

enum { VISIBLE_SCATTERING = BENT_VISIBLE_DIFFUSE | BENT_VISIBLE_GLOSSY | BENT_VISIBLE_TRANSMISSION };
/* Fainter images than this part of a vertex' brightest one get a shadow ray by chance only. */
static const double FAINT = 0.05;
/* What a shadow ray meets nearer than this to its target, in parts of their distance, is not before it. */
static const double SLACK = 1e-6;
/* The least chance with which a vertex is joined with a light where that is slow. */
static const double CHANCE_LEAST = 0.1;

/* What a vertex brings goes with its throughput, and so does the chance that spends an even effort on it best. The camera's
 * own vertices, whose light is seen at once, are always joined. */
double direct_chance(const tracer *t, const path *p)
{
  return t->joins_slowly && p->ray.bounces > 0 ? min2(max2(v3_max(p->beta), CHANCE_LEAST), 1) : 1;
}

vec3 direct_normal(const shade_point *point, const closure_set *set)
{
  for (int i = 0; i < set->count; i++) {
    const closure_kind kind = set->closures[i].kind;
    if (kind == CLOSURE_GLASS || kind == CLOSURE_REFRACTION || kind == CLOSURE_TRANSLUCENT) return v3(0, 0, 0);
  }
  return point->geometric_normal;
}

/* The power heuristic of Veach & Guibas (1995) for a sample of pdf `own` that could also have come with pdf `other`.
 *
 * It also keeps light beside caustics from making fireflies. Where a lamp, a hole and a vertex are in line, a connection's
 * spread goes to 0 like the distance rho of the place on the lamp from that line, and so does its pdf p: its light f / p,
 * as connections alone would have it, goes like 1 / rho, whose square has no finite mean over an area. Weighed against
 * scattering, of pdf q, it is (f / p) p^2 / (p^2 + q^2) <= f / 2q: at most half of what scattering could have brought, a
 * surface's albedo times the lamp's radiance. Lamps and suns without size have q = 0: their light is that of a true point,
 * infinite in line and, with a finite mean, of infinite variance around it. No unbiased estimate from such samples is
 * bounded; a size, which real lamps have, or clamping bounds them (path_limited: each image by itself). Rings, on which
 * the spread is 0, are left out. */
static double heuristic(double own, double other)
{
  const double ratio = other / own;
  return 1 / (1 + ratio * ratio);
}

/* ---- What scattering has met ---- */

void direct_reach(const tracer *t, int count, const path *paths, const bent_hit *hits, reach *out)
{
  const lights *lights = t->scene->lights;
  vec3 from[3][DIRECT_BATCH], to[3][DIRECT_BATCH]; /* places, the sky, the far sky */
  joint_trace traces[3][DIRECT_BATCH];
  int path_of[3][DIRECT_BATCH], n[3] = {0};
  for (int i = 0; i < count; i++) {
    const bent_hit *hit = &hits[i];
    const scattering *s = &paths[i].scattered;
    out[i] = (reach){0};
    const int weighed = s->pdf > 0 && t->settings->light_sampling != BENT_LIGHTS_SCATTERING;
    const int is_place = hit->fate == BENT_HIT && (t->bidirectional ? !paths[i].chain.sharp
                                                   : weighed && lights_draw_triangle(lights, hit->instance, hit->triangle));
    const int is_sky = weighed && (hit->fate == BENT_ESCAPED || hit->fate == BENT_ESCAPED_FAR) && lights_draw_sky(lights);
    if (!is_place && !is_sky) continue;
    const int list = is_place ? 0 : hit->fate == BENT_ESCAPED ? 1 : 2, k = n[list]++;
    from[list][k] = s->position;
    to[list][k] = v3_from(is_place ? hit->position : hit->direction);
    traces[list][k] = (joint_trace){s->direction, s->swept + hit->swept,
                                    s->first_lens < 0 ? hit->first_lens : s->first_lens, s->borders + hit->borders};
    path_of[list][k] = i;
  }
  for (int list = 0; list < 3; list++) {
    joint found[DIRECT_BATCH];
    join_traced(t->scene->geometry, (size_t)n[list], from[list], to[list], list > 0, list == 2, traces[list], found);
    for (int k = 0; k < n[list]; k++)
      if (found[k].spread > 0) {
        const int i = path_of[list][k];
        const double chance = found[k].chance * paths[i].scattered.join_chance;
        out[i] = (reach){1, found[k].weigh_spread * chance, v3_scale(found[k].weigh_cone, 1 / chance)};
      }
  }
}

/* Whether scattering finds a light as connections do. Of lights that are not for every kind of scattering it could not tell
 * by the kind of lobe that its ray was drawn from, and what does not hold a light up does hold its ray up: such lights
 * are left to connections. */
static int is_shared(uint32_t visibility, const bent_influence *influence)
{
  return (visibility & VISIBLE_SCATTERING) == VISIBLE_SCATTERING && influence->blockers == UINT64_MAX;
}

/* The weight against a connection of pdf `pdf`, by solid angle. */
static double weight_against(const tracer *t, const path *p, double pdf, uint32_t visibility,
                             const bent_influence *influence)
{
  if (t->settings->light_sampling == BENT_LIGHTS_CONNECTIONS || !is_shared(visibility, influence)) return 0;
  return heuristic(p->scattered.pdf, pdf);
}

/* Whether an emitter lights what is in a set of receivers, seen after some scatterings. */
static int is_lit(const bent_influence *influence, uint32_t receiver_set, uint32_t bounces)
{
  return influence->receivers >> receiver_set & 1 && bounces <= influence->max_bounces;
}

/* The same of what the path's ray comes from: the camera sees everything. */
static int is_lit_path(const bent_influence *influence, const path *p)
{
  return p->ray.bounces == 0 || is_lit(influence, p->scattered.receiver_set, p->ray.bounces - 1);
}

double direct_weight_emission(const tracer *t, const path *p, const reach *reach, const chain *arrived,
                              const bent_hit *hit)
{
  const instance *emitter = &t->scene->geometry->instances[hit->instance];
  if (!is_lit_path(&emitter->influence, p)) return 0;
  if (p->ray.bounces == 0) return 1;
  if (t->bidirectional && is_shared(emitter->visibility, &emitter->influence))
    return bidirectional_weight_emission(t, p, arrived, hit);
  if (!reach->joined) return 1;
  const double probability =
      lights_triangle_probability(t->scene->lights, hit->instance, hit->triangle, v3_from(hit->position),
                                  p->scattered.position, p->scattered.normal);
  if (!(probability > 0)) return 1;
  const vec3 area = lights_triangle_area(t->scene, hit->instance, hit->triangle, v3_from(hit->position));
  const double pdf = probability / fabs(v3_dot(area, reach->cone));
  return weight_against(t, p, pdf, emitter->visibility, &emitter->influence);
}

double direct_weight_sun(const tracer *t, const path *p, const reach *reach, size_t index)
{
  const sun *s = &t->scene->suns->list[index];
  if (!is_lit_path(&s->influence, p)) return 0;
  if (!reach->joined) return 1;
  const double probability = lights_sun_probability(t->scene->lights, index, p->scattered.position, p->scattered.normal);
  if (!(probability > 0)) return 1;
  return weight_against(t, p, probability / s->solid_angle * reach->spread, s->visibility, &s->influence);
}

double direct_weight_sky(const tracer *t, const path *p, const reach *reach, vec3 direction)
{
  if (!reach->joined) return 1;
  const double pdf = lights_sky_pdf(t->scene->lights, direction, p->scattered.position, p->scattered.normal);
  return pdf > 0 ? weight_against(t, p, pdf * reach->spread, VISIBLE_SCATTERING, &BENT_INFLUENCE_ALL) : 1;
}

/* ---- Connections with lights that are drawn ---- */

/* A connection with a light. */
typedef struct beam {
  double pdf; /* with which the connection was drawn, by solid angle at the vertex; of a point: its probability */
  double weigh_pdf; /* the same by the spread that it is weighed by */
  int point;
  uint32_t visibility;
  bent_influence influence;
  int asks_scattering; /* its light depends on how the ray towards it was scattered */
} beam;

static beam beam_of(const bent_scene *scene, const light_sample *s, const joint *j, double vertex_chance)
{
  const double probability = s->probability * j->chance * vertex_chance;
  beam b = {.pdf = probability * j->spread, .weigh_pdf = probability * j->weigh_spread,
            .visibility = VISIBLE_SCATTERING, .influence = BENT_INFLUENCE_ALL};
  if (s->kind == LIGHT_TRIANGLE) {
    const instance *i = &scene->geometry->instances[s->index];
    b.pdf = probability / fabs(v3_dot(s->area, j->cone));
    b.weigh_pdf = probability / fabs(v3_dot(s->area, j->weigh_cone));
    b.visibility = i->visibility;
    b.influence = i->influence;
    b.asks_scattering = shading_asks_scattering(scene->shading, geometry_material(scene->geometry, i, s->triangle));
  } else if (s->kind == LIGHT_LAMP) {
    const lamp *lamp = &scene->lamps->list[s->index];
    b.point = 1;
    b.visibility = lamp->visibility;
    b.influence = lamp->influence;
    b.asks_scattering = shading_asks_scattering(scene->shading, lamp->material);
  } else if (s->kind == LIGHT_SUN) {
    const sun *sun = &scene->suns->list[s->index];
    b.point = sun->solid_angle == 0;
    if (!b.point) b.pdf /= sun->solid_angle, b.weigh_pdf /= sun->solid_angle;
    b.visibility = sun->visibility;
    b.asks_scattering = sun->material >= 0 && shading_asks_scattering(scene->shading, sun->material);
    b.influence = sun->influence;
  } else {
    b.asks_scattering = shading_sky_asks_scattering(scene->shading);
  }
  return b;
}

/* The length of a connection with a triangle or lamp, if that shines by it. */
static double length_if_asked(const bent_scene *scene, const light_sample *s, const joint *j, vec3 from)
{
  const geometry *g = scene->geometry;
  const int material = s->kind == LIGHT_LAMP ? scene->lamps->list[s->index].material
                                             : geometry_material(g, &g->instances[s->index], s->triangle);
  return shading_asks_length(scene->shading, material) ? join_length(g, from, s->target, j) : 0;
}

/* What a triangle sends along a connection to a vertex at `from`: its frequency is shifted on the way. */
static vec3 triangle_light(const bent_scene *scene, const light_sample *s, const joint *j, vec3 from, ray_history ray)
{
  const geometry *g = scene->geometry;
  if (shading_asks_frequency(scene->shading, geometry_material(g, &g->instances[s->index], s->triangle))) {
    const frequency_leg leg = {from, j->launch, s->target, j->arrival, j->swept};
    frequency_follow(g, &leg, &ray);
  }
  return lights_radiance(scene, s, length_if_asked(scene, s, j, from), j->arrival, &ray);
}

/* What a light sends along a connection to a vertex at `from`, for a ray of that history: radiance; of a point: radiance
 * times solid angle. */
static vec3 light_along(const bent_scene *scene, const light_sample *s, const joint *j, vec3 from, ray_history ray)
{
  if (shading_shifts(scene->shading)) {
    const frequency_leg leg = {from, j->launch, s->target, j->arrival, j->swept};
    if (s->kind == LIGHT_LAMP) frequency_follow(scene->geometry, &leg, &ray);
    if (s->kind == LIGHT_SUN || s->kind == LIGHT_SKY) frequency_leave(scene->geometry, from, j->launch, &ray);
  }
  switch (s->kind) {
    case LIGHT_TRIANGLE: return triangle_light(scene, s, j, from, ray);
    case LIGHT_LAMP:
      return lamp_intensity(scene, &scene->lamps->list[s->index], v3_scale(j->arrival, -1),
                            length_if_asked(scene, s, j, from), &ray);
    case LIGHT_SUN: return sun_radiance(scene, &scene->suns->list[s->index], s->target, &ray);
    case LIGHT_SKY: return shading_sky(scene->shading, s->target, NULL, &ray);
  }
  return v3(0, 0, 0);
}

/* The light of a beam that a vertex scatters; `pdf`: the chance that scattering had drawn its direction; parts, from 0, if not
 * NULL: what lobes bring of it. A light that asks
 * how it is looked at is looked at by each kind of lobe for itself: it shines as it does on rays that scattering draws. */
static vec3 scattered_light(const tracer *t, const lit_vertex *v, const light_sample *s, const joint *j, const beam *b,
                            double *pdf, bsdf_parts *parts)
{
  static const bsdf_lobe KINDS[] = {LOBE_DIFFUSE, LOBE_GLOSSY, LOBE_TRANSMISSION};
  vec3 sum = v3(0, 0, 0);
  for (int k = 0; k < (b->asks_scattering ? 3 : 1); k++) {
    const uint32_t kinds = b->asks_scattering ? (uint32_t)KINDS[k] : UINT32_MAX;
    const vec3 value = bsdf_evaluate(&v->set, &v->surface.point, j->launch, b->visibility & kinds, pdf);
    if (!(v3_max(value) > 0)) continue;
    const ray_history ray = path_scattered(v->surface.point.ray, &v->set, KINDS[k], 0);
    const vec3 light = light_along(t->scene, s, j, v->surface.point.position, ray);
    sum = v3_add(sum, v3_mul(value, light));
    if (!parts) continue;
    const bsdf_parts own = bsdf_evaluate_parts(&v->set, &v->surface.point, j->launch, b->visibility & kinds);
    parts->diffuse = v3_add(parts->diffuse, v3_mul(own.diffuse, light));
    parts->glossy = v3_add(parts->glossy, v3_mul(own.glossy, light));
  }
  *pdf = portal_pdf(&v->mix, j->launch, *pdf);
  return sum;
}

/* The light that a vertex passes on to the camera from one connection, if nothing is in its way; the sets of what may be in
 * its way; and by what it was scattered first. */
static vec3 joined_light(const tracer *t, const path_block *block, const lit_vertex *v, const light_sample *s,
                         const joint *j, uint64_t *blockers, credit *credit)
{
  const vec3 dark = v3(0, 0, 0);
  const beam b = beam_of(t->scene, s, j, v->chance);
  *blockers = b.influence.blockers;
  const uint32_t receiver_set = t->scene->geometry->instances[v->hit->instance].receiver_set;
  if (!is_lit(&b.influence, receiver_set, v->surface.point.ray.bounces)) return dark;
  if (!(b.pdf > 0) || !isfinite(b.pdf)) return dark;
  double pdf;
  bsdf_parts parts = {.all = {0, 0, 0}};
  const int is_first = t->layout->light && v->surface.point.ray.bounces == 0;
  const vec3 value = parts.all = scattered_light(t, v, s, j, &b, &pdf, is_first ? &parts : NULL);
  if (!(v3_max(value) > 0)) return dark;
  if (is_first) parts_set(credit, &parts);
  else *credit = (struct credit){v->path->diffuse_part, v->path->glossy_part, -1};
  const int weighed =
      !b.point && t->settings->light_sampling == BENT_LIGHTS_BOTH && is_shared(b.visibility, &b.influence);
  double weight = (weighed ? heuristic(b.weigh_pdf, pdf) : 1) / b.pdf;
  if (t->bidirectional && (s->kind == LIGHT_TRIANGLE || s->kind == LIGHT_LAMP) && is_shared(b.visibility, &b.influence))
    weight = 1 / (1 / weight + b.pdf * bidirectional_rivals(t, block, v, s, j));
  weight /= s->facing;
  const vec3 light = path_limited(t, v->surface.point.ray.bounces + 1, v3_mul(v->beta, v3_scale(value, weight)));
  return v3_is_finite(light) ? light : dark;
}

bent_ray *direct_add_shadow(const tracer *t, path_block *block, const shadow *s, uint32_t visibility, vec3 direction,
                            const bent_hit *surface)
{
  const int i = block->shadow_count++;
  block->shadows[i] = *s;
  block->shadows[i].ray.kinds = RAY_SHADOW;
  block->shadows[i].ray.frequency = 0; /* is not followed */
  block->shadows[i].ray.bounces++; /* as if scattered, but by no kind of lobe */
  bent_ray *ray = &block->shadow_rays[i];
  *ray = (bent_ray){.length_max = INFINITY, .visibility = visibility};
  path_set_ray(t, ray, s->from, direction, surface);
  return ray;
}

static void add_shadow(const tracer *t, path_block *block, const lit_vertex *v, const light_sample *s, const joint *j,
                       int far, vec3 light, uint64_t blockers, int credit)
{
  const int straight = joint_is_straight(j), sky = s->kind == LIGHT_SUN || s->kind == LIGHT_SKY;
  const shadow made = {.credit = credit, .path = (int)(v->path - block->paths), .kind = s->kind, .target = s->target,
                       .instance = s->kind == LIGHT_TRIANGLE ? s->index : -1, .triangle = s->triangle,
                       .swept = j->swept, .borders = j->borders, .straight = straight, .far = far, .light = light,
                       .blockers = blockers, .from = v->surface.point.position, .ray = v->surface.point.ray};
  bent_ray *ray = direct_add_shadow(t, block, &made, BENT_SHADOW, j->launch, v->hit);
  /* In flat space it then mostly meets nothing, which is quick; past a lamp it would go on into the next lens. */
  const double end = t->scene->geometry->lens_count ? 1 : 1 - SLACK;
  if (straight && !sky) ray->length_max = end * sqrt(j->spread);
  if (block->counts) {
    const size_t target = sky ? portal_sky_home(t->scene->geometry) : portal_home(t->scene->geometry, s->target);
    const size_t cell = portal_cell(t->scene->geometry, portal_home(t->scene->geometry, v->surface.point.position), target);
    shadow *added = &block->shadows[block->shadow_count - 1];
    added->cell = cell + joint_way(j);
    block->counts[added->cell].traced++;
  }
}

/* Number of a credit that the block keeps; CREDIT_NONE if light is not told apart. */
static int keep_credit(path_block *block, const credit *credit)
{
  if (!block->credits) return CREDIT_NONE;
  block->credits[block->credit_count] = *credit;
  return block->credit_count++;
}

/* Shadows of all connections of a vertex with its light; of those that bring little by Russian roulette: less than the
 * settings' threshold, or images after the first that are faint beside the brightest. */
static void add_shadows(const tracer *t, path_block *block, const lit_vertex *v, const light_sample *s,
                        const joints *joints, int far)
{
  vec3 light[JOINTS_MAX];
  credit credits[JOINTS_MAX];
  uint64_t blockers = 0; /* one light's */
  double brightest = 0;
  const int group = t->layout->light ? parts_group(t->scene, s) : -1;
  for (int k = 0; k < joints->count; k++) {
    light[k] = joined_light(t, block, v, s, &joints->list[k], &blockers, &credits[k]);
    credits[k].group = group;
    brightest = max2(brightest, v3_max(light[k]));
  }
  for (int k = 0; k < joints->count; k++) {
    const double value = v3_max(light[k]);
    const double chance = value / max2(t->settings->light_threshold, k ? FAINT * brightest : value);
    if (!(value > 0) || joints->rest >= chance) continue;
    light[k] = v3_scale(light[k], 1 / (min2(chance, 1) * joints->list[k].way_chance));
    if (!blockers)
      path_receive(t, v->path, &block->records[v->path->record], &credits[k], v->surface.point.ray.bounces + 1, light[k]);
    else
      add_shadow(t, block, v, s, &joints->list[k], far, light[k], blockers, keep_credit(block, &credits[k]));
  }
}

void direct_count_joins(bent_render_statistics *statistics, size_t n, const joints *found)
{
  for (size_t i = 0; i < n; i++) {
    statistics->joins += (uint64_t)found[i].wanted;
    statistics->lost_joins += (uint64_t)found[i].lost;
  }
}

void direct_draw(const tracer *t, path_block *block, int count, const lit_vertex *vertices, bent_render_statistics *statistics)
{
  if (!count) return;
  if (t->bidirectional) bidirectional_connect(t, block, count, vertices, statistics);
  const bent_scene *scene = t->scene;
  light_sample sample[DIRECT_BATCH];
  vec3 from[2][DIRECT_BATCH], to[2][DIRECT_BATCH]; /* to places, to the sky */
  double u[2][DIRECT_BATCH];
  const double *chances[2][DIRECT_BATCH]; /* of ways that are mostly blocked */
  int vertex_of[2][DIRECT_BATCH], n[2] = {0};
  for (int i = 0; i < count; i++) {
    const lit_vertex *v = &vertices[i];
    if (!lights_draw(scene->lights, scene, v->surface.point.position, direct_normal(&v->surface.point, &v->set), v->u, &sample[i]))
      continue;
    const int list = sample[i].kind == LIGHT_SUN || sample[i].kind == LIGHT_SKY;
    from[list][n[list]] = v->surface.point.position;
    to[list][n[list]] = sample[i].target;
    u[list][n[list]] = v->u[LIGHT_IMAGES];
    chances[list][n[list]] = portal_way_chances(scene, &v->mix, list, sample[i].target);
    vertex_of[list][n[list]++] = i;
  }
  for (int pass = 0; pass < 3; pass++) { /* places, the sky, the far sky */
    const int list = pass > 0, far = pass == 2;
    joints found[DIRECT_BATCH];
    if (!n[list] || (far && !join_has_far_sky(scene->geometry))) continue;
    join_by_chance(scene->geometry, (size_t)n[list], from[list], to[list], u[list], chances[list], list, far, found);
    direct_count_joins(statistics, (size_t)n[list], found);
    for (int k = 0; k < n[list]; k++) {
      const int i = vertex_of[list][k];
      add_shadows(t, block, &vertices[i], &sample[i], &found[k], far);
    }
  }
}

/* ---- Shadows ---- */

/* Whether a surface that a shadow ray has met stands before its target. */
static int is_before(const shadow *s, const bent_ray *ray, const bent_hit *hit)
{
  if (s->kind == LIGHT_SUN || s->kind == LIGHT_SKY) return 1;
  if (hit->borders != s->borders) return hit->borders < s->borders;
  const double left = s->swept - hit->swept;
  if (fabs(left) > 0.1) return left > 0;
  /* the rest of the way is nearly straight */
  if (hit->instance == s->instance && hit->triangle == s->triangle) return 0;
  const vec3 to = v3_sub(s->target, v3_from(hit->position)), way = v3_sub(s->target, v3_from(ray->origin));
  const double slack = SLACK * v3_length(way) + (s->straight ? 0 : 4 * ray->tolerance);
  return v3_dot(to, v3_from(hit->direction)) > slack;
}

/* Whether a shadow ray that has met nothing has come to where its target is. */
static int arrives(const shadow *s, const bent_hit *hit)
{
  if (s->credit == CREDIT_OCCLUSION) return 1; /* no surface is near, wherever the ray ends */
  if (hit->fate == BENT_UNRESOLVED) return 0;
  if (s->kind == LIGHT_SUN || s->kind == LIGHT_SKY) return hit->fate == (s->far ? BENT_ESCAPED_FAR : BENT_ESCAPED);
  return hit->borders >= s->borders; /* behind a target it may end as it likes */
}

vec3 direct_transmitted(const bent_scene *scene, const bent_hit *hit, double length, const ray_history *ray, closure *room)
{
  surface surface;
  surface_at(scene, hit, length, &surface);
  surface.point.ray = *ray;
  if (surface.see_through || scene->geometry->instances[hit->instance].visibility & BENT_IMMATERIAL) return v3_splat(1);
  vec3 sum = v3(0, 0, 0);
  if (!shading_may_be_transparent(scene->shading, surface.material)) return sum;
  closure_set set = {.closures = room};
  shading_evaluate(scene->shading, surface.material, &surface.point, &set);
  for (int i = 0; i < set.count; i++)
    if (set.closures[i].kind == CLOSURE_TRANSPARENT) sum = v3_add(sum, set.closures[i].weight);
  return sum;
}

/* A shadow's light has come to where it goes. */
static void deliver(const tracer *t, path_block *block, const shadow *s)
{
  if (s->path < 0) {
    light_image_add(t, s->image, s->light);
    return;
  }
  path *p = &block->paths[s->path];
  sample_record *record = &block->records[p->record];
  if (s->credit == CREDIT_OCCLUSION) record_add(record, CHANNEL_AMBIENT_OCCLUSION, s->light);
  else path_receive(t, p, record, block->credits + (s->credit >= 0 ? s->credit : 0), s->ray.bounces, s->light);
}

/* One step of a shadow; returns 1 if it goes on along *ray behind a surface that it could see through. */
static int shadow_step(const tracer *t, path_block *block, shadow *s, bent_ray *ray, const bent_hit *hit)
{
  if (hit->fate != BENT_HIT || !is_before(s, ray, hit)) {
    if (hit->fate != BENT_HIT && !arrives(s, hit)) return 0;
    deliver(t, block, s);
    if (block->counts) block->counts[s->cell].arrived++;
    return 0;
  }
  if (s->path < 0 && t->scene->geometry->instances[hit->instance].visibility & BENT_HOLDOUT) return 0;
  if (s->blockers >> t->scene->geometry->instances[hit->instance].blocker_set & 1) {
    if (s->ray.transparent >= t->settings->transparent_bounces) return 0;
    s->light = v3_mul(s->light, direct_transmitted(t->scene, hit, s->length + hit->length, &s->ray, block->closures));
    s->ray.transparent++;
  }
  if (!(v3_max(s->light) > 0)) return 0;
  s->length += hit->length;
  s->swept -= hit->swept;
  s->borders -= hit->borders;
  ray->length_max -= hit->length;
  if (!(ray->length_max >= 0)) ray->length_max = 0;
  ray->length_min = max2(ray->length_min - hit->length, 0);
  path_set_ray(t, ray, v3_from(hit->position), v3_from(hit->direction), hit);
  return 1;
}

bent_status direct_trace(const tracer *t, path_block *block, bent_render_statistics *statistics, bent_progress *progress,
                         bent_error *error)
{
  while (block->shadow_count > 0) {
    const int count = block->shadow_count;
    const bent_status status = path_intersect(t, count, block->shadow_rays, block->shadow_hits, progress, error);
    if (status) return status;
    statistics->rays += (uint64_t)count;
    block->shadow_count = 0;
    for (int i = 0; i < count; i++) {
      const int kept = block->shadow_count;
      statistics->unresolved += block->shadow_hits[i].fate == BENT_UNRESOLVED;
      if (!shadow_step(t, block, &block->shadows[i], &block->shadow_rays[i], &block->shadow_hits[i])) continue;
      block->shadows[kept] = block->shadows[i], block->shadow_rays[kept] = block->shadow_rays[i];
      block->shadow_count++;
    }
  }
  block->credit_count = 0;
  return BENT_OK;
}
