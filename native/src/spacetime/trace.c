/* bent_trace_rays: checks the rays, then block by block asks the endpoint route and gives Taylor what that declines. */
#include "bentlight/trace.h"

#include <math.h>

#include "base/vec3.h"
#include "spacetime/endpoint.h"
#include "spacetime/path.h"
#include "spacetime/taylor.h"

/* Rays between two looks at the cancel flag; their arrays stay in the second-level cache. */
enum { BLOCK = 512 };

static bent_status refuse(const bent_spacetime *spacetime, size_t at, const double origin[3], bent_error *error)
{
  if (!bent_spacetime_contains(spacetime, origin))
    return bent_fail(error, BENT_ERROR_ARGUMENT,
                     "origins: ray %zu starts at (%g, %g, %g), which is inside a horizon or not a finite point", at,
                     origin[0], origin[1], origin[2]);
  return bent_fail(error, BENT_ERROR_ARGUMENT, "directions: ray %zu has a direction that is zero or not finite", at);
}

static bent_status check(const bent_spacetime *spacetime, size_t n, const double (*origins)[3],
                         const double (*directions)[3], double tolerance, bent_error *error)
{
  if (!(tolerance > 0) || isinf(tolerance))
    return bent_fail(error, BENT_ERROR_ARGUMENT, "tolerance: must be positive and finite, got %g", tolerance);
  const size_t bad = BENT_CALL(bent_first_bad_ray)(spacetime, n, origins, directions);
  return bad < n ? refuse(spacetime, bad, origins[bad], error) : BENT_OK;
}

static void trace_straight(size_t n, const double (*directions)[3], const bent_trace_result *out)
{
  for (size_t i = 0; i < n; i++) {
    const double *d = directions[i], length = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    if (out->fate) out->fate[i] = BENT_ESCAPED;
    if (out->direction)
      for (int k = 0; k < 3; k++) out->direction[i][k] = d[k] / length;
    if (out->error) out->error[i] = 0;
    if (out->steps) out->steps[i] = 0;
    if (out->swept) out->swept[i] = 0;
  }
}

/* One block of at most BLOCK rays by the wanted route; AUTO gives Taylor what the endpoint route declines. */
static void trace_block(const bent_spacetime *spacetime, size_t n, const double (*origins)[3],
                        const double (*directions)[3], double tolerance, bent_route route, const bent_trace_result *out)
{
  if (route == BENT_ROUTE_TAYLOR) {
    BENT_CALL(bent_trace_taylor)(spacetime, n, NULL, origins, directions, tolerance, out);
    return;
  }
  uint8_t own_fate[BLOCK];
  bent_trace_result results = *out;
  if (!results.fate) results.fate = own_fate;
  BENT_CALL(bent_trace_endpoint)(spacetime, n, origins, directions, tolerance, &results);
  if (route == BENT_ROUTE_ENDPOINT) return;
  uint32_t declined[BLOCK];
  size_t count = 0;
  for (size_t i = 0; i < n; i++) {
    declined[count] = (uint32_t)i;
    count += results.fate[i] == BENT_UNRESOLVED;
  }
  if (count) BENT_CALL(bent_trace_taylor)(spacetime, count, declined, origins, directions, tolerance, &results);
}

static bent_trace_result from(const bent_trace_result *out, size_t first)
{
  return (bent_trace_result){.fate = out->fate ? out->fate + first : NULL,
                             .direction = out->direction ? out->direction + first : NULL,
                             .error = out->error ? out->error + first : NULL,
                             .steps = out->steps ? out->steps + first : NULL,
                             .swept = out->swept ? out->swept + first : NULL};
}

bent_status bent_trace_rays(const bent_spacetime *spacetime, size_t n, const double (*origins)[3],
                            const double (*directions)[3], double tolerance, bent_route route,
                            const bent_trace_result *out, bent_progress *progress, bent_error *error)
{
  const bent_status status = check(spacetime, n, origins, directions, tolerance, error);
  if (status) return status;
  const int straight = bent_spacetime_is_flat(spacetime);
  for (size_t first = 0; first < n; first += BLOCK) {
    if (progress && atomic_load_explicit(&progress->cancel, memory_order_relaxed))
      return bent_fail(error, BENT_CANCELLED, "tracing was cancelled after %zu of %zu rays", first, n);
    const size_t count = n - first < BLOCK ? n - first : BLOCK;
    const bent_trace_result results = from(out, first);
    if (straight) trace_straight(count, directions + first, &results);
    else
      trace_block(spacetime, count, origins + first, directions + first, tolerance, route, &results);
    if (progress) atomic_fetch_add_explicit(&progress->done, count, memory_order_relaxed);
  }
  return BENT_OK;
}

bent_status bent_ray_path(const bent_spacetime *spacetime, const double origin[3], const double direction[3],
                          double tolerance, size_t n, const double *mino_times, double (*positions)[3],
                          double (*directions)[3], uint8_t *sides, bent_error *error)
{
  const bent_status status =
      check(spacetime, 1, (const double(*)[3])origin, (const double(*)[3])direction, tolerance, error);
  if (status) return status;
  for (size_t i = 0; i < n; i++)
    if (!(mino_times[i] >= (i ? mino_times[i - 1] : 0)))
      return bent_fail(error, BENT_ERROR_ARGUMENT, "mino_times: must not be negative, must ascend; entry %zu does not", i);
  if (!bent_spacetime_is_flat(spacetime)) {
    BENT_CALL(bent_march_path)(spacetime, origin, direction, tolerance, n, mino_times, positions, directions, sides);
    return BENT_OK;
  }
  const vec3 look = v3_normalize(v3_from(direction));
  for (size_t i = 0; i < n; i++) {
    sides[i] = 0;
    v3_to(positions[i], v3_mad(look, mino_times[i], v3_from(origin)));
    v3_to(directions[i], look);
  }
  return BENT_OK;
}
