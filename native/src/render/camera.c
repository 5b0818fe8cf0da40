/* See camera.h. Panoramic projections are written in the panorama's own axes, forward +x, left +y, up +z, as Cycles
 * does, then turned into camera space. */
#include "render/camera.h"

#include <stdlib.h>
#include <string.h>

#include "render/aperture.h"
#include "scene/scene.h"

static double lerp(const double range[2], double t) { return range[0] + t * (range[1] - range[0]); }

static vec3 camera_from_panorama(vec3 d) { return v3(-d.y, d.z, -d.x); }

/* Forward turned by `angle` towards the image direction (u, v), r = |(u, v)|. */
static vec3 turned(double angle, double u, double v, double r)
{
  const double s = r > 0 ? sin(angle) / r : 0;
  return v3(cos(angle), -u * s, v * s);
}

/* Direction in camera space for projection coordinates (u, v) of the whole panorama; 0 where there is none. Not
 * necessarily of unit length. Same mappings as Cycles. */
static int panoramic_direction(const bent_camera *c, double u, double v, vec3 *out)
{
  const double du = u - 0.5, dv = v - 0.5, half_fov = c->fisheye_fov / 2;
  double r = v2_length(du, dv), angle;
  switch (c->kind) {
    case BENT_CAMERA_EQUIRECTANGULAR: {
      const double longitude = lerp(c->longitude, u), latitude = lerp(c->latitude, v);
      *out = camera_from_panorama(
          v3(cos(latitude) * cos(longitude), -cos(latitude) * sin(longitude), sin(latitude)));
      return 1;
    }
    case BENT_CAMERA_EQUIANGULAR_CUBEMAP_FACE:
      *out = v3(tan(M_PI_2 * du), tan(M_PI_2 * dv), -1);
      return 1;
    case BENT_CAMERA_CENTRAL_CYLINDRICAL: {
      const double longitude = lerp(c->cylinder_longitude, u);
      *out = camera_from_panorama(
          v3(cos(longitude), -sin(longitude), lerp(c->cylinder_height, v) / c->cylinder_radius));
      return 1;
    }
    case BENT_CAMERA_MIRRORBALL: { /* the view along -z reflected by the ball's normal */
      const double x = 2 * du, y = 2 * dv, z2 = 1 - x * x - y * y;
      if (z2 < 0) return 0;
      const double z = sqrt(z2);
      *out = v3(2 * x * z, 2 * y * z, 2 * z2 - 1);
      out->z = -out->z;
      return 1;
    }
    case BENT_CAMERA_FISHEYE_EQUIDISTANT:
      if (2 * r > 1) return 0;
      *out = camera_from_panorama(turned(2 * r * half_fov, du, dv, r));
      return 1;
    case BENT_CAMERA_FISHEYE_EQUISOLID:
      r = v2_length(du * c->sensor_width, dv * c->sensor_height);
      if (r > 2 * c->fisheye_lens * sin(half_fov / 2)) return 0;
      angle = 2 * asin(fmin(r / (2 * c->fisheye_lens), 1));
      *out = camera_from_panorama(turned(angle, du * c->sensor_width, dv * c->sensor_height, r));
      return 1;
    default: { /* fisheye lens polynomial */
      const double *k = c->fisheye_polynomial;
      r = v2_length(du * c->sensor_width, dv * c->sensor_height);
      angle = -(k[0] + r * (k[1] + r * (k[2] + r * (k[3] + r * k[4]))));
      if (!(fabs(angle) <= half_fov)) return 0;
      *out = camera_from_panorama(turned(angle, du * c->sensor_width, dv * c->sensor_height, r));
      return 1;
    }
  }
}

int camera_cast(const camera *camera, double x, double y, camera_ray *ray)
{
  return camera_cast_lens(camera, x, y, (const double[2]){0, 0}, ray);
}

int camera_cast_lens(const camera *camera, double x, double y, const double lens[2], camera_ray *ray)
{
  const bent_camera *c = &camera->settings;
  const double u = lerp(&c->viewplane[0], x), v = lerp(&c->viewplane[2], y);
  vec3 origin = v3(0, 0, 0), direction = v3(0, 0, -1);
  if (c->kind == BENT_CAMERA_PERSPECTIVE) {
    direction = v3_normalize(v3(u, v, -1));
  } else if (c->kind == BENT_CAMERA_ORTHOGRAPHIC) {
    origin = v3(u, v, 0);
  } else {
    if (!panoramic_direction(c, u, v, &direction)) return 0;
    direction = v3_normalize(direction);
  }
  aperture_refract(c, lens, &origin, &direction);
  const double depth_per_length = c->kind > BENT_CAMERA_ORTHOGRAPHIC ? 1 : -direction.z;
  *ray = (camera_ray){.origin = mat4_point(&camera->world_from_camera, origin),
                      .direction = v3_normalize(mat4_vector(&camera->world_from_camera, direction)),
                      .length_min = c->clip_start / depth_per_length,
                      .length_max = c->clip_end / depth_per_length,
                      .depth_per_length = depth_per_length};
  return 1;
}

vec3 camera_from_world_direction(const camera *camera, vec3 direction)
{
  return mat4_transposed_vector(&camera->world_from_camera, direction);
}

int camera_has_inverse(const camera *camera) { return camera->settings.kind == BENT_CAMERA_PERSPECTIVE; }

vec3 camera_lens_position(const camera *camera, const double lens[2])
{
  return mat4_point(&camera->world_from_camera, v3(lens[0], lens[1], 0));
}

int camera_project(const camera *camera, const double lens[2], vec3 direction, double image[2], double *solid_angle)
{
  const double *plane = camera->settings.viewplane, width = plane[1] - plane[0], height = plane[3] - plane[2];
  const double focus = camera->settings.aperture.focal_distance;
  const vec3 d = camera_from_world_direction(camera, direction);
  if (!camera_has_inverse(camera) || !(d.z < 0)) return 0;
  const double x = (d.x / -d.z - plane[0]) / width, y = (d.y / -d.z - plane[2]) / height; /* by the lens' middle */
  *solid_angle = camera_solid_angle(camera, x, y); /* of any place: it sees another part of the plane in focus, as large */
  image[0] = x + (lens[0] ? lens[0] / (focus * width) : 0);
  image[1] = y + (lens[1] ? lens[1] / (focus * height) : 0);
  return 1;
}

/* The change of direction per step across the image; on one side only where the other has no ray. */
static vec3 slope(const camera *camera, double x, double y, double step_x, double step_y)
{
  camera_ray before, here, after;
  const int has_before = camera_cast(camera, x - step_x, y - step_y, &before), is_here = camera_cast(camera, x, y, &here);
  const int has_after = camera_cast(camera, x + step_x, y + step_y, &after);
  if (!is_here || (!has_before && !has_after)) return v3(0, 0, 0);
  const vec3 change = v3_sub(has_after ? after.direction : here.direction, has_before ? before.direction : here.direction);
  return v3_scale(change, 1.0 / (has_before + has_after));
}

double camera_solid_angle(const camera *camera, double x, double y)
{
  const double step = 1e-4; /* the error is of second order */
  return v3_length(v3_cross(slope(camera, x, y, step, 0), slope(camera, x, y, 0, step))) / (step * step);
}

void camera_free(camera *camera) { free(camera); }

static bent_status check_panoramic(const bent_camera *c, bent_error *error)
{
  const int fisheye = c->kind == BENT_CAMERA_FISHEYE_EQUIDISTANT || c->kind == BENT_CAMERA_FISHEYE_EQUISOLID ||
                      c->kind == BENT_CAMERA_FISHEYE_LENS_POLYNOMIAL;
  if (fisheye && !(c->fisheye_fov > 0 && c->fisheye_fov <= 10 * M_PI * (1 + 1e-6))) /* float32 rounds it up */
    return bent_fail(error, BENT_ERROR_ARGUMENT, "camera: fisheye_fov must lie in (0, 10 pi], got %g", c->fisheye_fov);
  if (fisheye && c->kind != BENT_CAMERA_FISHEYE_EQUIDISTANT &&
      !(c->sensor_width > 0 && c->sensor_height > 0 && isfinite(c->sensor_width) && isfinite(c->sensor_height)))
    return bent_fail(error, BENT_ERROR_ARGUMENT, "camera: the sensor must have a positive size, got %g x %g mm",
                     c->sensor_width, c->sensor_height);
  if (c->kind == BENT_CAMERA_FISHEYE_EQUISOLID && !(c->fisheye_lens > 0 && isfinite(c->fisheye_lens)))
    return bent_fail(error, BENT_ERROR_ARGUMENT, "camera: fisheye_lens must be positive, got %g", c->fisheye_lens);
  double sum = 0; /* not finite if any of these is not */
  if (c->kind == BENT_CAMERA_EQUIRECTANGULAR)
    sum = c->longitude[0] + c->longitude[1] + c->latitude[0] + c->latitude[1];
  if (c->kind == BENT_CAMERA_FISHEYE_LENS_POLYNOMIAL)
    for (int i = 0; i < 5; i++) sum += c->fisheye_polynomial[i];
  if (c->kind == BENT_CAMERA_CENTRAL_CYLINDRICAL) {
    if (!(c->cylinder_radius > 0))
      return bent_fail(error, BENT_ERROR_ARGUMENT, "camera: the cylinder's radius must be positive, got %g",
                       c->cylinder_radius);
    sum = c->cylinder_longitude[0] + c->cylinder_longitude[1] +
          (c->cylinder_height[0] + c->cylinder_height[1]) / c->cylinder_radius;
  }
  return isfinite(sum) ? BENT_OK
                       : bent_fail(error, BENT_ERROR_ARGUMENT, "camera: a parameter of the panorama is not finite");
}

/* Copies the matrix with the columns of its rotation made unit vectors. */
static bent_status remove_scale(const double given[4][4], mat4 *out, bent_error *error)
{
  double(*const m)[4] = out->m;
  memcpy(m, given, sizeof out->m);
  for (int row = 0; row < 4; row++)
    for (int column = 0; column < 4; column++)
      if (!isfinite(m[row][column]))
        return bent_fail(error, BENT_ERROR_ARGUMENT, "camera: world_from_camera contains NaN or infinity");
  vec3 axis[3];
  for (int column = 0; column < 3; column++) {
    axis[column] = v3_normalize(v3(m[0][column], m[1][column], m[2][column]));
    m[0][column] = axis[column].x, m[1][column] = axis[column].y, m[2][column] = axis[column].z;
  }
  if (fabs(v3_dot(axis[0], v3_cross(axis[1], axis[2]))) < 1e-6)
    return bent_fail(error, BENT_ERROR_ARGUMENT, "camera: world_from_camera is singular");
  return BENT_OK;
}

bent_status bent_scene_set_camera(bent_scene *scene, const bent_camera *given, bent_error *error)
{
  const bent_camera c = *given;
  mat4 world_from_camera;
  if ((unsigned)c.kind >= BENT_CAMERA_KINDS)
    return bent_fail(error, BENT_ERROR_ARGUMENT, "camera: unknown kind %d", (int)c.kind);
  bent_status status = remove_scale(c.world_from_camera, &world_from_camera, error);
  if (!status && c.kind > BENT_CAMERA_ORTHOGRAPHIC) status = check_panoramic(&c, error);
  if (status) return status;
  const double width = c.viewplane[1] - c.viewplane[0], height = c.viewplane[3] - c.viewplane[2];
  if (!(fabs(width) > 0 && fabs(height) > 0 && isfinite(width) && isfinite(height)))
    return bent_fail(error, BENT_ERROR_ARGUMENT, "camera: the viewplane must have a finite size, not 0, got %g x %g",
                     width, height);
  if (!(c.clip_start >= 0 && c.clip_end > c.clip_start && isfinite(c.clip_start)))
    return bent_fail(error, BENT_ERROR_ARGUMENT, "camera: expected 0 <= clip_start < clip_end, got %g and %g",
                     c.clip_start, c.clip_end);
  if ((status = aperture_check(&c.aperture, error))) return status;
  if (!scene->camera && !(scene->camera = malloc(sizeof *scene->camera)))
    return bent_fail(error, BENT_ERROR_MEMORY, "camera: out of memory");
  *scene->camera = (camera){.settings = c, .world_from_camera = world_from_camera};
  scene->committed = 0;
  return BENT_OK;
}
