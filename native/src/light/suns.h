/* Suns: disks of even radiance on the asymptotic sky, or points of it. */
#ifndef BENT_LIGHT_SUNS_H
#define BENT_LIGHT_SUNS_H
#include "base/vec3.h"
#include "bentlight/render.h"

typedef struct sun {
  vec3 direction;
  vec3 radiance;      /* of a point: irradiance of a surface that faces it */
  double chord2;      /* squared distance on the unit sphere from center to rim: precise for small suns, unlike a cosine */
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
/* A direction drawn evenly from the disk, (u, v) in [0, 1)^2. */
vec3 sun_draw(const sun *sun, double u, double v);
void suns_free(suns *suns);
#endif
