/* What part of the sky a camera ray stands for. */
#ifndef BENT_RENDER_FOOTPRINT_H
#define BENT_RENDER_FOOTPRINT_H
#include "render/path.h"

/* Vectors by which the asymptotic direction changes over sky_filter (render.h), across and up the picture. */
typedef struct footprint {
  int known; /* 0: the ray does not come from the camera to the sky, or not without scattering */
  vec3 across[2];
} footprint;

/* Of `count` <= DIRECT_BATCH paths with these hits: by rays as far to all four sides, past all surfaces. A side whose ray
 * ends elsewhere, as in a hole, is as the other one. Nothing is traced where no image of the sky asks. */
bent_status footprint_measure(const tracer *t, int count, const path *paths, const bent_hit *hits, footprint *out,
                              bent_progress *progress, bent_error *error);
#endif
