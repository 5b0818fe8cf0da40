/* The opening of the camera's lens: places on it, and the rays that they see what is in focus by. */
#ifndef BENT_RENDER_APERTURE_H
#define BENT_RENDER_APERTURE_H
#include "base/vec3.h"
#include "bentlight/render.h"

/* A place on the opening, evenly over its area: u in [0, 1)^2, out in scene units. Neighbors in u are neighbors there. */
void aperture_draw(const bent_aperture *aperture, const double u[2], double out[2]);
/* Turns the ray of a pinhole (camera space, unit direction) into that through a place on the lens which meets it where it is
 * sharp. */
void aperture_refract(const bent_camera *camera, const double lens[2], vec3 *origin, vec3 *direction);
/* For the ray of a pinhole, camera space and unit: the length to where it is sharp, and the axes in which places on the
 * lens count. */
double aperture_reach(const bent_camera *camera, vec3 direction);
void aperture_axes(const bent_camera *camera, vec3 direction, vec3 *x, vec3 *y);
bent_status aperture_check(const bent_aperture *aperture, bent_error *error);
#endif
