/* See describe.h. The rules are those of Cycles, so that passes and denoisers see what they are used to. */
#include "render/describe.h"

#include "render/bsdf.h"
#include "scene/scene.h"

void record_vec3(sample_record *record, channel channel, vec3 value)
{
  float *out = record->value[channel];
  out[0] = (float)value.x, out[1] = (float)value.y, out[2] = (float)value.z;
}

void record_add(sample_record *record, channel channel, vec3 value)
{
  float *out = record->value[channel];
  out[0] += (float)value.x, out[1] += (float)value.y, out[2] += (float)value.z;
}

/* Mean normal of the lobes for which `wanted` is nonzero, by their share of the light. */
static vec3 mean_normal(const shade_point *point, const closure_set *set, int (*wanted)(const closure *))
{
  vec3 sum = v3(0, 0, 0);
  for (int i = 0; i < set->count; i++)
    if (wanted(&set->closures[i])) sum = v3_mad(set->closures[i].normal, set->closures[i].share, sum);
  return v3_dot(sum, sum) > 0 ? v3_normalize(sum) : point->normal;
}

static int is_opaque(const closure *c) { return c->kind != CLOSURE_TRANSPARENT; }

/* Sharp reflections and refractions show what lies behind; denoising wants to see that (Cycles: alpha 0.075). */
static int is_rough(const closure *c)
{
  return is_opaque(c) && (!closure_is_microfacet(c) || c->alpha * c->alpha_y > 0.075 * 0.075);
}

void describe_surface(const tracer *t, path *path, double length, sample_record *record, const shade_point *point,
                      const closure_set *set)
{
  if (path->described) return;
  double transparency = 0;
  for (int i = 0; i < set->count; i++)
    if (!is_opaque(&set->closures[i])) transparency += v3_average(set->closures[i].weight);
  if (transparency > 0 && 1 - transparency < t->settings->alpha_threshold) return;
  path->described = 1;
  record->value[CHANNEL_DEPTH][0] = (float)((path->travelled + length) * path->depth_per_length);
  record_vec3(record, CHANNEL_POSITION, point->position);
  record_vec3(record, CHANNEL_NORMAL, mean_normal(point, set, is_opaque));
}

void describe_features(const tracer *t, path *path, sample_record *record, const shade_point *point,
                       const closure_set *set)
{
  if (path->featured) return;
  record_add(record, CHANNEL_DENOISING_ALBEDO, v3_mul(path->feature_beta, set->emission));
  double rough = 0, all = 0;
  for (int i = 0; i < set->count; i++) {
    all += set->closures[i].share;
    if (is_rough(&set->closures[i])) rough += set->closures[i].share;
  }
  if (all > 0 && 4 * rough <= all) return;
  path->featured = 1;
  record_add(record, CHANNEL_DENOISING_ALBEDO, v3_mul(path->feature_beta, bsdf_albedo(set)));
  vec3 normal = camera_from_world_direction(t->scene->camera, mean_normal(point, set, is_rough));
  normal.z = -normal.z; /* Cycles' camera space looks along +z */
  record_vec3(record, CHANNEL_DENOISING_NORMAL, normal);
}
