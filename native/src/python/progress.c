/* Progress: the cell through which Python watches and cancels a running call. */
#include "python.h"

typedef struct progress_object {
  PyObject_HEAD
  bent_progress progress;
} progress_object;

static PyTypeObject *progress_type;

static PyObject *get_done(PyObject *self, void *closure)
{
  (void)closure;
  return PyLong_FromUnsignedLongLong(atomic_load(&((progress_object *)self)->progress.done));
}
static PyObject *get_cancelled(PyObject *self, void *closure)
{
  (void)closure;
  return PyBool_FromLong(atomic_load(&((progress_object *)self)->progress.cancel));
}
static PyObject *cancel(PyObject *self, PyObject *unused)
{
  (void)unused;
  atomic_store(&((progress_object *)self)->progress.cancel, 1);
  Py_RETURN_NONE;
}

static PyObject *advance(PyObject *self, PyObject *count)
{
  const unsigned long long units = PyLong_AsUnsignedLongLong(count);
  if (units == (unsigned long long)-1 && PyErr_Occurred()) return NULL;
  atomic_fetch_add(&((progress_object *)self)->progress.done, units);
  Py_RETURN_NONE;
}

static PyGetSetDef getset[] = {
    {"done", get_done, NULL, "Units of work finished so far (rays, rows or samples, as the call says).", NULL},
    {"cancelled", get_cancelled, NULL, "Whether cancel() was called.", NULL},
    {0}};
static PyMethodDef methods[] = {
    {"cancel", cancel, METH_NOARGS, "Ask the running call to stop soon."},
    {"advance", advance, METH_O, "advance(count)\n\nAdd to `done`: for work that is driven from Python."},
    {0}};

static PyType_Slot slots[] = {{Py_tp_doc, "Progress()\n\nShared with a running call; poll `done`, call `cancel()`."},
                              {Py_tp_dealloc, object_free}, {Py_tp_getset, getset}, {Py_tp_methods, methods}, {0, NULL}};
static PyType_Spec spec = {"bentlight_native.Progress", sizeof(progress_object), 0, Py_TPFLAGS_DEFAULT, slots};

int progress_add_type(PyObject *module)
{
  if (!progress_type) progress_type = (PyTypeObject *)PyType_FromSpec(&spec);
  return progress_type ? PyModule_AddObjectRef(module, "Progress", (PyObject *)progress_type) : -1;
}

bent_progress *progress_value(PyObject *object, int *ok)
{
  *ok = 1;
  if (!object || object == Py_None) return NULL;
  if (PyObject_TypeCheck(object, progress_type)) return &((progress_object *)object)->progress;
  *ok = 0;
  PyErr_SetString(PyExc_TypeError, "progress: expected a bentlight_native.Progress or None");
  return NULL;
}
