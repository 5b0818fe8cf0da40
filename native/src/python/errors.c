/* The one mapping from bent_status to Python exceptions. */
#include "python.h"

static PyObject *cancelled_type;

int errors_add_types(PyObject *module)
{
  if (!cancelled_type)
    cancelled_type = PyErr_NewExceptionWithDoc("bentlight_native.Cancelled",
                                               "The call was stopped through its Progress.", NULL, NULL);
  return cancelled_type ? PyModule_AddObjectRef(module, "Cancelled", cancelled_type) : -1;
}

PyObject *raise_error(const bent_error *error)
{
  PyObject *type = PyExc_RuntimeError;
  switch (error->status) {
    case BENT_ERROR_ARGUMENT:
    case BENT_ERROR_DATA: type = PyExc_ValueError; break;
    case BENT_ERROR_MEMORY: type = PyExc_MemoryError; break;
    case BENT_ERROR_UNAVAILABLE: type = PyExc_OSError; break;
    case BENT_CANCELLED: type = cancelled_type; break;
    default: break;
  }
  PyErr_SetString(type, error->message);
  return NULL;
}
