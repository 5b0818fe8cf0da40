/* The channels of a render, arrays of them, and the states that they are developed from. */
#include "python.h"

#include "render/channels.h"

static const char *const REDUCTIONS[] = {
    [BENT_MEAN] = "mean", [BENT_MAX] = "max", [BENT_FIRST] = "first", [BENT_COUNT] = "count",
    [BENT_MATTE] = "matte", [BENT_STATE] = "state"};
static const char *const ITEMS[] = {[BENT_SINGLE] = "", [BENT_PER_LIGHT_GROUP] = "light_groups", [BENT_PER_AOV] = "aovs",
                                    [BENT_PER_RANK] = "matte_ranks"};
/* What decides how much a state holds: noise_threshold, light_groups, aovs, matte_ranks. */
#define SIZES "(dIII)"
#define SIZES_OF(settings) \
  &(settings).noise_threshold, &(settings).light_groups, &(settings).aovs, &(settings).matte_ranks


int channels_get(PyObject *dict, Py_ssize_t height, Py_ssize_t width, const bent_render_settings *settings,
                 buffer buffers[BENT_CHANNELS_MAX], float *arrays[BENT_CHANNELS_MAX])
{
  size_t count;
  const bent_channel *table = bent_render_channels(&count);
  const char *names[BENT_CHANNELS_MAX];
  for (size_t i = 0; i < count; i++) names[i] = table[i].name;
  PyObject *key, *value;
  for (Py_ssize_t position = 0; PyDict_Next(dict, &position, &key, &value);) {
    const char *name = PyUnicode_Check(key) ? PyUnicode_AsUTF8AndSize(key, NULL) : NULL;
    if (!name) {
      if (!PyErr_Occurred()) PyErr_SetString(PyExc_TypeError, "channels: expected names as keys");
      return -1;
    }
    const int i = choose(name, "channels", names, (int)count);
    if (i < 0) return -1;
    Py_ssize_t shape[] = {height, width, (Py_ssize_t)channel_width((channel)i, settings)};
    if (buffer_get(&buffers[i], value, name, 'f', 3, shape, BUFFER_WRITE)) return -1;
    arrays[i] = buffer_data(&buffers[i]);
  }
  return 0;
}

int state_get(buffer *out, PyObject *object, const bent_render_settings *settings, Py_ssize_t height, Py_ssize_t width,
              float *const channels[BENT_CHANNELS_MAX])
{
  uint8_t wanted[BENT_CHANNELS_MAX];
  for (int i = 0; i < BENT_CHANNELS_MAX; i++) wanted[i] = channels[i] != NULL;
  Py_ssize_t shape[] = {height, width, (Py_ssize_t)bent_render_state_width(settings, wanted)};
  return buffer_get(out, object, "state", 'd', 3, shape, BUFFER_WRITE | BUFFER_OPTIONAL);
}

/* Takes a sequence of names. Returns 0, or -1 with an error. */
static int wanted_get(PyObject *names, uint8_t wanted[BENT_CHANNELS_MAX])
{
  size_t count;
  const bent_channel *table = bent_render_channels(&count);
  const char *known[BENT_CHANNELS_MAX];
  for (size_t i = 0; i < count; i++) known[i] = table[i].name;
  const Py_ssize_t n = PySequence_Size(names);
  for (Py_ssize_t k = 0; k < n; k++) {
    PyObject *item = PySequence_GetItem(names, k);
    const char *name = item ? PyUnicode_AsUTF8AndSize(item, NULL) : NULL;
    const int i = name ? choose(name, "channels", known, (int)count) : -1;
    Py_XDECREF(item);
    if (i < 0) return -1;
    wanted[i] = 1;
  }
  return n < 0 ? -1 : 0;
}

static PyObject *state_width(PyObject *module, PyObject *args)
{
  (void)module;
  PyObject *names;
  bent_render_settings s = {0};
  uint8_t wanted[BENT_CHANNELS_MAX] = {0};
  if (!PyArg_ParseTuple(args, "O" SIZES ":state_width", &names, SIZES_OF(s)) || wanted_get(names, wanted)) return NULL;
  return PyLong_FromSize_t(bent_render_state_width(&s, wanted));
}

static PyObject *state_merge(PyObject *module, PyObject *args)
{
  (void)module;
  PyObject *names, *state, *other;
  bent_render_settings s = {0};
  uint8_t wanted[BENT_CHANNELS_MAX] = {0};
  if (!PyArg_ParseTuple(args, "O" SIZES "OO:state_merge", &names, SIZES_OF(s), &state, &other) || wanted_get(names, wanted))
    return NULL;
  buffer b[2] = {0};
  Py_ssize_t shape[] = {-1, -1, (Py_ssize_t)bent_render_state_width(&s, wanted)};
  const int bad = buffer_get(&b[0], state, "state", 'd', 3, shape, BUFFER_WRITE) ||
                  buffer_get(&b[1], other, "other", 'd', 3, shape, BUFFER_READ);
  if (!bad) {
    Py_BEGIN_ALLOW_THREADS
    bent_render_state_merge(&s, wanted, (size_t)(shape[0] * shape[1]), buffer_data(&b[0]), buffer_data(&b[1]));
    Py_END_ALLOW_THREADS
  }
  buffer_release_all(b, 2);
  return bad ? NULL : Py_NewRef(Py_None);
}

static PyObject *state_develop(PyObject *module, PyObject *args)
{
  (void)module;
  PyObject *dict, *object;
  bent_render_settings s = {0};
  Py_ssize_t height, width;
  buffer buffers[BENT_CHANNELS_MAX] = {0}, state = {0};
  float *arrays[BENT_CHANNELS_MAX] = {0};
  if (!PyArg_ParseTuple(args, SIZES "nnOO!:state_develop", SIZES_OF(s), &height, &width, &object, &PyDict_Type, &dict))
    return NULL;
  const int bad = channels_get(dict, height, width, &s, buffers, arrays) || state_get(&state, object, &s, height, width, arrays);
  if (!bad && buffer_data(&state)) {
    Py_BEGIN_ALLOW_THREADS
    bent_render_state_develop(&s, (size_t)(height * width), buffer_data(&state), arrays);
    Py_END_ALLOW_THREADS
  }
  buffer_release_all(buffers, BENT_CHANNELS_MAX);
  buffer_release(&state);
  return bad ? NULL : Py_NewRef(Py_None);
}

static PyObject *render_channels(PyObject *module, PyObject *unused)
{
  (void)module, (void)unused;
  size_t count;
  const bent_channel *table = bent_render_channels(&count);
  PyObject *list = PyList_New(0);
  for (size_t i = 0; list && i < count; i++) {
    PyObject *row = Py_BuildValue("(sisss)", table[i].name, table[i].components, REDUCTIONS[table[i].reduction],
                                  table[i].description, ITEMS[table[i].items]);
    if (!row || PyList_Append(list, row) < 0) Py_CLEAR(list);
    Py_XDECREF(row);
  }
  return list;
}

/* The numpy-facing signatures and docstrings are in state.py. */
PyMethodDef channel_functions[] = {
    {"render_channels", render_channels, METH_NOARGS,
     "render_channels() -> list[tuple[str, int, str, str, str]]\n\n"
     "The channels of a render: name, number of components, reduction, description, setting that says how many items."},
    {"state_width", state_width, METH_VARARGS,
     "state_width(names, sizes)\n\nNumbers in the state of a pixel."},
    {"state_merge", state_merge, METH_VARARGS,
     "state_merge(names, sizes, state, other)\n\nAdds the state of other samples to a state."},
    {"state_develop", state_develop, METH_VARARGS,
     "state_develop(sizes, height, width, state, channels)\n\nFills the arrays of channels from a state."},
    {0}};
