/* Lamps without size: points that shine into each direction as their material says. */
#ifndef BENT_LIGHT_LAMPS_H
#define BENT_LIGHT_LAMPS_H
#include "base/vec3.h"
#include "bentlight/render.h"
#include "scene/shading.h"

typedef struct lamp {
  mat4 world_from_lamp, lamp_from_world;
  vec3 position;
  int material;
  uint32_t visibility;
  bent_influence influence;
} lamp;

typedef struct lamps {
  size_t count;
  lamp list[];
} lamps;

void lamps_free(lamps *lamps);
/* Radiant intensity towards a unit direction, local in world axes, for who is `distance` away, along a ray with that
 * history. */
vec3 lamp_intensity(const bent_scene *scene, const lamp *lamp, vec3 direction, double distance, const ray_history *ray);
#endif
