/* Static observers around a Schwarzschild hole. Kernel code. */
#ifndef BENT_SPACETIME_SCHWARZSCHILD_PLACE_H
#define BENT_SPACETIME_SCHWARZSCHILD_PLACE_H
#include "base/lanes.h"

typedef struct schwarzschild_place {
  lanes w;     /* 1/r */
  lanes above; /* w - 1/(3M), how far from the photon sphere, with all digits where that is little */
  lanes lapse;
} schwarzschild_place;

/* The observer at `radius` of the isotropic or the areal chart. r - 3M is factored so that its large terms cancel without
 * rounding (Sterbenz 1974). */
LANES_INLINE schwarzschild_place schwarzschild_place_at(double M, int is_isotropic, lanes radius)
{
  const double peak = 1 / (3 * M);
  schwarzschild_place at;
  if (is_isotropic) {
    const lanes inverse = 1 / (radius + 0.5 * M), square = inverse * inverse;
    at.w = radius * square;
    at.above = -(radius * (radius - 2 * M) + 0.25 * M * M) * square * peak;
    at.lapse = (radius - 0.5 * M) * inverse;
  } else {
    at.w = 1 / radius;
    at.above = ((2 * M - radius) + M) * at.w * peak;
    at.lapse = lanes_sqrt((radius - 2 * M) * at.w);
  }
  return at;
}
#endif
