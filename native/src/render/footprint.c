/* See footprint.h. */
#include "render/footprint.h"

#include "geometry/geometry.h"
#include "render/direct.h"
#include "scene/scene.h"

enum { SIDES = 4 }; /* left, right, below, above */
/* Angular error of the rays, over what they are to measure. */
static const double PRECISION = 0.03;

/* Rays of some paths. */
typedef struct bundle {
  int count;
  int path[SIDES * DIRECT_BATCH], side[SIDES * DIRECT_BATCH];
  bent_ray rays[SIDES * DIRECT_BATCH];
  bent_hit hits[SIDES * DIRECT_BATCH];
} bundle;

static int sees_sky(const path *p, const bent_hit *hit)
{
  return p->ray.bounces == 0 && p->sky_filter > 0 && (hit->fate == BENT_ESCAPED || hit->fate == BENT_ESCAPED_FAR);
}

/* Adds the ray to one side of a path's own, if the camera has it. */
static void add_ray(const tracer *t, bundle *b, int index, const path *p, int side)
{
  const double step = (side & 1 ? 1 : -1) * p->sky_filter;
  const double x = p->image[0] + (side < 2 ? step / t->settings->width : 0);
  const double y = p->image[1] + (side < 2 ? 0 : step / t->settings->height);
  camera_ray camera;
  if (!camera_cast_lens(t->scene->camera, x, y, p->lens, &camera)) return;
  bent_ray *ray = &b->rays[b->count];
  *ray = (bent_ray){.length_max = INFINITY}; /* it sees nothing: visibility 0 */
  path_set_ray(t, ray, camera.origin, camera.direction, NULL);
  const double part = min2(PRECISION * p->sky_filter * t->pixel_slope / ray->angular_tolerance, 1);
  if (part > 0) ray->angular_tolerance *= part, ray->tolerance *= part;
  b->path[b->count] = index;
  b->side[b->count++] = side;
}

/* From the directions on both sides, or from one of them and that in the middle. */
static vec3 change(const vec3 sides[2], const int has[2], vec3 middle)
{
  if (has[0] && has[1]) return v3_scale(v3_sub(sides[1], sides[0]), 0.5);
  if (has[0]) return v3_sub(middle, sides[0]);
  return has[1] ? v3_sub(sides[1], middle) : v3(0, 0, 0);
}

/* footprint_measure where some path asks: those that are `known` in `out`. */
static bent_status measure(const tracer *t, int count, const path *paths, const bent_hit *hits, footprint *out,
                           bent_progress *progress, bent_error *error)
{
  bundle b;
  b.count = 0;
  vec3 directions[DIRECT_BATCH][SIDES];
  int has[DIRECT_BATCH][SIDES];
  for (int i = 0; i < count; i++) {
    for (int side = 0; side < SIDES; side++) {
      has[i][side] = 0;
      if (out[i].known) add_ray(t, &b, i, &paths[i], side);
    }
  }
  const bent_status status = path_intersect(t, b.count, b.rays, b.hits, progress, error);
  if (status) return status;
  for (int k = 0; k < b.count; k++) {
    const int i = b.path[k];
    directions[i][b.side[k]] = v3_from(b.hits[k].direction);
    has[i][b.side[k]] = b.hits[k].fate == hits[i].fate && b.hits[k].sky == hits[i].sky;
  }
  for (int i = 0; i < count; i++)
    for (int axis = 0; axis < 2 && out[i].known; axis++)
      out[i].across[axis] = change(&directions[i][2 * axis], &has[i][2 * axis], v3_from(hits[i].direction));
  return BENT_OK;
}

bent_status footprint_measure(const tracer *t, int count, const path *paths, const bent_hit *hits, footprint *out,
                              bent_progress *progress, bent_error *error)
{
  int any = 0;
  for (int i = 0; i < count; i++) any |= out[i].known = sees_sky(&paths[i], &hits[i]);
  return any ? measure(t, count, paths, hits, out, progress, error) : BENT_OK;
}
