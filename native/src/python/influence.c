/* The argument that says whom an emitter lights. */
#include "python.h"

int influence_get(PyObject *object, bent_influence *out)
{
  unsigned long long receivers, blockers;
  unsigned max_bounces;
  if (!object || !PyTuple_Check(object)) {
    PyErr_SetString(PyExc_TypeError, "influence: expected an Influence (receivers, blockers, max_bounces)");
    return -1;
  }
  if (!PyArg_ParseTuple(object, "KKI:influence", &receivers, &blockers, &max_bounces)) return -1;
  *out = (bent_influence){receivers, blockers, max_bounces};
  return 0;
}
