/* What a surface or the sky does to light: images, material programs, and the closures they produce.
 *
 * A Blender node tree is compiled by the host into a compact program (scene/program.h) that runs here at each hit.
 * Spectrum values are linear scene-referred RGB. Everything below is read-only after commit.
 */
#ifndef BENT_SCENE_SHADING_H
#define BENT_SCENE_SHADING_H
#include <stdint.h>

#include "base/vec3.h"
#include "bentlight/scene.h"

typedef struct shading shading;

/* Where and how a surface is looked at. All directions are local unit vectors in world axes (the ZAMO frame that stands
 * for the flat basis), so that a BSDF never knows that space is curved. */
typedef struct shade_point {
  vec3 position;         /* world */
  vec3 object_position;  /* in the mesh's own coordinates (Texture Coordinate: Object) */
  vec3 generated;        /* in [0, 1] over the undeformed bounding box (Texture Coordinate: Generated) */
  vec3 wo;               /* towards where the ray came from */
  vec3 geometric_normal; /* of the triangle, on the side of wo */
  vec3 normal;           /* interpolated shading normal, on the side of wo */
  vec3 tangent;          /* dP/du, made orthogonal to normal; zero if there is no UV map */
  double tangent_sign;   /* +1 or -1: bitangent = sign * cross(normal, tangent) */
  double uv[2];
  float object_index;
  int backfacing;        /* wo is behind the triangle's own normal */
} shade_point;

/* One scattering lobe. `weight` multiplies a lobe whose directional albedo is at most 1. */
typedef enum closure_kind {
  CLOSURE_DIFFUSE,     /* Lambert, Oren-Nayar if roughness > 0 */
  CLOSURE_GLOSSY,      /* GGX reflection; roughness 0: mirror */
  CLOSURE_GLASS,       /* dielectric reflection and transmission, GGX or smooth */
  CLOSURE_TRANSPARENT, /* passes straight on */
  CLOSURE_PRINCIPLED_SPECULAR /* dielectric GGX coat of the Principled BSDF over its base */
} closure_kind;

enum { CLOSURE_MAX = 16 };

typedef struct closure {
  closure_kind kind;
  vec3 weight;
  vec3 normal;      /* shading normal after normal maps, on the side of wo */
  double roughness; /* alpha = roughness^2 for microfacets */
  double ior;       /* of the inside relative to the outside */
  vec3 f0, f90;     /* Fresnel colors where the kind uses them */
} closure;

typedef struct closure_set {
  int count;
  closure closures[CLOSURE_MAX];
  vec3 emission;    /* radiance leaving towards wo */
} closure_set;

/* Runs `material` (an index from bent_scene_add_material, or -1: default grey) at `point`. */
void shading_evaluate(const shading *shading, int material, const shade_point *point, closure_set *out);
/* Radiance of the scene's sky in the asymptotic world direction `direction`. */
vec3 shading_sky(const shading *shading, vec3 direction);
/* Nonzero if the material can be seen through (transparent closures), so that the ray may pass on. */
int shading_may_be_transparent(const shading *shading, int material);

bent_status shading_new(shading **out, bent_error *error);
void shading_free(shading *shading);
bent_status shading_commit(shading *shading, bent_error *error);
#endif
