/* Image lookup. */
#ifndef BENT_SCENE_TEXTURE_H
#define BENT_SCENE_TEXTURE_H
#include "bentlight/shading.h"

typedef enum interpolation { INTERPOLATE_LINEAR, INTERPOLATE_CLOSEST, INTERPOLATE_CUBIC, INTERPOLATE_SMART } interpolation;
typedef enum extension { EXTEND_REPEAT, EXTEND_EXTEND, EXTEND_CLIP, EXTEND_MIRROR } extension;

/* One of `pixels` and `bytes` is held, the other NULL. */
typedef struct image {
  size_t width, height;
  float (*pixels)[4];
  uint8_t (*bytes)[4];
  int srgb;
  struct sky_levels *levels; /* sky_levels.h: of an image of the sky, freed with it; NULL: none */
} image;

typedef struct texel {
  double color[3], alpha;
} texel;

bent_status image_make(image *out, const bent_image *source, bent_error *error);
void image_free(image *image);
/* One texel as it is, scene-linear with associated alpha. */
texel image_texel(const image *image, size_t x, size_t y);
/* The image at (u, v), [0, 1] over its area, v upwards. Scene-linear with associated alpha, or with straight alpha if
 * wanted. Bytes are decoded after interpolation, as Cycles does. (u, v) that are not finite give transparent black. */
texel image_lookup(const image *image, double u, double v, interpolation interpolation, extension extension,
                   int straight_alpha);
#endif
