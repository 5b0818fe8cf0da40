/* Module functions that join points by light rays. Arrays are allocated by the numpy-facing wrapper. */
#include "python.h"

enum { ARRAYS = 9 };

static int get_arrays(PyObject *const *arrays, Py_ssize_t max_images, buffer *buffers, Py_ssize_t *pairs)
{
  static const char *const names[ARRAYS] = {"points", "ends", "status", "launch", "arrival",
                                            "spread", "frequency_ratio", "swept", "error"};
  Py_ssize_t rows[3] = {-1, 3, 0};
  for (int i = 0; i < 2; i++)
    if (buffer_get(&buffers[i], arrays[i], names[i], 'd', 2, rows, BUFFER_READ) < 0) return -1;
  Py_ssize_t images[3] = {rows[0], max_images, 3};
  for (int i = 2; i < ARRAYS; i++) {
    const int is_vector = i == 3 || i == 4;
    if (buffer_get(&buffers[i], arrays[i], names[i], i == 2 ? 'B' : 'd', is_vector ? 3 : 2, images, BUFFER_WRITE) < 0)
      return -1;
  }
  *pairs = rows[0];
  return 0;
}

/* connect(spacetime, points, ends, sky, far_side, max_images, min_share, tolerance, status, launch, arrival, spread,
 * frequency_ratio, swept, error, progress) -> (none, met, ring, coarse, failed); sky: the ends are directions */
static PyObject *connect_pairs(PyObject *module, PyObject *args)
{
  (void)module;
  PyObject *object, *arrays[ARRAYS], *watcher;
  int sky, far_side;
  Py_ssize_t max_images, pairs;
  double min_share, tolerance;
  if (!PyArg_ParseTuple(args, "OOOppnddOOOOOOOO:connect", &object, &arrays[0], &arrays[1], &sky, &far_side, &max_images,
                        &min_share, &tolerance, &arrays[2], &arrays[3], &arrays[4], &arrays[5], &arrays[6], &arrays[7],
                        &arrays[8], &watcher))
    return NULL;
  const bent_spacetime *spacetime = spacetime_value(object);
  int watched;
  bent_progress *progress = progress_value(watcher, &watched);
  if (!spacetime || !watched) return NULL;
  buffer b[ARRAYS] = {0};
  if (get_arrays(arrays, max_images, b, &pairs) < 0) {
    buffer_release_all(b, ARRAYS);
    return NULL;
  }
  const bent_connections out = {.status = buffer_data(&b[2]), .launch = buffer_data(&b[3]),
                                .arrival = buffer_data(&b[4]), .spread = buffer_data(&b[5]),
                                .frequency_ratio = buffer_data(&b[6]), .swept = buffer_data(&b[7]),
                                .error = buffer_data(&b[8])};
  const bent_spacetime value = *spacetime;
  bent_connection_count count;
  bent_error error;
  bent_status status;
  Py_BEGIN_ALLOW_THREADS
  if (sky)
    status = bent_connect_sky(&value, (size_t)pairs, buffer_data(&b[0]), buffer_data(&b[1]), far_side,
                              (size_t)max_images, min_share, tolerance, &out, &count, progress, &error);
  else
    status = bent_connect(&value, (size_t)pairs, buffer_data(&b[0]), buffer_data(&b[1]), (size_t)max_images, min_share,
                          tolerance, &out, &count, progress, &error);
  Py_END_ALLOW_THREADS
  buffer_release_all(b, ARRAYS);
  if (status) return raise_error(&error);
  return Py_BuildValue("(nnnnn)", (Py_ssize_t)count.none, (Py_ssize_t)count.met, (Py_ssize_t)count.ring,
                       (Py_ssize_t)count.coarse, (Py_ssize_t)count.failed);
}

PyMethodDef connect_functions[] = {
    {"connect", connect_pairs, METH_VARARGS, "See bentlight_native.connect and connect_sky."}, {0}};
