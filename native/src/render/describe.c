/* See describe.h. The rules are those of Cycles, so that passes and denoisers see what they are used to. */
#include "render/describe.h"

#include <math.h>

#include "geometry/geometry.h"
#include "render/bsdf.h"
#include "render/motion_vector.h"
#include "render/parts.h"
#include "scene/disk_seen.h"
#include "scene/labels.h"
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

vec3 describe_normal(const shade_point *point, const closure_set *set) { return mean_normal(point, set, is_opaque); }

/* Sharp reflections and refractions show what lies behind; denoising wants to see that (Cycles: alpha 0.075). */
static int is_rough(const closure *c)
{
  return is_opaque(c) && (!closure_is_microfacet(c) || c->alpha * c->alpha_y > 0.075 * 0.075);
}

/* The hole that a disk lies around, however far the disk reaches out of its sphere: it stands where the disk's object does. */
static const lens *hole_of_disk(const geometry *g, const shade_point *point)
{
  const vec3 center = point->world_from_object ? mat4_point(point->world_from_object, v3(0, 0, 0)) : v3(0, 0, 0);
  const lens *nearest = NULL;
  for (size_t i = 0; i < g->lens_count; i++) {
    const lens *l = &g->lenses[i];
    if (l->flat) continue;
    if (!nearest || v3_length(v3_sub(l->center, center)) < v3_length(v3_sub(nearest->center, center))) nearest = l;
  }
  return nearest;
}

/* Frequency at the camera over that of what a surface emits: a disk's matter moves, all else is at rest. */
static double frequency_shift(const bent_scene *scene, const shade_point *point)
{
  const double rest = point->ray.frequency > 0 ? point->ray.frequency : 1;
  if (!labels_instance(scene->labels, point->instance).is_disk) return rest;
  const lens *hole = hole_of_disk(scene->geometry, point);
  if (!hole) return rest;
  const bent_spacetime *s = &hole->spacetime;
  const disk_view seen = disk_look(point, s->mass, s->spin / s->mass, s->chart == BENT_CHART_ISOTROPIC);
  return seen.doppler * seen.gravitational;
}

/* What extra channels tell of the surface that stands for the pixel. */
static void describe_more(const tracer *t, sample_record *record, const surface *surface)
{
  const shade_point *point = &surface->point;
  if (point->corner_uvs) record_vec3(record, CHANNEL_UV, v3(point->uv[0], point->uv[1], 1));
  record->value[CHANNEL_OBJECT_INDEX][0] = point->object_index;
  record->value[CHANNEL_MATERIAL_INDEX][0] = labels_material(t->scene->labels, surface->material).index;
  if (t->layout->wanted[CHANNEL_FREQUENCY_SHIFT])
    record->value[CHANNEL_FREQUENCY_SHIFT][0] = (float)frequency_shift(t->scene, point);
}

/* 0 to 1 by the length of the way, as Blender's mist rises. */
static double mist_at(const bent_render_settings *s, double length)
{
  const double start = s->mist_start, way = length - start;
  const double part = s->mist_depth > 0 ? min2(max2(way / s->mist_depth, 0), 1) : way > 0;
  return s->mist_falloff == 1 ? part : pow(part, s->mist_falloff);
}

/* What is weighed by how much of the camera's view ends on a surface. */
static void describe_share(const tracer *t, const path *path, double length, sample_record *record,
                           const surface *surface, const closure_set *set, double share)
{
  if (t->layout->light) parts_add_colors(record, &surface->point, set, path->beta);
  if (!(share > 0)) return;
  record->value[CHANNEL_MIST][0] -= (float)(share * (1 - mist_at(t->settings, path->travelled + length)));
  if (!t->layout->mattes) return;
  const bent_instance_label instance = labels_instance(t->scene->labels, surface->point.instance);
  const float names[] = {instance.object, labels_material(t->scene->labels, surface->material).name, instance.asset};
  for (int i = 0; i < 3; i++) {
    const channel c = CHANNEL_MATTE_OBJECT + i;
    matte_add(record_list(record, t->layout, c), t->layout->list_length[c] / 2, names[i], (float)share);
  }
}

void describe_surface(const tracer *t, path *path, double length, sample_record *record, const surface *surface,
                      const closure_set *set)
{
  const shade_point *point = &surface->point;
  vec3 let_through = v3(0, 0, 0);
  for (int i = 0; i < set->count; i++)
    if (!is_opaque(&set->closures[i])) let_through = v3_add(let_through, set->closures[i].weight);
  const double transparency = v3_average(let_through);
  if (t->layout->extras)
    describe_share(t, path, length, record, surface, set, v3_average(path->beta) * (1 - transparency));
  if (path->described || (transparency > 0 && 1 - transparency < t->settings->alpha_threshold)) return;
  path->described = 1;
  record->value[CHANNEL_DEPTH][0] = (float)((path->travelled + length) * path->depth_per_length);
  record_vec3(record, CHANNEL_POSITION, point->position);
  record_vec3(record, CHANNEL_NORMAL, describe_normal(point, set));
  if (t->layout->extras) describe_more(t, record, surface);
  if (path->seen) motion_see_surface(t, path->seen, surface, M_PI * path->winding);
}

aov_sink describe_aovs(const tracer *t, const sample_record *record)
{
  return (aov_sink){record_list(record, t->layout, CHANNEL_AOVS), t->layout->list_length[CHANNEL_AOVS] / 4};
}

void describe_sky(const tracer *t, const path *path, const bent_hit *hit, const ray_history *history, sample_record *record)
{
  if (path->described) return;
  record->value[CHANNEL_FREQUENCY_SHIFT][0] = history->frequency > 0 ? (float)history->frequency : 1;
  const aov_sink aovs = describe_aovs(t, record);
  const vec3 direction = v3_from(hit->direction);
  if (aovs.count) shading_sky_aovs(t->scene->shading, direction, history, &aovs);
  if (path->seen) motion_see_sky(path->seen, direction, hit->fate == BENT_ESCAPED_FAR, M_PI * path->winding);
}

void describe_way(const tracer *t, const path *path, double length, sample_record *record)
{
  if (!t->layout->extras || path->featured) return;
  record->value[CHANNEL_DENOISING_DEPTH][0] += (float)(length * v3_average(path->feature_beta));
}

/* What the lobes that end a feature's way scatter. As in Cycles the others, which let see on, have no part in it. */
static vec3 rough_albedo(const closure_set *set)
{
  vec3 sum = v3(0, 0, 0);
  for (int i = 0; i < set->count; i++)
    if (is_rough(&set->closures[i])) sum = v3_add(sum, set->closures[i].albedo);
  return v3_saturate(sum);
}

void describe_features(const tracer *t, path *path, sample_record *record, const shade_point *point, const closure_set *set)
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
  record_add(record, CHANNEL_DENOISING_ALBEDO, v3_mul(path->feature_beta, rough_albedo(set)));
  vec3 normal = camera_from_world_direction(t->scene->camera, mean_normal(point, set, is_rough));
  normal.z = -normal.z; /* Cycles' camera space looks along +z */
  record_vec3(record, CHANNEL_DENOISING_NORMAL, normal);
}
