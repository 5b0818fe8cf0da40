/* Suns: disks on the asymptotic sky, or points of it. */
#ifndef BENT_LIGHT_SUNS_H
#define BENT_LIGHT_SUNS_H
#include "base/cap.h"
#include "bentlight/render.h"
#include "scene/shading.h"

typedef struct sun {
  cap disk;
  vec3 radiance;      /* of a point: irradiance of a surface that faces it */
  int material;       /* -1, or what the radiance comes from instead */
  mat4 world_from_sun, sun_from_world;
  double solid_angle; /* 0: a point */
  uint32_t visibility;
  bent_influence influence;
} sun;

typedef struct suns {
  size_t count;
  sun list[];
} suns;

/* Nonzero if a unit direction points at the disk. */
int sun_covers(const sun *sun, vec3 direction);
/* Radiance (of a point: irradiance) from a unit direction that it covers, for a ray with that history. */
vec3 sun_radiance(const bent_scene *scene, const sun *sun, vec3 direction, const ray_history *ray);
void suns_free(suns *suns);
#endif
