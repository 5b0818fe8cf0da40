/* Values that materials ask for by number: of the corners of a mesh's triangles, and of an instance as a whole. */
#ifndef BENT_SCENE_ATTRIBUTE_H
#define BENT_SCENE_ATTRIBUTE_H
#include <stddef.h>

#include "bentlight/error.h"

enum { ATTRIBUTE_COMPONENTS_MAX = 4 };

typedef struct attribute {
  int id, components;
  float *values; /* `components` for each corner of each triangle, or of an instance for all */
} attribute;

typedef struct attribute_list {
  size_t count;
  attribute *items;
} attribute_list;

/* Adds a copy of `count` values of `components` (1 to 4) floats, or puts it in the place of the one with that id. The values
 * must be finite. `name` begins the error message. */
bent_status attribute_set(attribute_list *list, int id, int components, size_t count, const float *values,
                          const char *name, bent_error *error);
/* NULL if there is none. */
const attribute *attribute_find(const attribute_list *list, int id);
void attributes_free(attribute_list *list);
#endif
