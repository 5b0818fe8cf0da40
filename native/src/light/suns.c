/* See suns.h. */
#include "light/suns.h"

#include <stdlib.h>
#include <string.h>

#include "geometry/mesh.h"
#include "scene/scene.h"

int sun_covers(const sun *sun, vec3 direction) { return sun->solid_angle > 0 && cap_covers(&sun->disk, direction); }

/* The disk in the unit square, as Cycles has it (kernel/light/distant.h): even in area, its edge a circle. */
static void disk_uv(const sun *sun, vec3 direction, double uv[2])
{
  uv[0] = uv[1] = 0.5;
  if (!(sun->disk.chord2 > 0)) return;
  const vec3 local = mat4_vector(&sun->sun_from_world, direction);
  const double scale = 1 / (sqrt(sun->disk.chord2) * v3_length(v3_add(direction, sun->disk.axis)));
  uv[0] += local.x * scale, uv[1] += local.y * scale;
}

vec3 sun_radiance(const bent_scene *scene, const sun *sun, vec3 direction, const ray_history *ray)
{
  if (sun->material < 0) return shading_shifted(scene->shading, sun->radiance, ray);
  const vec3 back = v3_scale(direction, -1);
  shade_point point = {.position = back, .wo = back, .geometric_normal = back, .normal = back, .tangent_sign = 1,
                       .ray_length = SKY_LENGTH, .object_color = {1, 1, 1, 1}, .ray = *ray,
                       .world_from_object = &sun->world_from_sun, .object_from_world = &sun->sun_from_world};
  disk_uv(sun, direction, point.uv);
  return shading_emission(scene->shading, sun->material, &point);
}

void suns_free(suns *suns) { free(suns); }

static bent_status make_sun(const bent_sun *given, sun *out, bent_error *error)
{
  const vec3 direction = v3_from(given->direction), radiance = v3_from(given->radiance);
  if (!v3_is_finite(direction) || !(v3_length(direction) > 0) || !isfinite(v3_length(direction)))
    return bent_fail(error, BENT_ERROR_ARGUMENT, "sun: the direction must be finite and not 0");
  if (!v3_is_finite(radiance) || radiance.x < 0 || radiance.y < 0 || radiance.z < 0)
    return bent_fail(error, BENT_ERROR_ARGUMENT, "sun: the radiance must be finite and not negative");
  if (!(given->angle >= 0 && given->angle <= M_PI))
    return bent_fail(error, BENT_ERROR_ARGUMENT, "sun: the angle must lie in [0, pi], got %g", given->angle);
  const double chord = 2 * sin(given->angle / 4);
  const cap disk = {v3_normalize(direction), chord * chord};
  *out = (sun){.disk = disk, .radiance = radiance, .material = -1, .solid_angle = cap_solid_angle(&disk),
               .visibility = given->visibility, .influence = given->influence};
  if (given->material < 0) return BENT_OK;
  out->material = given->material;
  memcpy(out->world_from_sun.m, given->world_from_sun, sizeof out->world_from_sun.m);
  return affine_check("world_from_sun", given->world_from_sun, &out->sun_from_world, error);
}

bent_status bent_scene_set_suns(bent_scene *scene, size_t count, const bent_sun *given, bent_error *error)
{
  suns *made = calloc(1, sizeof *made + count * sizeof *made->list);
  if (!made) return bent_fail(error, BENT_ERROR_MEMORY, "suns: out of memory");
  made->count = count;
  for (size_t i = 0; i < count; i++) {
    const bent_status status = make_sun(&given[i], &made->list[i], error);
    if (status) return free(made), status;
  }
  suns_free(scene->suns);
  scene->suns = made;
  scene_edited(scene);
  return BENT_OK;
}
