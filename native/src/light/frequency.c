/* See frequency.h. */
#include "light/frequency.h"

#include "scene/scene.h"

/* nu just inside the rim of a lens times the lapse there, where it is 1 outside. */
static double rim_factor(const lens *l)
{
  if (isinf(l->radius)) return 1;
  const double rim[3] = {l->radius / l->scale, 0, 0};
  return bent_lapse(&l->spacetime, rim) / bent_length_scale(&l->spacetime, rim);
}

double frequency_at(const geometry *g, vec3 position)
{
  const lens *l = geometry_lens_at(g, position);
  if (!l || l->flat) return 1;
  double at[3];
  v3_to(at, mat4_point(&l->spacetime_from_world, position));
  const double lapse = bent_lapse(&l->spacetime, at);
  return lapse > 0 ? rim_factor(l) / lapse : 1;
}

/* Energy, conserved along a ray, over that which the local observer measures of light on its way against `direction`, the
 * traced ray's. */
static double energy_ratio(const geometry *g, vec3 position, vec3 direction)
{
  const lens *l = geometry_lens_at(g, position);
  if (!l || l->flat) return 1;
  const vec3 at = mat4_point(&l->spacetime_from_world, position);
  const vec3 back = mat4_vector(&l->spacetime_from_world, direction);
  double local[3];
  v3_to(local, at);
  const double around = v2_length(at.x, at.y), length = v3_length(back);
  const double along = around > 0 ? (at.y * back.x - at.x * back.y) / (around * length) : 0;
  return bent_lapse(&l->spacetime, local) * (1 + bent_zamo_speed(&l->spacetime, local) * along);
}

double frequency_ratio(const geometry *g, const frequency_leg *leg)
{
  const double ratio = energy_ratio(g, leg->to, leg->arrival) / energy_ratio(g, leg->from, leg->launch);
  return ratio > 0 && ratio < INFINITY ? ratio : 1;
}

/* From the angle swept, about half a turn for each crossing, and exactly from the sides on which the ray started and on which
 * it comes: they say whether the number is even. */
static uint32_t crossings_before(const geometry *g, const frequency_leg *leg)
{
  const lens *l = geometry_lens_at(g, leg->to);
  if (!l) return 0;
  const double height = mat4_point(&l->spacetime_from_world, leg->from).z;
  const double rises = mat4_vector(&l->spacetime_from_world, leg->launch).z;
  const int above = height > 0 || (height == 0 && rises > 0);
  const int odd = above == (mat4_vector(&l->spacetime_from_world, leg->arrival).z > 0);
  const double pairs = round((leg->swept / M_PI - 0.5 - odd) / 2);
  return 2 * (uint32_t)fmin(fmax(pairs, 0), 1e6) + (uint32_t)odd;
}

void frequency_follow(const geometry *g, const frequency_leg *leg, ray_history *ray)
{
  ray->frequency = (ray->frequency > 0 ? ray->frequency : 1) * frequency_ratio(g, leg);
  ray->image_order = crossings_before(g, leg);
}

void frequency_leave(const geometry *g, vec3 from, vec3 launch, ray_history *ray)
{
  const double ratio = 1 / energy_ratio(g, from, launch);
  ray->frequency = (ray->frequency > 0 ? ray->frequency : 1) * (ratio > 0 && ratio < INFINITY ? ratio : 1);
}

void bent_scene_shift_light(const bent_scene *scene, size_t n, const double (*from)[3], const double (*launch)[3],
                            const double (*to)[3], const double (*arrival)[3], const uint8_t *sky, double *brightness)
{
  const geometry *g = scene->geometry;
  for (size_t i = 0; i < n; i++) {
    const frequency_leg leg = {.from = v3_from(from[i]), .launch = v3_from(launch[i]), .to = v3_from(to[i]),
                               .arrival = v3_from(arrival[i])};
    ray_history ray = {.frequency = 1};
    if (sky[i]) frequency_leave(g, leg.from, leg.launch, &ray);
    else ray.frequency = frequency_ratio(g, &leg);
    brightness[i] = shading_shifted(scene->shading, v3_splat(1), &ray).x;
  }
}

int frequency_is_of_place(const geometry *g)
{
  for (size_t i = 0; i < g->lens_count; i++) {
    const lens *l = &g->lenses[i];
    if (l->flat || l->spacetime.kind != BENT_ELLIS || l->exit < 0) continue;
    const lens *exit = &g->lenses[l->exit];
    const double here = rim_factor(l) * l->scale * l->spacetime.throat_radius;
    const double there = rim_factor(exit) * exit->scale * exit->spacetime.throat_radius;
    if (fabs(here / there - 1) > 1e-6) return 0;
  }
  return 1;
}
