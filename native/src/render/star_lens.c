/* See star_lens.h, and bentlight/stars.h for the cells of the lens. */
#include "render/star_lens.h"

#include <stdlib.h>
#include <string.h>

#include "render/aperture.h"
#include "render/star_rays.h"
#include "scene/scene.h"

static const double STEP = 1e-5; /* of the differences: radians, about, by which they turn a ray */
/* Cells along one side of the lens: as many as a blur's diameter has pixels, within these bounds. */
enum { CELLS_MIN = 8, CELLS_MAX = 24 };

void star_parallax(const camera *camera, vec3 launch, const vec3 turn[3], const double place[2], double out[2][2])
{
  const bent_camera *c = &camera->settings;
  const vec3 d = camera_from_world_direction(camera, launch);
  const double reach = aperture_reach(c, d), beside[2] = {1, 1};
  vec3 axes[2];
  aperture_axes(c, d, &axes[0], &axes[1]);
  for (int k = 0; k < 2; k++) {
    const vec3 a = axes[k];
    const vec3 turned = v3_mad(turn[0], a.x, v3_mad(turn[1], a.y, v3_scale(turn[2], a.z)));
    const double step = STEP / max2(1 / reach, v3_length(turned));
    /* The pinhole's ray that meets the one from aside where it is sharp. */
    const vec3 from_middle = v3_mad(v3_mad(turned, step, launch), reach, v3_scale(mat4_vector(&camera->world_from_camera, a), step));
    double places[CAMERA_PLACES_MAX][2], nearest = INFINITY;
    const int count = camera_places(camera, v3_normalize(from_middle), beside, places);
    out[0][k] = out[1][k] = 0;
    for (int i = 0; i < count; i++) {
      const double x = places[i][0] - place[0], y = places[i][1] - place[1];
      if (v2_length(x, y) < nearest) nearest = v2_length(x, y), out[0][k] = x / step, out[1][k] = y / step;
    }
  }
}

double star_blur(const camera *camera, uint32_t width, uint32_t height)
{
  const bent_aperture *lens = &camera->settings.aperture;
  const vec3 still[3] = {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
  double parallax[2][2];
  camera_ray middle;
  if (!(lens->radius > 0) || !camera_cast(camera, 0.5, 0.5, &middle)) return 0;
  star_parallax(camera, middle.direction, still, (const double[2]){0.5, 0.5}, parallax);
  const double across = v2_length(parallax[0][0] * width, parallax[1][0] * height) / lens->ratio;
  return lens->radius * max2(across, v2_length(parallax[0][1] * width, parallax[1][1] * height));
}

void bent_scene_star_cells(const bent_scene *scene, uint32_t width, uint32_t height, uint32_t cells[2])
{
  cells[0] = cells[1] = 0;
  if (!scene->camera || !(scene->camera->settings.aperture.radius > 0)) return;
  const double blur = 2 * star_blur(scene->camera, width, height);
  const uint32_t blades = scene->camera->settings.aperture.blades, side = (uint32_t)max2(CELLS_MIN, min2(ceil(blur), CELLS_MAX));
  cells[0] = blades < 3 ? side : blades * ((side + blades - 1) / blades); /* no cell has a corner of the lens within */
  cells[1] = side;
}

static void set_color(float out[3], vec3 color) { out[0] = (float)color.x, out[1] = (float)color.y, out[2] = (float)color.z; }

/* The ray through a cell's middle towards an image. Returns 0 if there is none. */
static int cell_ray(const star_tracer *t, const double place[2], const double parallax[2][2], const double u[2], star_ray *out)
{
  const camera *camera = t->tracer.scene->camera;
  double lens[2];
  camera_ray cast;
  aperture_draw(&camera->settings.aperture, u, lens);
  const double x = place[0] + parallax[0][0] * lens[0] + parallax[0][1] * lens[1];
  const double y = place[1] + parallax[1][0] * lens[0] + parallax[1][1] * lens[1];
  if (!camera_cast_lens(camera, x, y, lens, &cast) || !path_can_leave(&t->tracer, cast.origin)) return 0;
  *out = star_ray_of(t, &cast, cast.direction, STAR_SKY_ANY);
  return 1;
}

/* Cells under way: which they are, counted through all images, and their rays. */
typedef struct cell_batch {
  star_tracer *tracer;
  const uint32_t *cells;
  const double (*places)[2];
  const double (*parallax)[2][2];
  float (*seen)[3];
  int count;
  size_t which[STAR_RAYS_MAX];
  star_ray rays[STAR_RAYS_MAX];
} cell_batch;

static void add_cell(cell_batch *b, size_t image, size_t i, size_t j)
{
  const double u[2] = {((double)i + 0.5) / b->cells[0], ((double)j + 0.5) / b->cells[1]};
  const size_t at = (image * b->cells[0] + i) * b->cells[1] + j;
  set_color(b->seen[at], v3(0, 0, 0));
  b->which[b->count] = at;
  b->count += cell_ray(b->tracer, b->places[image], b->parallax[image], u, &b->rays[b->count]);
}

static bent_status trace_batch(cell_batch *b, bent_progress *progress, bent_error *error)
{
  const bent_status status = star_rays_trace(b->tracer, b->count, b->rays, progress, error);
  for (int i = 0; i < b->count && !status; i++)
    if (b->rays[i].arrived) set_color(b->seen[b->which[i]], b->rays[i].throughput);
  b->count = 0;
  return status;
}

/* Every third cell of each row and column tells whether an image is seen as well by all: then the others need no ray. */
static int is_telling(size_t i, size_t j) { return i % 3 == 1 && j % 3 == 1; }

/* Traces the cells of images that tell, or of mixed images the others. */
static bent_status trace_cells(cell_batch *b, size_t n, const uint8_t *mixed, bent_progress *progress, bent_error *error)
{
  bent_status status = BENT_OK;
  for (size_t image = 0; image < n && !status; image++)
    for (size_t i = 0; i < b->cells[0] && (!mixed || mixed[image]); i++)
      for (size_t j = 0; j < b->cells[1] && !status; j++)
        if (is_telling(i, j) == !mixed) {
          add_cell(b, image, i, j);
          if (b->count == STAR_RAYS_MAX) status = trace_batch(b, progress, error);
        }
  return status ? status : trace_batch(b, progress, error);
}

/* Gives all cells of an image what one that tells has seen; returns 1 if another has seen less. */
static int fill_image(const uint32_t cells[2], float (*seen)[3])
{
  float first[3];
  memcpy(first, seen[cells[1] + 1], sizeof first);
  for (size_t i = 0; i < cells[0]; i++)
    for (size_t j = 0; j < cells[1]; j++)
      if (is_telling(i, j) && memcmp(first, seen[i * cells[1] + j], sizeof first)) return 1;
  for (size_t cell = 0; cell < (size_t)cells[0] * cells[1]; cell++) memcpy(seen[cell], first, sizeof first);
  return 0;
}

bent_status bent_scene_trace_star_cells(const bent_scene *scene, size_t n, const double (*places)[2],
                                        const double (*parallax)[2][2], const bent_star_view *view,
                                        const uint32_t cells[2], float (*seen)[3], bent_progress *progress,
                                        bent_error *error)
{
  bent_status status = star_view_check(scene, view, error);
  if (status) return status;
  if (cells[0] < CELLS_MIN || cells[1] < CELLS_MIN)
    return bent_fail(error, BENT_ERROR_ARGUMENT, "stars: expected %d cells or more along both sides of an open lens, got %u x %u",
                     CELLS_MIN, cells[0], cells[1]);
  cell_batch *b = malloc(sizeof *b);
  uint8_t *mixed = malloc(n + 1);
  star_tracer *tracer = star_tracer_new(scene, view, error);
  if (!b || !mixed || !tracer) {
    status = bent_fail(error, BENT_ERROR_MEMORY, "stars: out of memory");
  } else {
    b->tracer = tracer, b->cells = cells, b->places = places, b->parallax = parallax, b->seen = seen, b->count = 0;
    status = trace_cells(b, n, NULL, progress, error);
    for (size_t i = 0; i < n && !status; i++) mixed[i] = (uint8_t)fill_image(cells, seen + i * cells[0] * cells[1]);
    if (!status) status = trace_cells(b, n, mixed, progress, error);
  }
  star_tracer_free(tracer);
  free(mixed);
  free(b);
  return status;
}

void bent_scene_star_lens(const bent_scene *scene, const uint32_t cells[2], double (*corners)[2])
{
  if (!scene->camera || !cells[0] || !cells[1]) return;
  const bent_aperture *lens = &scene->camera->settings.aperture;
  const double side = 2 * M_PI / (4 * cells[0]); /* of the polygon that the cells make of a disk: as large as that */
  const double grow = lens->blades < 3 ? sqrt(side / sin(side)) : 1;
  for (uint32_t i = 0; i <= cells[0]; i++)
    for (uint32_t j = 0; j <= cells[1]; j++) {
      const double u[2] = {(double)i / cells[0], (double)j / cells[1]};
      double *corner = corners[(size_t)i * (cells[1] + 1) + j];
      aperture_draw(lens, u, corner);
      corner[0] *= grow, corner[1] *= grow;
    }
}
