/* How a lens that is open shows stars: blurred, as everything at infinity is, to its own figure. */
#ifndef BENT_RENDER_STAR_LENS_H
#define BENT_RENDER_STAR_LENS_H
#include "render/camera.h"

/* How the place in the picture of an image at `place` changes, as out[coordinate][axis], per scene unit along either axis
 * of the lens. launch: of its ray, unit, world. turn: the change of that per unit along the camera's axes; 0 for what is at
 * infinity in flat space. Exact for perspective cameras; in panoramas of first order. */
void star_parallax(const camera *camera, vec3 launch, const vec3 turn[3], const double place[2], double out[2][2]);
/* Pixels by which the lens spreads what is at infinity, in the middle of the picture, to each side; 0 for a pinhole. */
double star_blur(const camera *camera, uint32_t width, uint32_t height);
#endif
