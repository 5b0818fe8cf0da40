/* See attribute.h. */
#include "scene/attribute.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static attribute *place_of(attribute_list *list, int id)
{
  for (size_t i = 0; i < list->count; i++)
    if (list->items[i].id == id) return &list->items[i];
  attribute *items = realloc(list->items, (list->count + 1) * sizeof *items);
  if (!items) return NULL;
  list->items = items;
  items[list->count] = (attribute){.id = id};
  return &items[list->count++];
}

bent_status attribute_set(attribute_list *list, int id, int components, size_t count, const float *values,
                          const char *name, bent_error *error)
{
  if (id < 0 || components < 1 || components > ATTRIBUTE_COMPONENTS_MAX)
    return bent_fail(error, BENT_ERROR_ARGUMENT, "%s: id %d with %d components; expected 0 or more with 1 to 4", name, id,
                     components);
  const size_t length = count * (size_t)components;
  for (size_t i = 0; i < length; i++)
    if (!isfinite(values[i]))
      return bent_fail(error, BENT_ERROR_ARGUMENT, "%s: value %zu is not finite", name, i / (size_t)components);
  float *copy = malloc((length + 1) * sizeof *copy);
  attribute *place = copy ? place_of(list, id) : NULL;
  if (!place) {
    free(copy);
    return bent_fail(error, BENT_ERROR_MEMORY, "%s: out of memory", name);
  }
  if (length) memcpy(copy, values, length * sizeof *copy);
  free(place->values);
  place->components = components;
  place->values = copy;
  return BENT_OK;
}

const attribute *attribute_find(const attribute_list *list, int id)
{
  for (size_t i = 0; list && i < list->count; i++)
    if (list->items[i].id == id) return &list->items[i];
  return NULL;
}

void attributes_free(attribute_list *list)
{
  for (size_t i = 0; i < list->count; i++) free(list->items[i].values);
  free(list->items);
  *list = (attribute_list){0};
}
