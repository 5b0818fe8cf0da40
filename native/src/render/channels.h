/* The table of channels, and the record of one sample that feeds them. */
#ifndef BENT_RENDER_CHANNELS_H
#define BENT_RENDER_CHANNELS_H
#include "bentlight/render.h"

/* Order of the table bent_render_channels. Those up to CHANNEL_EXTRAS are cheap and always written; what is behind is
 * written only if some of it is wanted. */
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
  CHANNEL_EXTRAS,
  CHANNEL_UV = CHANNEL_EXTRAS,
  CHANNEL_OBJECT_INDEX,
  CHANNEL_MATERIAL_INDEX,
  CHANNEL_MIST,
  CHANNEL_DENOISING_DEPTH,
  CHANNEL_DIFFUSE_DIRECT, /* of each kind of lobe: direct, indirect, color */
  CHANNEL_DIFFUSE_INDIRECT,
  CHANNEL_DIFFUSE_COLOR,
  CHANNEL_GLOSSY_DIRECT,
  CHANNEL_GLOSSY_INDIRECT,
  CHANNEL_GLOSSY_COLOR,
  CHANNEL_TRANSMISSION_DIRECT,
  CHANNEL_TRANSMISSION_INDIRECT,
  CHANNEL_TRANSMISSION_COLOR,
  CHANNEL_AMBIENT_OCCLUSION,
  CHANNEL_IMAGE_ORDER,
  CHANNEL_FREQUENCY_SHIFT,
  CHANNEL_DISK_ONLY,
  CHANNEL_DEFLECTION,
  CHANNEL_VECTOR,
  CHANNEL_VECTOR_WEIGHT,
  CHANNEL_LISTS, /* from here on as many values as the settings say: kept apart */
  CHANNEL_LIGHT_GROUPS = CHANNEL_LISTS,
  CHANNEL_AOVS,
  CHANNEL_MATTE_OBJECT,
  CHANNEL_MATTE_MATERIAL,
  CHANNEL_MATTE_ASSET,
  CHANNEL_COUNT
} channel;

enum { CHANNEL_COMPONENTS_MAX = 4 };

/* What is wanted of a call, and where lists lie in the records of its samples. */
typedef struct channel_layout {
  uint8_t wanted[CHANNEL_COUNT];
  uint8_t extras;  /* any behind CHANNEL_EXTRAS */
  uint8_t light;   /* any that tells light apart by where it comes from, or by what scattered it */
  uint8_t mattes;  /* any Cryptomatte */
  uint32_t list_offset[CHANNEL_COUNT], list_length[CHANNEL_COUNT]; /* 0 for all others */
  uint32_t list_total;
} channel_layout;

/* Nothing but what is always written. */
extern const channel_layout NO_CHANNELS;
/* Values of each pixel in a channel's array. */
uint32_t channel_width(channel channel, const bent_render_settings *settings);
channel_layout channel_layout_of(float *const channels[CHANNEL_COUNT], const bent_render_settings *settings);

/* What one sample says to each channel. Cryptomattes: pairs of name and coverage, those in use first. */
typedef struct sample_record {
  float value[CHANNEL_LISTS][CHANNEL_COMPONENTS_MAX];
  float *lists; /* layout.list_total values, if there are any */
} sample_record;

static inline float *record_list(const sample_record *record, const channel_layout *layout, channel channel)
{
  return record->lists + layout->list_offset[channel];
}
static inline const float *record_values(const sample_record *record, const channel_layout *layout, channel channel)
{
  return channel < CHANNEL_LISTS ? record->value[channel] : record_list(record, layout, channel);
}
/* All zero; what is not wanted may be left as it is. */
void record_clear(const channel_layout *layout, sample_record *record);
/* Makes what is not finite 0; returns 0 if there was any. */
int record_make_finite(const channel_layout *layout, sample_record *record);
/* Adds coverage to a name's pair in a list of pairs; what finds no room is left out. */
void matte_add(float *pairs, uint32_t count, float name, float coverage);
#endif
