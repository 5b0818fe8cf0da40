/* Scene methods for meshes, instances, spacetime objects, commit and intersect. */
#include "python.h"

#include <stdlib.h>
#include <string.h>

#include "geometry/geometry.h"
#include "scene/scene.h"

#define MANY(array) (sizeof(array) / sizeof *(array))

/* Everything that works on whole arrays lets other Python threads run. */
#define WITHOUT_GIL(call) Py_BEGIN_ALLOW_THREADS call; Py_END_ALLOW_THREADS

static PyObject *none_or_error(bent_status status, const bent_error *error)
{
  if (status) return raise_error(error);
  Py_RETURN_NONE;
}

/* A (4, 4) float64 matrix. */
static int get_matrix(PyObject *object, const char *name, double out[4][4])
{
  buffer b;
  Py_ssize_t shape[2] = {4, 4};
  if (buffer_get(&b, object, name, 'd', 2, shape, BUFFER_FINITE) < 0) return -1;
  memcpy(out, buffer_data(&b), 16 * sizeof(double));
  buffer_release(&b);
  return 0;
}

static PyObject *add_mesh(PyObject *self, PyObject *args)
{
  PyObject *in[6];
  if (!PyArg_ParseTuple(args, "OOOOOO:add_mesh", &in[0], &in[1], &in[2], &in[3], &in[4], &in[5])) return NULL;
  buffer b[6] = {{.held = 0}};
  Py_ssize_t v[2] = {-1, 3}, t[2] = {-1, 3};
  const int optional = BUFFER_OPTIONAL | BUFFER_FINITE;
  int bad = buffer_get(&b[0], in[0], "vertices", 'f', 2, v, BUFFER_FINITE) < 0 ||
            buffer_get(&b[1], in[1], "triangles", 'I', 2, t, 0) < 0;
  Py_ssize_t normals[3] = {t[0], 3, 3}, uvs[3] = {t[0], 3, 2}, slots[1] = {t[0]}, generated[2] = {v[0], 3};
  bad = bad || buffer_get(&b[2], in[2], "corner_normals", 'f', 3, normals, optional) < 0 ||
        buffer_get(&b[3], in[3], "corner_uvs", 'f', 3, uvs, optional) < 0 ||
        buffer_get(&b[4], in[4], "material_slots", 'I', 1, slots, optional) < 0 ||
        buffer_get(&b[5], in[5], "generated", 'f', 2, generated, optional) < 0;
  PyObject *result = NULL;
  bent_scene *scene = scene_value(self);
  if (!bad && scene) {
    const bent_mesh mesh = {(size_t)v[0], (size_t)t[0], buffer_data(&b[0]), buffer_data(&b[1]), buffer_data(&b[2]),
                            buffer_data(&b[3]), buffer_data(&b[4]), buffer_data(&b[5])};
    bent_error error;
    bent_status status;
    int index;
    WITHOUT_GIL(status = bent_scene_add_mesh(scene, &mesh, &index, &error))
    result = status ? raise_error(&error) : PyLong_FromLong(index);
  }
  buffer_release_all(b, MANY(b));
  return result;
}

static PyObject *set_mesh_attribute(PyObject *self, PyObject *args)
{
  int mesh, id;
  PyObject *values;
  buffer b;
  Py_ssize_t shape[3] = {-1, 3, -1};
  bent_scene *scene = scene_value(self);
  if (!scene || !PyArg_ParseTuple(args, "iiO:set_mesh_attribute", &mesh, &id, &values) ||
      buffer_get(&b, values, "values", 'f', 3, shape, BUFFER_FINITE) < 0)
    return NULL;
  bent_error error;
  const bent_status status = bent_scene_set_mesh_attribute(scene, mesh, id, (int)shape[2], (size_t)shape[0],
                                                           buffer_data(&b), &error);
  buffer_release(&b);
  return none_or_error(status, &error);
}

static PyObject *set_instance_attribute(PyObject *self, PyObject *args)
{
  int instance, id;
  float v[4];
  bent_scene *scene = scene_value(self);
  if (!scene || !PyArg_ParseTuple(args, "ii(ffff):set_instance_attribute", &instance, &id, &v[0], &v[1], &v[2], &v[3]))
    return NULL;
  bent_error error;
  return none_or_error(bent_scene_set_instance_attribute(scene, instance, id, v, &error), &error);
}

static PyObject *update_mesh(PyObject *self, PyObject *args)
{
  int index;
  PyObject *vertices, *normals, *generated;
  if (!PyArg_ParseTuple(args, "iOOO:update_mesh", &index, &vertices, &normals, &generated)) return NULL;
  buffer b[3] = {{.held = 0}};
  Py_ssize_t v[2] = {-1, 3}, n[3] = {-1, 3, 3};
  const int bad = buffer_get(&b[0], vertices, "vertices", 'f', 2, v, BUFFER_FINITE) < 0 ||
                  buffer_get(&b[1], normals, "corner_normals", 'f', 3, n, BUFFER_OPTIONAL | BUFFER_FINITE) < 0 ||
                  buffer_get(&b[2], generated, "generated", 'f', 2, v, BUFFER_OPTIONAL | BUFFER_FINITE) < 0;
  bent_scene *scene = scene_value(self);
  bent_error error;
  bent_status status = BENT_OK;
  if (!bad && scene) {
    const bent_mesh mesh = {.vertex_count = (size_t)v[0],
                            .triangle_count = b[1].held ? (size_t)n[0] : 0,
                            .vertices = buffer_data(&b[0]),
                            .corner_normals = buffer_data(&b[1]),
                            .generated = buffer_data(&b[2])};
    WITHOUT_GIL(status = bent_scene_update_mesh(scene, index, &mesh, &error))
  }
  buffer_release_all(b, MANY(b));
  return bad || !scene ? NULL : none_or_error(status, &error);
}

static PyObject *report_mesh(PyObject *self, PyObject *args)
{
  int index;
  bent_scene *scene = scene_value(self);
  if (!scene || !PyArg_ParseTuple(args, "i:report_mesh", &index)) return NULL;
  bent_mesh_report report;
  bent_error error;
  bent_status status;
  WITHOUT_GIL(status = bent_scene_report_mesh(scene, index, &report, &error))
  if (status) return raise_error(&error);
  return Py_BuildValue("{s:n,s:n,s:n}", "degenerate", (Py_ssize_t)report.degenerate, "too_large",
                       (Py_ssize_t)report.too_large, "duplicate", (Py_ssize_t)report.duplicate);
}

static PyObject *add_instance(PyObject *self, PyObject *args)
{
  PyObject *matrix, *materials;
  bent_instance instance = {0};
  PyObject *influence;
  unsigned visibility, one_sided, receiver_set, blocker_set;
  float *c = instance.color;
  if (!PyArg_ParseTuple(args, "iOOIfI(ffff)fO(II):add_instance", &instance.mesh, &matrix, &materials, &visibility,
                        &instance.object_index, &one_sided, &c[0], &c[1], &c[2], &c[3], &instance.random, &influence,
                        &receiver_set, &blocker_set) ||
      get_matrix(matrix, "world_from_mesh", instance.world_from_mesh) < 0 ||
      influence_get(influence, &instance.influence) < 0)
    return NULL;
  instance.visibility = visibility, instance.one_sided = one_sided;
  instance.receiver_set = receiver_set, instance.blocker_set = blocker_set;
  buffer b;
  Py_ssize_t shape[1] = {-1};
  bent_scene *scene = scene_value(self);
  if (!scene || buffer_get(&b, materials, "materials", 'i', 1, shape, BUFFER_OPTIONAL) < 0) return NULL;
  instance.materials = buffer_data(&b);
  instance.material_count = b.held ? (size_t)shape[0] : 0;
  int index;
  bent_error error;
  const bent_status status = bent_scene_add_instance(scene, &instance, &index, &error);
  buffer_release(&b);
  return status ? raise_error(&error) : PyLong_FromLong(index);
}

static PyObject *update_instance(PyObject *self, PyObject *args)
{
  int index;
  PyObject *object;
  double matrix[4][4];
  bent_scene *scene = scene_value(self);
  if (!scene || !PyArg_ParseTuple(args, "iO:update_instance", &index, &object) ||
      get_matrix(object, "world_from_mesh", matrix) < 0)
    return NULL;
  bent_error error;
  return none_or_error(bent_scene_update_instance(scene, index, matrix, &error), &error);
}

static PyObject *clear_instances(PyObject *self, PyObject *unused)
{
  (void)unused;
  bent_scene *scene = scene_value(self);
  bent_error error;
  return scene ? none_or_error(bent_scene_clear_instances(scene, &error), &error) : NULL;
}

/* One (spacetime, world_from_spacetime, sphere_radius, exit) tuple. */
static int get_object(PyObject *item, bent_spacetime_object *out)
{
  PyObject *value, *matrix;
  if (!PyTuple_Check(item)) {
    PyErr_SetString(PyExc_TypeError, "objects: expected tuples (spacetime, world_from_spacetime, sphere_radius, exit)");
    return -1;
  }
  if (!PyArg_ParseTuple(item, "OOdi", &value, &matrix, &out->sphere_radius, &out->exit)) return -1;
  const bent_spacetime *spacetime = spacetime_value(value);
  if (!spacetime) return -1;
  out->spacetime = *spacetime;
  return get_matrix(matrix, "world_from_spacetime", out->world_from_spacetime);
}

static PyObject *set_spacetimes(PyObject *self, PyObject *list)
{
  bent_scene *scene = scene_value(self);
  const Py_ssize_t count = scene ? PySequence_Size(list) : -1;
  if (count < 0) return NULL;
  bent_spacetime_object *objects = calloc((size_t)count + 1, sizeof *objects);
  if (!objects) return PyErr_NoMemory();
  int bad = 0;
  for (Py_ssize_t i = 0; i < count && !bad; i++) {
    PyObject *item = PySequence_GetItem(list, i);
    bad = !item || get_object(item, &objects[i]) < 0;
    Py_XDECREF(item);
  }
  bent_error error;
  const bent_status status = bad ? BENT_OK : bent_scene_set_spacetimes(scene, (size_t)count, objects, &error);
  free(objects);
  return bad ? NULL : none_or_error(status, &error);
}

static PyObject *commit(PyObject *self, PyObject *object)
{
  int ok;
  bent_scene *scene = scene_value(self);
  bent_progress *progress = progress_value(object, &ok);
  if (!scene || !ok) return NULL;
  bent_error error;
  bent_status status;
  WITHOUT_GIL(status = bent_scene_commit(scene, progress, &error))
  return none_or_error(status, &error);
}

/* The arrays of one intersect call. */
enum { ORIGIN, DIRECTION, SOURCE, IS_VEIL, FATE, INSTANCE, TRIANGLE, BARYCENTRIC, POSITION, OUT_DIRECTION, LENGTH,
       SWEPT, ERROR, FIRST_LENS, BORDERS, SKY, GLOW, TRANSMISSION, LAYERS, ARRAYS };
enum { CHUNK = 1024 }; /* rays converted at a time between the caller's arrays and the core's structs */

static void load_rays(const buffer *b, size_t begin, size_t n, const bent_ray *common, bent_ray *rays)
{
  const double(*origins)[3] = buffer_data(&b[ORIGIN]), (*directions)[3] = buffer_data(&b[DIRECTION]);
  const int32_t(*sources)[2] = buffer_data(&b[SOURCE]);
  for (size_t i = 0; i < n; i++) {
    rays[i] = *common;
    memcpy(rays[i].origin, origins[begin + i], sizeof rays[i].origin);
    memcpy(rays[i].direction, directions[begin + i], sizeof rays[i].direction);
    rays[i].source_instance = sources ? sources[begin + i][0] : -1;
    rays[i].source_triangle = sources ? sources[begin + i][1] : -1;
  }
}

static void store_hits(const buffer *b, size_t begin, size_t n, const bent_hit *hits)
{
  for (size_t i = 0; i < n; i++) {
    const bent_hit *h = &hits[i];
    const size_t k = begin + i;
    ((uint8_t *)buffer_data(&b[FATE]))[k] = h->fate;
    ((int32_t *)buffer_data(&b[INSTANCE]))[k] = h->instance;
    ((int32_t *)buffer_data(&b[TRIANGLE]))[k] = h->triangle;
    memcpy((double(*)[2])buffer_data(&b[BARYCENTRIC]) + k, h->barycentric, sizeof h->barycentric);
    memcpy((double(*)[3])buffer_data(&b[POSITION]) + k, h->position, sizeof h->position);
    memcpy((double(*)[3])buffer_data(&b[OUT_DIRECTION]) + k, h->direction, sizeof h->direction);
    ((double *)buffer_data(&b[LENGTH]))[k] = h->length;
    ((double *)buffer_data(&b[SWEPT]))[k] = h->swept;
    ((double *)buffer_data(&b[ERROR]))[k] = h->error;
    ((int32_t *)buffer_data(&b[FIRST_LENS]))[k] = h->first_lens;
    ((uint32_t *)buffer_data(&b[BORDERS]))[k] = h->borders;
    ((int32_t *)buffer_data(&b[SKY]))[k] = h->sky;
  }
}

static void store_veils(const buffer *b, size_t begin, size_t n, const bent_veil *veils)
{
  for (size_t i = 0; i < n; i++) {
    const size_t k = begin + i;
    memcpy((double(*)[3])buffer_data(&b[GLOW]) + k, veils[i].glow, sizeof veils[i].glow);
    memcpy((double(*)[3])buffer_data(&b[TRANSMISSION]) + k, veils[i].transmission, sizeof veils[i].transmission);
    ((uint32_t *)buffer_data(&b[LAYERS]))[k] = veils[i].layers;
  }
}

static bent_status intersect_chunks(const bent_scene *scene, const buffer *b, size_t n, const bent_ray *common,
                                    bent_progress *progress, bent_error *error)
{
  const uint8_t *is_veil = buffer_data(&b[IS_VEIL]);
  bent_ray *rays = malloc(CHUNK * sizeof *rays);
  bent_hit *hits = malloc(CHUNK * sizeof *hits);
  bent_veil *veils = malloc((is_veil ? CHUNK : 1) * sizeof *veils);
  bent_status status =
      rays && hits && veils ? BENT_OK : bent_fail(error, BENT_ERROR_MEMORY, "intersect: out of memory");
  for (size_t begin = 0; begin < n && !status; begin += CHUNK) {
    const size_t m = n - begin < CHUNK ? n - begin : CHUNK;
    load_rays(b, begin, m, common, rays);
    status = is_veil ? bent_scene_intersect_veiled(scene, m, rays, is_veil, hits, veils, progress, error)
                     : bent_scene_intersect(scene, m, rays, hits, progress, error);
    if (!status) store_hits(b, begin, m, hits);
    if (!status && is_veil) store_veils(b, begin, m, veils);
  }
  free(rays);
  free(hits);
  free(veils);
  return status;
}

static PyObject *intersect(PyObject *self, PyObject *args)
{
  PyObject *in[ARRAYS], *progress_object;
  bent_ray common = {.source_instance = -1, .source_triangle = -1};
  unsigned visibility;
  if (!PyArg_ParseTuple(args, "OOOddddIOOOOOOOOOOOOOOOOO:intersect", &in[ORIGIN], &in[DIRECTION], &in[SOURCE],
                        &common.tolerance, &common.angular_tolerance, &common.length_min, &common.length_max,
                        &visibility, &progress_object, &in[IS_VEIL], &in[FATE], &in[INSTANCE], &in[TRIANGLE],
                        &in[BARYCENTRIC], &in[POSITION], &in[OUT_DIRECTION], &in[LENGTH], &in[SWEPT], &in[ERROR],
                        &in[FIRST_LENS], &in[BORDERS], &in[SKY], &in[GLOW], &in[TRANSMISSION], &in[LAYERS]))
    return NULL;
  common.visibility = visibility;
  static const struct {
    const char *name;
    char format;
    int columns, flags;
  } KINDS[ARRAYS] = {{"origins", 'd', 3, BUFFER_FINITE}, {"directions", 'd', 3, BUFFER_FINITE},
                     {"sources", 'i', 2, BUFFER_OPTIONAL}, {"veils", 'B', 0, BUFFER_OPTIONAL},
                     {"fate", 'B', 0, BUFFER_WRITE}, {"instance", 'i', 0, BUFFER_WRITE},
                     {"triangle", 'i', 0, BUFFER_WRITE}, {"barycentric", 'd', 2, BUFFER_WRITE},
                     {"position", 'd', 3, BUFFER_WRITE}, {"direction", 'd', 3, BUFFER_WRITE},
                     {"length", 'd', 0, BUFFER_WRITE}, {"swept", 'd', 0, BUFFER_WRITE}, {"error", 'd', 0, BUFFER_WRITE},
                     {"first_lens", 'i', 0, BUFFER_WRITE}, {"borders", 'I', 0, BUFFER_WRITE},
                     {"sky", 'i', 0, BUFFER_WRITE}, {"glow", 'd', 3, BUFFER_WRITE},
                     {"transmission", 'd', 3, BUFFER_WRITE}, {"layers", 'I', 0, BUFFER_WRITE}};
  int ok;
  bent_scene *scene = scene_value(self);
  bent_progress *progress = progress_value(progress_object, &ok);
  if (!scene || !ok) return NULL;
  buffer b[ARRAYS] = {{.held = 0}};
  Py_ssize_t n = -1;
  int bad = 0;
  for (int i = 0; i < ARRAYS && !bad; i++) {
    Py_ssize_t shape[2] = {i == IS_VEIL ? (Py_ssize_t)scene->geometry->instance_count : n, KINDS[i].columns};
    const int flags = KINDS[i].flags | (i > SKY && !b[IS_VEIL].held ? BUFFER_OPTIONAL : 0);
    bad = buffer_get(&b[i], in[i], KINDS[i].name, KINDS[i].format, KINDS[i].columns ? 2 : 1, shape, flags) < 0;
    if (i == ORIGIN) n = shape[0];
  }
  bent_error error;
  bent_status status = BENT_OK;
  if (!bad) WITHOUT_GIL(status = intersect_chunks(scene, b, (size_t)n, &common, progress, &error))
  buffer_release_all(b, ARRAYS);
  return bad ? NULL : none_or_error(status, &error);
}

PyMethodDef scene_geometry_methods[] = {
    {"add_mesh", add_mesh, METH_VARARGS, "See bentlight_native.Scene.add_mesh."},
    {"update_mesh", update_mesh, METH_VARARGS, "See bentlight_native.Scene.update_mesh."},
    {"set_mesh_attribute", set_mesh_attribute, METH_VARARGS, "See bentlight_native.Scene.set_mesh_attribute."},
    {"set_instance_attribute", set_instance_attribute, METH_VARARGS,
     "See bentlight_native.Scene.set_instance_attribute."},
    {"report_mesh", report_mesh, METH_VARARGS, "See bentlight_native.Scene.report_mesh."},
    {"add_instance", add_instance, METH_VARARGS, "See bentlight_native.Scene.add_instance."},
    {"update_instance", update_instance, METH_VARARGS, "See bentlight_native.Scene.update_instance."},
    {"clear_instances", clear_instances, METH_NOARGS, "See bentlight_native.Scene.clear_instances."},
    {"set_spacetimes", set_spacetimes, METH_O, "See bentlight_native.Scene.set_spacetime_objects."},
    {"commit", commit, METH_O, "See bentlight_native.Scene.commit."},
    {"intersect", intersect, METH_VARARGS, "See bentlight_native.Scene.intersect."},
    {0}};
