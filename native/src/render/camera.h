/* The camera: from a point of the image to a ray. */
#ifndef BENT_RENDER_CAMERA_H
#define BENT_RENDER_CAMERA_H
#include "base/vec3.h"
#include "bentlight/render.h"

typedef struct camera camera;
struct camera {
  bent_camera settings;
  mat4 world_from_camera; /* without scale */
};

typedef struct camera_ray {
  vec3 origin, direction; /* world; unit */
  double length_min, length_max;
  double depth_per_length; /* z depth of a point at unit distance along the ray; 1 where depth means distance */
} camera_ray;

/* The ray through the point (x, y) of the image, in [0, 1] from its left and bottom edges. Returns 0 where the
 * projection has no ray (outside a fisheye's circle). */
int camera_cast(const camera *camera, double x, double y, camera_ray *ray);
/* The same through a place on the lens, as aperture_draw has it, instead of its middle. */
int camera_cast_lens(const camera *camera, double x, double y, const double lens[2], camera_ray *ray);
/* World position of a place on the lens of a camera that camera_has_inverse. */
vec3 camera_lens_position(const camera *camera, const double lens[2]);
/* The inverse: the point of the image, edges as above but maybe outside of them, that a place on the lens sees in a unit
 * world direction. *solid_angle: of directions at that place per area of the image, which is 1 as a whole. Returns 0 where there is none, and for projections that it does not know (camera_has_inverse). */
int camera_project(const camera *camera, const double lens[2], vec3 direction, double image[2], double *solid_angle);
int camera_has_inverse(const camera *camera);
/* All points of the image, and of a margin around it of `beside` widths and heights, that are seen in a unit world direction;
 * panoramas may show one more than once. Returns how many. An orthographic camera sees no single directions: 0. */
enum { CAMERA_PLACES_MAX = 8 };
int camera_places(const camera *camera, vec3 direction, const double beside[2], double places[CAMERA_PLACES_MAX][2]);
/* The same, but only one point: of several that which is nearest to `near`; perspective cameras see all of their plane, however
 * far from the image. Returns 0 if there is none. */
int camera_place_near(const camera *camera, vec3 direction, const double near[2], double place[2]);
/* Where an orthographic camera in flat space sees a point. */
void camera_place_of_point(const camera *camera, vec3 point, double place[2]);
/* Solid angle of directions at the lens' middle per area of the image, at a point of it; 0 where there is no ray. */
double camera_solid_angle(const camera *camera, double x, double y);
/* Inverse of world_from_camera's rotation: a world direction in camera space. */
vec3 camera_from_world_direction(const camera *camera, vec3 direction);
void camera_free(camera *camera);
#endif
