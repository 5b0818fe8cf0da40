/* See gather.h. */
#include "render/gather.h"

#include "light/frequency.h"
#include "render/describe.h"
#include "scene/labels.h"
#include "scene/scene.h"

vec3 path_limited(const tracer *t, uint32_t bounces, vec3 contribution)
{
  const double limit = 3 * (bounces > 1 ? t->settings->clamp_indirect : t->settings->clamp_direct);
  const double sum = contribution.x + contribution.y + contribution.z;
  return limit > 0 && sum > limit ? v3_scale(contribution, limit / sum) : contribution;
}

void path_receive(const tracer *t, path *p, sample_record *record, const credit *credit, uint32_t bounces, vec3 light)
{
  p->radiance = v3_add(p->radiance, light);
  if (t->layout->light) parts_add(t->layout, record, credit, bounces, light);
}

/* A ray in the sky. */
typedef struct sky_view {
  const bent_ray *ray;
  const reach *reach;
  vec3 direction; /* asymptotic */
  ray_history history;
} sky_view;

/* What a sun shows there; *weighed: its weight against connections with it. */
static vec3 see_sun(const tracer *t, const path *p, const sky_view *v, size_t index, double *weight)
{
  const sun *s = &t->scene->suns->list[index];
  *weight = 0;
  if (!(s->visibility & v->ray->visibility) || !sun_covers(s, v->direction)) return v3(0, 0, 0);
  *weight = direct_weight_sun(t, p, v->reach, index);
  return sun_radiance(t->scene, s, v->direction, &v->history);
}

/* Tells apart what the sky and the suns bring; of_sky: the sky's own part, weighed; all: of all together. */
static void tell_sky_apart(const tracer *t, const path *p, const sky_view *v, vec3 of_sky, vec3 all, sample_record *record)
{
  const vec3 whole = v3_mul(p->beta, all);
  const double limit = v3_max(whole) > 0 ? v3_max(path_limited(t, p->ray.bounces, whole)) / v3_max(whole) : 1;
  const vec3 scale = v3_scale(p->beta, limit);
  credit credit = {p->diffuse_part, p->glossy_part, labels_world_group(t->scene->labels)};
  parts_add(t->layout, record, &credit, p->ray.bounces, v3_mul(scale, of_sky));
  for (size_t i = 0; t->scene->suns && i < t->scene->suns->count; i++) {
    double weight;
    const vec3 radiance = see_sun(t, p, v, i, &weight);
    credit.group = labels_sun_group(t->scene->labels, (int)i);
    if (weight > 0) parts_add(t->layout, record, &credit, p->ray.bounces, v3_mul(scale, v3_scale(radiance, weight)));
  }
}

/* One sky surrounds both sides of a wormhole that has no exit. */
void gather_sky(const tracer *t, path *p, const bent_ray *ray, const bent_hit *hit, const footprint *footprint,
                const reach *reach, sample_record *record)
{
  sky_view view = {ray, reach, v3_from(hit->direction), p->ray};
  if (t->asks_frequency) frequency_leave(t->scene->geometry, p->scattered.position, p->scattered.direction, &view.history);
  if (t->layout->extras && p->ray.bounces == 0) describe_sky(t, p, hit, &view.history, record);
  const vec3 sky = shading_sky(t->scene->shading, view.direction, footprint->known ? footprint->across : NULL, &view.history);
  const vec3 of_sky = v3_scale(sky, direct_weight_sky(t, p, reach, view.direction));
  vec3 all = sky, weighed = of_sky;
  for (size_t i = 0; t->scene->suns && i < t->scene->suns->count; i++) {
    double weight;
    const vec3 radiance = see_sun(t, p, &view, i, &weight);
    all = v3_add(all, radiance);
    weighed = v3_mad(radiance, weight, weighed);
  }
  const vec3 contribution = path_limited(t, p->ray.bounces, v3_mul(p->beta, weighed));
  if (!p->featured) record_add(record, CHANNEL_DENOISING_ALBEDO, v3_mul(p->feature_beta, all));
  if (p->ray.bounces == 0) {
    record_add(record, CHANNEL_ENVIRONMENT, contribution);
    if (t->settings->film_transparent) {
      p->alpha -= v3_average(p->beta);
      return;
    }
  }
  if (t->layout->light) tell_sky_apart(t, p, &view, of_sky, weighed, record);
  p->radiance = v3_add(p->radiance, contribution);
}

void gather_emission(const tracer *t, path *p, const arrival *at, vec3 emission, sample_record *record)
{
  if (!(v3_max(emission) > 0)) return;
  const vec3 weighed = v3_scale(emission, direct_weight_emission(t, p, at->reach, &at->chain, at->hit));
  const vec3 contribution = path_limited(t, p->ray.bounces, v3_mul(p->beta, weighed));
  const int instance = at->hit->instance;
  const credit credit = {p->diffuse_part, p->glossy_part, labels_instance(t->scene->labels, instance).light_group};
  path_receive(t, p, record, &credit, p->ray.bounces, contribution);
  if (p->ray.bounces) return;
  record_add(record, CHANNEL_EMISSION, contribution);
  if (t->layout->wanted[CHANNEL_DISK_ONLY] && labels_instance(t->scene->labels, instance).is_disk)
    record_add(record, CHANNEL_DISK_ONLY, contribution);
}
