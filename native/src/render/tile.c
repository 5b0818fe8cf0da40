/* One tile of the picture: checks, and the order of its samples. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "bentlight/render.h"
#include "geometry/geometry.h"
#include "render/camera.h"
#include "render/compression.h"
#include "render/deflection.h"
#include "render/film.h"
#include "render/light_path.h"
#include "render/path.h"
#include "scene/scene.h"

/* The fields that only some channels ask for. */
static bent_status check_channels(const bent_render_settings *s, bent_error *error)
{
  if (s->light_groups > BENT_ITEMS_MAX || s->aovs > BENT_ITEMS_MAX || s->matte_ranks > BENT_ITEMS_MAX)
    return bent_fail(error, BENT_ERROR_ARGUMENT, "render: light_groups, aovs and matte_ranks must be at most %d, got %u, %u, %u",
                     BENT_ITEMS_MAX, s->light_groups, s->aovs, s->matte_ranks);
  if (!(isfinite(s->mist_start) && s->mist_depth >= 0 && s->mist_falloff >= 0))
    return bent_fail(error, BENT_ERROR_ARGUMENT,
                     "render: mist_start must be finite, mist_depth and mist_falloff not negative, got %g, %g, %g",
                     s->mist_start, s->mist_depth, s->mist_falloff);
  if (!(s->occlusion_distance >= 0))
    return bent_fail(error, BENT_ERROR_ARGUMENT, "render: occlusion_distance must not be negative, got %g",
                     s->occlusion_distance);
  return BENT_OK;
}

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
  if (s->photon_ring_samples < 1 || s->photon_ring_samples > 64)
    return bent_fail(error, BENT_ERROR_ARGUMENT, "render: photon_ring_samples must lie in [1, 64], got %u",
                     s->photon_ring_samples);
  if (s->sample_count < 1 || ((uint64_t)s->first_sample + s->sample_count) * s->photon_ring_samples >= 1ull << 31)
    return bent_fail(error, BENT_ERROR_ARGUMENT,
                     "render: sample_count must be at least 1 and first_sample + sample_count below 2^31 / "
                     "photon_ring_samples");
  if (!(s->tolerance > 0 && s->tolerance <= 0.1))
    return bent_fail(error, BENT_ERROR_ARGUMENT, "render: tolerance must lie in (0, 0.1] radians, got %g", s->tolerance);
  if (!(s->filter_width >= 0.01 && s->filter_width <= 30))
    return bent_fail(error, BENT_ERROR_ARGUMENT, "render: filter_width must lie in [0.01, 30] pixels, got %g",
                     s->filter_width);
  if (!(s->sky_filter >= 0 && s->sky_filter <= 1))
    return bent_fail(error, BENT_ERROR_ARGUMENT, "render: sky_filter must lie in [0, 1] pixels, got %g", s->sky_filter);
  if (!(s->clamp_direct >= 0 && s->clamp_indirect >= 0))
    return bent_fail(error, BENT_ERROR_ARGUMENT, "render: clamp_direct and clamp_indirect must not be negative, got %g, %g",
                     s->clamp_direct, s->clamp_indirect);
  if (!(s->blur_glossy >= 0 && isfinite(s->blur_glossy)))
    return bent_fail(error, BENT_ERROR_ARGUMENT, "render: blur_glossy must be finite and not negative, got %g",
                     s->blur_glossy);
  if (!(s->noise_threshold >= 0) || s->min_samples < 2)
    return bent_fail(error, BENT_ERROR_ARGUMENT,
                     "render: noise_threshold must not be negative and min_samples at least 2, got %g and %u",
                     s->noise_threshold, s->min_samples);
  if (!(s->light_threshold >= 0))
    return bent_fail(error, BENT_ERROR_ARGUMENT, "render: light_threshold must not be negative, got %g",
                     s->light_threshold);
  if ((unsigned)s->light_sampling >= BENT_LIGHT_SAMPLINGS)
    return bent_fail(error, BENT_ERROR_ARGUMENT, "render: there is no light_sampling %d", (int)s->light_sampling);
  if ((unsigned)s->integrator >= BENT_INTEGRATORS)
    return bent_fail(error, BENT_ERROR_ARGUMENT, "render: there is no integrator %d", (int)s->integrator);
  if (s->integrator == BENT_BIDIRECTIONAL && s->light_sampling != BENT_LIGHTS_BOTH)
    return bent_fail(error, BENT_ERROR_ARGUMENT, "render: the integrator BIDIRECTIONAL needs light_sampling BOTH");
  if ((unsigned)s->sampling_pattern >= BENT_SAMPLING_PATTERNS)
    return bent_fail(error, BENT_ERROR_ARGUMENT, "render: there is no sampling_pattern %d", (int)s->sampling_pattern);
  if (!(s->alpha_threshold >= 0 && s->alpha_threshold <= 1))
    return bent_fail(error, BENT_ERROR_ARGUMENT, "render: alpha_threshold must lie in [0, 1], got %g",
                     s->alpha_threshold);
  return check_channels(s, error);
}

/* What a call that resumes needs: counts that float32 holds exactly, and all that decides which pixels are clean. */
static bent_status check_resume(const bent_render_settings *s, float *const channels[BENT_CHANNELS_MAX],
                                const double *state, bent_error *error)
{
  if (!s->resume || state) return BENT_OK;
  const int adaptive = channels[CHANNEL_COMBINED] && channels[CHANNEL_NOISE_PARTIAL] && channels[CHANNEL_NOISE_SCATTER];
  if (!channels[CHANNEL_SAMPLE_COUNT] || (s->noise_threshold > 0 && !adaptive))
    return bent_fail(error, BENT_ERROR_ARGUMENT,
                     "render: to resume takes the channel sample_count, and with a noise_threshold combined, "
                     "noise_partial and noise_scatter");
  if ((uint64_t)s->first_sample * s->photon_ring_samples > 1u << 24)
    return bent_fail(error, BENT_ERROR_ARGUMENT,
                     "render: to resume, first_sample must be at most 2^24 / photon_ring_samples");
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
  const uint32_t *tile;    /* x, y, width, height */
  const uint8_t *multiple; /* of each pixel of the strip: samples where another takes one */
  const float (*deflection)[3]; /* of each; NULL: not wanted */
  size_t first;            /* number within the tile of the strip's first pixel */
  uint32_t count;          /* of pixels below */
  uint32_t pixels[FILM_PIXELS];
} strip;

/* The next sample to take: number `part` of those that the strip's pixel number `index` takes for one. */
typedef struct cursor {
  uint32_t sample, index, part;
} cursor;

/* Takes what the cursor stands at and moves it on: through a pixel's parts, the strip's pixels, the samples. */
static pixel_sample take_next(const strip *strip, cursor *at)
{
  const uint32_t pixel = strip->pixels[at->index], multiple = strip->multiple[pixel];
  const size_t in_tile = strip->first + pixel;
  const pixel_sample wanted = {strip->tile[0] + (uint32_t)(in_tile % strip->tile[2]),
                               strip->tile[1] + (uint32_t)(in_tile / strip->tile[2]),
                               at->sample * multiple + at->part, multiple};
  if (++at->part == multiple) at->part = 0, at->index++;
  if (at->index == strip->count) at->index = 0, at->sample++;
  return wanted;
}

/* Takes samples number begin .. end - 1 of all pixels of the strip that want them. */
static bent_status take_samples(const tracer *t, film *film, path_block *block, const strip *strip, uint32_t begin,
                                uint32_t end, bent_render_statistics *statistics, bent_progress *progress,
                                bent_error *error)
{
  for (cursor at = {begin, 0, 0}; at.sample < end;) {
    pixel_sample wanted[BLOCK_SAMPLES];
    uint32_t pixels[BLOCK_SAMPLES], parts[BLOCK_SAMPLES], count = 0, whole = 0;
    /* All parts of a sample are in one block: a cancel leaves whole samples. */
    while (at.sample < end && (at.part || count + strip->multiple[strip->pixels[at.index]] <= BLOCK_SAMPLES)) {
      pixels[count] = strip->pixels[at.index];
      parts[count] = at.part;
      wanted[count++] = take_next(strip, &at);
      whole += at.part == 0;
    }
    const bent_status status = path_trace(t, block, (int)count, wanted, statistics, progress, error);
    if (status) return status;
    for (uint32_t i = 0; i < count; i++) {
      float *deflection = block->records[i].value[CHANNEL_DEFLECTION];
      if (strip->deflection) memcpy(deflection, strip->deflection[pixels[i]], sizeof *strip->deflection);
      film_add(film, pixels[i], &block->records[i], parts[i], strip->multiple[pixels[i]]);
    }
    statistics->samples += count;
    if (progress) atomic_fetch_add_explicit(&progress->done, (uint64_t)whole, memory_order_relaxed);
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

/* Lists the strip's pixels that have not been dropped before the call: those that have all samples so far. */
static void list_pixels(strip *strip, const film *film, uint32_t pixels, uint32_t samples)
{
  for (uint32_t i = 0; i < pixels; i++)
    if (film->taken[i] == samples) strip->pixels[strip->count++] = i;
}

/* Samples that a pixel which has `taken` takes until the next look at its noise. */
static uint32_t until_look(const bent_render_settings *s, uint32_t taken)
{
  return taken < s->min_samples ? s->min_samples - taken : NOISE_CHECK - (taken - s->min_samples) % NOISE_CHECK;
}

static int is_time_to_look(const bent_render_settings *s, uint32_t taken)
{
  return taken >= s->min_samples && (taken - s->min_samples) % NOISE_CHECK == 0;
}

/* Takes the samples of the strip's `pixels` pixels. before: how many are in the film. */
static bent_status render_strip(const tracer *t, film *film, path_block *block, strip *strip, uint32_t pixels,
                                uint32_t before, bent_render_statistics *statistics, bent_progress *progress,
                                bent_error *error)
{
  const bent_render_settings *s = t->settings;
  list_pixels(strip, film, pixels, before);
  uint32_t waiting = pixels; /* that progress does not count as done */
  for (uint32_t taken = 0, more; taken < s->sample_count; taken += more) {
    const int adaptive = s->noise_threshold > 0;
    if (adaptive && is_time_to_look(s, before + taken)) drop_clean(strip, film, s->noise_threshold);
    if (progress) /* samples that are not needed count as done */
      atomic_fetch_add_explicit(&progress->done, (uint64_t)(waiting - strip->count) * (s->sample_count - taken),
                                memory_order_relaxed);
    waiting = strip->count;
    if (!strip->count) break;
    const uint32_t left = s->sample_count - taken;
    more = adaptive && until_look(s, before + taken) < left ? until_look(s, before + taken) : left;
    const uint32_t first = s->first_sample + taken;
    const bent_status status = take_samples(t, film, block, strip, first, first + more, statistics, progress, error);
    if (status) return status;
  }
  return BENT_OK;
}

/* What is known of a tile's pixels before their samples; to be freed. */
typedef struct measures {
  uint8_t *multiple;
  float (*deflection)[3]; /* NULL: not wanted */
} measures;

static bent_status measure(const tracer *t, const uint32_t tile[4], measures *out, bent_progress *progress,
                           bent_error *error)
{
  const size_t pixels = (size_t)tile[2] * tile[3];
  const int deflection = t->layout->wanted[CHANNEL_DEFLECTION];
  out->multiple = malloc(pixels + 1);
  if (deflection) out->deflection = malloc((pixels + 1) * sizeof *out->deflection);
  if (!out->multiple || (deflection && !out->deflection)) return bent_fail(error, BENT_ERROR_MEMORY, "render: out of memory");
  const bent_status status =
      compression_measure(t, tile, t->settings->photon_ring_samples, out->multiple, progress, error);
  return status || !deflection ? status : deflection_measure(t, tile, out->deflection, progress, error);
}

/* Takes the samples of a tile, strip by strip. */
static bent_status render_strips(const tracer *t, path_block *block, film *film, const uint32_t tile[4],
                                 const measures *measured, float *const channels[CHANNEL_COUNT], double *state,
                                 bent_render_statistics *statistics, bent_progress *progress, bent_error *error)
{
  const size_t pixels = (size_t)tile[2] * tile[3];
  bent_status status = BENT_OK;
  for (size_t first = 0; first < pixels; first += FILM_PIXELS) {
    const uint32_t count = (uint32_t)(pixels - first < FILM_PIXELS ? pixels - first : FILM_PIXELS);
    double *kept = state ? state + first * film->layout.width : NULL;
    if (t->settings->resume && kept) film_resume(film, kept, count);
    else film_begin(film, kept, count, t->settings->first_sample);
    if (t->settings->resume && !kept) film_read(film, channels, first, count, measured->multiple + first);
    strip strip = {.tile = tile, .multiple = measured->multiple + first, .first = first};
    if (measured->deflection) strip.deflection = (const float(*)[3])measured->deflection + first;
    const uint32_t since = t->settings->resume && kept ? film_first_sample(kept) : 0;
    const uint32_t before = t->settings->resume ? t->settings->first_sample - since : 0;
    if (!status) status = render_strip(t, film, block, &strip, count, before, statistics, progress, error);
    film_write(film, channels, first, count); /* after a cancel too: what is done is valid, the rest is 0 */
  }
  return status;
}

/* All channels of a tile whose first sample was not even begun. */
static void write_nothing(float *const channels[CHANNEL_COUNT], const bent_render_settings *settings, size_t pixels)
{
  for (int c = 0; c < CHANNEL_COUNT; c++)
    if (channels[c]) memset(channels[c], 0, pixels * channel_width((channel)c, settings) * sizeof *channels[c]);
}

/* What has to go together. */
static bent_status check_integrator(const tracer *t, const channel_layout *records, bent_error *error)
{
  if (t->bidirectional && !t->light)
    return bent_fail(error, BENT_ERROR_ARGUMENT, "render: the integrator BIDIRECTIONAL needs the array `light`");
  if (t->bidirectional && records->light)
    return bent_fail(error, BENT_ERROR_ARGUMENT,
                     "render: the integrator BIDIRECTIONAL cannot tell light apart by what scatters it, or whose it is");
  return BENT_OK;
}

bent_status bent_scene_render_tile(const bent_scene *scene, uint32_t x, uint32_t y, uint32_t width, uint32_t height,
                                   const bent_render_settings *settings, float *const channels[BENT_CHANNELS_MAX],
                                   double *state, int64_t (*light)[3], bent_render_statistics *statistics,
                                   bent_progress *progress, bent_error *error)
{
  const uint32_t tile[4] = {x, y, width, height};
  *statistics = (bent_render_statistics){0};
  bent_status status = check(scene, settings, tile, error);
  if (!status) status = check_resume(settings, channels, state, error);
  if (!status) status = check_camera(scene, error);
  if (status) return status;
  tracer t;
  path_block block;
  measures measured = {.multiple = NULL};
  const channel_layout records = channel_layout_of(channels, settings);
  tracer_init(&t, scene, settings, &records);
  t.light = light;
  status = check_integrator(&t, &records, error);
  if (!status) status = path_block_new(&block, scene, &records, BLOCK_SAMPLES, error);
  if (status) return status;
  const film_layout layout = film_layout_of(records.wanted, settings);
  film *film = film_new(&layout, &records);
  if (t.bidirectional) block.light = light_paths_new(BLOCK_SAMPLES, block.lobes);
  if (!film || (t.bidirectional && !block.light)) status = bent_fail(error, BENT_ERROR_MEMORY, "render: out of memory");
  if (!status) status = measure(&t, tile, &measured, progress, error);
  if (!status) status = render_strips(&t, &block, film, tile, &measured, channels, state, statistics, progress, error);
  else if (status == BENT_CANCELLED && settings->resume && state) {
    bent_render_state_develop(settings, (size_t)width * height, state, channels);
  } else if (status == BENT_CANCELLED && !settings->resume) {
    write_nothing(channels, settings, (size_t)width * height);
    if (state) memset(state, 0, (size_t)width * height * layout.width * sizeof *state);
  }
  film_free(film);
  free(measured.multiple);
  free(measured.deflection);
  path_block_free(&block);
  return status;
}
