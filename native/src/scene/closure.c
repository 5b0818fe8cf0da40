/* Constructors of scattering lobes; the Principled BSDF as a stack of them. */
#include "scene/closure.h"

#include <math.h>
#include <stddef.h>

#include "scene/fresnel.h"
#include "scene/microfacet_energy.h"
#include "scene/shading.h"

/* The smallest cosine that a reflection may leave a microfacet's surface with, if wo itself is not lower. */
static const double LOWEST_REFLECTION = 0.01;

static vec3 valid_normal(const shade_point *point, vec3 normal)
{
  const double length = v3_length(normal);
  return length > 1e-12 && length < INFINITY ? v3_scale(normal, 1 / length) : point->normal;
}

/* A normal map or smooth shading may send a mirror ray into the surface: turns the normal towards the geometric one, just
 * as far as lifts the ray above the surface. Leaves good normals alone, and those that turn their back on wo but whose
 * mirror ray is above: nothing is seen of their reflection. This is what Cycles does (Keller et al., "The Iray Light
 * Transport Simulation and Rendering System", 2017, A.3, has the idea).
 *
 * With the normal turned by phi from the geometric one, the mirror ray's height above the surface is
 * r cos(2 phi - theta), where r and theta are the polar coordinates of wo in the plane of the two normals.
 */
static vec3 raise_reflection(const shade_point *point, vec3 normal)
{
  const vec3 ng = point->geometric_normal, wo = point->wo;
  const double up = v3_dot(ng, wo), lowest = min2(0.9 * up, LOWEST_REFLECTION);
  const double height = 2 * v3_dot(normal, wo) * v3_dot(normal, ng) - up;
  if (height >= lowest) return normal;
  const vec3 sideways = v3_mad(ng, -v3_dot(normal, ng), normal);
  const double length = v3_length(sideways);
  if (length < 1e-12) return ng;
  const vec3 x = v3_scale(sideways, 1 / length);
  const double along = v3_dot(x, wo), r = v2_length(along, up);
  const double phi = r > 0 ? (atan2(along, up) + acos(min2(max2(lowest / r, -1), 1))) / 2 : 0;
  return v3_mad(x, sin(phi), v3_scale(ng, cos(phi)));
}

/* The next free lobe, or NULL if there is nothing to add. */
static closure *next_closure(closure_set *set, closure_kind kind, vec3 weight)
{
  if (!(v3_max(weight) > 0)) return NULL;
  closure *c = &set->closures[set->count++];
  c->kind = kind;
  c->fresnel = FRESNEL_NONE;
  c->weight = weight;
  c->alpha = 0;
  c->ior = c->energy_scale = 1;
  return c;
}

/* The lobe is complete except for what follows from `albedo`, its directional albedo without the weight. */
static void finish_closure(closure_set *set, closure *c, vec3 albedo)
{
  c->albedo = v3_mul(c->weight, albedo);
  c->share = v3_average(c->albedo);
  set->delta_count += closure_is_delta(c);
}

/* Oren-Nayar's G of Portsmouth, Kutz, Hill, "EON: A practical energy-preserving rough diffuse BRDF" (JCGT 2025); the
 * albedo of the single-scattering part is a (pi + sigma G). */
static double oren_nayar_g(double cos_n)
{
  if (cos_n < 1e-6) return M_PI / 2 - 2.0 / 3 - cos_n;
  const double c = min2(cos_n, 1), s = sqrt(1 - c * c);
  return s * (acos(c) - 2.0 / 3 - s * c) + 2.0 / 3 * (s / c) * (1 - s * s * s);
}
static double oren_nayar_a(double sigma) { return 1 / (M_PI + sigma * (M_PI / 2 - 2.0 / 3)); }
double closure_oren_nayar_albedo(double sigma, double cos_n)
{
  return oren_nayar_a(sigma) * (M_PI + sigma * oren_nayar_g(cos_n));
}
double closure_oren_nayar_single(double sigma, double nl, double nv, double lv)
{
  double t = lv - nl * nv;
  if (t > 0) t /= max2(nl, nv);
  return oren_nayar_a(sigma) * (1 + sigma * t);
}

void closure_add_diffuse(closure_set *set, const shade_point *point, vec3 weight, vec3 color, double roughness,
                         vec3 normal)
{
  closure *c = next_closure(set, CLOSURE_DIFFUSE, v3_positive(v3_mul(weight, v3_positive(color))));
  if (!c) return;
  c->normal = valid_normal(point, normal);
  c->alpha = saturate(roughness);
  vec3 albedo = v3_splat(1);
  if (c->alpha > 0) { /* the second bounce has one factor of the color more than in the paper, as in Cycles */
    const double a = oren_nayar_a(c->alpha), average = a * (M_PI + c->alpha * (2 * M_PI - 5.6) / 3);
    const double single = closure_oren_nayar_albedo(c->alpha, max2(v3_dot(c->normal, point->wo), 0));
    const vec3 rho = v3_saturate(color);
    const double scale = average / (1 - average) * (1 - single) / M_PI;
    c->multiscatter = v3_scale(v3(rho.x * rho.x / (1 - rho.x * (1 - average)), rho.y * rho.y / (1 - rho.y * (1 - average)),
                                  rho.z * rho.z / (1 - rho.z * (1 - average))), scale);
    albedo = v3_add(v3_splat(single), v3_scale(c->multiscatter, M_PI * (1 - average)));
  }
  finish_closure(set, c, albedo);
}

/* Puts back the light lost between microfacets: `single` is the lobe's albedo without Fresnel, `average` its mean, and
 * `fss` the mean Fresnel color that each further bounce is multiplied by. */
static void compensate_energy(closure *c, double single, double average, vec3 fss)
{
  const double missing = (1 - single) / single;
  c->energy_scale = 1 + missing;
  const vec3 fms = v3(fss.x * average / (1 - fss.x * (1 - average)), fss.y * average / (1 - fss.y * (1 - average)),
                      fss.z * average / (1 - fss.z * (1 - average)));
  c->weight = v3_mul(c->weight, v3_scale(v3_add(v3_splat(1), v3_scale(fms, missing)), 1 / c->energy_scale));
}

/* A reflecting lobe whose Fresnel fields are set: `colors` is its mean Fresnel color for this wo, `fss` over all. Returns
 * what the lobe takes from the layers below: light lost between microfacets is not given to them. */
static vec3 finish_reflection(closure_set *set, closure *c, const shade_point *point, double roughness, vec3 colors,
                              vec3 fss, int multiscatter)
{
  const double mu = saturate(v3_dot(c->normal, point->wo));
  double single = closure_is_delta(c) ? 1 : microfacet_reflection_albedo(roughness, mu);
  if (multiscatter && single < 1)
    compensate_energy(c, single, microfacet_reflection_average(roughness), fss);
  finish_closure(set, c, v3_scale(colors, single * c->energy_scale));
  return v3_mul(c->weight, colors);
}

static closure *next_microfacet(closure_set *set, closure_kind kind, const shade_point *point, vec3 weight,
                                double roughness, vec3 normal)
{
  closure *c = next_closure(set, kind, weight);
  if (!c) return NULL;
  c->normal = raise_reflection(point, valid_normal(point, normal));
  c->alpha = squared(saturate(roughness));
  return c;
}

void closure_add_glossy(closure_set *set, const shade_point *point, vec3 weight, vec3 color, double roughness,
                        vec3 normal, int multiscatter)
{
  closure *c = next_microfacet(set, CLOSURE_REFLECTION, point, v3_positive(v3_mul(weight, v3_positive(color))), roughness,
                               normal);
  if (c) finish_reflection(set, c, point, saturate(roughness), v3_splat(1), v3_saturate(color), multiscatter);
}

static double ior_beyond(const shade_point *point, double ior)
{
  const double valid = min2(max2(ior, 1e-3), 1e3);
  return point->backfacing ? 1 / valid : valid;
}

/* Glass with the Fresnel fields set; `fss` as in compensate_energy. */
static void finish_glass(closure_set *set, closure *c, const shade_point *point, double roughness, vec3 fss,
                         int multiscatter)
{
  const double mu = saturate(v3_dot(c->normal, point->wo));
  double single = 1;
  if (!closure_is_delta(c)) {
    single = microfacet_glass_albedo(roughness, mu, c->ior);
    if (multiscatter && single > 0) compensate_energy(c, single, microfacet_glass_average(roughness, c->ior), fss);
  }
  vec3 reflected, transmitted;
  double cos_t;
  fresnel_colors(c, mu, &reflected, &transmitted, &cos_t);
  finish_closure(set, c, v3_scale(v3_add(reflected, transmitted), single * c->energy_scale));
}

void closure_add_glass(closure_set *set, const shade_point *point, vec3 weight, vec3 color, double roughness, double ior,
                       vec3 normal, int multiscatter)
{
  closure *c = next_microfacet(set, CLOSURE_GLASS, point, v3_positive(v3_mul(weight, v3_positive(color))), roughness,
                               normal);
  if (!c) return;
  c->fresnel = FRESNEL_DIELECTRIC;
  c->ior = ior_beyond(point, ior);
  c->transmission_color = v3_splat(1);
  finish_glass(set, c, point, saturate(roughness), v3_saturate(color), multiscatter);
}

void closure_add_refraction(closure_set *set, const shade_point *point, vec3 weight, vec3 color, double roughness,
                            double ior, vec3 normal)
{
  closure *c = next_microfacet(set, CLOSURE_REFRACTION, point, v3_positive(v3_mul(weight, v3_positive(color))), roughness,
                               normal);
  if (!c) return;
  c->ior = ior_beyond(point, ior);
  vec3 reflected, transmitted;
  double cos_t;
  fresnel_colors(c, saturate(v3_dot(c->normal, point->wo)), &reflected, &transmitted, &cos_t);
  /* Microfacets may let light through where the surface as a whole would reflect it all. */
  finish_closure(set, c, closure_is_delta(c) ? transmitted : v3_splat(1));
}

void closure_add_translucent(closure_set *set, const shade_point *point, vec3 weight, vec3 color, vec3 normal)
{
  closure *c = next_closure(set, CLOSURE_TRANSLUCENT, v3_positive(v3_mul(weight, v3_positive(color))));
  if (!c) return;
  c->normal = raise_reflection(point, valid_normal(point, normal)); /* as Cycles, though nothing is reflected */
  finish_closure(set, c, v3_splat(1));
}

void closure_add_transparent(closure_set *set, vec3 weight)
{
  closure *c = next_closure(set, CLOSURE_TRANSPARENT, v3_positive(weight));
  if (c) finish_closure(set, c, v3_splat(1));
}

/* The layers of the Principled BSDF. Each adds its lobe with `weight` and returns what is left for those below. */
static vec3 principled_metal(closure_set *set, const shade_point *point, vec3 weight, const principled *p)
{
  const double metallic = saturate(p->metallic), roughness = saturate(p->roughness);
  const vec3 color = v3_saturate(p->base_color), f82 = v3_saturate(p->specular_tint);
  closure *c = next_microfacet(set, CLOSURE_REFLECTION, point, v3_scale(weight, metallic), roughness, p->normal);
  if (c) {
    c->fresnel = FRESNEL_CONDUCTOR;
    c->f0 = color;
    c->edge = fresnel_conductor_edge(color, f82);
    const double mu = saturate(v3_dot(c->normal, point->wo));
    const vec3 fss = v3_saturate(v3_sub(v3_mix(color, v3_splat(1), 1.0 / 21), v3_scale(c->edge, 1.0 / 126)));
    finish_reflection(set, c, point, roughness, fresnel_conductor(mu, c->f0, c->edge), fss, p->multiscatter);
  }
  return v3_scale(weight, 1 - metallic);
}

static vec3 principled_glass(closure_set *set, const shade_point *point, vec3 weight, const principled *p)
{
  const double transmission = saturate(p->transmission), roughness = saturate(p->roughness);
  const vec3 color = v3_saturate(p->base_color);
  closure *c = next_microfacet(set, CLOSURE_GLASS, point, v3_scale(weight, transmission), roughness, p->normal);
  if (c) {
    c->fresnel = FRESNEL_TINTED;
    c->ior = ior_beyond(point, p->ior);
    c->f0 = v3_saturate(v3_scale(v3_positive(p->specular_tint), fresnel_f0(c->ior)));
    c->transmission_color = v3(sqrt(color.x), sqrt(color.y), sqrt(color.z));
    finish_glass(set, c, point, roughness, c->transmission_color, p->multiscatter);
  }
  return v3_scale(weight, 1 - transmission);
}

static vec3 principled_specular(closure_set *set, const shade_point *point, vec3 weight, const principled *p)
{
  double eta = min2(max2(p->ior, 1e-3), 1e3), f0 = fresnel_f0(eta);
  if (p->specular_level != 0.5) {
    f0 *= 2 * positive(p->specular_level);
    eta = eta < 1 ? 1 / fresnel_ior(f0) : fresnel_ior(f0);
  }
  if (eta == 1) return weight;
  const double roughness = saturate(p->roughness);
  closure *c = next_microfacet(set, CLOSURE_REFLECTION, point, weight, roughness, p->normal);
  if (!c) return weight;
  c->fresnel = FRESNEL_TINTED;
  c->ior = eta;
  c->f0 = v3_saturate(v3_scale(v3_positive(p->specular_tint), f0));
  const double mu = saturate(v3_dot(c->normal, point->wo));
  const double rise = closure_is_delta(c) ? fresnel_rise(fresnel_dielectric(mu, eta, NULL), eta)
                                          : microfacet_fresnel_rise(roughness, mu, eta);
  const vec3 fss = v3_mix(c->f0, v3_splat(1), fresnel_rise(fresnel_average(eta), eta));
  const vec3 colors = v3_mix(c->f0, v3_splat(1), rise);
  const vec3 albedo = finish_reflection(set, c, point, roughness, colors, fss, p->multiscatter);
  const double most = max2(max2(weight.x > 0 ? albedo.x / weight.x : 0, weight.y > 0 ? albedo.y / weight.y : 0),
                           weight.z > 0 ? albedo.z / weight.z : 0);
  return v3_scale(weight, saturate(1 - most));
}

void closure_add_principled(closure_set *set, const shade_point *point, vec3 weight, const principled *p)
{
  const double alpha = saturate(p->alpha);
  closure_add_transparent(set, v3_scale(weight, 1 - alpha));
  weight = v3_scale(v3_positive(weight), alpha);
  const vec3 emission = v3_scale(v3_positive(p->emission_color), positive(p->emission_strength));
  set->emission = v3_add(set->emission, v3_mul(weight, emission));
  weight = principled_metal(set, point, weight, p);
  weight = principled_glass(set, point, weight, p);
  weight = principled_specular(set, point, weight, p);
  closure_add_diffuse(set, point, weight, p->base_color, p->diffuse_roughness, p->normal);
}

void closure_set_finish(closure_set *set)
{
  double total = 0;
  for (int i = 0; i < set->count; i++) total += set->closures[i].share;
  for (int i = 0; i < set->count; i++) set->closures[i].share = total > 0 ? set->closures[i].share / total : 0;
}
