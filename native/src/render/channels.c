/* The one table of what a render can deliver; Python and the host read it from here. */
#include "render/channels.h"

_Static_assert((int)CHANNEL_COUNT <= (int)BENT_CHANNELS_MAX, "bent_scene_render_tile takes at most BENT_CHANNELS_MAX arrays");

static const bent_channel CHANNELS[CHANNEL_COUNT] = {
    [CHANNEL_COMBINED] = {"combined", 4, BENT_MEAN,
                          "radiance, linear RGB; alpha 1, or with a transparent film what hides the sky (premultiplied)"},
    [CHANNEL_DEPTH] = {"depth", 1, BENT_FIRST,
                       "scene length along the camera ray to the first surface, times the cosine to the view axis for "
                       "perspective: in flat space the z depth; 1e10 where there is no surface"},
    [CHANNEL_NORMAL] = {"normal", 3, BENT_MEAN, "shading normal of the first surface, world axes, local frame"},
    [CHANNEL_POSITION] = {"position", 3, BENT_FIRST, "world position of the first surface; 0 without one"},
    [CHANNEL_EMISSION] = {"emission", 3, BENT_MEAN, "radiance that directly seen surfaces emit"},
    [CHANNEL_ENVIRONMENT] = {"environment", 3, BENT_MEAN, "radiance of the directly seen sky and suns"},
    [CHANNEL_DENOISING_ALBEDO] = {"denoising_albedo", 3, BENT_MEAN, "albedo and emission of the first surface that is not mostly mirror or glass, or the sky"},
    [CHANNEL_DENOISING_NORMAL] = {"denoising_normal", 3, BENT_MEAN, "normal of that surface in camera space, z along the view"},
    [CHANNEL_ERROR] = {"error", 1, BENT_MAX,
                       "largest estimated angular error of the camera rays, radians; pi for an unresolved one"},
    [CHANNEL_WINDING] = {"winding", 1, BENT_MEAN, "half turns of the camera ray around spacetime objects: angle / pi"},
    [CHANNEL_FATE] = {"fate", 1, BENT_FIRST, "bent_fate of the camera ray's first segment"},
    [CHANNEL_SAMPLE_COUNT] = {"sample_count", 1, BENT_COUNT, "samples that went into the pixel"},
    [CHANNEL_NOISE_PARTIAL] = {"noise_partial", 3, BENT_STATE, "sum of the colors since the last whole group of 8 samples"},
    [CHANNEL_NOISE_SCATTER] = {"noise_scatter", 3, BENT_STATE,
                               "sum of squared deviations of the groups' sums of colors from their mean"},
};

const bent_channel *bent_render_channels(size_t *count)
{
  *count = CHANNEL_COUNT;
  return CHANNELS;
}
