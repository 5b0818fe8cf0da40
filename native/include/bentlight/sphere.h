/* Crossing a lens sphere by table: a sphere around a Schwarzschild hole or an Ellis mouth, with flat space outside.
 *
 * With the radius fixed all depends on one number, delta = b/b_c - 1. For a ray that enters, with cosine and sine of its
 * angle to the inward radial, there are columns of two numbers each, piecewise polynomials by the bits of a float:
 *   delta > 0, turns back and leaves: (swept angle, drawn length) / cosine, which is smooth up to the rays that graze the
 *     sphere (both are odd in the cosine, as the way out mirrors the way in);
 *   delta < 0, goes down: swept angle and drawn length to the horizon (where the arcs of traced rays end too, at 1 - 1e-7 of
 *     its 1/r) or to the throat.
 * The drawn length is the Euclidean one of the path as the chart draws it. What columns hold comes from Gauss-Legendre sums
 * over Jacobi-like angles (sphere_integrals.h).
 */
#ifndef BENTLIGHT_SPHERE_H
#define BENTLIGHT_SPHERE_H
#include <stddef.h>
#include "bentlight/spacetime.h"

typedef struct bent_sphere bent_sphere;

/* What lookups differ by from direct evaluation, measured between the nodes of every segment when the table was built:
 * radians, and chart units of the radius. Measured: 2e-13, and 2e-13 of the radius. */
typedef struct bent_sphere_error {
  double swept_max, swept_rms;
  double length_max, length_rms;
} bent_sphere_error;

/* Nonzero if a sphere of this chart radius can have a table: Schwarzschild with mass > 0 from r = 4 M on, Ellis from
 * l = rho / 4 on, up to 1e6 times that. */
int bent_sphere_is_tabulated(const bent_spacetime *spacetime, double radius);
/* Builds it, in about a millisecond. BENT_ERROR_ARGUMENT unless bent_sphere_is_tabulated. */
bent_status bent_sphere_new(const bent_spacetime *spacetime, double radius, bent_sphere **out, bent_error *error);
void bent_sphere_free(bent_sphere *sphere);
bent_sphere_error bent_sphere_measured(const bent_sphere *sphere);

/* Caller-owned result arrays of n entries. NaN where the fate leaves nothing to say. */
typedef struct bent_crossing {
  uint8_t *fate;          /* bent_fate, and BENT_UNRESOLVED where the table declines: delta too close to 0, or a start that
                           * is not what it should be */
  double (*exit)[3];      /* ESCAPED: a point of the sphere; ESCAPED_FAR: of the throat, in these axes */
  double (*direction)[3]; /* local unit direction there */
  double *swept;          /* radians; CAPTURED: to the horizon */
  double *length;         /* drawn inside, chart units */
  double *error;          /* of the angles, radians: the measured one, and what rounding of the start makes of it */
} bent_crossing;

/* Rays that enter at points of the sphere: (n, 3) each, in spacetime axes, directions (any length) inward. Any number of
 * threads may ask at once. */
void bent_sphere_cross(const bent_sphere *sphere, size_t n, const double (*points)[3], const double (*directions)[3],
                       const bent_crossing *out);
/* Rays that come out of the throat, from points of it, in outward directions: ESCAPED, at the sphere. Ellis only. */
void bent_sphere_emerge(const bent_sphere *sphere, size_t n, const double (*points)[3], const double (*directions)[3],
                        const bent_crossing *out);
#endif
