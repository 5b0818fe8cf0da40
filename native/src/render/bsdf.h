/* Sampling and evaluating a closure_set. wo and wi point away from the surface; all directions are local.
 *
 * Radiance that is refracted is not scaled by the square of the IOR (the convention of Blender: what is carried is the
 * basic radiance L / n^2), so a path's throughput may be used as it is.
 */
#ifndef BENT_RENDER_BSDF_H
#define BENT_RENDER_BSDF_H
#include "scene/shading.h"

typedef enum bsdf_lobe { LOBE_DIFFUSE = 2, LOBE_GLOSSY = 4, LOBE_TRANSMISSION = 8, LOBE_TRANSPARENT = 16,
               LOBE_SUBSURFACE = 32 } bsdf_lobe;

typedef struct bsdf_sample {
  vec3 wi;
  vec3 weight;    /* f(wo, wi) |cos| / pdf of the whole set; the throughput factor */
  double pdf;     /* solid angle, of the whole set; 0 for a delta lobe (mirror, smooth glass, transparent, subsurface) */
  double lobes_pdf; /* the same of the lobes alone, after portal_draw */
  bsdf_lobe lobe; /* values agree with bent_visibility bits where both exist */
  const closure *entered; /* LOBE_SUBSURFACE: of which lobe; wi points into the surface */
} bsdf_sample;

/* Draws a direction with u in [0,1)^3 (u[2] picks the lobe). Returns 0 when the light is absorbed. */
int bsdf_draw(const closure_set *set, const shade_point *point, const double u[3], bsdf_sample *out);
/* What bsdf_draw would have returned had it drawn wi; u in [0, 1) picks the kind of lobe. 0 if it never draws wi. */
int bsdf_drawn(const closure_set *set, const shade_point *point, vec3 wi, double u, bsdf_sample *out);
/* f(wo, wi) |cos| over the non-delta lobes of the wanted kinds (bits of bsdf_lobe), and the pdf that bsdf_draw has there. */
vec3 bsdf_evaluate(const closure_set *set, const shade_point *point, vec3 wi, uint32_t kinds, double *pdf);
/* The same but for the pdf, and what of it comes from which lobes, as Cycles' light passes tell them apart: translucency is
 * diffuse, and what is neither diffuse nor glossy is transmitted. */
typedef struct bsdf_parts {
  vec3 all, diffuse, glossy;
} bsdf_parts;
bsdf_parts bsdf_evaluate_parts(const closure_set *set, const shade_point *point, vec3 wi, uint32_t kinds);
/* What the mirrors and smooth glass of a set do with light from wi. chance: with which bsdf_draw draws it. value: of the
 * radiance from wi that they send towards wo. flux: the same of light that is traced from wi, which is the value times
 * d(omega_o) / d(omega_i): where it is refracted (eta_i / eta_o)^2 cos_i / cos_o. through: it is refracted. */
typedef struct bsdf_sharp {
  double chance;
  vec3 value, flux;
  int through;
} bsdf_sharp;
bsdf_sharp bsdf_evaluate_sharp(const closure_set *set, const shade_point *point, vec3 wi);
/* What transparent closures let through, and the chance with which bsdf_draw draws them. */
vec3 bsdf_transparency(const closure_set *set, double *chance);
/* What to multiply a drawn sample's weight by where its kind of lobe matters to what the ray meets: that kind's part of the
 * scattered light over its part of the chances. Its mean over the kinds that draw wi is 1. (1, 1, 1) for a delta lobe. */
vec3 bsdf_kind_weight(const closure_set *set, const shade_point *point, const bsdf_sample *drawn);
/* The RAY_* bits of rays that a kind of lobe of the set scatters. */
uint32_t bsdf_ray_kinds(const closure_set *set, bsdf_lobe lobe);
/* Whether light passes count a lobe as diffuse. */
int bsdf_is_diffuse_part(const closure *c);
/* The albedo of a lobe of microfacets, or of velvet, by where the light goes. */
void bsdf_albedo_parts(const closure *c, const shade_point *point, vec3 *reflected, vec3 *transmitted);
/* Albedo for denoising: the directional albedo of the lobes but white for mirrors and smooth glass. */
vec3 bsdf_albedo(const closure_set *set);
#endif
