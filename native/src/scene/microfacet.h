/* GGX microfacets in the frame of the normal (z up), of roughness alpha_x > 0 along x and alpha_y > 0 along y.
 *
 * Walter et al., "Microfacet Models for Refraction through Rough Surfaces" (EGSR 2007); height-correlated Smith masking of
 * Heitz, "Understanding the Masking-Shadowing Function" (JCGT 2014); sampling by Dupuy and Benyoub, "Sampling Visible GGX
 * Normals with Spherical Caps" (HPG 2023).
 */
#ifndef BENT_SCENE_MICROFACET_H
#define BENT_SCENE_MICROFACET_H
#include "base/turn.h"
#include "base/vec3.h"

#define MICROFACET_PI 3.14159265358979323846

/* Density of normals. */
static inline double ggx_density(vec3 h, double alpha_x, double alpha_y)
{
  const double a = alpha_x * alpha_y, x = h.x * alpha_y, y = h.y * alpha_x, z = h.z * a, t = x * x + y * y + z * z;
  return a * a * a / (MICROFACET_PI * t * t);
}
/* Lambda for a slope of the surface's horizon: squared tangent to the normal, times the roughness squared. */
static inline double ggx_lambda_of_slope(double slope2) { return (sqrt(1 + slope2) - 1) / 2; }
static inline double ggx_lambda(vec3 w, double alpha_x, double alpha_y)
{
  const double x = alpha_x * w.x, y = alpha_y * w.y;
  return ggx_lambda_of_slope((x * x + y * y) / (w.z * w.z));
}
/* Of one roughness all around, by the cosine to the normal. */
static inline double ggx_lambda_isotropic(double cos_n, double alpha)
{
  const double c2 = cos_n * cos_n;
  return c2 >= 1 ? 0 : ggx_lambda_of_slope(alpha * alpha * (1 - c2) / c2);
}

/* A normal visible from w (w.z > 0), with density G1(w) max(0, w.h) D(h) / w.z. */
static inline vec3 ggx_sample_visible(vec3 w, double alpha_x, double alpha_y, double u0, double u1)
{
  const vec3 stretched = v3_normalize(v3(alpha_x * w.x, alpha_y * w.y, w.z));
  const double z = (1 - u1) * (1 + stretched.z) - stretched.z, r = sqrt(max2(1 - z * z, 0));
  double sine, cosine;
  turn_sincos(u0, &sine, &cosine);
  const vec3 h = v3_add(v3(r * cosine, r * sine, z), stretched);
  const vec3 normal = v3_normalize(v3(alpha_x * h.x, alpha_y * h.y, max2(h.z, 0)));
  return normal.z > 0 ? normal : v3(0, 0, 1);
}

static inline vec3 reflect(vec3 w, vec3 h) { return v3_sub(v3_scale(h, 2 * v3_dot(w, h)), w); }
/* cos_i = w.h > 0 and cos_t > 0 as fresnel_dielectric gives it for `eta`. */
static inline vec3 refract(vec3 w, vec3 h, double cos_i, double cos_t, double eta)
{
  return v3_sub(v3_scale(h, cos_i / eta - cos_t), v3_scale(w, 1 / eta));
}
#endif
