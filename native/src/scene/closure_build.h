/* What the constructors of lobes (closure.c, closure_principled.c) share. */
#ifndef BENT_SCENE_CLOSURE_BUILD_H
#define BENT_SCENE_CLOSURE_BUILD_H
#include "scene/closure.h"
#include "scene/shading.h"

/* `normal` as a unit vector, or the point's shading normal if it is zero or not finite. */
vec3 closure_valid_normal(const shade_point *point, vec3 normal);
/* The IOR beyond the surface relative to the side of wo. */
double closure_ior_beyond(const shade_point *point, double ior);

/* The next free lobe, or NULL if there is nothing to add. */
closure *closure_next(closure_set *set, closure_kind kind, vec3 weight);
/* The same for microfacets, whose normal is turned so that its mirror ray leaves the surface. */
closure *closure_next_microfacet(closure_set *set, closure_kind kind, const shade_point *point, vec3 weight,
                                 double roughness, vec3 normal);
/* Multiplies the roughness squared by `factor` > 0 along the tangent and divides it by that across. */
void closure_stretch(closure *c, double factor, const stretch *stretch);
/* Up to 10 times as rough along the tangent as across. */
void closure_stretch_along(closure *c, const stretch *stretch);
/* Of microfacets, the geometric mean of both directions. */
double closure_roughness(const closure *c);

/* The lobe is complete except for what follows from `albedo`, its directional albedo without the weight. */
void closure_finish(closure_set *set, closure *c, vec3 albedo);
/* A reflecting lobe whose Fresnel fields are set: `colors` is its mean Fresnel color for this wo, `fss` over all. Returns
 * what the lobe takes from the layers below: light lost between microfacets is not given to them. */
vec3 closure_finish_reflection(closure_set *set, closure *c, const shade_point *point, vec3 colors, vec3 fss,
                               int multiscatter);
/* Puts a film, if there is one, on a lobe whose other Fresnel fields are set. */
void closure_put_film(closure *c, const thin_film *film);
/* The same on glass of that IOR, which is seen from outside or from inside. */
void closure_put_glass_film(closure *c, const shade_point *point, const thin_film *film, double ior);
/* The reflectance of a lobe at its normal. */
vec3 closure_reflectance(const closure *c, const shade_point *point);
/* A reflecting lobe of metal by its color and its tint at the edge, both in [0, 1]. */
void closure_finish_metal(closure_set *set, closure *c, const shade_point *point, vec3 color, vec3 tint,
                          const thin_film *film, int multiscatter);
/* Glass with the Fresnel fields set; `fss` is the mean color that each bounce between facets is multiplied by. */
void closure_finish_glass(closure_set *set, closure *c, const shade_point *point, vec3 fss, int multiscatter);
#endif
