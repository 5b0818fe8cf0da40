/* What passes tell objects, materials and lights apart by. Nothing of it changes the picture. */
#ifndef BENTLIGHT_LABELS_H
#define BENTLIGHT_LABELS_H
#include "bentlight/scene.h"

typedef struct bent_instance_label {
  float object, asset; /* Cryptomatte names, as numbers: what their hashes are as float32; 0: none */
  int32_t light_group; /* of the light that it emits; -1: none, as in all that follows */
  int32_t is_disk;     /* an accretion disk */
} bent_instance_label;

typedef struct bent_material_label {
  float name;  /* Cryptomatte's */
  float index; /* material_index */
} bent_material_label;

/* In the order in which they were added; what has no label has none of all that. */
typedef struct bent_labels {
  size_t instance_count, material_count, lamp_count, sun_count;
  const bent_instance_label *instances;
  const bent_material_label *materials;
  const int32_t *lamp_groups, *sun_groups;
  int32_t world_group;
} bent_labels;

/* Replaces all labels, which are copied. Visible at once: not while the scene is being rendered. */
bent_status bent_scene_set_labels(bent_scene *scene, const bent_labels *labels, bent_error *error);
#endif
