/* One tile of the picture. */
#include <math.h>

#include "bentlight/render.h"
#include "scene/scene.h"

bent_render_settings bent_render_settings_default(void)
{
  return (bent_render_settings){.sample_count = 1, .max_bounces = 12, .diffuse_bounces = 4, .glossy_bounces = 4,
                                .transmission_bounces = 12, .transparent_bounces = 8, .roulette_start = 3,
                                .tolerance = 1e-4, .filter = BENT_FILTER_BLACKMAN_HARRIS, .filter_width = 1.5,
                                .alpha_threshold = 0.5};
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
  if (s->sample_count < 1 || (uint64_t)s->first_sample + s->sample_count >= 1ull << 31)
    return bent_fail(error, BENT_ERROR_ARGUMENT,
                     "render: sample_count must be at least 1 and first_sample + sample_count below 2^31");
  if (!(s->tolerance > 0 && s->tolerance <= 0.1))
    return bent_fail(error, BENT_ERROR_ARGUMENT, "render: tolerance must lie in (0, 0.1] radians, got %g", s->tolerance);
  if (!(s->filter_width >= 0.01 && s->filter_width <= 10))
    return bent_fail(error, BENT_ERROR_ARGUMENT, "render: filter_width must lie in [0.01, 10] pixels, got %g",
                     s->filter_width);
  if (!(s->clamp_indirect >= 0))
    return bent_fail(error, BENT_ERROR_ARGUMENT, "render: clamp_indirect must not be negative, got %g",
                     s->clamp_indirect);
  if (!(s->alpha_threshold >= 0 && s->alpha_threshold <= 1))
    return bent_fail(error, BENT_ERROR_ARGUMENT, "render: alpha_threshold must lie in [0, 1], got %g",
                     s->alpha_threshold);
  return BENT_OK;
}

bent_status bent_scene_render_tile(const bent_scene *scene, uint32_t x, uint32_t y, uint32_t width, uint32_t height,
                                   const bent_render_settings *settings, float *const channels[BENT_CHANNELS_MAX],
                                   bent_render_statistics *statistics, bent_progress *progress, bent_error *error)
{
  (void)channels, (void)statistics, (void)progress;
  const bent_status status = check(scene, settings, (const uint32_t[]){x, y, width, height}, error);
  return status ? status : bent_fail(error, BENT_ERROR_UNAVAILABLE, "render: path tracing is not linked yet");
}
