/* The scene method for labels: what passes tell things apart by. */
#include "python.h"

#include <stdlib.h>

#include "bentlight/labels.h"

/* (instance names (n, 2), instance light groups and disks (n, 2), materials (m, 2), lamp groups, sun groups, world group) */
static PyObject *set_labels(PyObject *self, PyObject *args)
{
  enum { NAMES, GROUPS, MATERIALS, LAMPS, SUNS, COUNT };
  PyObject *objects[COUNT];
  int world_group;
  if (!PyArg_ParseTuple(args, "OOOOOi:set_labels", &objects[NAMES], &objects[GROUPS], &objects[MATERIALS], &objects[LAMPS],
                        &objects[SUNS], &world_group))
    return NULL;
  bent_scene *scene = scene_value(self);
  if (!scene) return NULL;
  Py_ssize_t instances[] = {-1, 2}, materials[] = {-1, 2}, lamps[] = {-1}, suns[] = {-1};
  buffer b[COUNT] = {0};
  PyObject *result = NULL;
  if (!buffer_get(&b[NAMES], objects[NAMES], "instance_names", 'f', 2, instances, BUFFER_FINITE) &&
      !buffer_get(&b[GROUPS], objects[GROUPS], "instance_groups", 'i', 2, instances, 0) &&
      !buffer_get(&b[MATERIALS], objects[MATERIALS], "materials", 'f', 2, materials, BUFFER_FINITE) &&
      !buffer_get(&b[LAMPS], objects[LAMPS], "lamp_groups", 'i', 1, lamps, 0) &&
      !buffer_get(&b[SUNS], objects[SUNS], "sun_groups", 'i', 1, suns, 0)) {
    bent_instance_label *list = malloc(((size_t)instances[0] + 1) * sizeof *list);
    const float(*names)[2] = buffer_data(&b[NAMES]), (*of_materials)[2] = buffer_data(&b[MATERIALS]);
    const int32_t(*groups)[2] = buffer_data(&b[GROUPS]);
    bent_material_label *second = malloc(((size_t)materials[0] + 1) * sizeof *second);
    for (Py_ssize_t i = 0; list && i < instances[0]; i++)
      list[i] = (bent_instance_label){names[i][0], names[i][1], groups[i][0], groups[i][1]};
    for (Py_ssize_t i = 0; second && i < materials[0]; i++)
      second[i] = (bent_material_label){of_materials[i][0], of_materials[i][1]};
    const bent_labels labels = {(size_t)instances[0], (size_t)materials[0], (size_t)lamps[0], (size_t)suns[0], list, second,
                                buffer_data(&b[LAMPS]), buffer_data(&b[SUNS]), world_group};
    bent_error error;
    if (!list || !second) PyErr_NoMemory();
    else if (bent_scene_set_labels(scene, &labels, &error)) raise_error(&error);
    else result = Py_NewRef(Py_None);
    free(list);
    free(second);
  }
  buffer_release_all(b, COUNT);
  return result;
}

/* The numpy-facing signature and docstring are in render.py. */
PyMethodDef scene_label_methods[] = {{"_set_labels", set_labels, METH_VARARGS, NULL}, {0}};
