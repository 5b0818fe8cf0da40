/* Deflection tables in Python: the handle type DeflectionTable, and the map functions of table/map.h over arrays. */
#include "python.h"

#include <string.h>

#include "table/map.h"

typedef struct table_object {
  PyObject_HEAD
  bent_table *table;
} table_object;

static PyTypeObject *table_type;

/* table_new(spacetime) -> Table */
static PyObject *table_new(PyObject *module, PyObject *spacetime)
{
  (void)module;
  const bent_spacetime *value = spacetime_value(spacetime);
  if (!value) return NULL;
  bent_error error;
  bent_table *table;
  if (bent_table_new(value, &table, &error)) return raise_error(&error);
  table_object *self = PyObject_New(table_object, table_type);
  if (self) self->table = table;
  else bent_table_free(table);
  return (PyObject *)self;
}

static void dealloc(PyObject *self)
{
  bent_table_free(((table_object *)self)->table);
  object_free(self);
}

static PyObject *get_rows(PyObject *self, void *closure)
{
  (void)closure;
  return PyLong_FromSize_t(bent_table_rows(((table_object *)self)->table));
}

/* build(first, last, progress) */
static PyObject *build(PyObject *self, PyObject *args)
{
  Py_ssize_t first, last;
  PyObject *object = NULL;
  if (!PyArg_ParseTuple(args, "nn|O:build", &first, &last, &object)) return NULL;
  int ok;
  bent_progress *progress = progress_value(object, &ok);
  if (!ok) return NULL;
  bent_error error;
  bent_status status;
  Py_BEGIN_ALLOW_THREADS
  status = bent_table_build(((table_object *)self)->table, (size_t)first, (size_t)last, progress, &error);
  Py_END_ALLOW_THREADS
  if (status) return raise_error(&error);
  Py_RETURN_NONE;
}

/* measured() -> (total_max, total_rms, sweep_max, sweep_rms) */
static PyObject *measured(PyObject *self, PyObject *unused)
{
  (void)unused;
  bent_table_error measured;
  bent_error error;
  if (bent_table_measured(((table_object *)self)->table, &measured, &error)) return raise_error(&error);
  return Py_BuildValue("(dddd)", measured.total_max, measured.total_rms, measured.sweep_max, measured.sweep_rms);
}

/* The table inside `self` if every row is built, else NULL with a Python error. */
static const bent_table *built(PyObject *self)
{
  const bent_table *table = ((table_object *)self)->table;
  bent_table_error measured;
  bent_error error;
  if (bent_table_measured(table, &measured, &error)) return (const bent_table *)raise_error(&error);
  return table;
}

typedef struct array {
  const char *name;
  char format;
  int dimensions, flags;
} array;

/* Parses `count` array arguments that share their first dimension; the second, if any, is 3. Returns the table or NULL. */
static const bent_table *get_arrays(PyObject *self, PyObject *args, const array *wanted, Py_ssize_t count,
                                    buffer *buffers, size_t *n)
{
  const bent_table *table = built(self);
  if (!table) return NULL;
  if (PyTuple_Size(args) != count) {
    PyErr_Format(PyExc_TypeError, "expected %zd arrays, got %zd", count, PyTuple_Size(args));
    return NULL;
  }
  Py_ssize_t shape[2] = {-1, 3};
  for (Py_ssize_t i = 0; i < count; i++)
    if (buffer_get(&buffers[i], PyTuple_GetItem(args, i), wanted[i].name, wanted[i].format, wanted[i].dimensions, shape,
                   wanted[i].flags) < 0) {
      buffer_release_all(buffers, (size_t)count);
      return NULL;
    }
  *n = (size_t)shape[0];
  return table;
}

static PyObject *total(PyObject *self, PyObject *args)
{
  static const array wanted[] = {{"delta", 'd', 1, BUFFER_READ}, {"angle", 'd', 1, BUFFER_WRITE}};
  buffer b[2] = {0};
  size_t n;
  const bent_table *table = get_arrays(self, args, wanted, 2, b, &n);
  if (!table) return NULL;
  Py_BEGIN_ALLOW_THREADS
  bent_table_total(table, n, buffer_data(&b[0]), buffer_data(&b[1]));
  Py_END_ALLOW_THREADS
  buffer_release_all(b, 2);
  Py_RETURN_NONE;
}

static PyObject *sweep(PyObject *self, PyObject *args)
{
  static const array wanted[] = {{"radius", 'd', 1, BUFFER_READ}, {"cosine", 'd', 1, BUFFER_READ},
                                 {"sine", 'd', 1, BUFFER_READ}, {"fate", 'B', 1, BUFFER_WRITE},
                                 {"swept", 'd', 1, BUFFER_WRITE}};
  buffer b[5] = {0};
  size_t n;
  const bent_table *table = get_arrays(self, args, wanted, 5, b, &n);
  if (!table) return NULL;
  Py_BEGIN_ALLOW_THREADS
  bent_table_sweep(table, n, buffer_data(&b[0]), buffer_data(&b[1]), buffer_data(&b[2]), buffer_data(&b[3]),
                   buffer_data(&b[4]));
  Py_END_ALLOW_THREADS
  buffer_release_all(b, 5);
  Py_RETURN_NONE;
}

static PyObject *trace(PyObject *self, PyObject *args)
{
  static const array wanted[] = {{"origins", 'd', 2, BUFFER_FINITE}, {"directions", 'd', 2, BUFFER_FINITE},
                                 {"fate", 'B', 1, BUFFER_WRITE}, {"direction", 'd', 2, BUFFER_WRITE},
                                 {"error", 'd', 1, BUFFER_WRITE}, {"swept", 'd', 1, BUFFER_WRITE}};
  buffer b[6] = {0};
  size_t n;
  const bent_table *table = get_arrays(self, args, wanted, 6, b, &n);
  if (!table) return NULL;
  const bent_trace_result out = {.fate = buffer_data(&b[2]), .direction = buffer_data(&b[3]),
                                 .error = buffer_data(&b[4]), .swept = buffer_data(&b[5])};
  Py_BEGIN_ALLOW_THREADS
  bent_table_trace(table, n, buffer_data(&b[0]), buffer_data(&b[1]), &out);
  Py_END_ALLOW_THREADS
  buffer_release_all(b, 6);
  Py_RETURN_NONE;
}

static PyGetSetDef getset[] = {{"rows", get_rows, NULL, "Rows to build.", NULL}, {0}};
static PyMethodDef methods[] = {
    {"build", build, METH_VARARGS, "build(first, last, progress=None)\n\nBuild rows first <= row < last."},
    {"measured", measured, METH_NOARGS, "measured() -> (total_max, total_rms, sweep_max, sweep_rms), radians."},
    {"total", total, METH_VARARGS, "total(delta, angle)"},
    {"sweep", sweep, METH_VARARGS, "sweep(radius, cosine, sine, fate, swept)"},
    {"trace", trace, METH_VARARGS, "trace(origins, directions, fate, direction, error, swept)"},
    {0}};
static PyType_Slot slots[] = {{Py_tp_doc, "The core of a bentlight_native.DeflectionTable."}, {Py_tp_dealloc, dealloc},
                              {Py_tp_getset, getset}, {Py_tp_methods, methods}, {0, NULL}};
static PyType_Spec spec = {"bentlight_native._core.Table", sizeof(table_object), 0,
                           Py_TPFLAGS_DEFAULT | Py_TPFLAGS_DISALLOW_INSTANTIATION, slots};

int table_add_type(PyObject *module)
{
  if (!table_type) table_type = (PyTypeObject *)PyType_FromSpec(&spec);
  return table_type ? PyModule_AddObjectRef(module, "Table", (PyObject *)table_type) : -1;
}

/* Functions of table/map.h by name: one variable and up to two parameters. */
static double apply_map(int which, double x, double p, double q)
{
  switch (which) {
    case 0: return map_delta_coordinate(x, p, q);
    case 1: return map_delta_from_coordinate(x, p, q);
    case 2: return map_total_stored(p, x);
    case 3: return map_total_from_stored(p, x);
    case 4: return map_x_schwarzschild(x);
    case 5: return map_ratio_schwarzschild(x);
    case 6: return map_x_ellis(x);
    case 7: return map_ratio_ellis(x);
    case 8: return map_delta_schwarzschild(x, p);
    case 9: return map_delta_ellis(x, p);
    case 10: return map_edge_coordinate(x, p, q);
    default: return map_psi_from_coordinate(x, p, q);
  }
}

/* table_map(name, x, p, q, out): arrays of one length */
static PyObject *table_map(PyObject *module, PyObject *args)
{
  static const char *const names[] = {"delta_coordinate", "delta_from_coordinate", "total_stored", "total_from_stored",
                                      "x_schwarzschild", "ratio_schwarzschild", "x_ellis", "ratio_ellis",
                                      "delta_schwarzschild", "delta_ellis", "edge_coordinate", "psi_from_coordinate"};
  (void)module;
  const char *name;
  PyObject *objects[4];
  if (!PyArg_ParseTuple(args, "sOOOO:table_map", &name, &objects[0], &objects[1], &objects[2], &objects[3])) return NULL;
  int which = 0;
  const int count = (int)(sizeof names / sizeof *names);
  while (which < count && strcmp(name, names[which])) which++;
  if (which == count) return PyErr_Format(PyExc_ValueError, "table_map: no map function '%s'", name);
  static const char *const labels[] = {"x", "p", "q", "out"};
  buffer b[4] = {0};
  Py_ssize_t n = -1;
  for (int i = 0; i < 4; i++)
    if (buffer_get(&b[i], objects[i], labels[i], 'd', 1, &n, i == 3 ? BUFFER_WRITE : BUFFER_READ) < 0) {
      buffer_release_all(b, 4);
      return NULL;
    }
  const double *x = buffer_data(&b[0]), *p = buffer_data(&b[1]), *q = buffer_data(&b[2]);
  double *out = buffer_data(&b[3]);
  Py_BEGIN_ALLOW_THREADS
  for (Py_ssize_t i = 0; i < n; i++) out[i] = apply_map(which, x[i], p[i], q[i]);
  Py_END_ALLOW_THREADS
  buffer_release_all(b, 4);
  Py_RETURN_NONE;
}

static PyObject *table_constants(PyObject *module, PyObject *unused)
{
  (void)module, (void)unused;
  return Py_BuildValue("(idd)", BENT_MAP_VERSION, BENT_TABLE_SCHWARZSCHILD_MAX, BENT_TABLE_ELLIS_MIN);
}

PyMethodDef table_functions[] = {
    {"table_constants", table_constants, METH_NOARGS,
     "table_constants() -> (map version, largest M/r, smallest l/r in tables)"},
    {"table_new", table_new, METH_O, "table_new(spacetime) -> Table, empty."},
    {"table_map", table_map, METH_VARARGS, "table_map(name, x, p, q, out): a function of table/map.h over arrays."},
    {0}};
