/* Scene methods that find stars' images, and the function that draws them. The numpy-facing side is stars.py. */
#include "python.h"

/* _find_stars(directions, (width, height, margin, tolerance, transparent_bounces), count, place, throughput, parallax,
 * solid_angle, swept, progress) */
static PyObject *find_stars(PyObject *self, PyObject *args)
{
  enum { ARRAYS = 7 };
  PyObject *in[ARRAYS], *progress_object;
  bent_star_view view;
  if (!PyArg_ParseTuple(args, "O(IIddI)OOOOOOO:find_stars", &in[0], &view.width, &view.height, &view.margin, &view.tolerance,
                        &view.transparent_bounces, &in[1], &in[2], &in[3], &in[4], &in[5], &in[6], &progress_object))
    return NULL;
  int ok;
  bent_progress *progress = progress_value(progress_object, &ok);
  const bent_scene *scene = scene_value(self);
  if (!ok || !scene) return NULL;
  buffer b[ARRAYS] = {0};
  Py_ssize_t rows[] = {-1, 3}, each[] = {-1}, pairs[] = {-1, BENT_STAR_IMAGES_MAX, 2},
             triples[] = {-1, BENT_STAR_IMAGES_MAX, 3}, matrices[] = {-1, BENT_STAR_IMAGES_MAX, 2, 2},
             numbers[] = {-1, BENT_STAR_IMAGES_MAX};
  PyObject *result = NULL;
  if (!buffer_get(&b[0], in[0], "directions", 'd', 2, rows, BUFFER_FINITE) &&
      (each[0] = pairs[0] = triples[0] = matrices[0] = numbers[0] = rows[0], 1) &&
      !buffer_get(&b[1], in[1], "count", 'i', 1, each, BUFFER_WRITE) &&
      !buffer_get(&b[2], in[2], "place", 'd', 3, pairs, BUFFER_WRITE) &&
      !buffer_get(&b[3], in[3], "throughput", 'd', 3, triples, BUFFER_WRITE) &&
      !buffer_get(&b[4], in[4], "parallax", 'd', 4, matrices, BUFFER_WRITE) &&
      !buffer_get(&b[5], in[5], "solid_angle", 'd', 2, numbers, BUFFER_WRITE) &&
      !buffer_get(&b[6], in[6], "swept", 'd', 2, numbers, BUFFER_WRITE)) {
    const bent_star_images out = {buffer_data(&b[1]), buffer_data(&b[2]), buffer_data(&b[3]),
                                  buffer_data(&b[4]), buffer_data(&b[5]), buffer_data(&b[6])};
    bent_error error;
    bent_status status;
    Py_BEGIN_ALLOW_THREADS
    status = bent_scene_find_stars(scene, (size_t)rows[0], buffer_data(&b[0]), &view, &out, progress, &error);
    Py_END_ALLOW_THREADS
    result = status ? raise_error(&error) : Py_NewRef(Py_None);
  }
  buffer_release_all(b, ARRAYS);
  return result;
}

/* _star_cells(width, height) */
static PyObject *star_cells(PyObject *self, PyObject *args)
{
  unsigned width, height;
  uint32_t cells[2];
  const bent_scene *scene = scene_value(self);
  if (!scene || !PyArg_ParseTuple(args, "II:_star_cells", &width, &height)) return NULL;
  bent_scene_star_cells(scene, width, height, cells);
  return Py_BuildValue("(II)", cells[0], cells[1]);
}

/* _trace_star_cells(places, parallax, (width, height, margin, tolerance, transparent_bounces), corners, seen, progress) */
static PyObject *trace_star_cells(PyObject *self, PyObject *args)
{
  enum { ARRAYS = 4 };
  PyObject *in[ARRAYS], *progress_object;
  bent_star_view view;
  if (!PyArg_ParseTuple(args, "OO(IIddI)OOO:_trace_star_cells", &in[0], &in[1], &view.width, &view.height, &view.margin,
                        &view.tolerance, &view.transparent_bounces, &in[2], &in[3], &progress_object))
    return NULL;
  int ok;
  bent_progress *progress = progress_value(progress_object, &ok);
  const bent_scene *scene = scene_value(self);
  if (!ok || !scene) return NULL;
  buffer b[ARRAYS] = {0};
  uint32_t cells[2];
  bent_scene_star_cells(scene, view.width, view.height, cells);
  Py_ssize_t pairs[] = {-1, 2}, matrices[] = {-1, 2, 2}, corners[] = {cells[0] + 1, cells[1] + 1, 2},
             seen[] = {-1, cells[0], cells[1], 3};
  PyObject *result = NULL;
  if (!buffer_get(&b[0], in[0], "places", 'd', 2, pairs, BUFFER_FINITE) && (matrices[0] = seen[0] = pairs[0], 1) &&
      !buffer_get(&b[1], in[1], "parallax", 'd', 3, matrices, BUFFER_FINITE) &&
      !buffer_get(&b[2], in[2], "corners", 'd', 3, corners, BUFFER_WRITE) &&
      !buffer_get(&b[3], in[3], "seen", 'f', 4, seen, BUFFER_WRITE)) {
    bent_error error;
    bent_status status;
    Py_BEGIN_ALLOW_THREADS
    status = bent_scene_trace_star_cells(scene, (size_t)pairs[0], buffer_data(&b[0]), buffer_data(&b[1]), &view, cells,
                                         buffer_data(&b[3]), progress, &error);
    if (!status) bent_scene_star_lens(scene, cells, buffer_data(&b[2]));
    Py_END_ALLOW_THREADS
    result = status ? raise_error(&error) : Py_NewRef(Py_None);
  }
  buffer_release_all(b, ARRAYS);
  return result;
}

static PyObject *shows_stars(PyObject *self, PyObject *unused)
{
  (void)unused;
  const bent_scene *scene = scene_value(self);
  return scene ? PyBool_FromLong(bent_scene_shows_stars(scene)) : NULL;
}

/* What an open lens makes of n images: arrays of bent_stars_draw_blurred. */
typedef struct blur {
  buffer parallax, corners, seen;
  uint32_t cells[2];
} blur;

static int blur_get(blur *out, PyObject *tuple, Py_ssize_t n)
{
  PyObject *parallax, *corners, *seen;
  if (!PyArg_ParseTuple(tuple, "OOO:blur", &parallax, &corners, &seen)) return -1;
  Py_ssize_t matrices[] = {n, 2, 2}, grid[] = {-1, -1, 2}, lights[] = {n, 0, 0, 3};
  if (buffer_get(&out->parallax, parallax, "parallax", 'd', 3, matrices, BUFFER_FINITE) ||
      buffer_get(&out->corners, corners, "corners", 'd', 3, grid, BUFFER_FINITE))
    return -1;
  if (grid[0] < 2 || grid[1] < 2) return PyErr_SetString(PyExc_ValueError, "corners: expected 2 or more along both sides"), -1;
  lights[1] = grid[0] - 1, lights[2] = grid[1] - 1;
  out->cells[0] = (uint32_t)lights[1], out->cells[1] = (uint32_t)lights[2];
  return buffer_get(&out->seen, seen, "seen", 'B', 4, lights, BUFFER_READ);
}

/* draw_stars(places, light, blur, width, height, filter, filter_width, tile, pixels) */
static PyObject *draw_stars(PyObject *module, PyObject *args)
{
  (void)module;
  PyObject *places_object, *light_object, *blur_object, *pixels_object;
  bent_star_canvas c;
  const char *name;
  if (!PyArg_ParseTuple(args, "OOOIIsd(IIII)O:draw_stars", &places_object, &light_object, &blur_object, &c.width, &c.height,
                        &name, &c.filter_width, &c.tile[0], &c.tile[1], &c.tile[2], &c.tile[3], &pixels_object))
    return NULL;
  const int filter = filter_value(name);
  if (filter < 0) return NULL;
  c.filter = (bent_filter_kind)filter;
  buffer b[3] = {0};
  blur blur = {0};
  Py_ssize_t pairs[] = {-1, 2}, triples[] = {-1, 3}, shape[] = {c.tile[3], c.tile[2], 3};
  PyObject *result = NULL;
  if (!buffer_get(&b[0], places_object, "places", 'd', 2, pairs, BUFFER_FINITE) && (triples[0] = pairs[0], 1) &&
      !buffer_get(&b[1], light_object, "light", 'd', 2, triples, BUFFER_FINITE) &&
      !buffer_get(&b[2], pixels_object, "pixels", 'f', 3, shape, BUFFER_WRITE) &&
      (blur_object == Py_None || !blur_get(&blur, blur_object, pairs[0]))) {
    c.pixels = buffer_data(&b[2]);
    bent_error error;
    bent_status status;
    const void *places = buffer_data(&b[0]), *light = buffer_data(&b[1]);
    Py_BEGIN_ALLOW_THREADS
    status = blur_object == Py_None
                 ? bent_stars_draw(&c, (size_t)pairs[0], places, light, &error)
                 : bent_stars_draw_blurred(&c, (size_t)pairs[0], places, light, buffer_data(&blur.parallax), blur.cells,
                                           buffer_data(&blur.corners), buffer_data(&blur.seen), &error);
    Py_END_ALLOW_THREADS
    result = status ? raise_error(&error) : Py_NewRef(Py_None);
  }
  buffer_release_all(b, 3);
  buffer_release_all((buffer[]){blur.parallax, blur.corners, blur.seen}, 3);
  return result;
}

PyMethodDef scene_star_methods[] = {{"_find_stars", find_stars, METH_VARARGS, NULL},
                                    {"_star_cells", star_cells, METH_VARARGS, NULL},
                                    {"_trace_star_cells", trace_star_cells, METH_VARARGS, NULL},
                                    {"shows_stars", shows_stars, METH_NOARGS,
                                     "shows_stars() -> bool\n\nWhether there is a camera in whose picture stars have a "
                                     "place: not so for orthographic ones."},
                                    {0}};
PyMethodDef star_functions[] = {{"draw_stars", draw_stars, METH_VARARGS,
                                 "draw_stars(places, light, blur, width, height, filter, filter_width, tile, pixels)\n\n"
                                 "Adds images of stars to pixels; see bentlight_native.StarImages.draw."},
                                {0}};
