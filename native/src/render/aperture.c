/* See aperture.h. Blades, ratio and panoramas as in Cycles. */
#include "render/aperture.h"

/* The unit disk: squares around the middle become circles (Shirley & Chiu 1997). */
static void draw_disk(const double u[2], double out[2])
{
  const double x = 2 * u[0] - 1, y = 2 * u[1] - 1;
  const int is_wide = fabs(x) > fabs(y);
  const double radius = is_wide ? x : y;
  const double angle = is_wide ? M_PI_4 * (y / x) : y != 0 ? M_PI_2 - M_PI_4 * (x / y) : 0;
  out[0] = radius * cos(angle), out[1] = radius * sin(angle);
}

/* A regular polygon of circumradius 1: a triangle from its middle for each side. */
static void draw_polygon(const bent_aperture *a, const double u[2], double out[2])
{
  const double side = floor(u[0] * a->blades), along = u[0] * a->blades - side, outward = sqrt(u[1]);
  const double half = M_PI / a->blades, turn = a->rotation + 2 * half * side;
  const double x = outward * cos(half), y = outward * (2 * along - 1) * sin(half);
  out[0] = x * cos(turn) - y * sin(turn), out[1] = x * sin(turn) + y * cos(turn);
}

void aperture_draw(const bent_aperture *aperture, const double u[2], double out[2])
{
  out[0] = out[1] = 0;
  if (aperture->radius == 0) return;
  if (aperture->blades < 3) draw_disk(u, out);
  else draw_polygon(aperture, u, out);
  out[0] *= aperture->radius / aperture->ratio, out[1] *= aperture->radius;
}

double aperture_reach(const bent_camera *camera, vec3 direction)
{
  const double focus = camera->aperture.focal_distance;
  return camera->kind == BENT_CAMERA_PERSPECTIVE ? focus / -direction.z : focus;
}

void aperture_axes(const bent_camera *camera, vec3 direction, vec3 *x, vec3 *y)
{
  *x = v3(1, 0, 0), *y = v3(0, 1, 0);
  if (camera->kind <= BENT_CAMERA_ORTHOGRAPHIC) return;
  const int is_ball = camera->kind == BENT_CAMERA_MIRRORBALL;
  const vec3 toward = is_ball ? v3(1, 0, 0) : v3(0, 0, -1);
  *x = v3_mad(direction, -v3_dot(toward, direction), toward);
  if (v3_length(*x) < 1e-9) { /* along the axis itself any will do */
    v3_basis(direction, x, y);
    return;
  }
  *x = v3_normalize(*x);
  *y = is_ball ? v3_cross(*x, direction) : v3_cross(direction, *x);
}

void aperture_refract(const bent_camera *camera, const double lens[2], vec3 *origin, vec3 *direction)
{
  if (lens[0] == 0 && lens[1] == 0) return;
  vec3 x, y;
  aperture_axes(camera, *direction, &x, &y);
  const double length = aperture_reach(camera, *direction);
  const vec3 offset = v3_mad(x, lens[0], v3_scale(y, lens[1]));
  *origin = v3_add(*origin, offset);
  *direction = v3_normalize(v3_sub(v3_scale(*direction, length), offset));
}

bent_status aperture_check(const bent_aperture *a, bent_error *error)
{
  if (!(a->radius >= 0 && isfinite(a->radius)))
    return bent_fail(error, BENT_ERROR_ARGUMENT, "camera: aperture_radius must be finite and not negative, got %g", a->radius);
  if (a->radius == 0) return BENT_OK;
  if (!(a->focal_distance > 0 && isfinite(a->focal_distance)))
    return bent_fail(error, BENT_ERROR_ARGUMENT, "camera: focal_distance must be finite and positive, got %g",
                     a->focal_distance);
  if (a->blades > BENT_APERTURE_BLADES_MAX) /* the lens' cells are as many (star_lens.c) */
    return bent_fail(error, BENT_ERROR_ARGUMENT, "camera: aperture_blades must be at most %d, got %u",
                     BENT_APERTURE_BLADES_MAX, a->blades);
  if (!(a->ratio > 0 && isfinite(a->ratio)))
    return bent_fail(error, BENT_ERROR_ARGUMENT, "camera: aperture_ratio must be finite and positive, got %g", a->ratio);
  return isfinite(a->rotation) ? BENT_OK
                               : bent_fail(error, BENT_ERROR_ARGUMENT, "camera: aperture_rotation is not finite");
}
