/* Where in the picture a direction is seen: the inverse of camera_cast. */
#include "render/camera.h"

/* Radians by which a place's ray may miss its direction. */
static const double MISS = 1e-6;
/* Turns around a panorama that are looked at, to each side. */
enum { TURNS = 2, BRACKETS = 64, HALVINGS = 60 };

/* Those found so far. */
typedef struct found {
  const camera *camera;
  vec3 direction;
  const double *beside;
  int count;
  double (*places)[2];
} found;

/* Adds projection coordinates of the whole image, if they are in the picture and their ray is the right one. */
static void add(found *f, double u, double v)
{
  const double *plane = f->camera->settings.viewplane;
  const double x = (u - plane[0]) / (plane[1] - plane[0]), y = (v - plane[2]) / (plane[3] - plane[2]);
  camera_ray ray;
  if (f->count == CAMERA_PLACES_MAX || !(x >= -f->beside[0] && x <= 1 + f->beside[0]) ||
      !(y >= -f->beside[1] && y <= 1 + f->beside[1]) || !camera_cast(f->camera, x, y, &ray) ||
      v3_length(v3_sub(ray.direction, f->direction)) > MISS)
    return;
  for (int i = 0; i < f->count; i++) /* in the middle of a fisheye all turns meet */
    if (f->places[i][0] == x && f->places[i][1] == y) return;
  f->places[f->count][0] = x;
  f->places[f->count++][1] = y;
}

/* All turns of a longitude. */
static void add_turns(found *f, double longitude, const double range[2], double v)
{
  for (int turn = -TURNS; turn <= TURNS; turn++)
    add(f, (longitude + 2 * M_PI * turn - range[0]) / (range[1] - range[0]), v);
}

static void add_latitude(found *f, double longitude, double latitude)
{
  const bent_camera *c = &f->camera->settings;
  add_turns(f, longitude, c->longitude, (latitude - c->latitude[0]) / (c->latitude[1] - c->latitude[0]));
}

/* At a distance from the middle of a fisheye that measures `width` x `height`, towards (x, y) of length `length`. */
static void add_around(found *f, double distance, double x, double y, double length, double width, double height)
{
  if (length > 0) distance /= length;
  add(f, 0.5 + distance * x / width, 0.5 + distance * y / height);
}

/* The distance from the middle at which a polynomial fisheye has an angle: the least that is found. */
static double polynomial_distance(const bent_camera *c, double angle)
{
#define OFF(r) (angle + k[0] + (r) * (k[1] + (r) * (k[2] + (r) * (k[3] + (r) * k[4]))))
  const double *k = c->fisheye_polynomial, most = v2_length(c->sensor_width, c->sensor_height);
  double low = 0;
  for (int i = 1; i <= BRACKETS; i++) {
    double high = most * i / BRACKETS;
    if (OFF(low) * OFF(high) <= 0) {
      for (int h = 0; h < HALVINGS; h++) {
        const double middle = 0.5 * (low + high);
        if (OFF(low) * OFF(middle) <= 0) high = middle;
        else low = middle;
      }
      return 0.5 * (low + high);
    }
    low = high;
  }
#undef OFF
  return INFINITY;
}

static void add_panoramic(found *f, vec3 d)
{
  const bent_camera *c = &f->camera->settings;
  const double side = v2_length(d.x, d.y); /* from the axis of sight, which is -z */
  const double longitude = atan2(d.x, -d.z), angle = atan2(side, -d.z), level = v2_length(d.x, d.z);
  switch (c->kind) {
    case BENT_CAMERA_EQUIRECTANGULAR:
      add_latitude(f, longitude, atan2(d.y, level));
      add_latitude(f, longitude + M_PI, M_PI - atan2(d.y, level)); /* beyond a pole */
      add_latitude(f, longitude + M_PI, -M_PI - atan2(d.y, level));
      break;
    case BENT_CAMERA_CENTRAL_CYLINDRICAL:
      add_turns(f, longitude, c->cylinder_longitude, (d.y / level * c->cylinder_radius - c->cylinder_height[0]) /
                                                         (c->cylinder_height[1] - c->cylinder_height[0]));
      break;
    case BENT_CAMERA_EQUIANGULAR_CUBEMAP_FACE:
      if (d.z < 0) add(f, 0.5 + atan(d.x / -d.z) / M_PI_2, 0.5 + atan(d.y / -d.z) / M_PI_2);
      break;
    case BENT_CAMERA_MIRRORBALL: {
      const double z = sqrt((1 - d.z) / 2);
      add(f, 0.5 + d.x / (4 * z), 0.5 + d.y / (4 * z));
      break;
    }
    case BENT_CAMERA_FISHEYE_EQUIDISTANT:
      for (int turn = 0; turn <= TURNS; turn++) { /* over the edge of the sphere the way back comes first */
        add_around(f, (2 * M_PI * turn + angle) / c->fisheye_fov, d.x, d.y, side, 1, 1);
        add_around(f, (2 * M_PI * (turn + 1) - angle) / c->fisheye_fov, -d.x, -d.y, side, 1, 1);
      }
      break;
    case BENT_CAMERA_FISHEYE_EQUISOLID:
      add_around(f, 2 * c->fisheye_lens * sin(angle / 2), d.x, d.y, side, c->sensor_width, c->sensor_height);
      break;
    default:
      add_around(f, polynomial_distance(c, angle), d.x, d.y, side, c->sensor_width, c->sensor_height);
  }
}

int camera_places(const camera *camera, vec3 direction, const double beside[2], double places[CAMERA_PLACES_MAX][2])
{
  found f = {.camera = camera, .direction = direction, .beside = beside, .places = places};
  const vec3 d = camera_from_world_direction(camera, direction);
  if (camera->settings.kind > BENT_CAMERA_ORTHOGRAPHIC) add_panoramic(&f, d);
  else if (camera->settings.kind == BENT_CAMERA_PERSPECTIVE && d.z < 0) add(&f, d.x / -d.z, d.y / -d.z);
  return f.count;
}

int camera_place_near(const camera *camera, vec3 direction, const double near[2], double place[2])
{
  const double middle[2] = {0, 0}, beside[2] = {0.5, 0.5};
  double places[CAMERA_PLACES_MAX][2], nearest = INFINITY, unused;
  if (camera_has_inverse(camera)) return camera_project(camera, middle, direction, place, &unused);
  const int count = camera_places(camera, direction, beside, places);
  for (int i = 0; i < count; i++) {
    const double distance = v2_length(places[i][0] - near[0], places[i][1] - near[1]);
    if (distance >= nearest) continue;
    nearest = distance;
    place[0] = places[i][0], place[1] = places[i][1];
  }
  return count > 0;
}

void camera_place_of_point(const camera *camera, vec3 point, double place[2])
{
  const double *plane = camera->settings.viewplane;
  const vec3 from = mat4_point(&camera->world_from_camera, v3(0, 0, 0));
  const vec3 p = camera_from_world_direction(camera, v3_sub(point, from));
  place[0] = (p.x - plane[0]) / (plane[1] - plane[0]);
  place[1] = (p.y - plane[2]) / (plane[3] - plane[2]);
}
