/* Where bent light compresses the image of the scene: near the image of a photon sphere, and in a wormhole's mouth. */
#ifndef BENT_RENDER_COMPRESSION_H
#define BENT_RENDER_COMPRESSION_H
#include "render/path.h"

/* For each pixel of the tile (x, y, width, height), row by row, how many samples to take where another pixel takes one:
 * one more for every 0.1 radians by which bending alone spreads the rays through its corners, along its most spread
 * edge; rounded, and at most `most` <= 64. That is `most` where one corner's rays end in a hole or on another side of a
 * throat than the next. Near a critical curve angles go like the logarithm of the distance from it: the n-th pixel from
 * the curve is 1/n radians wide, in any spacetime and at any resolution, so that about seven pixels' width is concerned.
 *
 * The ends are those of the camera rays, each traced once as it is and once as if there were no surface, and the lesser
 * spread counts: behind a surface nothing is compressed, and a surface's edge before a hole is an ordinary edge.
 *
 * A pixel's answer depends on the pixel alone. Nothing is traced where nothing bends light or `most` is 1. */
bent_status compression_measure(const tracer *t, const uint32_t tile[4], uint32_t most, uint8_t *out,
                                bent_progress *progress, bent_error *error);
#endif
