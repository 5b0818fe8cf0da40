/* The table of channels, and the record of one sample that feeds them. */
#ifndef BENT_RENDER_CHANNELS_H
#define BENT_RENDER_CHANNELS_H
#include "bentlight/render.h"

/* Order of the table bent_render_channels. */
typedef enum channel {
  CHANNEL_COMBINED,
  CHANNEL_DEPTH,
  CHANNEL_NORMAL,
  CHANNEL_POSITION,
  CHANNEL_EMISSION,
  CHANNEL_ENVIRONMENT,
  CHANNEL_DENOISING_ALBEDO,
  CHANNEL_DENOISING_NORMAL,
  CHANNEL_ERROR,
  CHANNEL_WINDING,
  CHANNEL_FATE,
  CHANNEL_SAMPLE_COUNT,
  CHANNEL_NOISE_PARTIAL,
  CHANNEL_NOISE_SCATTER,
  CHANNEL_COUNT
} channel;

enum { CHANNEL_COMPONENTS_MAX = 4 };

/* What one sample says to each channel. */
typedef struct sample_record {
  float value[CHANNEL_COUNT][CHANNEL_COMPONENTS_MAX];
} sample_record;
#endif
