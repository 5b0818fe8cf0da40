/* The endpoint route: fate, asymptotic direction and swept angle of a ray from the separated integrals, without a path.
 *
 * Schwarzschild and Ellis by Carlson's R_F, Kerr by Gauss-Legendre sums in variables in which the integrands are smooth.
 * Full double precision where it answers (Kerr: the tolerance); it declines what it cannot do well, with fate
 * BENT_UNRESOLVED and error NaN, for Taylor arcs to do: rays within rounding of the critical one, origins it may not start
 * from, and for Kerr also E <= 0, Q < 0, origins close to the horizon (endpoint_kerr.h names them).
 */
#ifndef BENT_SPACETIME_ENDPOINT_H
#define BENT_SPACETIME_ENDPOINT_H
#include "base/isa.h"
#include "bentlight/trace.h"

/* Curved spacetimes only. origins, directions, out: n entries as in bent_trace_rays; directions need not be normalized.
 * tolerance: wanted angular error, radians; only Kerr saves time by it. Near the critical ray rounding alone exceeds any
 * tolerance: such a ray is answered while its fate is certain and its error at most BENT_TRACE_ERROR_MAX, with the error that
 * it has. A ray's answer depends on that ray alone. */
BENT_DECLARE_KERNEL(void, bent_trace_endpoint,
                    (const bent_spacetime *spacetime, size_t n, const double (*origins)[3],
                     const double (*directions)[3], double tolerance, const bent_trace_result *out))
#endif
