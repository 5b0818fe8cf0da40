/* Scene methods that find stars' images, and the function that draws them. The numpy-facing side is stars.py. */
#include "python.h"

/* _find_stars(directions, (width, height, margin, tolerance, transparent_bounces), count, place, throughput, solid_angle,
 * swept, progress) */
static PyObject *find_stars(PyObject *self, PyObject *args)
{
  enum { ARRAYS = 6 };
  PyObject *in[ARRAYS], *progress_object;
  bent_star_view view;
  if (!PyArg_ParseTuple(args, "O(IIddI)OOOOOO:find_stars", &in[0], &view.width, &view.height, &view.margin, &view.tolerance,
                        &view.transparent_bounces, &in[1], &in[2], &in[3], &in[4], &in[5], &progress_object))
    return NULL;
  int ok;
  bent_progress *progress = progress_value(progress_object, &ok);
  const bent_scene *scene = scene_value(self);
  if (!ok || !scene) return NULL;
  buffer b[ARRAYS] = {0};
  Py_ssize_t rows[] = {-1, 3}, each[] = {-1}, pairs[] = {-1, BENT_STAR_IMAGES_MAX, 2},
             triples[] = {-1, BENT_STAR_IMAGES_MAX, 3}, numbers[] = {-1, BENT_STAR_IMAGES_MAX};
  PyObject *result = NULL;
  if (!buffer_get(&b[0], in[0], "directions", 'd', 2, rows, BUFFER_FINITE) &&
      (each[0] = pairs[0] = triples[0] = numbers[0] = rows[0], 1) &&
      !buffer_get(&b[1], in[1], "count", 'i', 1, each, BUFFER_WRITE) &&
      !buffer_get(&b[2], in[2], "place", 'd', 3, pairs, BUFFER_WRITE) &&
      !buffer_get(&b[3], in[3], "throughput", 'd', 3, triples, BUFFER_WRITE) &&
      !buffer_get(&b[4], in[4], "solid_angle", 'd', 2, numbers, BUFFER_WRITE) &&
      !buffer_get(&b[5], in[5], "swept", 'd', 2, numbers, BUFFER_WRITE)) {
    const bent_star_images out = {buffer_data(&b[1]), buffer_data(&b[2]), buffer_data(&b[3]), buffer_data(&b[4]),
                                  buffer_data(&b[5])};
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

static PyObject *shows_stars(PyObject *self, PyObject *unused)
{
  (void)unused;
  const bent_scene *scene = scene_value(self);
  return scene ? PyBool_FromLong(bent_scene_shows_stars(scene)) : NULL;
}

/* draw_stars(places, light, width, height, filter, filter_width, tile, pixels) */
static PyObject *draw_stars(PyObject *module, PyObject *args)
{
  (void)module;
  PyObject *places_object, *light_object, *pixels_object;
  unsigned width, height, tile[4];
  const char *name;
  double filter_width;
  if (!PyArg_ParseTuple(args, "OOIIsd(IIII)O:draw_stars", &places_object, &light_object, &width, &height, &name,
                        &filter_width, &tile[0], &tile[1], &tile[2], &tile[3], &pixels_object))
    return NULL;
  const int filter = filter_value(name);
  if (filter < 0) return NULL;
  buffer b[3] = {0};
  Py_ssize_t pairs[] = {-1, 2}, triples[] = {-1, 3}, shape[] = {tile[3], tile[2], 3};
  PyObject *result = NULL;
  if (!buffer_get(&b[0], places_object, "places", 'd', 2, pairs, BUFFER_FINITE) && (triples[0] = pairs[0], 1) &&
      !buffer_get(&b[1], light_object, "light", 'd', 2, triples, BUFFER_FINITE) &&
      !buffer_get(&b[2], pixels_object, "pixels", 'f', 3, shape, BUFFER_WRITE)) {
    bent_error error;
    bent_status status;
    Py_BEGIN_ALLOW_THREADS
    status = bent_stars_draw((size_t)pairs[0], buffer_data(&b[0]), buffer_data(&b[1]), width, height,
                             (bent_filter_kind)filter, filter_width, tile, buffer_data(&b[2]), &error);
    Py_END_ALLOW_THREADS
    result = status ? raise_error(&error) : Py_NewRef(Py_None);
  }
  buffer_release_all(b, 3);
  return result;
}

PyMethodDef scene_star_methods[] = {{"_find_stars", find_stars, METH_VARARGS, NULL},
                                    {"shows_stars", shows_stars, METH_NOARGS,
                                     "shows_stars() -> bool\n\nWhether there is a camera in whose picture stars have a "
                                     "place: not so for orthographic ones, nor yet for panoramas."},
                                    {0}};
PyMethodDef star_functions[] = {{"draw_stars", draw_stars, METH_VARARGS,
                                 "draw_stars(places, light, width, height, filter, filter_width, tile, pixels)\n\n"
                                 "Adds images of stars to pixels; see bentlight_native.StarImages.draw."},
                                {0}};
