/* The one table of what a render can deliver; Python and the host read it from here. */
#include "render/channels.h"

#include <math.h>
#include <string.h>

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
    [CHANNEL_UV] = {"uv", 3, BENT_MEAN, "texture coordinates of the first surface, and 1; 0 where there are none"},
    [CHANNEL_OBJECT_INDEX] = {"object_index", 1, BENT_FIRST, "the first surface's instance's object_index"},
    [CHANNEL_MATERIAL_INDEX] = {"material_index", 1, BENT_FIRST, "the index of its material (bent_material_label)"},
    [CHANNEL_MIST] = {"mist", 1, BENT_MEAN,
                      "0 before mist_start to 1 behind mist_depth, by the length along the camera ray; of what is seen "
                      "through transparent surfaces the mean; 1 where there is none"},
    [CHANNEL_DENOISING_DEPTH] = {"denoising_depth", 1, BENT_MEAN, "length of the camera's way to the surface of denoising_normal, each leg weighed by what mirrors and glass before it let through"},
    [CHANNEL_DIFFUSE_DIRECT] = {"diffuse_direct", 3, BENT_MEAN, "light that diffuse lobes of the camera's surfaces scatter, from lights at once"},
    [CHANNEL_DIFFUSE_INDIRECT] = {"diffuse_indirect", 3, BENT_MEAN, "the same of light that has been scattered before"},
    [CHANNEL_DIFFUSE_COLOR] = {"diffuse_color", 3, BENT_MEAN, "color of diffuse lobes"},
    [CHANNEL_GLOSSY_DIRECT] = {"glossy_direct", 3, BENT_MEAN, "as diffuse_direct, of what is reflected by microfacets and mirrors"},
    [CHANNEL_GLOSSY_INDIRECT] = {"glossy_indirect", 3, BENT_MEAN, "as diffuse_indirect"},
    [CHANNEL_GLOSSY_COLOR] = {"glossy_color", 3, BENT_MEAN, "albedo of such reflection"},
    [CHANNEL_TRANSMISSION_DIRECT] = {"transmission_direct", 3, BENT_MEAN, "as diffuse_direct, of what is refracted"},
    [CHANNEL_TRANSMISSION_INDIRECT] = {"transmission_indirect", 3, BENT_MEAN, "as diffuse_indirect"},
    [CHANNEL_TRANSMISSION_COLOR] = {"transmission_color", 3, BENT_MEAN, "albedo of refraction"},
    [CHANNEL_AMBIENT_OCCLUSION] = {"ambient_occlusion", 3, BENT_MEAN,
                                   "part of the hemisphere around the normal, by its cosine, that sees no surface within occlusion_distance"},
    [CHANNEL_IMAGE_ORDER] = {"image_order", 1, BENT_FIRST,
                             "whole half turns of the camera ray around spacetime objects: 0 direct images, 1 those by the far side, ..."},
    [CHANNEL_FREQUENCY_SHIFT] = {"frequency_shift", 1, BENT_MEAN,
                                 "frequency at the camera over that at the first surface (a disk's matter moves, others rest) or in the sky; 0 for rays that are captured"},
    [CHANNEL_DISK_ONLY] = {"disk_only", 3, BENT_MEAN, "the part of emission that comes from disks (bent_instance_label)"},
    [CHANNEL_DEFLECTION] = {"deflection", 3, BENT_FIRST,
                            "of the ray through the pixel's center: the place in the picture, from 0 to 1 from its left and "
                            "bottom edges, where the unbent picture shows what this ray meets; and 1, or 0 where there is none"},
    [CHANNEL_VECTOR] = {"vector", 4, BENT_MEAN,
                        "motion in the picture of what is seen, pixels, times vector_weight: its place before less the present "
                        "one, and the present one less that after (bentlight/motion.h); 0 where it is not known"},
    [CHANNEL_VECTOR_WEIGHT] = {"vector_weight", 1, BENT_MEAN, "how much the samples count for `vector`, which is to be divided by it"},
    [CHANNEL_LIGHT_GROUPS] = {"light_groups", 3, BENT_MEAN, "for each light group: the part of combined that its lights bring", BENT_PER_LIGHT_GROUP},
    [CHANNEL_AOVS] = {"aovs", 4, BENT_MEAN, "for each AOV: what materials write to it", BENT_PER_AOV},
    [CHANNEL_MATTE_OBJECT] = {"matte_object", 2, BENT_MATTE, "for each rank: Cryptomatte name of an object and the part of the pixel that it covers", BENT_PER_RANK},
    [CHANNEL_MATTE_MATERIAL] = {"matte_material", 2, BENT_MATTE, "the same of materials", BENT_PER_RANK},
    [CHANNEL_MATTE_ASSET] = {"matte_asset", 2, BENT_MATTE, "the same of assets, objects with all that is parented to them", BENT_PER_RANK},
};

const bent_channel *bent_render_channels(size_t *count)
{
  *count = CHANNEL_COUNT;
  return CHANNELS;
}

const channel_layout NO_CHANNELS;

uint32_t channel_width(channel channel, const bent_render_settings *s)
{
  const uint32_t items[] = {[BENT_SINGLE] = 1, [BENT_PER_LIGHT_GROUP] = s->light_groups, [BENT_PER_AOV] = s->aovs,
                            [BENT_PER_RANK] = s->matte_ranks};
  return (uint32_t)CHANNELS[channel].components * items[CHANNELS[channel].items];
}

channel_layout channel_layout_of(float *const channels[CHANNEL_COUNT], const bent_render_settings *settings)
{
  channel_layout l = {.extras = 0};
  for (int c = 0; c < CHANNEL_COUNT; c++) {
    if (!channels[c]) continue;
    l.wanted[c] = 1;
    l.extras |= c >= CHANNEL_EXTRAS;
    l.light |= c == CHANNEL_LIGHT_GROUPS || (c >= CHANNEL_DIFFUSE_DIRECT && c <= CHANNEL_AMBIENT_OCCLUSION);
    l.mattes |= c >= CHANNEL_MATTE_OBJECT;
    if (c < CHANNEL_LISTS) continue;
    l.list_offset[c] = l.list_total;
    l.list_length[c] = channel_width((channel)c, settings);
    l.list_total += l.list_length[c];
  }
  return l;
}

void matte_add(float *pairs, uint32_t count, float name, float coverage)
{
  for (uint32_t i = 0; i < count; i++) {
    float *pair = pairs + 2 * i;
    if (pair[1] > 0 && pair[0] != name) continue;
    pair[0] = name, pair[1] += coverage;
    return;
  }
}

void record_clear(const channel_layout *layout, sample_record *record)
{
  memset(record->value, 0, (layout->extras ? CHANNEL_LISTS : CHANNEL_EXTRAS) * sizeof *record->value);
  if (layout->list_total) memset(record->lists, 0, layout->list_total * sizeof *record->lists);
}

/* Without a branch, which is quick. */
static int all_finite(const float *values, uint32_t count)
{
  const uint32_t exponent = 0x7f800000;
  uint32_t wrong = 0;
  for (uint32_t i = 0; i < count; i++) {
    uint32_t bits;
    memcpy(&bits, &values[i], sizeof bits);
    wrong |= (bits & exponent) == exponent;
  }
  return !wrong;
}

static void drop_broken(float *values, uint32_t count)
{
  for (uint32_t i = 0; i < count; i++)
    if (!isfinite(values[i])) values[i] = 0;
}

int record_make_finite(const channel_layout *layout, sample_record *record)
{
  const uint32_t count = (layout->extras ? CHANNEL_LISTS : CHANNEL_EXTRAS) * CHANNEL_COMPONENTS_MAX;
  if (all_finite(record->value[0], count) && all_finite(record->lists, layout->list_total)) return 1;
  drop_broken(record->value[0], count);
  drop_broken(record->lists, layout->list_total);
  return 0;
}
