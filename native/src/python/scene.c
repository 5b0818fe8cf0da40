/* Scene: the handle type; its methods live in scene_geometry.c, scene_shading.c, scene_render.c and scene_stars.c. */
#include "python.h"

#include <stdlib.h>
#include <string.h>

typedef struct scene_object {
  PyObject_HEAD
  bent_scene *scene;
} scene_object;

static PyTypeObject *scene_type;
static PyMethodDef *all_methods;

static PyObject *new_scene(PyTypeObject *type, PyObject *args, PyObject *keywords)
{
  static char *names[] = {NULL};
  if (!PyArg_ParseTupleAndKeywords(args, keywords, ":Scene", names)) return NULL;
  allocfunc allocate = (allocfunc)PyType_GetSlot(type, Py_tp_alloc);
  scene_object *self = (scene_object *)allocate(type, 0);
  bent_error error;
  if (self && bent_scene_new(&self->scene, &error)) {
    Py_DECREF(self);
    return raise_error(&error);
  }
  return (PyObject *)self;
}

static void dealloc(PyObject *self)
{
  bent_scene_free(((scene_object *)self)->scene);
  object_free(self);
}

/* One method table out of the topics' tables; it lives as long as the process. */
static PyMethodDef *gather(void)
{
  PyMethodDef *const topics[] = {scene_geometry_methods, scene_shading_methods, scene_render_methods, scene_label_methods,
                                 scene_star_methods, scene_motion_methods};
  size_t count = 1, used = 0;
  for (size_t t = 0; t < sizeof topics / sizeof *topics; t++)
    for (PyMethodDef *m = topics[t]; m->ml_name; m++) count++;
  PyMethodDef *methods = calloc(count, sizeof *methods);
  for (size_t t = 0; methods && t < sizeof topics / sizeof *topics; t++)
    for (PyMethodDef *m = topics[t]; m->ml_name; m++) methods[used++] = *m;
  return methods;
}

int scene_add_type(PyObject *module)
{
  if (!scene_type) {
    if (!all_methods && !(all_methods = gather())) return PyErr_NoMemory(), -1;
    PyType_Slot slots[] = {{Py_tp_doc, "A scene: edit it from one thread, commit(), then read it from many."},
                           {Py_tp_new, new_scene}, {Py_tp_dealloc, dealloc}, {Py_tp_methods, all_methods}, {0, NULL}};
    PyType_Spec spec = {"bentlight_native._core.Scene", sizeof(scene_object), 0,
                        Py_TPFLAGS_DEFAULT | Py_TPFLAGS_BASETYPE, slots};
    scene_type = (PyTypeObject *)PyType_FromSpec(&spec);
  }
  return scene_type ? PyModule_AddObjectRef(module, "Scene", (PyObject *)scene_type) : -1;
}

bent_scene *scene_value(PyObject *object)
{
  if (PyObject_TypeCheck(object, scene_type)) return ((scene_object *)object)->scene;
  PyErr_SetString(PyExc_TypeError, "expected a bentlight_native.Scene");
  return NULL;
}
