/* Rays from finite observers to infinity or the horizon, in batches.
 *
 * Two routes lead there (design: separable geodesics in Mino time). ENDPOINT solves the separated integrals and needs no
 * path; it declines rays it cannot do well. TAYLOR marches Taylor arcs and covers everything. AUTO asks ENDPOINT first.
 */
#ifndef BENTLIGHT_TRACE_H
#define BENTLIGHT_TRACE_H
#include <stddef.h>
#include "bentlight/spacetime.h"

/* A ray whose estimated error, radians, is larger (and larger than its tolerance) is unresolved: its direction would be
 * noise. */
#define BENT_TRACE_ERROR_MAX 0.5

typedef enum bent_fate {
  BENT_UNRESOLVED = 0, /* nearer to the critical ray than double precision can tell */
  BENT_ESCAPED = 1,
  BENT_CAPTURED = 2,
  BENT_ESCAPED_FAR = 3, /* out on the far side of a wormhole */
  BENT_HIT = 4          /* only from bent_scene_intersect */
} bent_fate;

typedef enum bent_route { BENT_ROUTE_AUTO, BENT_ROUTE_ENDPOINT, BENT_ROUTE_TAYLOR } bent_route;

/* Caller-owned result arrays of n entries; any pointer may be NULL. */
typedef struct bent_trace_result {
  uint8_t *fate;          /* bent_fate; with ROUTE_ENDPOINT a declined ray is BENT_UNRESOLVED with error NaN */
  double (*direction)[3]; /* asymptotic unit direction (ESCAPED_FAR: angular position on the far side); else NaN */
  double *error;          /* estimated angular error, radians: at least half of the true one, at any spin */
  uint32_t *steps;        /* Taylor arcs used; 0 on the endpoint route */
  double *swept;          /* angle swept about the center, radians: the length of the path of n on the unit sphere in the
                             axes that the hole drags along, the integral of |dn/dlambda|, to the ray's end; NaN where
                             the endpoint route answers BENT_CAPTURED. Error: that of the direction, in Kerr 1e-4 of
                             1 + swept more (measured: 4e-5): it counts windings, no direction hangs on it */
} bent_trace_result;

/* origins: (n, 3) positions in spacetime axes. directions: (n, 3) local unit directions (normalised here; a zero or
 * non-finite one is an argument error, as is an origin inside a horizon). tolerance: wanted angular error, radians. */
bent_status bent_trace_rays(const bent_spacetime *spacetime, size_t n, const double (*origins)[3],
                            const double (*directions)[3], double tolerance, bent_route route,
                            const bent_trace_result *out, bent_progress *progress, bent_error *error);

/* Points along one ray at n ascending Mino times (dlambda = d(affine)/Sigma, local energy 1; units 1/length; in flat space
 * the times are scene lengths): positions and local unit directions, (n, 3) each, NaN beyond the ray's end. sides[i] is 1
 * where a point lies beyond the throat: it is then in the other mouth's axes. */
bent_status bent_ray_path(const bent_spacetime *spacetime, const double origin[3], const double direction[3],
                          double tolerance, size_t n, const double *mino_times, double (*positions)[3],
                          double (*directions)[3], uint8_t *sides, bent_error *error);
#endif
