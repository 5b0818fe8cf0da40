/* See parts.h. */
#include "render/parts.h"

#include "render/describe.h"
#include "scene/labels.h"
#include "scene/scene.h"

/* What two parts leave of 1; 0 if that is no more than rounding. */
static double rest(double a, double b)
{
  const double left = 1 - a - b;
  return left > 1e-14 ? left : 0;
}

void parts_add(const channel_layout *layout, sample_record *record, const credit *c, uint32_t bounces, vec3 light)
{
  if (c->group >= 0 && (uint32_t)c->group < layout->list_length[CHANNEL_LIGHT_GROUPS] / 3) {
    float *sum = record_list(record, layout, CHANNEL_LIGHT_GROUPS) + 3 * c->group;
    sum[0] += (float)light.x, sum[1] += (float)light.y, sum[2] += (float)light.z;
  }
  if (!bounces) return;
  const int later = bounces > 1;
  const vec3 through = v3(rest(c->diffuse.x, c->glossy.x), rest(c->diffuse.y, c->glossy.y), rest(c->diffuse.z, c->glossy.z));
  record_add(record, CHANNEL_DIFFUSE_DIRECT + later, v3_mul(light, c->diffuse));
  record_add(record, CHANNEL_GLOSSY_DIRECT + later, v3_mul(light, c->glossy));
  record_add(record, CHANNEL_TRANSMISSION_DIRECT + later, v3_mul(light, through));
}

int parts_group(const bent_scene *scene, const light_sample *s)
{
  switch (s->kind) {
    case LIGHT_TRIANGLE: return labels_instance(scene->labels, s->index).light_group;
    case LIGHT_LAMP: return labels_lamp_group(scene->labels, s->index);
    case LIGHT_SUN: return labels_sun_group(scene->labels, s->index);
    case LIGHT_SKY: return labels_world_group(scene->labels);
  }
  return -1;
}

static double part(double own, double all) { return all > 0 ? min2(own / all, 1) : 0; }
static vec3 part_of(vec3 own, vec3 all) { return v3(part(own.x, all.x), part(own.y, all.y), part(own.z, all.z)); }

void parts_set(credit *credit, const bsdf_parts *parts)
{
  credit->diffuse = part_of(parts->diffuse, parts->all);
  credit->glossy = part_of(parts->glossy, parts->all);
}

void parts_of_scattering(const closure_set *set, const shade_point *point, const bsdf_sample *drawn, uint32_t kinds,
                         credit *out)
{
  if (!(drawn->pdf > 0)) {
    out->diffuse = v3(0, 0, 0);
    out->glossy = v3_splat(drawn->lobe == LOBE_GLOSSY);
    return;
  }
  const bsdf_parts parts = bsdf_evaluate_parts(set, point, drawn->wi, kinds);
  parts_set(out, &parts);
}

void parts_add_colors(sample_record *record, const shade_point *point, const closure_set *set, vec3 beta)
{
  for (int i = 0; i < set->count; i++) {
    const closure *c = &set->closures[i];
    if (c->kind == CLOSURE_TRANSPARENT) continue;
    if (bsdf_is_diffuse_part(c)) {
      record_add(record, CHANNEL_DIFFUSE_COLOR, v3_mul(beta, c->weight));
      continue;
    }
    vec3 reflected, transmitted;
    bsdf_albedo_parts(c, point, &reflected, &transmitted);
    record_add(record, CHANNEL_GLOSSY_COLOR, v3_mul(beta, reflected));
    record_add(record, CHANNEL_TRANSMISSION_COLOR, v3_mul(beta, transmitted));
  }
}
