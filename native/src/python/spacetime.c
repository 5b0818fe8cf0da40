/* Spacetime: an immutable value, made by its four class methods. */
#include "python.h"

#include <string.h>

typedef struct spacetime_object {
  PyObject_HEAD
  bent_spacetime value;
} spacetime_object;

static PyTypeObject *spacetime_type;

static PyObject *make(const bent_spacetime *value)
{
  spacetime_object *self = PyObject_New(spacetime_object, spacetime_type);
  if (self) self->value = *value;
  return (PyObject *)self;
}

static PyObject *minkowski(PyObject *cls, PyObject *unused)
{
  (void)cls, (void)unused;
  const bent_spacetime value = bent_minkowski();
  return make(&value);
}

static PyObject *schwarzschild(PyObject *cls, PyObject *args, PyObject *keywords)
{
  (void)cls;
  static char *names[] = {"mass", "chart", NULL};
  double mass;
  const char *chart = "isotropic";
  if (!PyArg_ParseTupleAndKeywords(args, keywords, "d|s:schwarzschild", names, &mass, &chart)) return NULL;
  const int areal = !strcmp(chart, "areal");
  if (!areal && strcmp(chart, "isotropic"))
    return PyErr_Format(PyExc_ValueError, "chart: expected 'isotropic' or 'areal', got '%s'", chart);
  bent_spacetime value;
  bent_error error;
  if (bent_schwarzschild(mass, areal ? BENT_CHART_AREAL : BENT_CHART_ISOTROPIC, &value, &error))
    return raise_error(&error);
  return make(&value);
}

static PyObject *kerr(PyObject *cls, PyObject *args, PyObject *keywords)
{
  (void)cls;
  static char *names[] = {"mass", "spin", NULL};
  double mass, spin;
  if (!PyArg_ParseTupleAndKeywords(args, keywords, "dd:kerr", names, &mass, &spin)) return NULL;
  bent_spacetime value;
  bent_error error;
  if (bent_kerr(mass, spin, &value, &error)) return raise_error(&error);
  return make(&value);
}

static PyObject *ellis(PyObject *cls, PyObject *args, PyObject *keywords)
{
  (void)cls;
  static char *names[] = {"throat_radius", NULL};
  double throat_radius;
  if (!PyArg_ParseTupleAndKeywords(args, keywords, "d:ellis", names, &throat_radius)) return NULL;
  bent_spacetime value;
  bent_error error;
  if (bent_ellis(throat_radius, &value, &error)) return raise_error(&error);
  return make(&value);
}

static PyObject *represent(PyObject *self)
{
  const bent_spacetime *s = &((spacetime_object *)self)->value;
  char text[160];
  switch (s->kind) {
    case BENT_MINKOWSKI: PyOS_snprintf(text, sizeof text, "Spacetime.minkowski()"); break;
    case BENT_SCHWARZSCHILD:
      PyOS_snprintf(text, sizeof text, "Spacetime.schwarzschild(mass=%.17g, chart='%s')", s->mass,
                    s->chart == BENT_CHART_AREAL ? "areal" : "isotropic");
      break;
    case BENT_KERR:
      PyOS_snprintf(text, sizeof text, "Spacetime.kerr(mass=%.17g, spin=%.17g)", s->mass, s->spin);
      break;
    case BENT_ELLIS:
      PyOS_snprintf(text, sizeof text, "Spacetime.ellis(throat_radius=%.17g)", s->throat_radius);
      break;
  }
  return PyUnicode_FromString(text);
}

static PyObject *get_core_radius(PyObject *self, void *closure)
{
  (void)closure;
  return PyFloat_FromDouble(bent_spacetime_core_radius(&((spacetime_object *)self)->value));
}

static PyObject *get_kind(PyObject *self, void *closure)
{
  (void)closure;
  static const char *const names[] = {"minkowski", "schwarzschild", "kerr", "ellis"};
  return PyUnicode_FromString(names[((spacetime_object *)self)->value.kind]);
}

static PyObject *get_chart(PyObject *self, void *closure)
{
  (void)closure;
  static const char *const names[] = {"cartesian", "isotropic", "areal", "oblate"};
  return PyUnicode_FromString(names[((spacetime_object *)self)->value.chart]);
}

static PyObject *get_mass(PyObject *self, void *closure)
{
  (void)closure;
  return PyFloat_FromDouble(((spacetime_object *)self)->value.mass);
}

static PyObject *get_spin(PyObject *self, void *closure)
{
  (void)closure;
  return PyFloat_FromDouble(((spacetime_object *)self)->value.spin);
}

static PyGetSetDef getset[] = {
    {"mass", get_mass, NULL, "Mass as a length; 0 for flat space and wormholes.", NULL},
    {"spin", get_spin, NULL, "Spin as a length; 0 unless Kerr.", NULL},
    {"kind", get_kind, NULL, "'minkowski', 'schwarzschild', 'kerr' or 'ellis'.", NULL},
    {"chart", get_chart, NULL, "'cartesian', 'isotropic', 'areal' or 'oblate'.", NULL},
    {"core_radius", get_core_radius, NULL, "Scene radius of the horizon or throat at the equator; 0 if flat.", NULL},
    {0}};

#define METHOD(name, doc) {#name, (PyCFunction)(void (*)(void))name, METH_CLASS | METH_VARARGS | METH_KEYWORDS, doc}
static PyMethodDef methods[] = {
    {"minkowski", minkowski, METH_CLASS | METH_NOARGS, "minkowski()\n\nFlat space."},
    METHOD(schwarzschild, "schwarzschild(mass, chart='isotropic')\n\nA hole without spin; chart 'isotropic' or 'areal'."),
    METHOD(kerr, "kerr(mass, spin)\n\nA spinning hole; spin is a length, |spin| < mass; chart 'oblate'."),
    METHOD(ellis, "ellis(throat_radius)\n\nA wormhole (Ellis 1973), isotropic chart."),
    {0}};
#undef METHOD

static PyType_Slot slots[] = {
    {Py_tp_doc, "A spacetime: use minkowski(), schwarzschild(), kerr() or ellis(). Lengths in scene units, G = c = 1."},
    {Py_tp_dealloc, object_free}, {Py_tp_repr, represent}, {Py_tp_getset, getset}, {Py_tp_methods, methods}, {0, NULL}};
static PyType_Spec spec = {"bentlight_native.Spacetime", sizeof(spacetime_object), 0,
                           Py_TPFLAGS_DEFAULT | Py_TPFLAGS_DISALLOW_INSTANTIATION, slots};

int spacetime_add_type(PyObject *module)
{
  if (!spacetime_type) spacetime_type = (PyTypeObject *)PyType_FromSpec(&spec);
  return spacetime_type ? PyModule_AddObjectRef(module, "Spacetime", (PyObject *)spacetime_type) : -1;
}

const bent_spacetime *spacetime_value(PyObject *object)
{
  if (PyObject_TypeCheck(object, spacetime_type)) return &((spacetime_object *)object)->value;
  PyErr_SetString(PyExc_TypeError, "spacetime: expected a bentlight_native.Spacetime");
  return NULL;
}
