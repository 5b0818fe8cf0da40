/* Deflection tables: fate and swept angle of a ray by lookup instead of integration, for Schwarzschild and Ellis.
 *
 * By symmetry a ray is two numbers: where it starts and its angle to the radial direction. With delta = b/b_c - 1 the table
 * holds, as piecewise polynomials,
 *   total(delta): the angle swept from infinity back to infinity (Schwarzschild: delta > 0; Ellis: either side of b = rho),
 *     segments by the bits of the float delta, so that its logarithmic divergence costs no logarithm;
 *   J = I / sin(psi): I is the angle swept going out to infinity from a finite radius at the angle psi to the outward radial.
 * A ray going out sweeps I, a ray going in total - I. Radii closer than 4 M (Ellis: |l| < rho / 4) and deltas beyond the
 * segments are computed directly, which is exact and slower. Rays that just cross a sphere: sphere.h.
 */
#ifndef BENTLIGHT_TABLE_H
#define BENTLIGHT_TABLE_H
#include "bentlight/trace.h"

/* Positions that J is tabulated for: M/r from 0 to the first, l/r (l = rho / 4) from the second to 1. */
#define BENT_TABLE_SCHWARZSCHILD_MAX 0.25
#define BENT_TABLE_ELLIS_MIN 0.24253562503633297

typedef struct bent_table bent_table;

/* What lookups differ by from direct evaluation, radians, measured between the nodes of every segment when it was built. */
typedef struct bent_table_error {
  double total_max, total_rms; /* of total(delta), 2^-44 <= |delta| < 2^20 */
  double sweep_max, sweep_rms; /* of I */
} bent_table_error;

/* An empty table of a Schwarzschild spacetime with mass > 0 or an Ellis wormhole. */
bent_status bent_table_new(const bent_spacetime *spacetime, bent_table **out, bent_error *error);
void bent_table_free(bent_table *table);
/* The table is built by rows, in any order; different rows may be built by different threads at once. */
size_t bent_table_rows(const bent_table *table);
/* Rows first <= row < last; adds 1 to progress->done (progress may be NULL) for each. */
bent_status bent_table_build(bent_table *table, size_t first, size_t last, bent_progress *progress, bent_error *error);
/* BENT_ERROR_STATE while a row is missing: then no lookup may be made. */
bent_status bent_table_measured(const bent_table *table, bent_table_error *out, bent_error *error);

/* Lookups, n entries each; a built table may serve any number of threads. */
/* angle: swept from infinity to infinity, radians (the deflection is angle - pi). delta <= 0 in Schwarzschild, delta <= -1
 * and delta = 0 in Ellis, and NaN give NaN. */
void bent_table_total(const bent_table *table, size_t n, const double *delta, double *angle);
/* radius: in the chart. cosine, sine: of the local angle between direction and outward radial; sine >= 0 (both, because
 * far away neither gives the other). fate: bent_fate, BENT_UNRESOLVED within rounding of the critical ray. swept: NaN unless
 * it escapes. */
void bent_table_sweep(const bent_table *table, size_t n, const double *radius, const double *cosine, const double *sine,
                      uint8_t *fate, double *swept);
/* Positions and local directions in, fate and asymptotic direction out, as bent_trace_rays does; error is the table's
 * measured one plus rounding, steps 0. */
void bent_table_trace(const bent_table *table, size_t n, const double (*origins)[3], const double (*directions)[3],
                      const bent_trace_result *out);
#endif
