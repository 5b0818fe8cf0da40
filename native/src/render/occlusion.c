/* See occlusion.h. */
#include "render/occlusion.h"

#include "base/turn.h"
#include "render/describe.h"
#include "render/dimensions.h"

void occlusion_add(const tracer *t, path_block *block, const path *p, const bent_hit *hit, const shade_point *point,
                   const closure_set *set)
{
  vec3 let_through = v3(0, 0, 0), x, y;
  for (int i = 0; i < set->count; i++)
    if (set->closures[i].kind == CLOSURE_TRANSPARENT) let_through = v3_add(let_through, set->closures[i].weight);
  const vec3 light = v3_mul(p->beta, v3_saturate(v3_sub(v3_splat(1), let_through)));
  const vec3 normal = describe_normal(point, set);
  double u[SAMPLER_DIMENSIONS], sine, cosine;
  sampler_draw(&t->sampler, p->pixel, p->sample, dimensions_occlusion(p->vertex), u);
  turn_sincos(u[1], &sine, &cosine);
  v3_basis(normal, &x, &y);
  const double across = sqrt(u[0]);
  const vec3 direction = v3_normalize(v3_mad(x, across * cosine, v3_mad(y, across * sine, v3_scale(normal, sqrt(1 - u[0])))));
  if (!(v3_max(light) > 0) || v3_dot(direction, point->geometric_normal) <= 0) return;
  const shadow made = {.credit = CREDIT_OCCLUSION, .path = (int)(p - block->paths), .kind = LIGHT_SKY, .instance = -1,
                       .light = light, .blockers = UINT64_MAX, .from = point->position, .ray = point->ray};
  direct_add_shadow(t, block, &made, BENT_SHADOW, direction, hit)->length_max = t->settings->occlusion_distance;
}
