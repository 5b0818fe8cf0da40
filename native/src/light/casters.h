/* Objects that may throw caustics: those of glass, mirrors and polished metal. Light subpaths are what finds caustics, so
 * half of them set out towards such objects, as far as straight rays lead there; the others into all directions. */
#ifndef BENT_LIGHT_CASTERS_H
#define BENT_LIGHT_CASTERS_H
#include "base/cap.h"
#include "bentlight/error.h"
#include "scene/scene.h"

enum { CASTERS_MAX = 16 }; /* the largest */

typedef struct caster {
  vec3 center; /* of a sphere around the object, world */
  double radius;
  double weight; /* the part of its light that narrow lobes scatter */
} caster;

typedef struct casters {
  int count;
  caster list[CASTERS_MAX];
} casters;

/* Of a scene whose geometry is committed. */
casters casters_find(const bent_scene *scene);

/* How the directions away from a place are drawn. */
typedef struct caster_mix {
  double chance; /* with which one is drawn towards a caster */
  int count;
  cap caps[CASTERS_MAX];
  double shares[CASTERS_MAX]; /* of the chance */
} caster_mix;

/* normal: of the surface that shines, or 0 if it shines all around. */
caster_mix casters_seen(const casters *casters, vec3 place, vec3 normal);
/* A direction for u in [0, 1)^2, pick in [0, 1). */
vec3 caster_draw(const caster_mix *mix, double pick, const double u[2]);
/* The density by solid angle of such directions, without the chance. */
double caster_pdf(const caster_mix *mix, vec3 direction);
#endif
