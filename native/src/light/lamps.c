/* See lamps.h. */
#include "light/lamps.h"

#include <stdlib.h>
#include <string.h>

#include "geometry/mesh.h"
#include "scene/scene.h"
#include "scene/shading.h"

void lamps_free(lamps *lamps) { free(lamps); }

vec3 lamp_intensity(const bent_scene *scene, const lamp *lamp, vec3 direction, double distance, const ray_history *ray)
{
  const shade_point point = {.position = lamp->position, .wo = direction, .geometric_normal = direction,
                             .normal = direction, .tangent_sign = 1, .ray_length = distance, .object_color = {1, 1, 1, 1},
                             .world_from_object = &lamp->world_from_lamp, .object_from_world = &lamp->lamp_from_world, .ray = *ray};
  return shading_emission(scene->shading, lamp->material, &point);
}

bent_status bent_scene_set_lamps(bent_scene *scene, size_t count, const bent_lamp *given, bent_error *error)
{
  lamps *made = calloc(1, sizeof *made + count * sizeof *made->list);
  if (!made) return bent_fail(error, BENT_ERROR_MEMORY, "lamps: out of memory");
  made->count = count;
  for (size_t i = 0; i < count; i++) {
    lamp *l = &made->list[i];
    const bent_status status = affine_check("world_from_lamp", given[i].world_from_lamp, &l->lamp_from_world, error);
    if (status) return free(made), status;
    memcpy(l->world_from_lamp.m, given[i].world_from_lamp, sizeof l->world_from_lamp.m);
    l->position = mat4_point(&l->world_from_lamp, v3(0, 0, 0));
    l->material = given[i].material;
    l->visibility = given[i].visibility;
    l->influence = given[i].influence;
  }
  lamps_free(scene->lamps);
  scene->lamps = made;
  scene_edited(scene);
  return BENT_OK;
}
