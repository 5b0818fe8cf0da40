/* Scene methods for the camera, suns and rendering tiles; and the render topic's module functions. */
#include "python.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "light/join.h"
#include "light/lights.h"
#include "render/aperture.h"
#include "render/camera.h"
#include "render/filter.h"
#include "render/sampler.h"
#include "scene/scene.h"

static const char *const CAMERA_KINDS[BENT_CAMERA_KINDS] = {
    [BENT_CAMERA_PERSPECTIVE] = "PERSPECTIVE",
    [BENT_CAMERA_ORTHOGRAPHIC] = "ORTHOGRAPHIC",
    [BENT_CAMERA_EQUIRECTANGULAR] = "EQUIRECTANGULAR",
    [BENT_CAMERA_EQUIANGULAR_CUBEMAP_FACE] = "EQUIANGULAR_CUBEMAP_FACE",
    [BENT_CAMERA_MIRRORBALL] = "MIRRORBALL",
    [BENT_CAMERA_FISHEYE_EQUIDISTANT] = "FISHEYE_EQUIDISTANT",
    [BENT_CAMERA_FISHEYE_EQUISOLID] = "FISHEYE_EQUISOLID",
    [BENT_CAMERA_FISHEYE_LENS_POLYNOMIAL] = "FISHEYE_LENS_POLYNOMIAL",
    [BENT_CAMERA_CENTRAL_CYLINDRICAL] = "CENTRAL_CYLINDRICAL",
};
static const char *const FILTERS[] = {"BLACKMAN_HARRIS", "GAUSSIAN", "BOX"};
static const char *const INTEGRATORS[BENT_INTEGRATORS] = {[BENT_PATH] = "PATH", [BENT_BIDIRECTIONAL] = "BIDIRECTIONAL"};
static const char *const LIGHT_SAMPLINGS[BENT_LIGHT_SAMPLINGS] = {[BENT_LIGHTS_BOTH] = "BOTH",
                                                                  [BENT_LIGHTS_SCATTERING] = "SCATTERING",
                                                                  [BENT_LIGHTS_CONNECTIONS] = "CONNECTIONS"};
static const char *const PATTERNS[BENT_SAMPLING_PATTERNS] = {[BENT_PATTERN_BLUE_NOISE] = "BLUE_NOISE",
                                                             [BENT_PATTERN_CLASSIC] = "CLASSIC"};

#define COUNT(array) ((int)(sizeof(array) / sizeof *(array)))

/* Index of `text` among `names`, or -1 with a ValueError that lists them. */
int choose(const char *text, const char *what, const char *const *names, int count)
{
  char list[512] = "";
  size_t used = 0;
  for (int i = 0; i < count; i++) {
    if (!strcmp(text, names[i])) return i;
    const int wrote = PyOS_snprintf(list + used, sizeof list - used, "%s'%s'", i ? ", " : "", names[i]);
    if (wrote > 0 && used + (size_t)wrote < sizeof list) used += (size_t)wrote;
  }
  PyErr_Format(PyExc_ValueError, "%s: expected one of %s, got '%s'", what, list, text);
  return -1;
}

int filter_value(const char *name) { return choose(name, "filter", FILTERS, COUNT(FILTERS)); }

static PyObject *set_camera(PyObject *self, PyObject *args, PyObject *keywords)
{
  static char *names[] = {"kind", "world_from_camera", "viewplane", "clip_start", "clip_end", "longitude_min",
                          "longitude_max", "latitude_min", "latitude_max", "fisheye_fov", "fisheye_lens",
                          "sensor_width", "sensor_height", "fisheye_polynomial_k0", "fisheye_polynomial_k1",
                          "fisheye_polynomial_k2", "fisheye_polynomial_k3", "fisheye_polynomial_k4",
                          "central_cylindrical_range_u_min", "central_cylindrical_range_u_max",
                          "central_cylindrical_range_v_min", "central_cylindrical_range_v_max",
                          "central_cylindrical_radius", "aperture", NULL};
  bent_camera c = {0};
  const char *kind;
  PyObject *matrix;
  double *k = c.fisheye_polynomial;
  if (!PyArg_ParseTupleAndKeywords(
          args, keywords, "sO(dddd)dddddddddddddddddddd(ddIdd):set_camera", names, &kind, &matrix, &c.viewplane[0],
          &c.viewplane[1], &c.viewplane[2], &c.viewplane[3], &c.clip_start, &c.clip_end, &c.longitude[0],
          &c.longitude[1], &c.latitude[0], &c.latitude[1], &c.fisheye_fov, &c.fisheye_lens, &c.sensor_width,
          &c.sensor_height, &k[0], &k[1], &k[2], &k[3], &k[4], &c.cylinder_longitude[0], &c.cylinder_longitude[1],
          &c.cylinder_height[0], &c.cylinder_height[1], &c.cylinder_radius, &c.aperture.radius, &c.aperture.focal_distance,
          &c.aperture.blades, &c.aperture.rotation, &c.aperture.ratio))
    return NULL;
  const int chosen = choose(kind, "camera kind", CAMERA_KINDS, BENT_CAMERA_KINDS);
  Py_ssize_t shape[] = {4, 4};
  buffer world_from_camera;
  if (chosen < 0 || buffer_get(&world_from_camera, matrix, "world_from_camera", 'd', 2, shape, BUFFER_FINITE))
    return NULL;
  c.kind = (bent_camera_kind)chosen;
  memcpy(c.world_from_camera, buffer_data(&world_from_camera), sizeof c.world_from_camera);
  buffer_release(&world_from_camera);
  bent_error error;
  bent_scene *scene = scene_value(self);
  if (!scene) return NULL;
  if (bent_scene_set_camera(scene, &c, &error)) return raise_error(&error);
  Py_RETURN_NONE;
}

static PyObject *camera_rays(PyObject *self, PyObject *args)
{
  PyObject *objects[5];
  if (!PyArg_ParseTuple(args, "OOOOO:camera_rays", &objects[0], &objects[1], &objects[2], &objects[3], &objects[4]))
    return NULL;
  const bent_scene *scene = scene_value(self);
  if (!scene) return NULL;
  if (!scene->camera) return PyErr_SetString(PyExc_RuntimeError, "scene: no camera is set"), NULL;
  Py_ssize_t points_shape[] = {-1, 2}, rays_shape[] = {-1, 3}, range_shape[] = {-1, 3};
  buffer b[5] = {0};
  PyObject *result = NULL;
  if (!buffer_get(&b[0], objects[0], "points", 'd', 2, points_shape, BUFFER_FINITE) &&
      !buffer_get(&b[4], objects[4], "lens", 'd', 2, points_shape, BUFFER_FINITE | BUFFER_OPTIONAL) &&
      (rays_shape[0] = range_shape[0] = points_shape[0], 1) &&
      !buffer_get(&b[1], objects[1], "origins", 'd', 2, rays_shape, BUFFER_WRITE) &&
      !buffer_get(&b[2], objects[2], "directions", 'd', 2, rays_shape, BUFFER_WRITE) &&
      !buffer_get(&b[3], objects[3], "range", 'd', 2, range_shape, BUFFER_WRITE)) {
    const double(*points)[2] = buffer_data(&b[0]), (*u)[2] = buffer_data(&b[4]);
    double(*origins)[3] = buffer_data(&b[1]), (*directions)[3] = buffer_data(&b[2]), (*range)[3] = buffer_data(&b[3]);
    for (Py_ssize_t i = 0; i < points_shape[0]; i++) {
      camera_ray ray;
      double lens[2] = {0, 0};
      if (u) aperture_draw(&scene->camera->settings.aperture, u[i], lens);
      if (!camera_cast_lens(scene->camera, points[i][0], points[i][1], lens, &ray))
        ray = (camera_ray){{NAN, NAN, NAN}, {NAN, NAN, NAN}, NAN, NAN, NAN};
      v3_to(origins[i], ray.origin);
      v3_to(directions[i], ray.direction);
      range[i][0] = ray.length_min, range[i][1] = ray.length_max, range[i][2] = ray.depth_per_length;
    }
    result = Py_NewRef(Py_None);
  }
  buffer_release_all(b, 5);
  return result;
}

static PyObject *set_suns(PyObject *self, PyObject *args)
{
  PyObject *objects[6], *influence;
  if (!PyArg_ParseTuple(args, "OOOOO!OO:set_suns", &objects[0], &objects[1], &objects[2], &objects[3], &PyList_Type,
                        &influence, &objects[4], &objects[5]))
    return NULL;
  bent_scene *scene = scene_value(self);
  if (!scene) return NULL;
  Py_ssize_t shape[] = {-1, 3}, count[] = {-1}, square[] = {-1, 4, 4};
  buffer b[6] = {0};
  PyObject *result = NULL;
  if (!buffer_get(&b[0], objects[0], "directions", 'd', 2, shape, 0) && (count[0] = square[0] = shape[0], 1) &&
      !buffer_get(&b[1], objects[1], "radiance", 'd', 2, shape, 0) &&
      !buffer_get(&b[2], objects[2], "angle", 'd', 1, count, 0) &&
      !buffer_get(&b[3], objects[3], "visibility", 'I', 1, count, 0) &&
      !buffer_get(&b[4], objects[4], "materials", 'i', 1, count, 0) &&
      !buffer_get(&b[5], objects[5], "world_from_sun", 'd', 3, square, 0)) {
    bent_sun *suns = calloc((size_t)count[0] + 1, sizeof *suns);
    const double(*directions)[3] = buffer_data(&b[0]), (*radiance)[3] = buffer_data(&b[1]), *angle = buffer_data(&b[2]);
    const uint32_t *visibility = buffer_data(&b[3]);
    const int32_t *materials = buffer_data(&b[4]);
    const double(*matrices)[4][4] = buffer_data(&b[5]);
    int bad = 0;
    for (Py_ssize_t i = 0; suns && i < count[0] && !bad; i++) {
      memcpy(suns[i].direction, directions[i], sizeof suns[i].direction);
      memcpy(suns[i].radiance, radiance[i], sizeof suns[i].radiance);
      memcpy(suns[i].world_from_sun, matrices[i], sizeof suns[i].world_from_sun);
      suns[i].angle = angle[i], suns[i].visibility = visibility[i], suns[i].material = materials[i];
      bad = influence_get(PyList_GetItem(influence, i), &suns[i].influence);
    }
    bent_error error;
    if (!suns)
      PyErr_NoMemory();
    else if (!bad && bent_scene_set_suns(scene, (size_t)count[0], suns, &error))
      raise_error(&error);
    else if (!bad)
      result = Py_NewRef(Py_None);
    free(suns);
  }
  buffer_release_all(b, 6);
  return result;
}

static PyObject *set_lamps(PyObject *self, PyObject *args)
{
  PyObject *objects[3], *influence;
  if (!PyArg_ParseTuple(args, "OOOO!:set_lamps", &objects[0], &objects[1], &objects[2], &PyList_Type, &influence))
    return NULL;
  bent_scene *scene = scene_value(self);
  if (!scene) return NULL;
  Py_ssize_t shape[] = {-1, 4, 4}, count[] = {-1};
  buffer b[3] = {0};
  PyObject *result = NULL;
  if (!buffer_get(&b[0], objects[0], "world_from_lamp", 'd', 3, shape, 0) && (count[0] = shape[0], 1) &&
      !buffer_get(&b[1], objects[1], "materials", 'i', 1, count, 0) &&
      !buffer_get(&b[2], objects[2], "visibility", 'I', 1, count, 0)) {
    bent_lamp *lamps = calloc((size_t)count[0] + 1, sizeof *lamps);
    const double(*matrices)[4][4] = buffer_data(&b[0]);
    const int32_t *materials = buffer_data(&b[1]);
    const uint32_t *visibility = buffer_data(&b[2]);
    int bad = 0;
    for (Py_ssize_t i = 0; lamps && i < count[0] && !bad; i++) {
      memcpy(lamps[i].world_from_lamp, matrices[i], sizeof lamps[i].world_from_lamp);
      lamps[i].material = materials[i], lamps[i].visibility = visibility[i];
      bad = influence_get(PyList_GetItem(influence, i), &lamps[i].influence);
    }
    bent_error error;
    if (!lamps)
      PyErr_NoMemory();
    else if (!bad && bent_scene_set_lamps(scene, (size_t)count[0], lamps, &error))
      raise_error(&error);
    else if (!bad)
      result = Py_NewRef(Py_None);
    free(lamps);
  }
  buffer_release_all(b, 3);
  return result;
}

/* Draws a light for one point; `which`, `target` and `probability` as render.py says. */
static void draw_light(const bent_scene *scene, const double point[3], const double normal[3], const double u[4],
                       int32_t which[3], double target[3], double probability[3])
{
  const vec3 p = v3_from(point), n = v3_from(normal);
  light_sample s = {.kind = LIGHT_TRIANGLE, .index = -1, .triangle = -1, .target = {NAN, NAN, NAN}};
  const int drawn = lights_draw(scene->lights, scene, p, n, u, &s);
  which[0] = drawn ? (int32_t)s.kind : -1, which[1] = s.index, which[2] = s.triangle;
  v3_to(target, s.target);
  probability[0] = s.probability * s.facing;
  probability[1] = probability[2] = s.probability;
  if (drawn && s.kind == LIGHT_TRIANGLE)
    probability[2] = lights_triangle_probability(scene->lights, s.index, s.triangle, s.target, p, n);
  if (drawn && s.kind == LIGHT_SUN) probability[2] = lights_sun_probability(scene->lights, (size_t)s.index, p, n);
  if (drawn && s.kind == LIGHT_SKY) probability[2] = lights_sky_pdf(scene->lights, s.target, p, n);
}

static PyObject *draw_lights(PyObject *self, PyObject *args)
{
  PyObject *objects[6];
  if (!PyArg_ParseTuple(args, "OOOOOO:draw_lights", &objects[0], &objects[1], &objects[2], &objects[3], &objects[4],
                        &objects[5]))
    return NULL;
  const bent_scene *scene = scene_value(self);
  if (!scene) return NULL;
  if (!scene->committed) return PyErr_SetString(PyExc_RuntimeError, "scene: has edits without a commit"), NULL;
  Py_ssize_t rows[] = {-1, 3}, numbers[] = {-1, 4};
  buffer b[6] = {0};
  PyObject *result = NULL;
  if (!buffer_get(&b[0], objects[0], "points", 'd', 2, rows, BUFFER_FINITE) &&
      (numbers[0] = rows[0], 1) && !buffer_get(&b[1], objects[1], "normals", 'd', 2, rows, BUFFER_FINITE) &&
      !buffer_get(&b[2], objects[2], "u", 'd', 2, numbers, BUFFER_FINITE) &&
      !buffer_get(&b[3], objects[3], "which", 'i', 2, rows, BUFFER_WRITE) &&
      !buffer_get(&b[4], objects[4], "target", 'd', 2, rows, BUFFER_WRITE) &&
      !buffer_get(&b[5], objects[5], "probability", 'd', 2, rows, BUFFER_WRITE)) {
    const double(*points)[3] = buffer_data(&b[0]), (*normals)[3] = buffer_data(&b[1]), (*u)[4] = buffer_data(&b[2]);
    int32_t(*which)[3] = buffer_data(&b[3]);
    double(*target)[3] = buffer_data(&b[4]), (*probability)[3] = buffer_data(&b[5]);
    for (Py_ssize_t i = 0; i < rows[0]; i++)
      draw_light(scene, points[i], normals[i], u[i], which[i], target[i], probability[i]);
    result = Py_NewRef(Py_None);
  }
  buffer_release_all(b, 6);
  return result;
}

static PyObject *draw_light_starts(PyObject *self, PyObject *args)
{
  PyObject *objects[5];
  if (!PyArg_ParseTuple(args, "OOOOO:draw_light_starts", &objects[0], &objects[1], &objects[2], &objects[3], &objects[4]))
    return NULL;
  const bent_scene *scene = scene_value(self);
  if (!scene) return NULL;
  if (!scene->committed) return PyErr_SetString(PyExc_RuntimeError, "scene: has edits without a commit"), NULL;
  if (!lights_any_start(scene->lights)) return PyErr_SetString(PyExc_ValueError, "scene: no light starts anywhere"), NULL;
  Py_ssize_t numbers[] = {-1, 6}, rows[] = {-1, 3}, pairs[] = {-1, 2};
  buffer b[5] = {0};
  PyObject *result = NULL;
  if (!buffer_get(&b[0], objects[0], "u", 'd', 2, numbers, BUFFER_FINITE) && (rows[0] = pairs[0] = numbers[0], 1) &&
      !buffer_get(&b[1], objects[1], "which", 'i', 2, rows, BUFFER_WRITE) &&
      !buffer_get(&b[2], objects[2], "place", 'd', 2, rows, BUFFER_WRITE) &&
      !buffer_get(&b[3], objects[3], "direction", 'd', 2, rows, BUFFER_WRITE) &&
      !buffer_get(&b[4], objects[4], "probability", 'd', 2, pairs, BUFFER_WRITE)) {
    const double(*u)[6] = buffer_data(&b[0]);
    int32_t(*which)[3] = buffer_data(&b[1]);
    double(*place)[3] = buffer_data(&b[2]), (*direction)[3] = buffer_data(&b[3]), (*probability)[2] = buffer_data(&b[4]);
    for (Py_ssize_t i = 0; i < rows[0]; i++) {
      light_sample s;
      probability[i][0] = lights_draw_start(scene->lights, scene, u[i], &s);
      const vec3 drawn = lights_draw_direction(scene->lights, &s, u[i] + 3);
      probability[i][1] = lights_direction_pdf(scene->lights, &s, drawn);
      which[i][0] = (int32_t)s.kind, which[i][1] = s.index, which[i][2] = s.kind == LIGHT_TRIANGLE ? s.triangle : -1;
      v3_to(place[i], s.target);
      v3_to(direction[i], drawn);
    }
    result = Py_NewRef(Py_None);
  }
  buffer_release_all(b, 5);
  return result;
}

/* The arrays of join(), in its order. */
enum { JOIN_POINTS, JOIN_ENDS, JOIN_U, JOIN_CHANCES, JOIN_COUNT, JOIN_WANTED, JOIN_LOST, JOIN_REST, JOIN_LAUNCH, JOIN_ARRIVAL, JOIN_SPREAD,
       JOIN_SWEPT, JOIN_FIRST_LENS, JOIN_BORDERS, JOIN_LENGTH, JOIN_CHANCE, JOIN_IMAGE_CHANCE, JOIN_WAY, JOIN_ARRAYS };
static const struct {
  const char *name;
  char format;
  int dimensions, flags;
} JOIN_KINDS[JOIN_ARRAYS] = {
    {"points", 'd', 2, BUFFER_FINITE}, {"ends", 'd', 2, BUFFER_FINITE}, {"u", 'd', 1, BUFFER_FINITE | BUFFER_OPTIONAL},
    {"way_chances", 'd', 2, BUFFER_FINITE | BUFFER_OPTIONAL}, {"count", 'i', 1, BUFFER_WRITE},
    {"wanted", 'i', 1, BUFFER_WRITE}, {"lost", 'i', 1, BUFFER_WRITE}, {"rest", 'd', 1, BUFFER_WRITE},
    {"launch", 'd', 3, BUFFER_WRITE}, {"arrival", 'd', 3, BUFFER_WRITE}, {"spread", 'd', 2, BUFFER_WRITE},
    {"swept", 'd', 2, BUFFER_WRITE}, {"first_lens", 'i', 2, BUFFER_WRITE}, {"borders", 'I', 2, BUFFER_WRITE},
    {"length", 'd', 2, BUFFER_WRITE}, {"chance", 'd', 2, BUFFER_WRITE}, {"image_chance", 'd', 2, BUFFER_WRITE},
    {"way", 'i', 2, BUFFER_WRITE}};

/* Joins n <= JOIN_BLOCK pairs from number `first`. */
enum { JOIN_BLOCK = 64 };
static void join_block(const bent_scene *scene, const buffer *b, size_t first, size_t n, int sky, int far)
{
  const double(*points)[3] = buffer_data(&b[JOIN_POINTS]), (*ends)[3] = buffer_data(&b[JOIN_ENDS]);
  const double *decisions = buffer_data(&b[JOIN_U]), *chances = buffer_data(&b[JOIN_CHANCES]);
  vec3 from[JOIN_BLOCK], to[JOIN_BLOCK];
  double u[JOIN_BLOCK];
  const double *tried[JOIN_BLOCK];
  joints found[JOIN_BLOCK];
  for (size_t i = 0; i < n; i++) {
    from[i] = v3_from(points[first + i]), to[i] = v3_from(ends[first + i]);
    /* without decisions: too small to leave out any, but different, for what is too much */
    u[i] = decisions ? decisions[first + i] : 1e-200 * (double)(first + i);
    tried[i] = chances ? chances + (first + i) * joint_ways(scene->geometry) : NULL;
  }
  join_by_chance(scene->geometry, n, from, to, u, tried, sky, far, found);
  for (size_t i = 0; i < n; i++) {
    ((int32_t *)buffer_data(&b[JOIN_COUNT]))[first + i] = found[i].count;
    ((int32_t *)buffer_data(&b[JOIN_WANTED]))[first + i] = found[i].wanted;
    ((int32_t *)buffer_data(&b[JOIN_LOST]))[first + i] = found[i].lost;
    ((double *)buffer_data(&b[JOIN_REST]))[first + i] = found[i].rest;
    for (int k = 0; k < found[i].count; k++) {
      const joint *j = &found[i].list[k];
      const size_t at = (first + i) * JOINTS_MAX + (size_t)k;
      v3_to(((double(*)[3])buffer_data(&b[JOIN_LAUNCH]))[at], j->launch);
      v3_to(((double(*)[3])buffer_data(&b[JOIN_ARRIVAL]))[at], j->arrival);
      ((double *)buffer_data(&b[JOIN_SPREAD]))[at] = j->spread;
      ((double *)buffer_data(&b[JOIN_SWEPT]))[at] = j->swept;
      ((int32_t *)buffer_data(&b[JOIN_FIRST_LENS]))[at] = j->first_lens;
      ((uint32_t *)buffer_data(&b[JOIN_BORDERS]))[at] = j->borders;
      ((double *)buffer_data(&b[JOIN_LENGTH]))[at] = sky ? INFINITY : join_length(scene->geometry, from[i], to[i], j);
      ((double *)buffer_data(&b[JOIN_CHANCE]))[at] = j->way_chance;
      ((double *)buffer_data(&b[JOIN_IMAGE_CHANCE]))[at] = j->chance;
      ((int32_t *)buffer_data(&b[JOIN_WAY]))[at] = (int32_t)joint_way(j);
    }
  }
}

/* _join(sky, far, the arrays of JOIN_KINDS) */
static PyObject *join(PyObject *self, PyObject *args)
{
  PyObject *in[JOIN_ARRAYS];
  int sky, far, bad = 0;
  if (!PyArg_ParseTuple(args, "ppOOOOOOOOOOOOOOOOOO:join", &sky, &far, &in[0], &in[1], &in[2], &in[3], &in[4], &in[5], &in[6],
                        &in[7], &in[8], &in[9], &in[10], &in[11], &in[12], &in[13], &in[14], &in[15], &in[16], &in[17]))
    return NULL;
  const bent_scene *scene = scene_value(self);
  if (!scene) return NULL;
  if (!scene->committed) return PyErr_SetString(PyExc_RuntimeError, "scene: has edits without a commit"), NULL;
  buffer b[JOIN_ARRAYS] = {0};
  Py_ssize_t n = -1;
  for (int i = 0; i < JOIN_ARRAYS && !bad; i++) {
    Py_ssize_t rows[2] = {n, 3}, many[3] = {n, JOINTS_MAX, 3};
    if (i == JOIN_CHANCES) rows[1] = (Py_ssize_t)joint_ways(scene->geometry);
    bad = buffer_get(&b[i], in[i], JOIN_KINDS[i].name, JOIN_KINDS[i].format, JOIN_KINDS[i].dimensions,
                     i < JOIN_LAUNCH ? rows : many, JOIN_KINDS[i].flags) < 0;
    if (i == 0) n = rows[0];
  }
  if (!bad) {
    Py_BEGIN_ALLOW_THREADS
    for (size_t first = 0; first < (size_t)n; first += JOIN_BLOCK)
      join_block(scene, b, first, (size_t)n - first < JOIN_BLOCK ? (size_t)n - first : JOIN_BLOCK, sky, far);
    Py_END_ALLOW_THREADS
  }
  buffer_release_all(b, JOIN_ARRAYS);
  return bad ? NULL : Py_NewRef(Py_None);
}

/* Whole-number fields of RenderSettings, in the order in which render_tile parses them. */
enum { WHOLE_FIELDS = 16 };

static int set_whole_fields(bent_render_settings *s, const long long whole[WHOLE_FIELDS], char *const names[])
{
  uint32_t *const fields[WHOLE_FIELDS] = {
      &s->width, &s->height, &s->first_sample, &s->sample_count, &s->seed, &s->min_samples, &s->max_bounces,
      &s->diffuse_bounces, &s->glossy_bounces, &s->transmission_bounces, &s->transparent_bounces, &s->roulette_start,
      &s->photon_ring_samples, &s->light_groups, &s->aovs, &s->matte_ranks};
  for (int i = 0; i < WHOLE_FIELDS; i++) {
    if (whole[i] < 0 || whole[i] > UINT32_MAX) {
      PyErr_Format(PyExc_ValueError, "%s: expected a number from 0 to 2^32 - 1, got %lld", names[i], whole[i]);
      return -1;
    }
    *fields[i] = (uint32_t)whole[i];
  }
  return 0;
}

static PyObject *render_tile(PyObject *self, PyObject *args, PyObject *keywords)
{
  /* All names after the fifth are RenderSettings' fields, which render.py passes by name. */
  static char *names[] = {"tile", "channels", "state", "light", "progress", "width", "height", "first_sample", "sample_count", "seed",
                          "min_samples", "max_bounces", "diffuse_bounces", "glossy_bounces", "transmission_bounces",
                          "transparent_bounces", "roulette_start", "photon_ring_samples",
                          "light_groups", "aovs", "matte_ranks", "tolerance", "filter",
                          "filter_width", "film_transparent", "clamp_indirect", "light_sampling", "alpha_threshold",
                          "noise_threshold", "light_threshold", "clamp_direct", "portal_sampling", "resume",
                          "blur_glossy", "caustics_reflective", "caustics_refractive", "integrator",
                          "sampling_pattern", "sky_filter", "mist_start", "mist_depth", "mist_falloff",
                          "occlusion_distance", NULL};
  bent_render_settings s = {0};
  long long tile[4], whole[WHOLE_FIELDS];
  PyObject *channels, *state_object, *light_object, *progress_object;
  const char *filter, *light_sampling, *integrator, *pattern;
  if (!PyArg_ParseTupleAndKeywords(
          args, keywords, "(LLLL)O!OOOLLLLLLLLLLLLLLLLdsdpdsddddppdppssddddd:render_tile", names, &tile[0], &tile[1], &tile[2],
          &tile[3], &PyDict_Type, &channels, &state_object, &light_object, &progress_object, &whole[0], &whole[1], &whole[2], &whole[3], &whole[4],
          &whole[5], &whole[6], &whole[7], &whole[8], &whole[9], &whole[10], &whole[11], &whole[12], &whole[13], &whole[14],
          &whole[15], &s.tolerance,
          &filter, &s.filter_width, &s.film_transparent, &s.clamp_indirect, &light_sampling, &s.alpha_threshold,
          &s.noise_threshold, &s.light_threshold, &s.clamp_direct, &s.portal_sampling, &s.resume,
          &s.blur_glossy, &s.caustics_reflective, &s.caustics_refractive, &integrator, &pattern, &s.sky_filter,
          &s.mist_start, &s.mist_depth, &s.mist_falloff, &s.occlusion_distance))
    return NULL;
  int ok;
  bent_progress *progress = progress_value(progress_object, &ok);
  const bent_scene *scene = scene_value(self);
  const int kind = filter_value(filter);
  const int sampling = kind < 0 ? -1 : choose(light_sampling, "light_sampling", LIGHT_SAMPLINGS, BENT_LIGHT_SAMPLINGS);
  const int way = sampling < 0 ? -1 : choose(integrator, "integrator", INTEGRATORS, BENT_INTEGRATORS);
  const int chosen = way < 0 ? -1 : choose(pattern, "sampling_pattern", PATTERNS, BENT_SAMPLING_PATTERNS);
  if (!ok || !scene || chosen < 0 || set_whole_fields(&s, whole, names + 5)) return NULL;
  s.integrator = (bent_integrator)way;
  s.filter = (bent_filter_kind)kind;
  s.light_sampling = (bent_light_sampling)sampling;
  s.sampling_pattern = (bent_sampling_pattern)chosen;
  for (int i = 0; i < 4; i++)
    if (tile[i] < 0 || tile[i] > INT32_MAX)
      return PyErr_Format(PyExc_ValueError, "tile: expected x, y, width, height from 0 to 2^31 - 1, got %lld", tile[i]);
  buffer buffers[BENT_CHANNELS_MAX] = {0}, state = {0}, light = {0};
  Py_ssize_t whole_image[] = {s.height, s.width, 3};
  float *arrays[BENT_CHANNELS_MAX] = {0};
  bent_render_statistics statistics = {0};
  PyObject *result = NULL;
  if (!channels_get(channels, tile[3], tile[2], &s, buffers, arrays) &&
      !state_get(&state, state_object, &s, tile[3], tile[2], arrays) &&
      (light_object == Py_None || !buffer_get(&light, light_object, "light", 'q', 3, whole_image, BUFFER_WRITE))) {
    bent_error error;
    bent_status status;
    Py_BEGIN_ALLOW_THREADS
    status = bent_scene_render_tile(scene, (uint32_t)tile[0], (uint32_t)tile[1], (uint32_t)tile[2], (uint32_t)tile[3],
                                    &s, arrays, buffer_data(&state), light_object == Py_None ? NULL : buffer_data(&light),
                                    &statistics, progress, &error);
    Py_END_ALLOW_THREADS
    result = status ? raise_error(&error)
                    : Py_BuildValue("{sKsKsKsKsKsK}", "samples", (unsigned long long)statistics.samples, "rays",
                                    (unsigned long long)statistics.rays, "unresolved",
                                    (unsigned long long)statistics.unresolved, "invalid",
                                    (unsigned long long)statistics.invalid, "joins",
                                    (unsigned long long)statistics.joins, "lost_joins",
                                    (unsigned long long)statistics.lost_joins);
  }
  buffer_release_all(buffers, BENT_CHANNELS_MAX);
  buffer_release(&state);
  buffer_release(&light);
  return result;
}

static PyObject *bidirectional_obstacle(PyObject *self, PyObject *unused)
{
  (void)unused;
  const bent_scene *scene = scene_value(self);
  if (!scene) return NULL;
  if (!scene->committed) return PyErr_SetString(PyExc_RuntimeError, "scene: has edits without a commit"), NULL;
  const char *obstacle = bent_scene_bidirectional_obstacle(scene);
  if (!obstacle) Py_RETURN_NONE;
  return PyUnicode_FromString(obstacle);
}

static PyObject *sobol_points(PyObject *module, PyObject *args)
{
  (void)module;
  unsigned seed, x, y, set, first;
  const char *pattern;
  PyObject *object;
  if (!PyArg_ParseTuple(args, "sIIIIIO:sobol_points", &pattern, &seed, &x, &y, &set, &first, &object)) return NULL;
  const int chosen = choose(pattern, "pattern", PATTERNS, BENT_SAMPLING_PATTERNS);
  Py_ssize_t shape[] = {-1, SAMPLER_DIMENSIONS};
  buffer out;
  if (chosen < 0 || buffer_get(&out, object, "out", 'd', 2, shape, BUFFER_WRITE)) return NULL;
  sampler s;
  sampler_init(&s, (bent_sampling_pattern)chosen);
  const sampler_pixel pixel = sampler_pixel_at(&s, seed, x, y);
  double(*points)[SAMPLER_DIMENSIONS] = buffer_data(&out);
  for (Py_ssize_t i = 0; i < shape[0]; i++) sampler_draw(&s, pixel, first + (uint32_t)i, set, points[i]);
  buffer_release(&out);
  Py_RETURN_NONE;
}

static PyObject *filter_offsets(PyObject *module, PyObject *args)
{
  (void)module;
  const char *name;
  double width;
  PyObject *object;
  if (!PyArg_ParseTuple(args, "sdO:filter_offsets", &name, &width, &object)) return NULL;
  const int kind = filter_value(name);
  Py_ssize_t shape[] = {-1};
  buffer values;
  if (kind < 0 || buffer_get(&values, object, "u", 'd', 1, shape, BUFFER_WRITE)) return NULL;
  pixel_filter filter;
  filter_init(&filter, (bent_filter_kind)kind, width);
  double *u = buffer_data(&values);
  for (Py_ssize_t i = 0; i < shape[0]; i++) u[i] = filter_offset(&filter, u[i]);
  buffer_release(&values);
  Py_RETURN_NONE;
}

/* The numpy-facing signatures and docstrings are in render.py. */
#define KEYWORDS(function) (PyCFunction)(void (*)(void))function, METH_VARARGS | METH_KEYWORDS
PyMethodDef scene_render_methods[] = {{"_set_camera", KEYWORDS(set_camera), NULL},
                                      {"_camera_rays", camera_rays, METH_VARARGS, NULL},
                                      {"_set_suns", set_suns, METH_VARARGS, NULL},
                                      {"_set_lamps", set_lamps, METH_VARARGS, NULL},
                                      {"_draw_lights", draw_lights, METH_VARARGS, NULL},
                                      {"_draw_light_starts", draw_light_starts, METH_VARARGS, NULL},
                                      {"_join", join, METH_VARARGS, NULL},
                                      {"bidirectional_obstacle", bidirectional_obstacle, METH_NOARGS,
                                       "bidirectional_obstacle() -> str | None\n\nWhy the integrator BIDIRECTIONAL "
                                       "renders this scene, which must be committed, as PATH does; None if it does not."},
                                      {"_render_tile", KEYWORDS(render_tile), NULL},
                                      {0}};
PyMethodDef render_functions[] = {
    {"sobol_points", sobol_points, METH_VARARGS,
     "sobol_points(pattern, seed, x, y, set, first, out)\n\nFills out, (n, 4) float64, with a pixel's samples from `first` on."},
    {"filter_offsets", filter_offsets, METH_VARARGS,
     "filter_offsets(kind, width, values)\n\nReplaces values, (n,) float64 in [0, 1), by offsets in pixels."},
    {0}};
