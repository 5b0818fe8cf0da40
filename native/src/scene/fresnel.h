/* Reflectance of smooth interfaces. `eta` is the IOR beyond the interface relative to the side of the ray. */
#ifndef BENT_SCENE_FRESNEL_H
#define BENT_SCENE_FRESNEL_H
#include "scene/closure.h"

static inline double squared(double x) { return x * x; }
static inline vec3 v3_mix(vec3 a, vec3 b, double t) { return v3_mad(v3_sub(b, a), t, a); }
/* Negative and not finite components become 0. */
static inline double positive(double x) { return x > 0 && x < INFINITY ? x : 0; }
static inline vec3 v3_positive(vec3 a) { return v3(positive(a.x), positive(a.y), positive(a.z)); }

/* Unpolarized dielectric at cos_i >= 0; 1 under total internal reflection. *cos_t (may be NULL): cosine of the refracted
 * direction, 0 under total internal reflection. */
static inline double fresnel_dielectric(double cos_i, double eta, double *cos_t)
{
  const double sin2 = (1 - cos_i * cos_i) / (eta * eta);
  if (cos_t) *cos_t = 0;
  if (sin2 >= 1) return 1;
  const double c = sqrt(1 - sin2);
  if (cos_t) *cos_t = c;
  if (cos_i + c * eta == 0) return 1;
  const double s = cos_i + eta * c, p = c + eta * cos_i, sp = s * p; /* two quotients over one denominator */
  return (squared((cos_i - eta * c) * p) + squared((c - eta * cos_i) * s)) / (2 * sp * sp);
}

static inline double fresnel_f0(double eta) { return squared((eta - 1) / (eta + 1)); }
/* The IOR >= 1 whose reflectance at normal incidence is f0. */
static inline double fresnel_ior(double f0)
{
  const double root = sqrt(min2(f0, 0.99));
  return (1 + root) / (1 - root);
}

/* Cosine-weighted hemispherical average; fit of Kulla and Conty, "Revisiting Physically Based Shading at Imageworks"
 * (SIGGRAPH 2017 course), p. 11, good to 1e-3 for 1 <= eta <= 400 and 1/3 <= eta < 1. */
static inline double fresnel_average(double eta)
{
  return eta < 1 ? 0.997118 + eta * (0.1014 - eta * (0.965241 + eta * 0.130607)) : (eta - 1) / (4.08567 + 1.00071 * eta);
}

/* How far the dielectric curve has risen from its value f0 at normal incidence (0) to 1: (reflectance - f0) / (1 - f0). */
static inline double fresnel_rise(double reflectance, double eta)
{
  return saturate((reflectance * squared(eta + 1) - squared(eta - 1)) / (4 * eta));
}

/* Schlick minus the F82 dip: Kutz, Hasan, Edmondson, "Novel aspects of the Adobe Standard Material" (2021). */
static inline vec3 fresnel_conductor(double mu, vec3 f0, vec3 edge)
{
  const double m = 1 - mu, m5 = squared(squared(m)) * m;
  return v3_saturate(v3_sub(v3_mix(f0, v3_splat(1), m5), v3_scale(edge, mu * m5 * m)));
}
/* `edge` for a wanted reflectance `f82` times Schlick's at mu = 1/7. */
static inline vec3 fresnel_conductor_edge(vec3 f0, vec3 f82)
{
  const double f = 6.0 / 7, f5 = squared(squared(f)) * f;
  return v3_mul(v3_scale(v3_mix(f0, v3_splat(1), f5), 7 / (f5 * f)), v3_sub(v3_splat(1), f82));
}

/* Unpolarized conductor of one channel with refractive index n and extinction coefficient k, at mu in (0, 1]: Born and
 * Wolf, "Principles of Optics", section 14.2. */
static inline double fresnel_complex(double mu, double n, double k)
{
  const double mu2 = mu * mu, sin2 = 1 - mu2, d = n * n - k * k - sin2, ab = sqrt(d * d + 4 * n * n * k * k);
  const double t = 2 * mu * sqrt(max2((ab + d) / 2, 0)), c = ab + mu2, e = mu2 * ab + sin2 * sin2;
  const double s = (c - t) / max2(c + t, 1e-300), p = s * (e - t * sin2) / max2(e + t * sin2, 1e-300);
  return saturate((s + p) / 2);
}
static inline vec3 fresnel_complex_colors(double mu, vec3 n, vec3 k)
{
  return v3(fresnel_complex(mu, n.x, k.x), fresnel_complex(mu, n.y, k.y), fresnel_complex(mu, n.z, k.z));
}

/* The reflectance of a lobe that is not of a dielectric. */
vec3 fresnel_of_metal(const closure *c, double cos_i);
/* That of a lobe under a film (fresnel_film.c). *cos_t: as above, of light in a dielectric below the film. */
vec3 fresnel_of_film(const closure *c, double cos_i, double *cos_t);

/* Reflected and transmitted colors of a lobe for a microfacet seen under cos_i. Always inline: most lobes are dielectric,
 * and what of this they do not need then goes. */
static inline __attribute__((always_inline)) void fresnel_colors(const closure *c, double cos_i, vec3 *reflected, vec3 *transmitted, double *cos_t)
{
  *transmitted = v3(0, 0, 0);
  *cos_t = 0;
  if (c->kind == CLOSURE_REFRACTION) {
    *reflected = v3(0, 0, 0);
    *transmitted = v3_splat(fresnel_dielectric(cos_i, c->ior, cos_t) < 1);
  } else if (c->fresnel == FRESNEL_DIELECTRIC || c->fresnel == FRESNEL_TINTED) {
    const double f = fresnel_dielectric(cos_i, c->ior, cos_t);
    *reflected = c->fresnel == FRESNEL_DIELECTRIC ? v3_splat(f)
                                                  : v3_mix(c->f0, v3_splat(1), fresnel_rise(f, c->ior));
    if (c->kind == CLOSURE_GLASS) *transmitted = v3_mul(v3_sub(v3_splat(1), *reflected), c->transmission_color);
  } else if (c->fresnel < FRESNEL_FILM_ON_TINTED) {
    *reflected = fresnel_of_metal(c, cos_i);
  } else {
    *reflected = fresnel_of_film(c, cos_i, cos_t);
    if (c->kind == CLOSURE_GLASS) *transmitted = v3_mul(v3_sub(v3_splat(1), *reflected), c->transmission_color);
  }
  if (c->no_reflection) *reflected = v3(0, 0, 0);
  if (c->no_refraction) *transmitted = v3(0, 0, 0);
}
#endif
