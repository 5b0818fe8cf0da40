/* See deflection.h. */
#include "render/deflection.h"

#include <math.h>
#include <string.h>

#include "geometry/geometry.h"
#include "light/surface.h"
#include "render/direct.h"
#include "scene/scene.h"

/* Surfaces that are not there, as lamps', which a ray is followed through at most. */
enum { PASSES_MAX = 64 };

/* Rays of one row's part, and which pixels they belong to. */
typedef struct row_part {
  int count;
  uint32_t pixel[DIRECT_BATCH];
  double own[DIRECT_BATCH][2]; /* places in the picture */
  bent_ray rays[DIRECT_BATCH];
  bent_hit hits[DIRECT_BATCH];
  uint32_t borders[DIRECT_BATCH];
} row_part;

/* Whether a ray from the camera has come through a throat: by spheres alone it would have crossed an even number of borders,
 * with those that it starts (counted in `borders` already) and ends in. */
static int went_through(const tracer *t, const bent_hit *hit, uint32_t borders)
{
  const geometry *g = t->scene->geometry;
  if (hit->fate == BENT_ESCAPED_FAR) return 1;
  if (g->lens_count == 1 && isinf(g->lenses[0].radius)) return 0;
  const int ends_in = hit->fate == BENT_HIT && geometry_lens_at(g, v3_from(hit->position));
  return (borders + (uint32_t)ends_in) % 2;
}

/* Lets a ray go on if it has met what is not there. */
static int goes_on(const tracer *t, bent_ray *ray, const bent_hit *hit)
{
  surface surface;
  if (hit->fate != BENT_HIT) return 0;
  surface_at(t->scene, hit, hit->length, &surface);
  if (!surface.see_through && !(t->scene->geometry->instances[hit->instance].visibility & BENT_IMMATERIAL)) return 0;
  ray->length_min = fmax(ray->length_min - hit->length, 0);
  ray->length_max -= hit->length;
  path_set_ray(t, ray, v3_from(hit->position), v3_from(hit->direction), hit);
  return 1;
}

/* Where the unbent picture shows what a ray from the place `own` has met. */
static void map_place(const tracer *t, const bent_hit *hit, uint32_t borders, const double own[2], float out[3])
{
  const camera *camera = t->scene->camera;
  const int is_place = hit->fate == BENT_HIT;
  if ((!is_place && hit->fate != BENT_ESCAPED) || went_through(t, hit, borders)) return;
  const vec3 seen = is_place ? v3_normalize(v3_sub(v3_from(hit->position), t->eye)) : v3_from(hit->direction);
  double at[2];
  int is_seen = 1;
  if (camera->settings.kind != BENT_CAMERA_ORTHOGRAPHIC) is_seen = camera_place_near(camera, seen, own, at);
  else if (is_place) camera_place_of_point(camera, v3_from(hit->position), at);
  else is_seen = 0; /* parallel rays of a flat picture all see one place of the sky */
  if (is_seen) out[0] = (float)at[0], out[1] = (float)at[1], out[2] = 1;
}

/* Follows the rays of a part to their ends. */
static bent_status follow(const tracer *t, row_part *part, float (*row)[3], bent_progress *progress, bent_error *error)
{
  for (int round = 0; part->count && round < PASSES_MAX; round++) {
    const bent_status status = path_intersect(t, part->count, part->rays, part->hits, progress, error);
    if (status) return status;
    int kept = 0;
    for (int i = 0; i < part->count; i++) {
      const uint32_t borders = part->borders[i] + part->hits[i].borders;
      if (goes_on(t, &part->rays[i], &part->hits[i])) {
        part->rays[kept] = part->rays[i], part->pixel[kept] = part->pixel[i], part->borders[kept] = borders;
        part->own[kept][0] = part->own[i][0], part->own[kept][1] = part->own[i][1];
        kept++;
      } else {
        map_place(t, &part->hits[i], borders, part->own[i], row[part->pixel[i]]);
      }
    }
    part->count = kept;
  }
  return BENT_OK;
}

bent_status deflection_measure(const tracer *t, const uint32_t tile[4], float (*out)[3], bent_progress *progress,
                               bent_error *error)
{
  memset(out, 0, (size_t)tile[2] * tile[3] * sizeof *out);
  for (uint32_t j = 0; j < tile[3]; j++) {
    for (uint32_t first = 0; first < tile[2]; first += DIRECT_BATCH) {
      row_part part = {.count = 0};
      for (uint32_t i = first; i < tile[2] && i < first + DIRECT_BATCH; i++) {
        const double x = (tile[0] + i + 0.5) / t->settings->width, y = (tile[1] + j + 0.5) / t->settings->height;
        camera_ray camera;
        if (!camera_cast(t->scene->camera, x, y, &camera) || !path_can_leave(t, camera.origin)) continue;
        const int k = part.count++;
        part.pixel[k] = i, part.own[k][0] = x, part.own[k][1] = y;
        part.borders[k] = geometry_lens_at(t->scene->geometry, camera.origin) != NULL;
        part.rays[k] = (bent_ray){.length_min = camera.length_min, .length_max = camera.length_max,
                                  .visibility = BENT_VISIBLE_CAMERA};
        path_set_ray(t, &part.rays[k], camera.origin, camera.direction, NULL);
      }
      const bent_status status = follow(t, &part, out + (size_t)j * tile[2], progress, error);
      if (status) return status;
    }
  }
  return BENT_OK;
}
