/* Module functions that trace rays to infinity or the horizon. Arrays are allocated by the numpy-facing wrapper. */
#include "python.h"

/* trace_rays(spacetime, origins, directions, tolerance, route, fate, direction, error, steps, swept, progress) */
static PyObject *trace_rays(PyObject *module, PyObject *args)
{
  (void)module;
  PyObject *object, *arrays[7], *watcher;
  double tolerance;
  int route;
  if (!PyArg_ParseTuple(args, "OOOdiOOOOOO:trace_rays", &object, &arrays[0], &arrays[1], &tolerance, &route, &arrays[2],
                        &arrays[3], &arrays[4], &arrays[5], &arrays[6], &watcher))
    return NULL;
  const bent_spacetime *spacetime = spacetime_value(object);
  int watched;
  bent_progress *progress = progress_value(watcher, &watched);
  if (!spacetime || !watched) return NULL;
  static const struct {
    const char *name;
    char format;
    int dimensions, flags;
  } wanted[] = {{"origins", 'd', 2, BUFFER_READ}, {"directions", 'd', 2, BUFFER_READ}, {"fate", 'B', 1, BUFFER_WRITE},
                {"direction", 'd', 2, BUFFER_WRITE}, {"error", 'd', 1, BUFFER_WRITE}, {"steps", 'I', 1, BUFFER_WRITE},
                {"swept", 'd', 1, BUFFER_WRITE}};
  buffer buffers[7] = {0};
  Py_ssize_t shape[2] = {-1, 3};
  for (int i = 0; i < 7; i++)
    if (buffer_get(&buffers[i], arrays[i], wanted[i].name, wanted[i].format, wanted[i].dimensions, shape,
                   wanted[i].flags) < 0) {
      buffer_release_all(buffers, 7);
      return NULL;
    }
  const bent_trace_result out = {.fate = buffer_data(&buffers[2]), .direction = buffer_data(&buffers[3]),
                                 .error = buffer_data(&buffers[4]), .steps = buffer_data(&buffers[5]),
                                 .swept = buffer_data(&buffers[6])};
  const bent_spacetime value = *spacetime;
  bent_error error;
  bent_status status;
  Py_BEGIN_ALLOW_THREADS
  status = bent_trace_rays(&value, (size_t)shape[0], buffer_data(&buffers[0]), buffer_data(&buffers[1]), tolerance,
                           (bent_route)route, &out, progress, &error);
  Py_END_ALLOW_THREADS
  buffer_release_all(buffers, 7);
  if (status) return raise_error(&error);
  Py_RETURN_NONE;
}

/* ray_path(spacetime, origin, direction, tolerance, mino_times, positions, directions, sides) */
static PyObject *ray_path(PyObject *module, PyObject *args)
{
  (void)module;
  PyObject *object, *arrays[6];
  double tolerance;
  if (!PyArg_ParseTuple(args, "OOOdOOOO:ray_path", &object, &arrays[0], &arrays[1], &tolerance, &arrays[2], &arrays[3],
                        &arrays[4], &arrays[5]))
    return NULL;
  const bent_spacetime *spacetime = spacetime_value(object);
  if (!spacetime) return NULL;
  buffer b[6] = {0};
  Py_ssize_t three[1] = {3}, rows[2] = {-1, 3};
  if (buffer_get(&b[0], arrays[0], "origin", 'd', 1, three, BUFFER_READ) < 0 ||
      buffer_get(&b[1], arrays[1], "direction", 'd', 1, three, BUFFER_READ) < 0 ||
      buffer_get(&b[2], arrays[2], "mino_times", 'd', 1, rows, BUFFER_READ | BUFFER_FINITE) < 0 ||
      buffer_get(&b[3], arrays[3], "positions", 'd', 2, rows, BUFFER_WRITE) < 0 ||
      buffer_get(&b[4], arrays[4], "directions", 'd', 2, rows, BUFFER_WRITE) < 0 ||
      buffer_get(&b[5], arrays[5], "sides", 'B', 1, rows, BUFFER_WRITE) < 0) {
    buffer_release_all(b, 6);
    return NULL;
  }
  bent_error error;
  const bent_status status =
      bent_ray_path(spacetime, buffer_data(&b[0]), buffer_data(&b[1]), tolerance, (size_t)rows[0], buffer_data(&b[2]),
                    buffer_data(&b[3]), buffer_data(&b[4]), buffer_data(&b[5]), &error);
  buffer_release_all(b, 6);
  if (status) return raise_error(&error);
  Py_RETURN_NONE;
}

/* lapse(spacetime, position) and local_from_covector(spacetime, position, matrix) serve tests and drivers. */
static int parse_position(PyObject *args, const char *format, const bent_spacetime **spacetime, double position[3])
{
  PyObject *object;
  if (!PyArg_ParseTuple(args, format, &object, &position[0], &position[1], &position[2])) return -1;
  *spacetime = spacetime_value(object);
  return *spacetime ? 0 : -1;
}

static PyObject *contains(PyObject *module, PyObject *args)
{
  (void)module;
  const bent_spacetime *spacetime;
  double position[3];
  if (parse_position(args, "O(ddd):contains", &spacetime, position) < 0) return NULL;
  return PyBool_FromLong(bent_spacetime_contains(spacetime, position));
}

static PyObject *lapse(PyObject *module, PyObject *args)
{
  (void)module;
  const bent_spacetime *spacetime;
  double position[3];
  if (parse_position(args, "O(ddd):lapse", &spacetime, position) < 0) return NULL;
  return PyFloat_FromDouble(bent_lapse(spacetime, position));
}

static PyObject *local_from_covector(PyObject *module, PyObject *args)
{
  (void)module;
  const bent_spacetime *spacetime;
  double position[3], m[3][3];
  if (parse_position(args, "O(ddd):local_from_covector", &spacetime, position) < 0) return NULL;
  bent_local_from_covector(spacetime, position, m);
  return Py_BuildValue("((ddd)(ddd)(ddd))", m[0][0], m[0][1], m[0][2], m[1][0], m[1][1], m[1][2], m[2][0], m[2][1],
                       m[2][2]);
}

PyMethodDef trace_functions[] = {
    {"trace_rays", trace_rays, METH_VARARGS, "See bentlight_native.trace_rays."},
    {"ray_path", ray_path, METH_VARARGS, "See bentlight_native.ray_path."},
    {"contains", contains, METH_VARARGS,
     "contains(spacetime, (x, y, z)) -> bool\n\nWhether a ray may start there: outside every horizon, and finite."},
    {"lapse", lapse, METH_VARARGS,
     "lapse(spacetime, (x, y, z)) -> float\n\nClock rate of the ZAMO there against infinity; 0 inside a horizon."},
    {"local_from_covector", local_from_covector, METH_VARARGS,
     "local_from_covector(spacetime, (x, y, z)) -> 3 x 3\n\nMatrix from flat covectors to ZAMO components."},
    {0}};
