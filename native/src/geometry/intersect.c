/* The nearest hit along each ray: checks the rays, and sends each through flat space or through the spacetime objects. */
#include "bentlight/intersect.h"

#include <math.h>

#include "geometry/flat.h"
#include "scene/scene.h"

enum { BATCH = 256 }; /* rays between two looks at the progress cell */

static bent_status check_ray(const geometry *g, size_t index, const bent_ray *ray, bent_error *error)
{
  const vec3 o = v3_from(ray->origin), d = v3_from(ray->direction);
  if (!v3_is_finite(o) || !v3_is_finite(d) || v3_dot(d, d) == 0)
    return bent_fail(error, BENT_ERROR_ARGUMENT, "ray %zu: origin and direction must be finite and the direction not zero",
                     index);
  if (!(ray->tolerance > 0) || !(ray->angular_tolerance > 0))
    return bent_fail(error, BENT_ERROR_ARGUMENT, "ray %zu: tolerances must be positive", index);
  if (!(ray->length_min >= 0) || !(ray->length_max >= ray->length_min))
    return bent_fail(error, BENT_ERROR_ARGUMENT, "ray %zu: needs 0 <= length_min <= length_max", index);
  if (ray->source_instance >= 0 &&
      ((size_t)ray->source_instance >= g->instance_count || ray->source_triangle < 0 ||
       (size_t)ray->source_triangle >= g->meshes[g->instances[ray->source_instance].mesh].triangle_count))
    return bent_fail(error, BENT_ERROR_ARGUMENT, "ray %zu: there is no triangle %d of instance %d", index,
                     ray->source_triangle, ray->source_instance);
  return BENT_OK;
}

bent_status bent_scene_intersect(const bent_scene *scene, size_t n, const bent_ray *rays, bent_hit *hits,
                                 bent_progress *progress, bent_error *error)
{
  if (!scene->committed)
    return bent_fail(error, BENT_ERROR_STATE, "intersect: the scene has edits that are not committed");
  const geometry *g = scene->geometry;
  for (size_t begin = 0; begin < n; begin += BATCH) {
    const size_t end = begin + BATCH < n ? begin + BATCH : n;
    if (progress && atomic_load_explicit(&progress->cancel, memory_order_relaxed))
      return bent_fail(error, BENT_CANCELLED, "intersect: cancelled");
    for (size_t i = begin; i < end; i++) {
      const bent_status status = check_ray(g, i, &rays[i], error);
      if (status) return status;
    }
    for (size_t i = begin; i < end; i++) flat_intersect(g, &rays[i], &hits[i]);
    if (progress) atomic_fetch_add_explicit(&progress->done, end - begin, memory_order_relaxed);
  }
  return BENT_OK;
}
