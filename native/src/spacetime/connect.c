/* bent_connect and bent_connect_sky: check the pairs, join them block by block; in flat space by straight lines. */
#include "spacetime/connect.h"

#include <math.h>

#include "base/vec3.h"

static bent_status check_points(const bent_spacetime *spacetime, const char *name, size_t n, const double (*points)[3],
                                bent_error *error)
{
  for (size_t i = 0; i < n; i++)
    if (!bent_spacetime_contains(spacetime, points[i]))
      return bent_fail(error, BENT_ERROR_ARGUMENT,
                       "%s: point %zu is (%g, %g, %g), inside a horizon or not a finite point", name, i, points[i][0],
                       points[i][1], points[i][2]);
  return BENT_OK;
}

static bent_status check_directions(size_t n, const double (*directions)[3], bent_error *error)
{
  for (size_t i = 0; i < n; i++) {
    const vec3 d = v3_from(directions[i]);
    const double length2 = v3_dot(d, d);
    if (!(length2 >= 1e-300 && length2 <= 1e300))
      return bent_fail(error, BENT_ERROR_ARGUMENT, "directions: direction %zu is zero or not finite", i);
  }
  return BENT_OK;
}

static bent_status check_request(const bent_spacetime *s, const connect_request *request, bent_error *error)
{
  if (request->max_images < 1 || request->max_images > BENT_CONNECT_IMAGES_MAX)
    return bent_fail(error, BENT_ERROR_ARGUMENT, "max_images: must be 1 to %d, got %zu", BENT_CONNECT_IMAGES_MAX,
                     request->max_images);
  if (!(request->min_share >= 0 && request->min_share < 1))
    return bent_fail(error, BENT_ERROR_ARGUMENT, "min_share: must be in [0, 1), got %g", request->min_share);
  if (!(request->tolerance > 0) || isinf(request->tolerance))
    return bent_fail(error, BENT_ERROR_ARGUMENT, "tolerance: must be positive and finite, got %g", request->tolerance);
  if (request->far_side && s->kind != BENT_ELLIS)
    return bent_fail(error, BENT_ERROR_ARGUMENT, "far_side: only a wormhole has one");
  return BENT_OK;
}

static void store_straight(vec3 from, vec3 to, const connect_request *request, size_t at, const bent_connections *out,
                           bent_connection_count *count)
{
  const vec3 way = request->sky ? to : v3_sub(to, from), direction = v3_normalize(way);
  const double length2 = v3_dot(way, way), sine = v3_length(v3_cross(from, to)), cosine = v3_dot(from, to);
  const int known = length2 > 0;
  ++*(known ? &count->met : &count->failed);
  if (out->status) out->status[at] = known ? BENT_CONNECTION_MET : BENT_CONNECTION_FAILED;
  if (out->launch) v3_to(out->launch[at], known ? direction : v3_splat(NAN));
  if (out->arrival) v3_to(out->arrival[at], known ? direction : v3_splat(NAN));
  if (out->spread) out->spread[at] = known ? (request->sky ? 1 : length2) : NAN;
  if (out->frequency_ratio) out->frequency_ratio[at] = known ? 1 : NAN;
  if (out->swept) out->swept[at] = sine > 0 || cosine != 0 ? atan2(sine, cosine) : 0;
  if (out->error) out->error[at] = known ? 0 : NAN;
}

static void store_none(size_t at, const bent_connections *out, bent_connection_count *count)
{
  count->none++;
  if (out->status) out->status[at] = BENT_CONNECTION_NONE;
  if (out->launch) v3_to(out->launch[at], v3_splat(NAN));
  if (out->arrival) v3_to(out->arrival[at], v3_splat(NAN));
  if (out->spread) out->spread[at] = NAN;
  if (out->frequency_ratio) out->frequency_ratio[at] = NAN;
  if (out->swept) out->swept[at] = NAN;
  if (out->error) out->error[at] = NAN;
}

/* Flat space: one straight ray, and no other image. */
static void connect_straight(size_t n, const double (*a)[3], const double (*b)[3], const connect_request *request,
                             const bent_connections *out, bent_connection_count *count)
{
  for (size_t i = 0; i < n; i++) {
    store_straight(v3_from(a[i]), v3_from(b[i]), request, i * request->max_images, out, count);
    for (size_t k = 1; k < request->max_images; k++) store_none(i * request->max_images + k, out, count);
  }
}

static bent_connections from(const bent_connections *out, size_t at)
{
  return (bent_connections){.status = out->status ? out->status + at : NULL,
                            .launch = out->launch ? out->launch + at : NULL,
                            .arrival = out->arrival ? out->arrival + at : NULL,
                            .spread = out->spread ? out->spread + at : NULL,
                            .frequency_ratio = out->frequency_ratio ? out->frequency_ratio + at : NULL,
                            .swept = out->swept ? out->swept + at : NULL,
                            .error = out->error ? out->error + at : NULL};
}

static bent_status connect_all(const bent_spacetime *spacetime, size_t n, const double (*a)[3], const double (*b)[3],
                               const connect_request *request, const bent_connections *out,
                               bent_connection_count *count, bent_progress *progress, bent_error *error)
{
  bent_connection_count counted = {0};
  const int straight = bent_spacetime_is_flat(spacetime), spins = spacetime->kind == BENT_KERR && spacetime->spin != 0;
  for (size_t first = 0; first < n; first += CONNECT_BLOCK) {
    if (progress && atomic_load_explicit(&progress->cancel, memory_order_relaxed))
      return bent_fail(error, BENT_CANCELLED, "connecting was cancelled after %zu of %zu pairs", first, n);
    const size_t block = n - first < CONNECT_BLOCK ? n - first : CONNECT_BLOCK;
    const bent_connections results = from(out, first * request->max_images);
    if (straight) connect_straight(block, a + first, b + first, request, &results, &counted);
    else if (spins)
      BENT_CALL(bent_connect_kerr)(spacetime, block, a + first, b + first, request, &results, &counted);
    else
      BENT_CALL(bent_connect_pairs)(spacetime, block, a + first, b + first, request, &results, &counted);
    if (progress) atomic_fetch_add_explicit(&progress->done, block, memory_order_relaxed);
  }
  if (count) *count = counted;
  return BENT_OK;
}

bent_status bent_connect(const bent_spacetime *spacetime, size_t n, const double (*points_a)[3],
                         const double (*points_b)[3], size_t max_images, double min_share, double tolerance,
                         const bent_connections *out, bent_connection_count *count, bent_progress *progress,
                         bent_error *error)
{
  const connect_request request = {max_images, min_share, tolerance, 0, 0};
  bent_status status = check_request(spacetime, &request, error);
  if (!status) status = check_points(spacetime, "points_a", n, points_a, error);
  if (!status) status = check_points(spacetime, "points_b", n, points_b, error);
  return status ? status : connect_all(spacetime, n, points_a, points_b, &request, out, count, progress, error);
}

bent_status bent_connect_sky(const bent_spacetime *spacetime, size_t n, const double (*points)[3],
                             const double (*directions)[3], int far_side, size_t max_images, double min_share,
                             double tolerance, const bent_connections *out, bent_connection_count *count,
                             bent_progress *progress, bent_error *error)
{
  const connect_request request = {max_images, min_share, tolerance, 1, far_side};
  bent_status status = check_request(spacetime, &request, error);
  if (!status) status = check_points(spacetime, "points", n, points, error);
  if (!status) status = check_directions(n, directions, error);
  return status ? status : connect_all(spacetime, n, points, directions, &request, out, count, progress, error);
}
