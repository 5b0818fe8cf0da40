/* Constructors of scattering lobes. */
#include "scene/closure_build.h"

#include <math.h>
#include <stddef.h>

#include "scene/facets.h"
#include "scene/fresnel.h"
#include "scene/microfacet_energy.h"
#include "scene/sheen.h"
#include "scene/shading.h"

/* The smallest cosine that a reflection may leave a microfacet's surface with, if wo itself is not lower. */
static const double LOWEST_REFLECTION = 0.01;

vec3 closure_valid_normal(const shade_point *point, vec3 normal)
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

closure *closure_next(closure_set *set, closure_kind kind, vec3 weight)
{
  if (!(v3_max(weight) > 0)) return NULL;
  closure *c = &set->closures[set->count++];
  c->kind = kind;
  c->fresnel = FRESNEL_NONE;
  c->facets = FACETS_GGX;
  c->weight = weight;
  c->alpha = c->alpha_y = 0;
  c->ior = c->energy_scale = 1;
  c->no_reflection = c->no_refraction = 0;
  return c;
}

void closure_finish(closure_set *set, closure *c, vec3 albedo)
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
  closure *c = closure_next(set, CLOSURE_DIFFUSE, v3_positive(v3_mul(weight, v3_positive(color))));
  if (!c) return;
  c->normal = closure_valid_normal(point, normal);
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
  closure_finish(set, c, albedo);
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

double closure_roughness(const closure *c)
{
  return sqrt(c->alpha == c->alpha_y ? c->alpha : sqrt(c->alpha * c->alpha_y));
}

/* Of rough microfacets: the axes in which they are described, and what is known in them of wo. */
static void orient(closure *c, const shade_point *point)
{
  vec3 across;
  if (c->alpha == c->alpha_y) v3_basis(c->normal, &c->tangent, &across);
  else across = v3_cross(c->normal, c->tangent);
  c->wo = v3(v3_dot(c->tangent, point->wo), v3_dot(across, point->wo), v3_dot(c->normal, point->wo));
  c->masking = 1 + facets_lambda(c, c->wo);
}

vec3 closure_finish_reflection(closure_set *set, closure *c, const shade_point *point, vec3 colors, vec3 fss,
                               int multiscatter)
{
  const double mu = saturate(v3_dot(c->normal, point->wo)), roughness = closure_roughness(c);
  double single = 1;
  if (!closure_is_delta(c)) {
    orient(c, point);
    single = microfacet_reflection_albedo(roughness, mu);
    if (multiscatter && single < 1) compensate_energy(c, single, microfacet_reflection_average(roughness), fss);
  }
  closure_finish(set, c, v3_scale(colors, single * c->energy_scale));
  return v3_mul(c->weight, colors);
}

closure *closure_next_microfacet(closure_set *set, closure_kind kind, const shade_point *point, vec3 weight,
                                 double roughness, vec3 normal)
{
  closure *c = closure_next(set, kind, weight);
  if (!c) return NULL;
  c->normal = raise_reflection(point, closure_valid_normal(point, normal));
  c->alpha = c->alpha_y = squared(saturate(roughness));
  return c;
}

void closure_stretch(closure *c, double factor, const stretch *stretch)
{
  const vec3 across = v3_cross(c->normal, stretch->tangent);
  const double length = v3_length(across);
  if (!(length > 1e-12 && length < INFINITY && factor > 0)) return;
  const vec3 y = v3_scale(across, 1 / length), x = v3_cross(y, c->normal);
  const double angle = isfinite(stretch->rotation) ? 2 * M_PI * stretch->rotation : 0;
  c->tangent = v3_add(v3_scale(x, cos(angle)), v3_scale(y, sin(angle)));
  c->alpha = saturate(c->alpha * factor);
  c->alpha_y = saturate(c->alpha_y / factor);
}

void closure_stretch_along(closure *c, const stretch *stretch)
{
  const double anisotropy = saturate(stretch->anisotropy);
  if (anisotropy > 0) closure_stretch(c, 1 / sqrt(1 - 0.9 * anisotropy), stretch);
}

/* Mean over the cosine-weighted hemisphere of Schlick's curve minus the dip of `edge`. */
static vec3 conductor_average(vec3 f0, vec3 edge)
{
  return v3_saturate(v3_sub(v3_mix(f0, v3_splat(1), 1.0 / 21), v3_scale(edge, 1.0 / 126)));
}

void closure_put_film(closure *c, const thin_film *film)
{
  if (!film_exists(film)) return;
  c->film = *film;
  c->fresnel = c->fresnel == FRESNEL_CONDUCTOR ? FRESNEL_FILM_ON_CONDUCTOR
               : c->fresnel == FRESNEL_COMPLEX ? FRESNEL_FILM_ON_COMPLEX : FRESNEL_FILM_ON_TINTED;
}

vec3 closure_reflectance(const closure *c, const shade_point *point)
{
  vec3 reflected, transmitted;
  double cos_t;
  fresnel_colors(c, saturate(v3_dot(c->normal, point->wo)), &reflected, &transmitted, &cos_t);
  return reflected;
}

void closure_finish_metal(closure_set *set, closure *c, const shade_point *point, vec3 color, vec3 tint,
                          const thin_film *film, int multiscatter)
{
  c->fresnel = FRESNEL_CONDUCTOR;
  c->f0 = color;
  c->edge = fresnel_conductor_edge(color, tint);
  closure_put_film(c, film);
  closure_finish_reflection(set, c, point, closure_reflectance(c, point), conductor_average(c->f0, c->edge),
                            multiscatter);
}

/* The mean of the true curve is that of the curve by Schlick that agrees at mu = 1 and 1/7, as in Cycles. */
static void finish_complex_metal(closure_set *set, closure *c, const shade_point *point, vec3 n, vec3 k,
                                 const thin_film *film, int multiscatter)
{
  c->fresnel = FRESNEL_COMPLEX;
  c->f0 = n;
  c->edge = k;
  const vec3 front = fresnel_complex_colors(1, n, k), side = fresnel_complex_colors(1.0 / 7, n, k);
  const vec3 schlick = fresnel_conductor(1.0 / 7, front, v3(0, 0, 0));
  const vec3 tint = v3(side.x / schlick.x, side.y / schlick.y, side.z / schlick.z);
  closure_put_film(c, film);
  closure_finish_reflection(set, c, point, closure_reflectance(c, point),
                            conductor_average(front, fresnel_conductor_edge(front, tint)), multiscatter);
}

void closure_add_metallic(closure_set *set, const shade_point *point, vec3 weight, vec3 color_or_ior,
                          vec3 tint_or_extinction, double roughness, vec3 normal, const stretch *stretch,
                          const thin_film *film, facets facets, int physical)
{
  if (point->no_reflection) return;
  closure *c = closure_next_microfacet(set, CLOSURE_REFLECTION, point, v3_positive(weight), roughness, normal);
  if (!c) return;
  c->facets = facets;
  closure_stretch_along(c, stretch);
  const int multiscatter = facets == FACETS_MULTI_GGX;
  const vec3 a = v3_positive(color_or_ior), b = v3_positive(tint_or_extinction);
  if (physical) finish_complex_metal(set, c, point, a, b, film, multiscatter);
  else closure_finish_metal(set, c, point, v3_saturate(a), v3_saturate(b), film, multiscatter);
}

/* The lobe of Ashikhmin and Shirley is a mirror below this roughness, and not defined above 1; as in Cycles. */
static void keep_in_range(closure *c)
{
  const double least = 1e-4;
  if (max2(c->alpha, c->alpha_y) <= least) c->alpha = c->alpha_y = 0;
  else c->alpha = max2(c->alpha, least), c->alpha_y = max2(c->alpha_y, least);
}

void closure_add_glossy(closure_set *set, const shade_point *point, vec3 weight, vec3 color, double roughness,
                        vec3 normal, const stretch *stretch, facets facets)
{
  if (point->no_reflection) return;
  closure *c = closure_next_microfacet(set, CLOSURE_REFLECTION, point, v3_positive(v3_mul(weight, v3_positive(color))),
                                       roughness, normal);
  if (!c) return;
  c->facets = facets;
  const double anisotropy = min2(max2(stretch->anisotropy, -0.99), 0.99);
  if (fabs(anisotropy) > 1e-4) closure_stretch(c, anisotropy < 0 ? 1 / (1 + anisotropy) : 1 - anisotropy, stretch);
  if (facets == FACETS_ASHIKHMIN_SHIRLEY) keep_in_range(c);
  closure_finish_reflection(set, c, point, v3_splat(1), v3_saturate(color), facets == FACETS_MULTI_GGX);
}

double closure_ior_beyond(const shade_point *point, double ior)
{
  const double valid = min2(max2(ior, 1e-3), 1e3);
  return point->backfacing ? 1 / valid : valid;
}

void closure_put_glass_film(closure *c, const shade_point *point, const thin_film *film, double ior)
{
  if (!film_exists(film)) return;
  thin_film here = *film; /* from inside, the film is seen from the glass */
  if (point->backfacing) here.ior /= min2(max2(ior, 1e-3), 1e3);
  closure_put_film(c, &here);
}

void closure_finish_glass(closure_set *set, closure *c, const shade_point *point, vec3 fss, int multiscatter)
{
  const double mu = saturate(v3_dot(c->normal, point->wo)), roughness = closure_roughness(c);
  double single = 1;
  c->no_reflection = point->no_reflection, c->no_refraction = point->no_refraction;
  if (c->no_refraction) fss = v3(0, 0, 0);
  if (!closure_is_delta(c)) {
    orient(c, point);
    single = microfacet_glass_albedo(roughness, mu, c->ior);
    if (multiscatter && single > 0) compensate_energy(c, single, microfacet_glass_average(roughness, c->ior), fss);
  }
  vec3 reflected, transmitted;
  double cos_t;
  fresnel_colors(c, mu, &reflected, &transmitted, &cos_t);
  closure_finish(set, c, v3_scale(v3_add(reflected, transmitted), single * c->energy_scale));
}

void closure_add_glass(closure_set *set, const shade_point *point, vec3 weight, vec3 color, double roughness, double ior,
                       vec3 normal, const thin_film *film, facets facets)
{
  if (point->no_reflection && point->no_refraction) return;
  closure *c = closure_next_microfacet(set, CLOSURE_GLASS, point, v3_positive(v3_mul(weight, v3_positive(color))),
                                       roughness, normal);
  if (!c) return;
  c->facets = facets;
  c->fresnel = FRESNEL_DIELECTRIC;
  c->ior = closure_ior_beyond(point, ior);
  c->f0 = v3_splat(fresnel_f0(c->ior));
  c->transmission_color = v3_splat(1);
  closure_put_glass_film(c, point, film, ior);
  closure_finish_glass(set, c, point, v3_saturate(color), facets == FACETS_MULTI_GGX);
}

void closure_add_refraction(closure_set *set, const shade_point *point, vec3 weight, vec3 color, double roughness,
                            double ior, vec3 normal, facets facets)
{
  if (point->no_refraction) return;
  closure *c = closure_next_microfacet(set, CLOSURE_REFRACTION, point, v3_positive(v3_mul(weight, v3_positive(color))),
                                       roughness, normal);
  if (!c) return;
  c->facets = facets;
  c->ior = closure_ior_beyond(point, ior);
  if (!closure_is_delta(c)) orient(c, point);
  vec3 reflected, transmitted;
  double cos_t;
  fresnel_colors(c, saturate(v3_dot(c->normal, point->wo)), &reflected, &transmitted, &cos_t);
  /* Microfacets may let light through where the surface as a whole would reflect it all. */
  closure_finish(set, c, closure_is_delta(c) ? transmitted : v3_splat(1));
}

void closure_add_translucent(closure_set *set, const shade_point *point, vec3 weight, vec3 color, vec3 normal)
{
  closure *c = closure_next(set, CLOSURE_TRANSLUCENT, v3_positive(v3_mul(weight, v3_positive(color))));
  if (!c) return;
  c->normal = raise_reflection(point, closure_valid_normal(point, normal)); /* as Cycles, though nothing is reflected */
  closure_finish(set, c, v3_splat(1));
}

vec3 closure_add_sheen(closure_set *set, const shade_point *point, vec3 weight, vec3 color, double roughness, vec3 normal)
{
  const vec3 n = closure_valid_normal(point, normal);
  const double mu = v3_dot(n, point->wo);
  const sheen_lobe lobe = sheen_lobe_at(max2(saturate(roughness), 1e-3), saturate(mu));
  if (!(lobe.a > 1e-5 && lobe.albedo > 1e-5)) return v3(0, 0, 0); /* nothing to see; as Cycles */
  closure *c = closure_next(set, CLOSURE_SHEEN, v3_positive(v3_scale(v3_mul(weight, v3_positive(color)), lobe.albedo)));
  if (!c) return v3(0, 0, 0);
  vec3 across;
  v3_basis(n, &c->tangent, &across);
  const vec3 along = v3_mad(n, -mu, point->wo); /* without length where wo is the normal, and the lobe round */
  if (v3_dot(along, along) > 1e-24) c->tangent = v3_normalize(along);
  c->normal = n;
  c->sheen_a = lobe.a;
  c->sheen_b = lobe.b;
  closure_finish(set, c, v3_splat(1));
  return c->weight;
}

void closure_add_velvet(closure_set *set, const shade_point *point, vec3 weight, vec3 color, double roughness, vec3 normal)
{
  closure *c = closure_next(set, CLOSURE_VELVET, v3_positive(v3_mul(weight, v3_positive(color))));
  if (!c) return;
  c->normal = closure_valid_normal(point, normal);
  c->sheen_a = 1 / squared(max2(saturate(roughness), 0.01));
  closure_finish(set, c, v3_splat(1)); /* its albedo is not known; as Cycles */
}

void closure_add_transparent(closure_set *set, vec3 weight)
{
  closure *c = closure_next(set, CLOSURE_TRANSPARENT, v3_positive(weight));
  if (c) closure_finish(set, c, v3_splat(1));
}

void closure_set_finish(closure_set *set)
{
  double total = 0;
  for (int i = 0; i < set->count; i++) total += set->closures[i].share;
  for (int i = 0; i < set->count; i++) set->closures[i].share = total > 0 ? set->closures[i].share / total : 0;
}

void closure_set_blur(closure_set *set, const shade_point *point, double alpha)
{
  set->delta_count = 0;
  for (int i = 0; i < set->count; i++) {
    closure *c = &set->closures[i];
    if (closure_is_microfacet(c) && min2(c->alpha, c->alpha_y) < alpha) {
      c->alpha = max2(c->alpha, alpha), c->alpha_y = max2(c->alpha_y, alpha);
      if (!closure_is_delta(c)) orient(c, point);
    }
    set->delta_count += closure_is_delta(c);
  }
}
