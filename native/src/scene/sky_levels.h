/* Images of the sky seen from afar: an equirectangular image at ever coarser levels, and lookups filtered over an ellipse
 * of directions (EWA by probes along its long axis: McCormack et al. 1999, "Feline").
 *
 * A texel of level k is about as wide, in every direction and at every latitude, as 2^k rows of the image are high:
 * towards the poles, where an image's own texels are narrow, rows of levels are blurred. The mean of a level over the
 * sphere is that of the image. */
#ifndef BENT_SCENE_SKY_LEVELS_H
#define BENT_SCENE_SKY_LEVELS_H
#include "base/vec3.h"
#include "scene/texture.h"

bent_status sky_levels_new(const image *image, struct sky_levels **out, bent_error *error);
void sky_levels_free(struct sky_levels *levels);

/* Where an equirectangular image shows a direction, of any length. In Blender's orientation: its middle lies along +x, its
 * left and right edges along -x, up is +z. */
void sky_place(vec3 direction, double *u, double *v);

/* The image around a direction, weighed by about a Gaussian: across, two vectors by which the direction changes, are a standard
 * deviation. Where that is no more than half a texel's height, and where the image has no levels, as image_lookup. */
texel sky_lookup(const image *image, vec3 direction, const vec3 across[2], interpolation interpolation);
#endif
