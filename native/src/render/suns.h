/* Suns: disks of even radiance on the asymptotic sky. */
#ifndef BENT_RENDER_SUNS_H
#define BENT_RENDER_SUNS_H
#include "base/vec3.h"
#include "bentlight/render.h"

typedef struct suns suns;

/* Radiance of the suns in the unit direction `direction` for a ray of the given kind (bent_visibility bit). NULL: 0. */
vec3 suns_radiance(const suns *suns, vec3 direction, uint32_t kind);
void suns_free(suns *suns);
#endif
