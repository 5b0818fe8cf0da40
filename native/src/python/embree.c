/* Python's view of the binding to Embree: which copy, and where from. */
#include "python.h"

#include <stdlib.h>

static PyObject *load_embree(PyObject *module, PyObject *list)
{
  (void)module;
  const Py_ssize_t count = PySequence_Size(list);
  if (count < 0) return NULL;
  PyObject **items = calloc((size_t)count + 1, sizeof *items);
  const char **paths = calloc((size_t)count + 1, sizeof *paths);
  PyObject *result = items && paths ? Py_None : PyErr_NoMemory();
  for (Py_ssize_t i = 0; i < count && result; i++) {
    items[i] = PySequence_GetItem(list, i);
    paths[i] = items[i] ? PyUnicode_AsUTF8AndSize(items[i], NULL) : NULL;
    if (!paths[i]) result = NULL;
  }
  bent_error error;
  if (result && bent_embree_load((size_t)count, paths, &error)) result = raise_error(&error);
  for (Py_ssize_t i = 0; items && i < count; i++) Py_XDECREF(items[i]);
  free(items);
  free(paths);
  Py_XINCREF(result);
  return result;
}

static PyObject *embree_copy(PyObject *module, PyObject *unused)
{
  (void)module, (void)unused;
  return Py_BuildValue("(zz)", bent_embree_version(), bent_embree_origin());
}

PyMethodDef embree_functions[] = {
    {"load_embree", load_embree, METH_O, "load_embree(paths): see bentlight_native.load_embree."},
    {"embree_copy", embree_copy, METH_NOARGS,
     "embree_copy() -> (version, origin)\n\nThe bound Embree, or (None, None) before it is needed."},
    {0}};
