/* See bidirectional.h. */
#include "render/bidirectional.h"

#include "geometry/geometry.h"
#include "light/frequency.h"
#include "render/dimensions.h"
#include "render/light_path.h"
#include "render/view.h"
#include "scene/scene.h"

const char *bent_scene_bidirectional_obstacle(const bent_scene *scene)
{
  const geometry *g = scene->geometry;
  for (size_t i = 0; i < g->lens_count; i++)
    if (!g->lenses[i].flat && g->lenses[i].spacetime.kind == BENT_KERR && g->lenses[i].spacetime.spin != 0)
      return "a black hole spins";
  if (!frequency_is_of_place(g)) return "a wormhole's mouths are of different size";
  for (size_t i = 0; i < g->instance_count; i++) {
    const uint32_t v = g->instances[i].visibility, scattering = BENT_VISIBLE_ALL & ~BENT_VISIBLE_CAMERA;
    if (v & BENT_IMMATERIAL || !is_seen(g, &g->instances[i])) continue;
    if ((v & scattering) != scattering || v & BENT_SHADOWLESS)
      return "an object is hidden from some kinds of ray, or casts no shadow";
  }
  return shading_any_asks_history(scene->shading) ? "a material asks for a ray's history (Light Path, image order)" : NULL;
}

/* ---- The chain ---- */

chain bidirectional_start(const tracer *t, vec3 direction)
{
  const double middle[2] = {0, 0}; /* any place on the lens has the same solid angle */
  double image[2], solid_angle = 0;
  camera_project(t->scene->camera, middle, direction, image, &solid_angle);
  return (chain){.pdf = solid_angle > 0 ? 1 / solid_angle : 1, .sharp = !(solid_angle > 0),
                 .frequency = frequency_at(t->scene->geometry, t->eye)};
}

chain bidirectional_begin(const tracer *t, vec3 position)
{
  return (chain){.frequency = frequency_at(t->scene->geometry, position)};
}

chain bidirectional_arrive(const tracer *t, const path *p, const shade_point *point, double spread)
{
  return chain_arrive(&p->chain, frequency_at(t->scene->geometry, point->position), view_cosine(point, point->wo), spread);
}

void bidirectional_leave(const tracer *t, chain *c, const bent_hit *hit, const shade_point *point,
                         const bsdf_sample *drawn, closure *closures)
{
  view from_light;
  view_at(t, hit, drawn->wi, closures, &from_light);
  const int sharp = !(drawn->pdf > 0);
  chain_back back = view_back(&from_light, point->wo);
  if (sharp) back.pdf = bsdf_evaluate_sharp(&from_light.set, &from_light.point, point->wo).chance > 0;
  if (from_light.see_through) back = (chain_back){0, 0};
  chain_leave(c, sharp ? 1 : drawn->pdf, view_cosine(point, drawn->wi), sharp, back);
}

/* ---- Weights of light that is met or drawn ---- */

double bidirectional_weight_emission(const tracer *t, const path *p, const chain *arrived, const bent_hit *hit)
{
  const lights *lights = t->scene->lights;
  const vec3 position = v3_from(hit->position);
  const light_sample place = {.kind = LIGHT_TRIANGLE, .index = hit->instance, .triangle = hit->triangle,
                              .target = position,
                              .area = lights_triangle_area(t->scene, hit->instance, hit->triangle, position)};
  const double drawn = lights_place_probability(lights, &place, p->scattered.position, p->scattered.normal);
  const double started = lights_start_chance(lights, LIGHT_TRIANGLE, hit->instance, hit->triangle) *
                         lights_direction_pdf(lights, &place, v3_scale(v3_from(hit->direction), -1));
  const double rivals = chain_squared(drawn) * arrived->once + chain_squared(started) * arrived->more;
  return 1 / (1 + rivals / v3_dot(place.area, place.area));
}

double bidirectional_rivals(const tracer *t, const path_block *block, const lit_vertex *v, const light_sample *s,
                            const joint *j)
{
  const double started = lights_start_chance(t->scene->lights, s->kind, s->index, s->triangle);
  if (!(started > 0)) return 0;
  view from_light;
  view_at(t, v->hit, j->launch, block->light->closures, &from_light);
  if (from_light.see_through) return 0;
  const double to_light = chain_squared(v->chain.frequency / frequency_at(t->scene->geometry, s->target));
  const double reverse_spread = j->spread / to_light;
  const double density = lights_direction_pdf(t->scene->lights, s, v3_scale(j->arrival, -1)) *
                         view_cosine(&v->surface.point, j->launch) / reverse_spread; /* with which light comes here, by area */
  return chain_squared(started / (s->probability * j->chance) * density) *
         chain_sum(&v->chain, view_back(&from_light, v->surface.point.wo));
}

/* ---- Connections with light subpaths ---- */

/* A vertex of the light subpath that belongs to a path's sample, and the numbers for joining them; NULL if it has none. The
 * subpath's other vertices might have been taken: *count is their number. */
static const light_vertex *choose(const tracer *t, const path_block *block, const lit_vertex *at, int *count,
                                  double u[SAMPLER_DIMENSIONS])
{
  const light_paths *light = block->light;
  const path *p = at->path;
  *count = light->length[p->record];
  if (!*count) return NULL;
  sampler_draw(&t->sampler, p->pixel, p->sample, dimensions_connection(at->vertex), u);
  const light_vertex *v = &light->list[light->last[p->record]];
  for (int skip = (int)(u[0] * *count); skip > 0; skip--) v = &light->list[v->previous];
  return v;
}

/* What a connection brings to the camera if nothing is in its way, but for the chance of having chosen the light vertex; 0
 * if that is less than `least`. u picks a kind of lobe. */
static vec3 connected_light(const tracer *t, const path_block *block, const lit_vertex *v, const light_vertex *l,
                            const joint *j, const double u[2], double least)
{
  closure *const room = block->light->closures;
  const vec3 dark = v3(0, 0, 0), to_lamp = v3_scale(v3_from(l->hit.direction), -1), back = v3_scale(j->arrival, -1);
  bsdf_sample here, there; /* as if drawn */
  view seen, from_light, from_lamp;
  if (!bsdf_drawn(&v->set, &v->surface.point, j->launch, u[0], &here)) return dark;
  view_at(t, &l->hit, back, room, &seen);
  if (seen.see_through || !bsdf_drawn(&seen.set, &seen.point, to_lamp, 0, &there)) return dark;
  if (!light_path_allowed(t, path_scattered(v->surface.point.ray, &v->set, here.lobe, 0), l, &seen, u[1])) return dark;
  const double cosine = view_cosine(&v->surface.point, j->launch), far_cosine = view_cosine(&seen.point, j->arrival);
  const double geometry = far_cosine / (j->spread * l->cosine * j->chance);
  const vec3 scattered = v3_mul(v3_scale(here.weight, here.pdf), v3_scale(there.weight, there.pdf));
  const vec3 unweighed = v3_scale(v3_mul(v3_mul(v->beta, l->flux), scattered), geometry);
  if (!(v3_max(unweighed) >= least)) return dark;
  view_at(t, v->hit, j->launch, room + block->lobes, &from_light);
  view_at(t, &l->hit, to_lamp, room + 2 * block->lobes, &from_lamp);
  const double reverse = j->spread / chain_squared(v->chain.frequency / l->chain.frequency);
  const double from_camera = portal_pdf(&v->mix, j->launch, here.pdf) * far_cosine / j->spread; /* densities by area */
  const double from_start = view_back(&from_lamp, back).pdf * cosine / reverse;
  const chain far_chain = light_vertex_chain(t, l, &seen);
  const double rivals =
      chain_squared(from_start / j->chance) * chain_sum(&v->chain, view_back(&from_light, v->surface.point.wo)) +
      chain_squared(from_camera / j->chance) *
          chain_sum(&far_chain, (chain_back){portal_pdf(&seen.mix, to_lamp, there.pdf), 1});
  const vec3 light = v3_scale(unweighed, 1 / (1 + rivals));
  return v3_is_finite(light) ? light : dark;
}

/* The joints of a vertex with its light vertex get shadows, the faint ones by chance. */
static void add_connections(const tracer *t, path_block *block, const lit_vertex *v, const light_vertex *l, int choices,
                            const joints *joints, const double u[SAMPLER_DIMENSIONS])
{
  const uint32_t bounces = v->surface.point.ray.bounces + l->history.bounces + 3 - (uint32_t)l->first;
  for (int k = 0; k < joints->count; k++) {
    const joint *j = &joints->list[k];
    const double least = joints->rest * t->settings->light_threshold / choices; /* less does not survive the roulette below */
    vec3 light = v3_scale(connected_light(t, block, v, l, j, (const double[2]){u[2], u[3]}, least), choices);
    light = path_limited(t, bounces, light);
    const double value = v3_max(light), chance = value / max2(t->settings->light_threshold, value);
    if (!(value > 0) || joints->rest >= chance) continue;
    ray_history history = v->surface.point.ray;
    history.transparent += l->history.transparent;
    const shadow s = {.credit = CREDIT_NONE, .path = (int)(v->path - block->paths), .kind = LIGHT_TRIANGLE, .target = v3_from(l->hit.position),
                      .instance = l->hit.instance, .triangle = l->hit.triangle, .swept = j->swept,
                      .borders = j->borders, .straight = joint_is_straight(j), .light = v3_scale(light, 1 / (chance * j->way_chance)),
                      .blockers = UINT64_MAX, .from = v->surface.point.position, .ray = history};
    direct_add_shadow(t, block, &s, BENT_SHADOW, j->launch, v->hit)->length_max =
        joint_is_straight(j) ? sqrt(j->spread) : INFINITY;
  }
}

void bidirectional_connect(const tracer *t, path_block *block, int count, const lit_vertex *vertices,
                           bent_render_statistics *statistics)
{
  vec3 from[DIRECT_BATCH], to[DIRECT_BATCH];
  double images[DIRECT_BATCH], u[DIRECT_BATCH][SAMPLER_DIMENSIONS];
  const light_vertex *light[DIRECT_BATCH];
  joints found[DIRECT_BATCH];
  int which[DIRECT_BATCH], choices[DIRECT_BATCH], n = 0;
  for (int i = 0; i < count; i++) {
    light[n] = choose(t, block, &vertices[i], &choices[n], u[n]);
    if (!light[n]) continue;
    from[n] = vertices[i].surface.point.position, to[n] = v3_from(light[n]->hit.position);
    images[n] = u[n][1];
    which[n++] = i;
  }
  if (!n) return;
  join_points(t->scene->geometry, (size_t)n, from, to, images, found);
  direct_count_joins(statistics, (size_t)n, found);
  for (int k = 0; k < n; k++) add_connections(t, block, &vertices[which[k]], light[k], choices[k], &found[k], u[k]);
}
