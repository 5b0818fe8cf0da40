/* See compression.h. */
#include "render/compression.h"

#include <stdlib.h>
#include <string.h>

#include "geometry/geometry.h"
#include "scene/scene.h"

/* Radians of spread that ask for one more sample: about what lamps and furniture subtend. Where pixels see less than that,
 * the noise of what they see hardly depends on how much it is. */
static const double SPREAD_OF_A_SAMPLE = 0.1;

/* What has become of a ray. */
typedef enum outcome { NO_RAY, DARK, NEAR_SIDE, FAR_SIDE } outcome;

/* The two traces of the ray through a corner: as it is, and without surfaces. */
enum { TRACES = 2 };
typedef struct corner {
  vec3 launch;
  struct {
    outcome outcome;
    vec3 direction;
  } end[TRACES];
} corner;

/* Room for one row of corners, and for their rays. */
typedef struct corner_row {
  corner *corners;
  bent_ray *rays;
  bent_hit *hits;
  uint32_t *of_ray; /* corner of each pair of rays */
} corner_row;

static outcome outcome_of(const bent_hit *hit)
{
  switch (hit->fate) {
    case BENT_HIT:
    case BENT_ESCAPED: return NEAR_SIDE;
    case BENT_ESCAPED_FAR: return FAR_SIDE;
    default: return DARK;
  }
}

/* Traces the rays through corners number 0 .. width of the row at height y, of which the first is at x. */
static bent_status trace_row(const tracer *t, const corner_row *row, uint32_t x, uint32_t y, uint32_t width,
                             bent_progress *progress, bent_error *error)
{
  int count = 0;
  for (uint32_t i = 0; i <= width; i++) {
    camera_ray camera;
    row->corners[i] = (corner){0};
    if (!camera_cast(t->scene->camera, (double)(x + i) / t->settings->width, (double)y / t->settings->height, &camera) ||
        !path_can_leave(t, camera.origin))
      continue;
    row->corners[i].launch = camera.direction;
    row->of_ray[count] = i;
    bent_ray *rays = row->rays + TRACES * count++;
    rays[0] = (bent_ray){.length_min = camera.length_min, .length_max = camera.length_max,
                         .visibility = BENT_VISIBLE_CAMERA};
    path_set_ray(t, &rays[0], camera.origin, camera.direction, NULL);
    rays[1] = rays[0];
    rays[1].visibility = 0;
  }
  const bent_status status = path_intersect(t, TRACES * count, row->rays, row->hits, progress, error);
  for (int i = 0; i < TRACES * count && !status; i++) {
    corner *c = &row->corners[row->of_ray[i / TRACES]];
    c->end[i % TRACES].outcome = outcome_of(&row->hits[i]);
    c->end[i % TRACES].direction = v3_from(row->hits[i].direction);
  }
  return status;
}

/* Radians by which two corners' rays are farther apart in one of the traces than at the camera; INFINITY where they part. */
static double spread_of(const corner *a, const corner *b, int trace)
{
  if (a->end[trace].outcome != b->end[trace].outcome) return INFINITY;
  if (a->end[trace].outcome == DARK) return 0;
  const double before = v3_length(v3_sub(a->launch, b->launch));
  return v3_length(v3_sub(a->end[trace].direction, b->end[trace].direction)) - before;
}

static double spread(const corner *a, const corner *b)
{
  if (a->end[0].outcome == NO_RAY || b->end[0].outcome == NO_RAY) return 0;
  return min2(spread_of(a, b, 0), spread_of(a, b, 1));
}

/* Pixels of one row between the corners below and above. */
static void measure_row(const corner *below, const corner *above, uint32_t width, uint32_t most, uint8_t *out)
{
  for (uint32_t i = 0; i < width; i++) {
    const double horizontal = max2(spread(&below[i], &below[i + 1]), spread(&above[i], &above[i + 1]));
    const double vertical = max2(spread(&below[i], &above[i]), spread(&below[i + 1], &above[i + 1]));
    const double wanted = 1.5 + max2(max2(horizontal, vertical), 0) / SPREAD_OF_A_SAMPLE;
    out[i] = (uint8_t)min2(wanted, most);
  }
}

static int bends_light(const geometry *g)
{
  for (size_t i = 0; i < g->lens_count; i++)
    if (!g->lenses[i].flat) return 1;
  return 0;
}

bent_status compression_measure(const tracer *t, const uint32_t tile[4], uint32_t most, uint8_t *out,
                                bent_progress *progress, bent_error *error)
{
  const uint32_t width = tile[2], height = tile[3];
  memset(out, 1, (size_t)width * height);
  if (most == 1 || !bends_light(t->scene->geometry)) return BENT_OK;
  const size_t n = (size_t)width + 1;
  corner *corners = malloc(2 * n * sizeof *corners); /* the row below and the row above */
  corner_row row = {.rays = malloc(TRACES * n * sizeof *row.rays), .hits = malloc(TRACES * n * sizeof *row.hits),
                    .of_ray = malloc(n * sizeof *row.of_ray)};
  bent_status status = BENT_OK;
  if (!corners || !row.rays || !row.hits || !row.of_ray) status = bent_fail(error, BENT_ERROR_MEMORY, "render: out of memory");
  for (uint32_t j = 0; j <= height && !status; j++) {
    const corner *below = corners + (j + 1) % 2 * n;
    row.corners = corners + j % 2 * n;
    status = trace_row(t, &row, tile[0], tile[1] + j, width, progress, error);
    if (j && !status) measure_row(below, row.corners, width, most, out + (size_t)(j - 1) * width);
  }
  free(corners);
  free(row.rays);
  free(row.hits);
  free(row.of_ray);
  return status;
}
