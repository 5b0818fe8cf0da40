/* Scene methods for images, materials and the world, and for looking at a material outside a render. */
#include "python.h"

#include <stdlib.h>

#include "render/direct.h"
#include "scene/scene.h"
#include "scene/shading.h"

/* The order of the numbers of a shade_point row; python/bentlight_native/shading.py writes them by the same names. */
enum { POINT_NUMBERS = 37 };
static const char *const point_fields[] = {"position", "generated", "wo", "geometric_normal", "normal", "tangent",
                                           "tangent_sign", "uv", "object_index", "backfacing", "barycentric",
                                           "object_color", "object_random", "ray_length", "ray_kinds", "ray_depths", NULL};

static shade_point point_from(const double *n)
{
  return (shade_point){.position = v3_from(n), .generated = v3_from(n + 3), .wo = v3_from(n + 6),
                       .geometric_normal = v3_from(n + 9), .normal = v3_from(n + 12), .tangent = v3_from(n + 15),
                       .tangent_sign = n[18], .uv = {n[19], n[20]}, .object_index = (float)n[21],
                       .backfacing = n[22] != 0, .barycentric = {n[23], n[24]},
                       .object_color = {(float)n[25], (float)n[26], (float)n[27], (float)n[28]},
                       .object_random = (float)n[29], .ray_length = n[30],
                       .ray = {(uint32_t)n[31], (uint32_t)n[32], (uint32_t)n[33], (uint32_t)n[34], (uint32_t)n[35],
                               (uint32_t)n[36]}};
}

/* Float or byte pixels of shape (height, width, 4). */
static int image_get(PyObject *object, int is_bytes, int srgb, buffer *held, bent_image *out)
{
  Py_ssize_t shape[3] = {-1, -1, 4};
  if (buffer_get(held, object, "pixels", is_bytes ? 'B' : 'f', 3, shape, BUFFER_FINITE) < 0) return -1;
  *out = (bent_image){.width = (size_t)shape[1], .height = (size_t)shape[0], .srgb = srgb};
  if (is_bytes) out->bytes = buffer_data(held);
  else out->pixels = buffer_data(held);
  return 0;
}

static PyObject *add_image(PyObject *self, PyObject *args)
{
  PyObject *pixels;
  int is_bytes, srgb, index;
  buffer held = {0};
  bent_image image;
  bent_error error;
  if (!PyArg_ParseTuple(args, "Opp", &pixels, &is_bytes, &srgb) || image_get(pixels, is_bytes, srgb, &held, &image) < 0)
    return NULL;
  const bent_status status = bent_scene_add_image(scene_value(self), &image, &index, &error);
  buffer_release(&held);
  return status ? raise_error(&error) : PyLong_FromLong(index);
}

static PyObject *update_image(PyObject *self, PyObject *args)
{
  PyObject *pixels;
  int is_bytes, srgb, index;
  buffer held = {0};
  bent_image image;
  bent_error error;
  if (!PyArg_ParseTuple(args, "iOpp", &index, &pixels, &is_bytes, &srgb) ||
      image_get(pixels, is_bytes, srgb, &held, &image) < 0)
    return NULL;
  const bent_status status = bent_scene_update_image(scene_value(self), index, &image, &error);
  buffer_release(&held);
  if (status) return raise_error(&error);
  Py_RETURN_NONE;
}

/* Code, constants and table of a program. `held` has three places. */
static int program_get(PyObject *const objects[3], buffer *held, bent_program *out)
{
  Py_ssize_t length[1] = {-1}, constants[2] = {-1, 3}, table[2] = {-1, 4};
  if (buffer_get(&held[0], objects[0], "code", 'i', 1, length, BUFFER_READ) < 0 ||
      buffer_get(&held[1], objects[1], "constants", 'd', 2, constants, BUFFER_FINITE) < 0 ||
      buffer_get(&held[2], objects[2], "table", 'f', 2, table, BUFFER_FINITE) < 0) {
    buffer_release_all(held, 3);
    return -1;
  }
  *out = (bent_program){.code = buffer_data(&held[0]), .code_length = (size_t)length[0],
                        .constants = buffer_data(&held[1]), .constant_count = (size_t)constants[0],
                        .table = buffer_data(&held[2]), .table_length = (size_t)table[0]};
  return 0;
}

static PyObject *add_material(PyObject *self, PyObject *args)
{
  PyObject *parts[3];
  buffer held[3] = {0};
  bent_program program;
  bent_error error;
  int index;
  if (!PyArg_ParseTuple(args, "OOO", &parts[0], &parts[1], &parts[2]) || program_get(parts, held, &program) < 0)
    return NULL;
  const bent_status status = bent_scene_add_material(scene_value(self), &program, &index, &error);
  buffer_release_all(held, 3);
  return status ? raise_error(&error) : PyLong_FromLong(index);
}

static PyObject *update_material(PyObject *self, PyObject *args)
{
  PyObject *parts[3];
  buffer held[3] = {0};
  bent_program program;
  bent_error error;
  int index;
  if (!PyArg_ParseTuple(args, "iOOO", &index, &parts[0], &parts[1], &parts[2]) || program_get(parts, held, &program) < 0)
    return NULL;
  const bent_status status = bent_scene_update_material(scene_value(self), index, &program, &error);
  buffer_release_all(held, 3);
  if (status) return raise_error(&error);
  Py_RETURN_NONE;
}

static PyObject *set_world(PyObject *self, PyObject *args)
{
  PyObject *parts[3] = {Py_None, Py_None, Py_None};
  buffer held[3] = {0};
  bent_program program;
  bent_error error;
  if (!PyArg_ParseTuple(args, "|OOO", &parts[0], &parts[1], &parts[2])) return NULL;
  const int empty = parts[0] == Py_None;
  if (!empty && program_get(parts, held, &program) < 0) return NULL;
  const bent_status status = bent_scene_set_world(scene_value(self), empty ? NULL : &program, &error);
  buffer_release_all(held, 3);
  if (status) return raise_error(&error);
  Py_RETURN_NONE;
}

static PyObject *set_gravitational(PyObject *self, PyObject *value)
{
  const double amount = PyFloat_AsDouble(value);
  bent_error error;
  if (PyErr_Occurred()) return NULL;
  if (bent_scene_set_gravitational(scene_value(self), amount, &error)) return raise_error(&error);
  Py_RETURN_NONE;
}

/* (from, launch, to, arrival, sky, brightness) */
static PyObject *shift_light(PyObject *self, PyObject *args)
{
  enum { FROM, LAUNCH, TO, ARRIVAL, SKY, BRIGHTNESS, COUNT };
  static const char *const NAMES[COUNT] = {"origins", "directions", "ends", "arrivals", "sky", "brightness"};
  PyObject *in[COUNT];
  buffer b[COUNT] = {{.held = 0}};
  Py_ssize_t n = -1;
  int bad = !PyArg_ParseTuple(args, "OOOOOO", &in[FROM], &in[LAUNCH], &in[TO], &in[ARRIVAL], &in[SKY], &in[BRIGHTNESS]);
  for (int i = 0; i < COUNT && !bad; i++) {
    Py_ssize_t shape[2] = {n, 3};
    bad = buffer_get(&b[i], in[i], NAMES[i], i == SKY ? 'B' : 'd', i < SKY ? 2 : 1, shape,
                     i == BRIGHTNESS ? BUFFER_WRITE : 0) < 0;
    if (i == FROM) n = shape[0];
  }
  if (!bad) {
    Py_BEGIN_ALLOW_THREADS
    bent_scene_shift_light(scene_value(self), (size_t)n, buffer_data(&b[FROM]), buffer_data(&b[LAUNCH]),
                           buffer_data(&b[TO]), buffer_data(&b[ARRIVAL]), buffer_data(&b[SKY]),
                           buffer_data(&b[BRIGHTNESS]));
    Py_END_ALLOW_THREADS
  }
  buffer_release_all(b, COUNT);
  if (bad) return NULL;
  Py_RETURN_NONE;
}

/* Room for the lobes of any material; freed by the caller. */
static closure *closures_new(const shading *shading)
{
  return malloc((size_t)shading_lobe_max(shading) * sizeof(closure));
}

static PyObject *shade(PyObject *self, PyObject *args)
{
  int material;
  PyObject *points, *matrices, *results;
  Py_ssize_t in[2] = {-1, POINT_NUMBERS}, pair[3] = {2, 4, 4}, out[2] = {-1, 6};
  buffer held[3] = {0};
  if (!PyArg_ParseTuple(args, "iOOO", &material, &points, &matrices, &results) ||
      buffer_get(&held[0], points, "points", 'd', 2, in, BUFFER_FINITE) < 0 || (out[0] = in[0], 0) ||
      buffer_get(&held[1], results, "results", 'd', 2, out, BUFFER_WRITE) < 0 ||
      buffer_get(&held[2], matrices, "matrices", 'd', 3, pair, BUFFER_FINITE) < 0) {
    buffer_release_all(held, 3);
    return NULL;
  }
  const mat4 *matrix = buffer_data(&held[2]);
  const shading *shading = scene_value(self)->shading;
  const double *point = buffer_data(&held[0]);
  double *result = buffer_data(&held[1]);
  closure_set set = {.closures = closures_new(shading)};
  Py_BEGIN_ALLOW_THREADS
  for (Py_ssize_t i = 0; set.closures && i < in[0]; i++) {
    shade_point p = point_from(point + i * POINT_NUMBERS);
    p.world_from_object = &matrix[0];
    p.object_from_world = &matrix[1];
    shading_evaluate(shading, material, &p, &set);
    v3_to(result + 6 * i, set.emission);
    v3_to(result + 6 * i + 3, bsdf_albedo(&set));
  }
  Py_END_ALLOW_THREADS
  buffer_release_all(held, 3);
  if (!set.closures) return PyErr_NoMemory();
  free(set.closures);
  Py_RETURN_NONE;
}

static PyObject *sky(PyObject *self, PyObject *args)
{
  PyObject *directions, *spreads, *radiance;
  unsigned kinds;
  Py_ssize_t shape[2] = {-1, 3}, spread_shape[3] = {-1, 2, 3};
  buffer held[3] = {0};
  if (!PyArg_ParseTuple(args, "OOIO", &directions, &spreads, &kinds, &radiance) ||
      buffer_get(&held[0], directions, "directions", 'd', 2, shape, BUFFER_FINITE) < 0 ||
      (spread_shape[0] = shape[0], buffer_get(&held[1], spreads, "across", 'd', 3, spread_shape, BUFFER_FINITE)) < 0 ||
      buffer_get(&held[2], radiance, "radiance", 'd', 2, shape, BUFFER_WRITE) < 0) {
    buffer_release_all(held, 3);
    return NULL;
  }
  const shading *shading = scene_value(self)->shading;
  const double *direction = buffer_data(&held[0]), *spread = buffer_data(&held[1]);
  double *out = buffer_data(&held[2]);
  Py_BEGIN_ALLOW_THREADS
  for (Py_ssize_t i = 0; i < shape[0]; i++) {
    const ray_history ray = {.kinds = kinds};
    const vec3 across[2] = {v3_from(spread + 6 * i), v3_from(spread + 6 * i + 3)};
    v3_to(out + 3 * i, shading_sky(shading, v3_from(direction + 3 * i), across, &ray));
  }
  Py_END_ALLOW_THREADS
  buffer_release_all(held, 3);
  Py_RETURN_NONE;
}

/* A call that asks the lobes of a material at one point for many directions or draws. */
typedef struct bsdf_call {
  shade_point point;
  closure_set set;
  portal_mix mix; /* empty unless portals are asked for */
  buffer held[3]; /* the point, what goes in, (count, 3), and what comes out, (count, width) */
  Py_ssize_t count;
} bsdf_call;

static void bsdf_end(bsdf_call *call)
{
  free(call->set.closures);
  buffer_release_all(call->held, 3);
}

static int bsdf_begin(PyObject *self, PyObject *args, const char *in_name, const char *out_name, Py_ssize_t width,
                      bsdf_call *call)
{
  const bent_scene *scene = scene_value(self);
  int material, portals;
  PyObject *row, *in, *out;
  Py_ssize_t numbers[1] = {POINT_NUMBERS}, in_shape[2] = {-1, 3}, out_shape[2] = {-1, width};
  *call = (bsdf_call){.count = 0};
  if (!PyArg_ParseTuple(args, "iOOOp", &material, &row, &in, &out, &portals) ||
      buffer_get(&call->held[0], row, "point", 'd', 1, numbers, BUFFER_FINITE) < 0 ||
      buffer_get(&call->held[1], in, in_name, 'd', 2, in_shape, BUFFER_FINITE) < 0 || (out_shape[0] = in_shape[0], 0) ||
      buffer_get(&call->held[2], out, out_name, 'd', 2, out_shape, BUFFER_WRITE) < 0) {
    bsdf_end(call);
    return -1;
  }
  call->count = in_shape[0];
  call->point = point_from(buffer_data(&call->held[0]));
  call->set.closures = closures_new(scene->shading);
  if (!call->set.closures || (portals && !scene->committed)) {
    if (!call->set.closures) PyErr_NoMemory();
    else PyErr_SetString(PyExc_RuntimeError, "scene: has edits without a commit");
    bsdf_end(call);
    return -1;
  }
  shading_evaluate(scene->shading, material, &call->point, &call->set);
  const vec3 normal = direct_normal(&call->point, &call->set);
  if (portals) call->mix = portal_mix_at(scene, call->point.position, normal, &call->set);
  return 0;
}

static PyObject *draw_bsdf(PyObject *self, PyObject *args)
{
  bsdf_call call;
  if (bsdf_begin(self, args, "u", "samples", 8, &call) < 0) return NULL;
  const double *u = buffer_data(&call.held[1]);
  double *result = buffer_data(&call.held[2]);
  Py_BEGIN_ALLOW_THREADS
  for (Py_ssize_t i = 0; i < call.count; i++) {
    bsdf_sample sample = {0};
    if (!portal_draw(&call.mix, &call.set, &call.point, u + 3 * i, &sample)) sample = (bsdf_sample){0};
    v3_to(result + 8 * i, sample.wi);
    v3_to(result + 8 * i + 3, sample.weight);
    result[8 * i + 6] = sample.pdf;
    result[8 * i + 7] = sample.lobe;
  }
  Py_END_ALLOW_THREADS
  bsdf_end(&call);
  Py_RETURN_NONE;
}

static PyObject *evaluate_bsdf(PyObject *self, PyObject *args)
{
  bsdf_call call;
  if (bsdf_begin(self, args, "wi", "values", 4, &call) < 0) return NULL;
  const double *wi = buffer_data(&call.held[1]);
  double *result = buffer_data(&call.held[2]);
  Py_BEGIN_ALLOW_THREADS
  for (Py_ssize_t i = 0; i < call.count; i++) {
    const vec3 direction = v3_from(wi + 3 * i);
    double pdf;
    v3_to(result + 4 * i, bsdf_evaluate(&call.set, &call.point, direction, UINT32_MAX, &pdf));
    result[4 * i + 3] = portal_pdf(&call.mix, direction, pdf);
  }
  Py_END_ALLOW_THREADS
  bsdf_end(&call);
  Py_RETURN_NONE;
}

static PyObject *strings(const char *const *names)
{
  PyObject *list = PyList_New(0);
  for (; list && *names; names++) {
    PyObject *name = PyUnicode_FromString(*names);
    if (!name || PyList_Append(list, name) < 0) Py_CLEAR(list);
    Py_XDECREF(name);
  }
  return list;
}

static PyObject *opcode_tuple(const bent_opcode *opcode)
{
  PyObject *choices = PyList_New(0);
  for (int i = 0; choices && opcode->choices[i]; i++) {
    PyObject *names = strings(opcode->choices[i]);
    if (!names || PyList_Append(choices, names) < 0) Py_CLEAR(choices);
    Py_XDECREF(names);
  }
  return choices ? Py_BuildValue("(siiN)", opcode->name, opcode->outputs, opcode->operands, choices) : NULL;
}

static PyObject *opcodes(PyObject *unused, PyObject *none)
{
  (void)unused, (void)none;
  PyObject *list = PyList_New(0);
  for (int i = 0; list && bent_opcode_info(i); i++) {
    PyObject *entry = opcode_tuple(bent_opcode_info(i));
    if (!entry || PyList_Append(list, entry) < 0) Py_CLEAR(list);
    Py_XDECREF(entry);
  }
  return list;
}

static PyObject *fields(PyObject *unused, PyObject *none)
{
  (void)unused, (void)none;
  return strings(point_fields);
}

PyMethodDef scene_shading_methods[] = {
    {"_opcodes", opcodes, METH_NOARGS | METH_STATIC, "List of (name, outputs, operands, choices of each immediate)."},
    {"_point_fields", fields, METH_NOARGS | METH_STATIC, "Names of the parts of a row of points, in order."},
    {"_add_image", add_image, METH_VARARGS, "(pixels, is_bytes, srgb) -> int"},
    {"_update_image", update_image, METH_VARARGS, "(index, pixels, is_bytes, srgb)"},
    {"_add_material", add_material, METH_VARARGS, "(code, constants, table) -> int"},
    {"_update_material", update_material, METH_VARARGS, "(index, code, constants, table)"},
    {"_set_world", set_world, METH_VARARGS, "(code=None, constants=None, table=None)"},
    {"_set_gravitational", set_gravitational, METH_O, "(amount)"},
    {"_shift_light", shift_light, METH_VARARGS, "(origins, directions, ends, arrivals, sky, brightness)"},
    {"_shade", shade, METH_VARARGS,
     "(material, points (n, 37), world_from_object and its inverse (2, 4, 4), results (n, 6): emission, albedo)"},
    {"_sky", sky, METH_VARARGS, "(directions (n, 3), ray_kinds, radiance (n, 3))"},
    {"_draw_bsdf", draw_bsdf, METH_VARARGS, "(material, point (37,), u (n, 3), samples (n, 8): wi, weight, pdf, lobe)"},
    {"_evaluate_bsdf", evaluate_bsdf, METH_VARARGS, "(material, point (37,), wi (n, 3), values (n, 4): value, pdf)"},
    {0}};
