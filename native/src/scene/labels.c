/* See labels.h. */
#include "scene/labels.h"

#include <stdlib.h>
#include <string.h>

#include "scene/scene.h"

struct labels {
  size_t instance_count, material_count, lamp_count, sun_count;
  bent_instance_label *instances;
  bent_material_label *materials;
  int32_t *lamp_groups, *sun_groups;
  int32_t world_group;
};

bent_instance_label labels_instance(const labels *l, int instance)
{
  const int is_known = l && instance >= 0 && (size_t)instance < l->instance_count;
  return is_known ? l->instances[instance] : (bent_instance_label){.light_group = -1};
}

bent_material_label labels_material(const labels *l, int material)
{
  const int is_known = l && material >= 0 && (size_t)material < l->material_count;
  return is_known ? l->materials[material] : (bent_material_label){.index = 0};
}

int labels_lamp_group(const labels *l, int lamp)
{
  return l && (size_t)lamp < l->lamp_count ? l->lamp_groups[lamp] : -1;
}

int labels_sun_group(const labels *l, int sun)
{
  return l && (size_t)sun < l->sun_count ? l->sun_groups[sun] : -1;
}

int labels_world_group(const labels *l) { return l ? l->world_group : -1; }

void labels_free(labels *l)
{
  if (!l) return;
  free(l->instances);
  free(l->materials);
  free(l->lamp_groups);
  free(l->sun_groups);
  free(l);
}

/* A copy of `count` things of `size` bytes; NULL: out of memory. */
static void *copied(const void *from, size_t count, size_t size)
{
  void *to = malloc(count * size + 1);
  if (to && count) memcpy(to, from, count * size);
  return to;
}

bent_status bent_scene_set_labels(bent_scene *scene, const bent_labels *given, bent_error *error)
{
  labels *l = calloc(1, sizeof *l);
  if (!l) return bent_fail(error, BENT_ERROR_MEMORY, "scene: out of memory");
  l->instance_count = given->instance_count, l->material_count = given->material_count;
  l->lamp_count = given->lamp_count, l->sun_count = given->sun_count;
  l->world_group = given->world_group;
  l->instances = copied(given->instances, given->instance_count, sizeof *l->instances);
  l->materials = copied(given->materials, given->material_count, sizeof *l->materials);
  l->lamp_groups = copied(given->lamp_groups, given->lamp_count, sizeof *l->lamp_groups);
  l->sun_groups = copied(given->sun_groups, given->sun_count, sizeof *l->sun_groups);
  if (!l->instances || !l->materials || !l->lamp_groups || !l->sun_groups) {
    labels_free(l);
    return bent_fail(error, BENT_ERROR_MEMORY, "scene: out of memory");
  }
  labels_free(scene->labels);
  scene->labels = l;
  return BENT_OK;
}
