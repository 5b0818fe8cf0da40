/* A scene's labels (bentlight/labels.h), looked up. */
#ifndef BENT_SCENE_LABELS_H
#define BENT_SCENE_LABELS_H
#include "bentlight/labels.h"

typedef struct labels labels; /* NULL: nothing has any */

bent_instance_label labels_instance(const labels *labels, int instance);
bent_material_label labels_material(const labels *labels, int material);
int labels_lamp_group(const labels *labels, int lamp);
int labels_sun_group(const labels *labels, int sun);
int labels_world_group(const labels *labels);
void labels_free(labels *labels);
#endif
