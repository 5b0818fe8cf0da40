/* The map by which bending distorts a picture, for compositors (ST map). */
#ifndef BENT_RENDER_DEFLECTION_H
#define BENT_RENDER_DEFLECTION_H
#include "render/path.h"

/* For each pixel of a tile (x, y, width, height), row by row from the bottom: the place of the picture, in [0, 1] from its
 * left and bottom edges or outside, at which a camera in flat space would see what the ray through the pixel's center
 * meets: of the sky its direction, of a surface the straight way to it; and 1. 0, 0, 0 for rays that are captured, that
 * went through a wormhole, or that meet what the flat picture's camera cannot show: what is behind it, or in the sky of an
 * orthographic one. In flat space the map is the pixel's center itself. */
bent_status deflection_measure(const tracer *t, const uint32_t tile[4], float (*out)[3], bent_progress *progress,
                               bent_error *error);
#endif
