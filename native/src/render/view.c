/* See view.h. */
#include "render/view.h"

#include "render/bsdf.h"
#include "render/direct.h"
#include "scene/scene.h"

void view_at(const tracer *t, const bent_hit *hit, vec3 wo, closure *closures, view *out)
{
  bent_hit looked_at = *hit;
  v3_to(looked_at.direction, v3_scale(wo, -1));
  surface surface;
  surface_at(t->scene, &looked_at, 0, &surface);
  surface.point.footprint = path_footprint(t, surface.point.position);
  *out = (view){.point = surface.point, .set = {.closures = closures}, .see_through = surface.see_through};
  shading_evaluate(t->scene->shading, surface.material, &out->point, &out->set);
  if (t->settings->portal_sampling)
    out->mix = portal_mix_at(t->scene, out->point.position, direct_normal(&out->point, &out->set), &out->set);
}

chain_back view_back(const view *v, vec3 wi)
{
  double pdf;
  bsdf_evaluate(&v->set, &v->point, wi, 0, &pdf);
  return (chain_back){portal_pdf(&v->mix, wi, pdf), v->set.count > v->set.delta_count};
}
