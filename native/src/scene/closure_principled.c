/* The Principled BSDF as a stack of layers. Each adds its lobe and lets through what is left for those below.
 *
 * From the top: opacity, sheen, coat, emission, metal, glass, specular, diffuse. The model is that of Blender 4.5 and 5.0.
 */
#include <stddef.h>

#include "scene/closure_build.h"
#include "scene/fresnel.h"
#include "scene/microfacet_energy.h"

/* What a layer that takes `albedo` leaves of `weight`: gray, by the channel that it takes most of, so that it does not
 * color the layers below by what it reflects. */
static vec3 layer_below(vec3 weight, vec3 albedo)
{
  const double most = max2(max2(weight.x > 0 ? albedo.x / weight.x : 0, weight.y > 0 ? albedo.y / weight.y : 0),
                           weight.z > 0 ? albedo.z / weight.z : 0);
  return v3_scale(weight, saturate(1 - most));
}

/* Completes a dielectric reflection whose reflectance starts at f0. Returns what it takes from the layers below. */
static vec3 finish_dielectric(closure_set *set, closure *c, const shade_point *point, double ior, vec3 f0,
                              const thin_film *film, int multiscatter)
{
  c->fresnel = FRESNEL_TINTED;
  c->ior = ior;
  c->f0 = f0;
  const vec3 fss = v3_mix(f0, v3_splat(1), fresnel_rise(fresnel_average(ior), ior));
  closure_put_film(c, film);
  if (c->fresnel != FRESNEL_TINTED) /* there is no table of rough films; as Cycles */
    return closure_finish_reflection(set, c, point, closure_reflectance(c, point), fss, multiscatter);
  const double mu = saturate(v3_dot(c->normal, point->wo));
  const double rise = closure_is_delta(c) ? fresnel_rise(fresnel_dielectric(mu, ior, NULL), ior)
                                          : microfacet_fresnel_rise(closure_roughness(c), mu, ior);
  return closure_finish_reflection(set, c, point, v3_mix(f0, v3_splat(1), rise), fss, multiscatter);
}

/* Its fibers stand on the coat where there is one. */
static vec3 principled_sheen(closure_set *set, const shade_point *point, vec3 weight, const principled *p)
{
  const sheen_layer *sheen = p->sheen;
  const double amount = sheen ? saturate(sheen->weight) : 0;
  if (amount == 0) return weight;
  vec3 normal = closure_valid_normal(point, p->normal);
  if (p->coat) normal = v3_mix(normal, closure_valid_normal(point, p->coat->normal), saturate(p->coat->weight));
  return layer_below(weight, closure_add_sheen(set, point, v3_scale(weight, amount), sheen->tint, sheen->roughness,
                                               normal));
}

/* Makes up for multiple scattering whatever the distribution. The tint is the color of light that goes straight down
 * through the coat and up again; its thickness is 1. */
static vec3 principled_coat(closure_set *set, const shade_point *point, vec3 weight, const principled *p)
{
  const coat_layer *coat = p->coat;
  if (!coat) return weight;
  const double amount = saturate(coat->weight), ior = min2(max2(coat->ior, 1), 1e3);
  closure unused[1];
  closure_set left_out = {.closures = unused}; /* the coat still tints if it must not reflect */
  closure *c = closure_next_microfacet(point->no_reflection ? &left_out : set, CLOSURE_REFLECTION, point,
                                       v3_scale(weight, amount), coat->roughness, coat->normal);
  if (!c) return weight;
  const double sine2 = 1 - squared(v3_dot(c->normal, point->wo));
  const double path = 1 / sqrt(max2(1 - sine2 / squared(ior), 1e-6));
  if (!point->no_reflection)
    weight = layer_below(weight, finish_dielectric(set, c, point, ior, v3_splat(fresnel_f0(ior)), NULL, 1));
  const vec3 tint = v3_positive(coat->tint), through = v3(pow(tint.x, path), pow(tint.y, path), pow(tint.z, path));
  return v3_positive(v3_mul(weight, v3_mix(v3_splat(1), through, amount)));
}

static vec3 principled_metal(closure_set *set, const shade_point *point, vec3 weight, const principled *p)
{
  const double metallic = saturate(p->metallic);
  if (metallic == 0) return weight;
  if (point->no_reflection) return v3_scale(weight, 1 - metallic);
  closure *c = closure_next_microfacet(set, CLOSURE_REFLECTION, point, v3_scale(weight, metallic), p->roughness,
                                       p->normal);
  if (c) {
    closure_stretch_along(c, &p->stretch);
    closure_finish_metal(set, c, point, v3_saturate(p->base_color), v3_saturate(p->specular_tint), p->film,
                         p->multiscatter);
  }
  return v3_scale(weight, 1 - metallic);
}

static vec3 principled_glass(closure_set *set, const shade_point *point, vec3 weight, const principled *p)
{
  const double transmission = saturate(p->transmission), roughness = saturate(p->roughness);
  if (transmission == 0) return weight;
  const vec3 color = v3_saturate(p->base_color);
  const int left_out = point->no_reflection && point->no_refraction;
  closure *c = left_out ? NULL : closure_next_microfacet(set, CLOSURE_GLASS, point, v3_scale(weight, transmission),
                                                         roughness, p->normal);
  if (c) {
    c->fresnel = FRESNEL_TINTED;
    c->ior = closure_ior_beyond(point, p->ior);
    c->f0 = v3_saturate(v3_scale(v3_positive(p->specular_tint), fresnel_f0(c->ior)));
    c->transmission_color = v3(sqrt(color.x), sqrt(color.y), sqrt(color.z));
    closure_put_glass_film(c, point, p->film, p->ior);
    closure_finish_glass(set, c, point, c->transmission_color, p->multiscatter);
  }
  return v3_scale(weight, 1 - transmission);
}

/* The IOR by which the surface reflects, after its specular level; *f0: that reflectance. */
static double specular_ior(const principled *p, double *f0)
{
  const double eta = min2(max2(p->ior, 1e-3), 1e3);
  *f0 = fresnel_f0(eta);
  if (p->specular_level == 0.5) return eta;
  *f0 *= 2 * positive(p->specular_level);
  return eta < 1 ? 1 / fresnel_ior(*f0) : fresnel_ior(*f0);
}

static vec3 principled_specular(closure_set *set, const shade_point *point, vec3 weight, const principled *p, double eta,
                                double f0)
{
  if ((eta == 1 && !film_exists(p->film)) || point->no_reflection) return weight;
  closure *c = closure_next_microfacet(set, CLOSURE_REFLECTION, point, weight, p->roughness, p->normal);
  if (!c) return weight;
  closure_stretch_along(c, &p->stretch);
  const vec3 color = v3_saturate(v3_scale(v3_positive(p->specular_tint), f0));
  return layer_below(weight, finish_dielectric(set, c, point, eta, color, p->film, p->multiscatter));
}

/* Below all layers: a diffuse surface, and in its place what is below the surface. */
static void principled_base(closure_set *set, const shade_point *point, vec3 weight, const principled *p, double eta)
{
  double amount = 0;
  if (p->subsurface) {
    subsurface s = *p->subsurface;
    amount = saturate(s.weight);
    s.alpha = squared(saturate(p->roughness));
    if (s.method != SUBSURFACE_SKIN) s.ior = eta;
    closure_add_subsurface(set, point, weight, p->base_color, &s, p->normal);
  }
  closure_add_diffuse(set, point, v3_scale(weight, 1 - amount), p->base_color, p->diffuse_roughness, p->normal);
}

/* What is above emission: the weight that is left for it and the layers below. */
static vec3 principled_upper_layers(closure_set *set, const shade_point *point, vec3 weight, const principled *p)
{
  weight = v3_scale(v3_positive(weight), saturate(p->alpha));
  return principled_coat(set, point, principled_sheen(set, point, weight, p), p);
}

static void add_emission(closure_set *set, vec3 weight, const principled *p)
{
  const vec3 emission = v3_scale(v3_positive(p->emission_color), positive(p->emission_strength));
  set->emission = v3_add(set->emission, v3_mul(weight, emission));
}

void closure_emit_principled(closure_set *set, const shade_point *point, vec3 weight, const principled *p)
{
  closure above[SHEEN_LAYER_LOBES + COAT_LAYER_LOBES];
  closure_set unused = {.closures = above};
  add_emission(set, principled_upper_layers(&unused, point, weight, p), p);
}

void closure_add_principled(closure_set *set, const shade_point *point, vec3 weight, const principled *p)
{
  closure_add_transparent(set, v3_scale(weight, 1 - saturate(p->alpha)));
  weight = principled_upper_layers(set, point, weight, p);
  add_emission(set, weight, p);
  weight = principled_metal(set, point, weight, p);
  weight = principled_glass(set, point, weight, p);
  double f0;
  const double eta = specular_ior(p, &f0);
  weight = principled_specular(set, point, weight, p, eta, f0);
  principled_base(set, point, weight, p, eta);
}
