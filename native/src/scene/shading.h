/* What a surface or the sky does to light: images, material programs, and the closures they produce.
 *
 * A Blender node tree is compiled by the host into a compact program (scene/program.h) that runs here at each hit.
 * Spectrum values are linear scene-referred RGB. Everything below is read-only
 * between edits.
 */
#ifndef BENT_SCENE_SHADING_H
#define BENT_SCENE_SHADING_H
#include <stdint.h>

#include "base/vec3.h"
#include "bentlight/shading.h"
#include "scene/attribute.h"
#include "scene/closure.h"

typedef struct shading shading;
struct bent_scene;

/* How far away the sky is for materials that ask. */
#define SKY_LENGTH 1e30

/* The kinds of ray that materials can tell apart (Light Path node), as Cycles sorts them: what is scattered back by a mirror
 * is GLOSSY and REFLECTION, what goes through glass GLOSSY and TRANSMISSION, what goes through paper DIFFUSE and
 * TRANSMISSION, and what is sharp SINGULAR besides. A ray that passes straight through something stays what it was. */
enum {
  RAY_CAMERA = 1, RAY_SHADOW = 2, RAY_DIFFUSE = 4, RAY_GLOSSY = 8, RAY_TRANSMISSION = 16, RAY_REFLECTION = 32,
  RAY_SINGULAR = 64
};

/* How a ray came to be. All zero: nothing is known of it. */
typedef struct ray_history {
  uint32_t kinds; /* RAY_* bits */
  uint32_t bounces, diffuse, glossy, transmission; /* scatterings since the camera: all, and by kind of lobe */
  uint32_t transparent; /* surfaces that it went straight through since the camera */
  /* Followed only if some material asks. */
  double frequency; /* of light at the path's beginning over that which local observers (ZAMOs) measure where the ray is:
                       where it started, or on a surface where it has arrived; 0: not known */
  uint32_t image_order; /* on a surface: how often it has crossed the plane through the equator of the hole there before */
} ray_history;
/* The history that stands for all scattered rays where lights are weighed for sampling. */
#define RAY_SCATTERED                                                                                                  \
  ((ray_history){.kinds = RAY_DIFFUSE | RAY_GLOSSY | RAY_TRANSMISSION | RAY_REFLECTION, .bounces = 1})

/* Where a material's AOVs go: four numbers each, to which it adds. */
typedef struct aov_sink {
  float *values;
  uint32_t count;
} aov_sink;

/* Where and how a surface is looked at. All directions are local unit vectors in world axes (the ZAMO frame that stands
 * for the flat basis), so that a BSDF never knows that space is curved. */
typedef struct shade_point {
  vec3 position;         /* world */
  vec3 generated;        /* in [0, 1] over the undeformed bounding box (Texture Coordinate: Generated) */
  vec3 wo;               /* towards where the ray came from */
  vec3 geometric_normal; /* of the triangle, on the side of wo */
  vec3 normal;           /* interpolated shading normal, on the same side of the triangle as geometric_normal */
  double normal_length;  /* before it was made unit, as interpolated in the object's axes; 0: 1 */
  vec3 tangent;          /* dP/du, made orthogonal to normal; zero if there is no UV map, or the material does not ask */
  double tangent_sign;   /* +1 or -1: bitangent = sign * cross(normal, tangent), normal as on the triangle's own side */
  double uv[2];
  double ray_length;     /* of the way to where light was scattered before, or to the camera, as it is drawn; of the sky: SKY_LENGTH */
  double barycentric[2];  /* weights of the second and third corner of the triangle */
  float object_index;
  float object_color[4];  /* RGB and alpha */
  float object_random;    /* in [0, 1], of the instance */
  int backfacing;        /* wo is behind the triangle's own normal */
  const mat4 *world_from_object, *object_from_world; /* of the instance; NULL: identity */
  const attribute_list *mesh_attributes, *instance_attributes; /* NULL: none */
  int triangle;          /* of the mesh, for its attributes */
  const struct bent_scene *scene; /* where it is, for materials that look around; NULL: nowhere */
  int instance;
  vec3 edges[2];         /* of the triangle, from its first corner to the others, in the object's axes */
  const float (*corner_uvs)[2], *corner_generated[3]; /* of the triangle; NULL: none */
  double footprint;      /* about the size of a pixel here, world units; 0: not known */
  const vec3 *across_sky; /* of the sky: see shading_sky; NULL: a single direction */
  ray_history ray;       /* that looks */
  const aov_sink *aovs;  /* NULL: nobody asks for them */
  int no_reflection, no_refraction; /* of microfacets: they are left out of the material */
} shade_point;

/* Runs `material` (an index from bent_scene_add_material, or anything else: default grey) at `point`. out->closures has
 * room for shading_lobe_max lobes. */
void shading_evaluate(const shading *shading, int material, const shade_point *point, closure_set *out);
/* Only the radiance that leaves towards wo; cheaper. */
vec3 shading_emission(const shading *shading, int material, const shade_point *point);
/* What a material emits everywhere and to all sides, or NULL if that depends on the point. */
const vec3 *shading_even_emission(const shading *shading, int material);
/* Radiance of the scene's sky in the asymptotic world direction `direction`, for a ray with this history. across: two vectors by
 * which the direction changes over the part of the sky that images are averaged over (sky_levels.h); NULL: none. */
vec3 shading_sky(const shading *shading, vec3 direction, const vec3 across[2], const ray_history *ray);
/* What the sky's material writes to its AOVs in that direction. */
void shading_sky_aovs(const shading *shading, vec3 direction, const ray_history *ray, const aov_sink *aovs);
/* Nonzero if the sky shows an image that can be averaged. */
int shading_sky_has_levels(const shading *shading);
/* Nonzero if the material can be seen through (transparent closures), so that the ray may pass on. */
int shading_may_be_transparent(const shading *shading, int material);
/* Nonzero if the material can emit light. */
int shading_may_emit(const shading *shading, int material);
/* Nonzero if a material, or the sky, or any of them all asks by what kind of scattering a ray came. */
int shading_asks_scattering(const shading *shading, int material);
/* Nonzero if what a material emits depends on the length of the ray. */
int shading_asks_length(const shading *shading, int material);
/* Nonzero if a material depends on the tangent. */
int shading_asks_tangent(const shading *shading, int material);
/* Nonzero if light is shifted by gravity: then radiance depends on the ray's frequency. */
int shading_shifts(const shading *shading);
/* Light as it is at the path's beginning, if the history of the ray that meets it tells how its frequency is shifted. The
 * functions above do that themselves, but for materials that ask for the shift: those color light by it. */
vec3 shading_shifted(const shading *shading, vec3 light, const ray_history *ray);
/* Nonzero if what a material, or any of them all, emits depends on the shift of frequency. */
int shading_asks_frequency(const shading *shading, int material);
int shading_any_asks_frequency(const shading *shading);
int shading_sky_asks_scattering(const shading *shading);
int shading_any_asks_scattering(const shading *shading);
/* Nonzero if a material of a surface or lamp asks for the ray's history, or scatters by its length. */
int shading_any_asks_history(const shading *shading);
/* The most lobes that any material can add at a point, at least 1. */
int shading_lobe_max(const shading *shading);

bent_status shading_new(shading **out, bent_error *error);
void shading_free(shading *shading);
#endif
