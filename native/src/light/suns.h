/* Suns: disks of even radiance on the asymptotic sky, or points of it. */
#ifndef BENT_LIGHT_SUNS_H
#define BENT_LIGHT_SUNS_H
#include "base/cap.h"
#include "bentlight/render.h"

typedef struct sun {
  cap disk;
  vec3 radiance;      /* of a point: irradiance of a surface that faces it */
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
void suns_free(suns *suns);
#endif
