/* The scene method for motion: where things are in the frames before and after. */
#include "python.h"

#include <stdlib.h>

#include "bentlight/motion.h"
#include "geometry/geometry.h"
#include "scene/scene.h"

/* One moment, as long as its buffers are held. */
typedef struct held_moment {
  bent_moment moment;
  buffer matrices, *vertices;
  const float (**pointers)[3];
  Py_ssize_t count;
} held_moment;

static void let_go(held_moment *h)
{
  buffer_release(&h->matrices);
  if (h->vertices) buffer_release_all(h->vertices, (size_t)h->count);
  free(h->vertices);
  free(h->pointers);
}

/* Vertices of meshes, or None for those that are the same. Returns 0, or -1 with an error. */
static int get_vertices(const bent_scene *scene, PyObject *list, held_moment *h)
{
  h->count = PySequence_Size(list);
  if (h->count < 0) return -1;
  if ((size_t)h->count > scene->geometry->mesh_count) return PyErr_SetString(PyExc_ValueError, "vertices: too many meshes"), -1;
  h->vertices = calloc((size_t)h->count + 1, sizeof *h->vertices);
  h->pointers = calloc((size_t)h->count + 1, sizeof *h->pointers);
  if (!h->vertices || !h->pointers) return PyErr_NoMemory(), -1;
  for (Py_ssize_t i = 0; i < h->count; i++) {
    PyObject *item = PySequence_GetItem(list, i);
    Py_ssize_t shape[] = {(Py_ssize_t)scene->geometry->meshes[i].vertex_count, 3};
    const int bad = !item || buffer_get(&h->vertices[i], item, "vertices", 'f', 2, shape, BUFFER_OPTIONAL | BUFFER_FINITE);
    Py_XDECREF(item);
    if (bad) return -1;
    h->pointers[i] = buffer_data(&h->vertices[i]);
  }
  return 0;
}

/* (view, world_from_mesh (n, 4, 4), [vertices (m, 3) or None, ...]) */
static int get_moment(const bent_scene *scene, PyObject *tuple, held_moment *h)
{
  PyObject *view, *matrices, *vertices;
  Py_ssize_t shape[] = {-1, 4, 4};
  if (!PyArg_ParseTuple(tuple, "OOO:moment", &view, &matrices, &vertices)) return -1;
  const bent_scene *value = scene_value(view);
  if (!value || buffer_get(&h->matrices, matrices, "world_from_mesh", 'd', 3, shape, BUFFER_FINITE) ||
      get_vertices(scene, vertices, h))
    return -1;
  h->moment = (bent_moment){value, (size_t)shape[0], (size_t)h->count, buffer_data(&h->matrices),
                            (const float(*const *)[3])h->pointers};
  return 0;
}

/* _set_motion(before, after), or (None, None) */
static PyObject *set_motion(PyObject *self, PyObject *args)
{
  PyObject *tuples[2];
  bent_scene *scene = scene_value(self);
  if (!scene || !PyArg_ParseTuple(args, "OO:set_motion", &tuples[0], &tuples[1])) return NULL;
  held_moment held[2] = {{.count = 0}, {.count = 0}};
  const int is_none = tuples[0] == Py_None;
  PyObject *result = NULL;
  if (is_none || (!get_moment(scene, tuples[0], &held[0]) && !get_moment(scene, tuples[1], &held[1]))) {
    const bent_moment moments[2] = {held[0].moment, held[1].moment};
    bent_error error;
    result = bent_scene_set_motion(scene, is_none ? NULL : moments, &error) ? raise_error(&error) : Py_NewRef(Py_None);
  }
  let_go(&held[0]);
  let_go(&held[1]);
  return result;
}

/* The numpy-facing signature and docstring are in motion.py. */
PyMethodDef scene_motion_methods[] = {{"_set_motion", set_motion, METH_VARARGS, NULL}, {0}};
