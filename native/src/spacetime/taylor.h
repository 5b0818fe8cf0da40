/* The Taylor route of bent_trace_rays: every ray, along its whole path. */
#ifndef BENT_SPACETIME_TAYLOR_H
#define BENT_SPACETIME_TAYLOR_H
#include "base/isa.h"
#include "bentlight/trace.h"

/* Traces the rays index[0 .. n) (0 .. n-1 if index is NULL) of arrays that are laid out as bent_trace_rays says; results go
 * to the rays' own places. Curved spacetimes only; rays must have been checked (bent_first_bad_ray). */
BENT_DECLARE_KERNEL(void, bent_trace_taylor,
                    (const bent_spacetime *spacetime, size_t n, const uint32_t *index, const double (*origins)[3],
                     const double (*directions)[3], double tolerance, const bent_trace_result *out))

/* The first ray whose origin is not outside the horizon and finite or whose direction is not finite and nonzero; n if all
 * are good. */
BENT_DECLARE_KERNEL(size_t, bent_first_bad_ray,
                    (const bent_spacetime *spacetime, size_t n, const double (*origins)[3],
                     const double (*directions)[3]))
#endif
