/* One tile of the picture: checks, and the order of its samples. */
#include <math.h>
#include <stdlib.h>

#include "bentlight/render.h"
#include "geometry/geometry.h"
#include "render/camera.h"
#include "render/film.h"
#include "render/path.h"
#include "scene/scene.h"

/* Every field is checked here, so that nothing behind needs to. */
static bent_status check(const bent_scene *scene, const bent_render_settings *s, const uint32_t tile[4],
                         bent_error *error)
{
  if (!scene->camera) return bent_fail(error, BENT_ERROR_STATE, "render: the scene has no camera");
  if (!scene->committed) return bent_fail(error, BENT_ERROR_STATE, "render: the scene has edits without a commit");
  if (s->width < 1 || s->height < 1 || s->width > 1u << 16 || s->height > 1u << 16)
    return bent_fail(error, BENT_ERROR_ARGUMENT, "render: the image must be 1 to 65536 pixels wide and high, got %u x %u",
                     s->width, s->height);
  if ((uint64_t)tile[0] + tile[2] > s->width || (uint64_t)tile[1] + tile[3] > s->height)
    return bent_fail(error, BENT_ERROR_ARGUMENT, "render: tile (%u, %u) of %u x %u leaves the image of %u x %u",
                     tile[0], tile[1], tile[2], tile[3], s->width, s->height);
  if (s->sample_count < 1 || (uint64_t)s->first_sample + s->sample_count >= 1ull << 31)
    return bent_fail(error, BENT_ERROR_ARGUMENT,
                     "render: sample_count must be at least 1 and first_sample + sample_count below 2^31");
  if (!(s->tolerance > 0 && s->tolerance <= 0.1))
    return bent_fail(error, BENT_ERROR_ARGUMENT, "render: tolerance must lie in (0, 0.1] radians, got %g", s->tolerance);
  if (!(s->filter_width >= 0.01 && s->filter_width <= 30))
    return bent_fail(error, BENT_ERROR_ARGUMENT, "render: filter_width must lie in [0.01, 30] pixels, got %g",
                     s->filter_width);
  if (!(s->clamp_direct >= 0 && s->clamp_indirect >= 0))
    return bent_fail(error, BENT_ERROR_ARGUMENT, "render: clamp_direct and clamp_indirect must not be negative, got %g, %g",
                     s->clamp_direct, s->clamp_indirect);
  if (!(s->noise_threshold >= 0) || s->min_samples < 2)
    return bent_fail(error, BENT_ERROR_ARGUMENT,
                     "render: noise_threshold must not be negative and min_samples at least 2, got %g and %u",
                     s->noise_threshold, s->min_samples);
  if (!(s->light_threshold >= 0))
    return bent_fail(error, BENT_ERROR_ARGUMENT, "render: light_threshold must not be negative, got %g",
                     s->light_threshold);
  if ((unsigned)s->light_sampling >= BENT_LIGHT_SAMPLINGS)
    return bent_fail(error, BENT_ERROR_ARGUMENT, "render: there is no light_sampling %d", (int)s->light_sampling);
  if (!(s->alpha_threshold >= 0 && s->alpha_threshold <= 1))
    return bent_fail(error, BENT_ERROR_ARGUMENT, "render: alpha_threshold must lie in [0, 1], got %g",
                     s->alpha_threshold);
  return BENT_OK;
}

/* The camera must stand where light can leave. */
static bent_status check_camera(const bent_scene *scene, bent_error *error)
{
  camera_ray ray;
  if (!camera_cast(scene->camera, 0.5, 0.5, &ray)) return BENT_OK;
  for (size_t i = 0; i < scene->geometry->lens_count; i++) {
    const lens *l = &scene->geometry->lenses[i];
    double local[3];
    v3_to(local, mat4_point(&l->spacetime_from_world, ray.origin));
    if (!l->flat && !bent_spacetime_contains(&l->spacetime, local))
      return bent_fail(error, BENT_ERROR_ARGUMENT, "render: the camera is inside the horizon of spacetime object %zu", i);
  }
  return BENT_OK;
}

/* Samples are taken in strips of pixels, as many as a film holds; within a strip sample by sample, so that a cancelled
 * call leaves an even picture. */
enum { BLOCK_SAMPLES = 1024 };
/* Samples between two looks at a pixel's noise, as in Cycles. */
enum { NOISE_CHECK = 16 };

/* A strip of a tile's pixels, and those of them that still want samples. */
typedef struct strip {
  const uint32_t *tile; /* x, y, width, height */
  size_t first;         /* number within the tile of the strip's first pixel */
  uint32_t count;       /* of pixels below */
  uint32_t pixels[FILM_PIXELS];
} strip;

/* Takes samples number taken .. taken + more - 1 of all pixels of the strip that want them. */
static bent_status take_samples(const tracer *t, film *film, path_block *block, const strip *strip, uint32_t taken,
                                uint32_t more, bent_render_statistics *statistics, bent_progress *progress,
                                bent_error *error)
{
  const uint64_t total = (uint64_t)strip->count * more;
  for (uint64_t begin = 0; begin < total; begin += BLOCK_SAMPLES) {
    const int count = (int)(total - begin < BLOCK_SAMPLES ? total - begin : BLOCK_SAMPLES);
    pixel_sample wanted[BLOCK_SAMPLES];
    for (int i = 0; i < count; i++) {
      const uint64_t at = begin + (uint64_t)i;
      const size_t pixel = strip->first + strip->pixels[at % strip->count];
      wanted[i] = (pixel_sample){strip->tile[0] + (uint32_t)(pixel % strip->tile[2]),
                                 strip->tile[1] + (uint32_t)(pixel / strip->tile[2]),
                                 t->settings->first_sample + taken + (uint32_t)(at / strip->count)};
    }
    const bent_status status = path_trace(t, block, count, wanted, statistics, progress, error);
    if (status) return status;
    for (int i = 0; i < count; i++)
      film_add(film, strip->pixels[(begin + (uint64_t)i) % strip->count], &block->records[i]);
    statistics->samples += (uint64_t)count;
    if (progress) atomic_fetch_add_explicit(&progress->done, (uint64_t)count, memory_order_relaxed);
  }
  return BENT_OK;
}

/* Drops the pixels whose noise is low enough. A pixel's own samples decide, so that tiles do not matter. */
static void drop_clean(strip *strip, const film *film, double threshold)
{
  uint32_t kept = 0;
  for (uint32_t i = 0; i < strip->count; i++)
    if (!(film_noise(film, strip->pixels[i]) < threshold)) strip->pixels[kept++] = strip->pixels[i];
  strip->count = kept;
}

/* Takes the samples of the strip of `pixels` pixels that begins with number `first` of the tile. */
static bent_status render_strip(const tracer *t, film *film, path_block *block, const uint32_t tile[4], size_t first,
                                uint32_t pixels, bent_render_statistics *statistics, bent_progress *progress,
                                bent_error *error)
{
  const bent_render_settings *s = t->settings;
  const int adaptive = s->noise_threshold > 0;
  strip strip = {.tile = tile, .first = first, .count = pixels};
  for (uint32_t i = 0; i < pixels; i++) strip.pixels[i] = i;
  for (uint32_t taken = 0, more; taken < s->sample_count && strip.count; taken += more) {
    more = !adaptive ? s->sample_count : taken ? NOISE_CHECK : s->min_samples;
    if (more > s->sample_count - taken) more = s->sample_count - taken;
    const bent_status status = take_samples(t, film, block, &strip, taken, more, statistics, progress, error);
    if (status) return status;
    const uint32_t before = strip.count;
    if (adaptive) drop_clean(&strip, film, s->noise_threshold);
    if (progress) /* samples that are not needed count as done */
      atomic_fetch_add_explicit(&progress->done, (uint64_t)(before - strip.count) * (s->sample_count - taken - more),
                                memory_order_relaxed);
  }
  return BENT_OK;
}

bent_status bent_scene_render_tile(const bent_scene *scene, uint32_t x, uint32_t y, uint32_t width, uint32_t height,
                                   const bent_render_settings *settings, float *const channels[BENT_CHANNELS_MAX],
                                   bent_render_statistics *statistics, bent_progress *progress, bent_error *error)
{
  const uint32_t tile[4] = {x, y, width, height};
  *statistics = (bent_render_statistics){0};
  bent_status status = check(scene, settings, tile, error);
  if (!status) status = check_camera(scene, error);
  if (status) return status;
  tracer t;
  path_block block;
  tracer_init(&t, scene, settings);
  status = path_block_new(&block, scene, BLOCK_SAMPLES, error);
  if (status) return status;
  film *film = malloc(sizeof *film);
  if (!film) status = bent_fail(error, BENT_ERROR_MEMORY, "render: out of memory");
  const size_t pixels = (size_t)width * height;
  for (size_t first = 0; film && first < pixels; first += FILM_PIXELS) {
    const uint32_t count = (uint32_t)(pixels - first < FILM_PIXELS ? pixels - first : FILM_PIXELS);
    film_clear(film);
    if (!status) status = render_strip(&t, film, &block, tile, first, count, statistics, progress, error);
    film_write(film, channels, first, count); /* after a cancel too: what is done is valid, the rest is 0 */
  }
  free(film);
  path_block_free(&block);
  return status;
}
