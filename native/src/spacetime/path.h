/* Points along one ray, for drawing and for tests. */
#ifndef BENT_SPACETIME_PATH_H
#define BENT_SPACETIME_PATH_H
#include "base/isa.h"
#include "bentlight/trace.h"

/* See bent_ray_path. Curved spacetimes only; the ray must have been checked. */
BENT_DECLARE_KERNEL(void, bent_march_path,
                    (const bent_spacetime *spacetime, const double origin[3], const double direction[3], double tolerance,
                     size_t n, const double *mino_times, double (*positions)[3], double (*directions)[3],
                     uint8_t *sides))
#endif
