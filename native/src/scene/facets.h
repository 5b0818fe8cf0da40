/* The distributions of microfacets that a lobe can have, in its axes (z: the normal, x: the tangent), alpha > 0.
 *
 * GGX: microfacet.h. Beckmann: Walter et al., "Microfacet Models for Refraction through Rough Surfaces" (EGSR 2007); visible
 * normals by their slopes: Heitz and d'Eon, "Importance Sampling Microfacet-Based BSDFs using the Distribution of Visible
 * Normals" (EGSR 2014). Its Lambda is exact, of which Cycles has a fit within 0.35 %.
 */
#ifndef BENT_SCENE_FACETS_H
#define BENT_SCENE_FACETS_H
#include "scene/closure.h"
#include "scene/microfacet.h"

double beckmann_lambda(vec3 w, double alpha_x, double alpha_y);
double beckmann_density(vec3 h, double alpha_x, double alpha_y);
/* A normal visible from w (w.z > 0), with density G1(w) max(0, w.h) D(h) / w.z. */
vec3 beckmann_sample_visible(vec3 w, double alpha_x, double alpha_y, double u0, double u1);

static inline double facets_lambda(const closure *c, vec3 w)
{
  return c->facets == FACETS_BECKMANN ? beckmann_lambda(w, c->alpha, c->alpha_y) : ggx_lambda(w, c->alpha, c->alpha_y);
}
static inline vec3 facets_sample_visible(const closure *c, double u0, double u1)
{
  return c->facets == FACETS_BECKMANN ? beckmann_sample_visible(c->wo, c->alpha, c->alpha_y, u0, u1)
                                      : ggx_sample_visible(c->wo, c->alpha, c->alpha_y, u0, u1);
}

/* The lobe of Ashikhmin and Shirley, "An Anisotropic Phong BRDF Model" (Journal of Graphics Tools 2000), without its
 * Fresnel term: f(wo, wi) wi.z, and the pdf of mirroring wo at ashikhmin_sample. */
double ashikhmin_value(const closure *c, vec3 wi, double *pdf);
vec3 ashikhmin_sample(const closure *c, double u0, double u1);
#endif
