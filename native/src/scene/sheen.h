/* Sheen of fibers that stand on a surface: a linearly transformed cosine fitted to what a layer of them reflects, in the
 * frame of the normal (z up) with wo in the plane of x and z.
 *
 * Model and fit: Zeltner, Burley, Chiang, "Practical Multiple-Scattering Sheen Using Linearly Transformed Cosines" (SIGGRAPH
 * 2022 Talks); the table is our own run of it (tools/fit_sheen.c), linear between its entries.
 *
 * And velvet, the older model: Ashikhmin, Premoze, Shirley, "A Microfacet-based BRDF Generator" (SIGGRAPH 2000), section 4.
 */
#ifndef BENT_SCENE_SHEEN_H
#define BENT_SCENE_SHEEN_H
#include "base/vec3.h"

enum { SHEEN_NODES = 32 };
/* [roughness][mu] of even steps in [0, 1] (0.01 for 0): a, b, directional albedo. */
extern const float sheen_table[SHEEN_NODES][SHEEN_NODES][3];

/* The matrix ((a, 0, b), (0, a, 0), (0, 0, 1)) makes the lobe's directions those of a cosine lobe. */
typedef struct sheen_lobe {
  double a, b, albedo;
} sheen_lobe;

/* For roughness in [0, 1] and mu = n.wo in [0, 1]. */
sheen_lobe sheen_lobe_at(double roughness, double mu);

/* The density of light reflected to wi with wi.z > 0; integrates to 1. */
static inline double sheen_density(double a, double b, vec3 wi)
{
  const double x = a * wi.x + b * wi.z, y = a * wi.y, length2 = x * x + y * y + wi.z * wi.z;
  return wi.z / 3.14159265358979323846 * (a / length2) * (a / length2);
}
/* The direction with that density that a direction of a cosine lobe becomes. */
static inline vec3 sheen_direction(double a, double b, vec3 cosine)
{
  return v3_normalize(v3(cosine.x - cosine.z * b, cosine.y, cosine.z * a));
}

/* f(wo, wi) wi.z of velvet for wo.z and wi.z > 0: `upright` is 1 / roughness^2. Its normals have the density
 * upright exp(-upright cot^2) / (pi sin^4) of their angle to z; masking is that of V-shaped grooves. */
static inline double velvet_value(double upright, vec3 wo, vec3 wi)
{
  const vec3 h = v3_normalize(v3_add(wo, wi));
  const double cos_i = v3_dot(wo, h), sin2 = h.x * h.x + h.y * h.y;
  if (cos_i < 1e-5 || sin2 < 2e-5) return 0; /* as Cycles */
  const double density = upright * exp(-upright * h.z * h.z / sin2) / (3.14159265358979323846 * sin2 * sin2);
  const double grooves = 2 * h.z / cos_i * min2(wo.z, wi.z);
  return 0.25 * density * min2(grooves, 1) / wo.z;
}
#endif
