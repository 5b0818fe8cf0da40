/* Tables of lens spheres in Python: the handle type behind LensSphere. */
#include "python.h"

typedef struct sphere_object {
  PyObject_HEAD
  bent_sphere *sphere;
} sphere_object;

static PyTypeObject *sphere_type;

/* sphere_new(spacetime, radius) -> Sphere */
static PyObject *sphere_new(PyObject *module, PyObject *args)
{
  (void)module;
  PyObject *spacetime;
  double radius;
  if (!PyArg_ParseTuple(args, "Od:sphere_new", &spacetime, &radius)) return NULL;
  const bent_spacetime *value = spacetime_value(spacetime);
  if (!value) return NULL;
  bent_error error;
  bent_sphere *sphere;
  bent_status status;
  Py_BEGIN_ALLOW_THREADS
  status = bent_sphere_new(value, radius, &sphere, &error);
  Py_END_ALLOW_THREADS
  if (status) return raise_error(&error);
  sphere_object *self = PyObject_New(sphere_object, sphere_type);
  if (self) self->sphere = sphere;
  else bent_sphere_free(sphere);
  return (PyObject *)self;
}

static void dealloc(PyObject *self)
{
  bent_sphere_free(((sphere_object *)self)->sphere);
  object_free(self);
}

/* measured() -> (swept_max, swept_rms, length_max, length_rms) */
static PyObject *measured(PyObject *self, PyObject *unused)
{
  (void)unused;
  const bent_sphere_error e = bent_sphere_measured(((sphere_object *)self)->sphere);
  return Py_BuildValue("(dddd)", e.swept_max, e.swept_rms, e.length_max, e.length_rms);
}

typedef void passage(const bent_sphere *, size_t, const double (*)[3], const double (*)[3], const bent_crossing *);

static PyObject *pass_through(PyObject *self, PyObject *args, passage *passage)
{
  static const struct {
    const char *name;
    char format;
    int dimensions, flags;
  } wanted[] = {{"points", 'd', 2, BUFFER_FINITE}, {"directions", 'd', 2, BUFFER_FINITE}, {"fate", 'B', 1, BUFFER_WRITE},
                {"exit", 'd', 2, BUFFER_WRITE},    {"direction", 'd', 2, BUFFER_WRITE},   {"swept", 'd', 1, BUFFER_WRITE},
                {"length", 'd', 1, BUFFER_WRITE},  {"error", 'd', 1, BUFFER_WRITE}};
  enum { COUNT = sizeof wanted / sizeof *wanted };
  if (PyTuple_Size(args) != COUNT)
    return PyErr_Format(PyExc_TypeError, "expected %d arrays, got %zd", COUNT, PyTuple_Size(args));
  buffer b[COUNT] = {0};
  Py_ssize_t shape[2] = {-1, 3};
  for (int i = 0; i < COUNT; i++)
    if (buffer_get(&b[i], PyTuple_GetItem(args, i), wanted[i].name, wanted[i].format, wanted[i].dimensions, shape,
                   wanted[i].flags) < 0) {
      buffer_release_all(b, COUNT);
      return NULL;
    }
  const bent_crossing out = {.fate = buffer_data(&b[2]), .exit = buffer_data(&b[3]), .direction = buffer_data(&b[4]),
                             .swept = buffer_data(&b[5]), .length = buffer_data(&b[6]), .error = buffer_data(&b[7])};
  Py_BEGIN_ALLOW_THREADS
  passage(((sphere_object *)self)->sphere, (size_t)shape[0], buffer_data(&b[0]), buffer_data(&b[1]), &out);
  Py_END_ALLOW_THREADS
  buffer_release_all(b, COUNT);
  Py_RETURN_NONE;
}

static PyObject *cross(PyObject *self, PyObject *args) { return pass_through(self, args, bent_sphere_cross); }
static PyObject *emerge(PyObject *self, PyObject *args) { return pass_through(self, args, bent_sphere_emerge); }

static PyMethodDef methods[] = {
    {"measured", measured, METH_NOARGS, "measured() -> (swept_max, swept_rms, length_max, length_rms)"},
    {"cross", cross, METH_VARARGS, "cross(points, directions, fate, exit, direction, swept, length, error)"},
    {"emerge", emerge, METH_VARARGS, "emerge(points, directions, fate, exit, direction, swept, length, error)"},
    {0}};
static PyType_Slot slots[] = {{Py_tp_doc, "The core of a bentlight_native.LensSphere."}, {Py_tp_dealloc, dealloc},
                              {Py_tp_methods, methods}, {0, NULL}};
static PyType_Spec spec = {"bentlight_native._core.Sphere", sizeof(sphere_object), 0,
                           Py_TPFLAGS_DEFAULT | Py_TPFLAGS_DISALLOW_INSTANTIATION, slots};

int sphere_add_type(PyObject *module)
{
  if (!sphere_type) sphere_type = (PyTypeObject *)PyType_FromSpec(&spec);
  return sphere_type ? PyModule_AddObjectRef(module, "Sphere", (PyObject *)sphere_type) : -1;
}

PyMethodDef sphere_functions[] = {
    {"sphere_new", sphere_new, METH_VARARGS, "sphere_new(spacetime, radius) -> Sphere, its table built."}, {0}};
