/* The C interface from C alone: life and death of every handle, refused arguments, and no leak.
 *
 * Built with AddressSanitizer, UndefinedBehaviorSanitizer and LeakSanitizer (`make test`); truth is the Python tests'
 * matter. Ends with exit code 0 and one closing line, or stops at the first failed check.
 */
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "bentlight.h"

static int checks;

static void check(int condition, const char *text, int line)
{
  checks++;
  if (condition) return;
  fprintf(stderr, "smoke.c:%d: %s\n", line, text);
  exit(1);
}
#define CHECK(condition) check(!!(condition), #condition, __LINE__)

/* A refusal has its status and says why. */
static int refused(bent_status got, bent_status wanted, bent_error *error)
{
  int right = got == wanted && error->status == wanted && error->message[0];
  memset(error, 0, sizeof *error);
  return right;
}

static void test_errors(void)
{
  bent_error error = {0};
  CHECK(bent_fail(NULL, BENT_ERROR_DATA, "nobody listens") == BENT_ERROR_DATA);
  /* Longer than the message holds: cut, terminated. */
  CHECK(refused(bent_fail(&error, BENT_ERROR_DATA, "%2000d", 7), BENT_ERROR_DATA, &error));
}

static void test_spacetimes(void)
{
  bent_error error = {0};
  bent_spacetime spacetime = bent_minkowski();
  const double far[3] = {10, 0, 0}, nowhere[3] = {NAN, 0, 0}, center[3] = {0, 0, 0};
  CHECK(spacetime.kind == BENT_MINKOWSKI);

  CHECK(bent_schwarzschild(1, BENT_CHART_ISOTROPIC, &spacetime, &error) == BENT_OK);
  CHECK(bent_spacetime_contains(&spacetime, far));
  CHECK(!bent_spacetime_contains(&spacetime, nowhere));
  CHECK(!bent_spacetime_contains(&spacetime, center));
  CHECK(refused(bent_schwarzschild(-1, BENT_CHART_AREAL, &spacetime, &error), BENT_ERROR_ARGUMENT, &error));
  CHECK(refused(bent_schwarzschild(NAN, BENT_CHART_AREAL, &spacetime, &error), BENT_ERROR_ARGUMENT, &error));
  CHECK(refused(bent_schwarzschild(1, BENT_CHART_OBLATE, &spacetime, &error), BENT_ERROR_ARGUMENT, &error));

  CHECK(bent_kerr(1, 0.9, &spacetime, &error) == BENT_OK);
  CHECK(refused(bent_kerr(1, 1, &spacetime, &error), BENT_ERROR_ARGUMENT, &error));
  CHECK(refused(bent_kerr(INFINITY, 0, &spacetime, &error), BENT_ERROR_ARGUMENT, &error));

  CHECK(bent_ellis(1, &spacetime, &error) == BENT_OK);
  CHECK(refused(bent_ellis(0, &spacetime, &error), BENT_ERROR_ARGUMENT, &error));
}

static void test_rays(void)
{
  enum { COUNT = 37 }; /* not a whole number of lanes */
  bent_error error = {0};
  bent_spacetime hole;
  CHECK(bent_kerr(1, 0.9, &hole, &error) == BENT_OK);
  double origins[COUNT][3], directions[COUNT][3];
  for (int i = 0; i < COUNT; i++) {
    memcpy(origins[i], (double[3]){30, 0, 0.5}, sizeof origins[i]);
    memcpy(directions[i], (double[3]){-1, 0.02 * (i - COUNT / 2), 0}, sizeof directions[i]);
  }
  uint8_t fate[COUNT];
  double asymptotic[COUNT][3];
  const bent_trace_result fates = {.fate = fate}, all = {.fate = fate, .direction = asymptotic};
  CHECK(bent_trace_rays(&hole, COUNT, origins, directions, 1e-8, BENT_ROUTE_AUTO, &fates, NULL, &error) == BENT_OK);
  CHECK(fate[COUNT / 2] == BENT_CAPTURED);
  CHECK(fate[0] == BENT_ESCAPED);
  CHECK(bent_trace_rays(&hole, COUNT, origins, directions, 1e-8, BENT_ROUTE_TAYLOR, &all, NULL, &error) == BENT_OK);
  CHECK(isnan(asymptotic[COUNT / 2][0]));
  CHECK(bent_trace_rays(&hole, 0, NULL, NULL, 1e-8, BENT_ROUTE_AUTO, &all, NULL, &error) == BENT_OK);

  bent_progress stopped = {0};
  atomic_store(&stopped.cancel, 1);
  CHECK(bent_trace_rays(&hole, COUNT, origins, directions, 1e-8, BENT_ROUTE_AUTO, &all, &stopped, &error) ==
        BENT_CANCELLED);
  CHECK(refused(bent_trace_rays(&hole, COUNT, origins, directions, 0, BENT_ROUTE_AUTO, &all, NULL, &error),
                BENT_ERROR_ARGUMENT, &error));
  directions[3][1] = NAN;
  CHECK(refused(bent_trace_rays(&hole, COUNT, origins, directions, 1e-8, BENT_ROUTE_AUTO, &all, NULL, &error),
                BENT_ERROR_ARGUMENT, &error));
}

static const float CORNERS[4][3] = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
static const uint32_t TRIANGLES[2][3] = {{0, 1, 2}, {0, 2, 3}};

/* A square below the origin, facing up; with `hole` a black hole between the two. */
static bent_scene *square_scene(int hole)
{
  bent_error error = {0};
  bent_scene *scene = NULL;
  int mesh = -1, instance = -1;
  CHECK(bent_scene_new(&scene, &error) == BENT_OK);
  const bent_mesh square = {.vertex_count = 4, .triangle_count = 2, .vertices = CORNERS, .triangles = TRIANGLES};
  CHECK(bent_scene_add_mesh(scene, &square, &mesh, &error) == BENT_OK);
  const bent_instance placed = {.mesh = mesh, .world_from_mesh = {{5, 0, 0, 0}, {0, 5, 0, 0}, {0, 0, 1, -5}, {0, 0, 0, 1}},
                                .visibility = BENT_VISIBLE_ALL, .influence = BENT_INFLUENCE_ALL};
  CHECK(bent_scene_add_instance(scene, &placed, &instance, &error) == BENT_OK);
  if (hole) {
    bent_spacetime_object object = {.world_from_spacetime = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, -2}, {0, 0, 0, 1}},
                                    .sphere_radius = INFINITY, .exit = -1};
    CHECK(bent_schwarzschild(0.1, BENT_CHART_ISOTROPIC, &object.spacetime, &error) == BENT_OK);
    CHECK(bent_scene_set_spacetimes(scene, 1, &object, &error) == BENT_OK);
  }
  return scene;
}

static bent_ray ray_down(double x)
{
  return (bent_ray){.origin = {x, 0, 0}, .direction = {0, 0, -1}, .tolerance = 1e-4, .angular_tolerance = 1e-6,
                    .length_max = INFINITY, .source_instance = -1, .source_triangle = -1,
                    .visibility = BENT_VISIBLE_ALL};
}

static void test_scene(int hole)
{
  bent_error error = {0};
  bent_scene *scene = square_scene(hole);
  const bent_ray rays[] = {ray_down(0), ray_down(2), ray_down(100)};
  bent_hit hits[3];
  CHECK(refused(bent_scene_intersect(scene, 3, rays, hits, NULL, &error), BENT_ERROR_STATE, &error));
  CHECK(bent_scene_commit(scene, NULL, &error) == BENT_OK);
  CHECK(bent_scene_intersect(scene, 3, rays, hits, NULL, &error) == BENT_OK);
  CHECK(hits[0].fate == (hole ? BENT_CAPTURED : BENT_HIT));
  CHECK(hits[1].fate == BENT_HIT && fabs(hits[1].position[2] + 5) <= 1e-4);
  CHECK(hits[2].fate == BENT_ESCAPED && hits[2].instance == -1);

  /* Edits: moved vertices, refused ones, a second commit. */
  float moved[4][3];
  memcpy(moved, CORNERS, sizeof moved);
  for (int i = 0; i < 4; i++) moved[i][2] = 1;
  const bent_mesh raised = {.vertex_count = 4, .triangle_count = 2, .vertices = moved, .triangles = TRIANGLES};
  CHECK(bent_scene_update_mesh(scene, 0, &raised, &error) == BENT_OK);
  CHECK(refused(bent_scene_update_mesh(scene, 7, &raised, &error), BENT_ERROR_ARGUMENT, &error));
  CHECK(bent_scene_commit(scene, NULL, &error) == BENT_OK);
  CHECK(bent_scene_intersect(scene, 3, rays, hits, NULL, &error) == BENT_OK);
  CHECK(hits[1].fate == BENT_HIT && fabs(hits[1].position[2] + 4) <= 1e-4);

  const uint32_t outside[1][3] = {{0, 1, 4}};
  const bent_mesh broken = {.vertex_count = 4, .triangle_count = 1, .vertices = CORNERS, .triangles = outside};
  int index;
  CHECK(refused(bent_scene_add_mesh(scene, &broken, &index, &error), BENT_ERROR_ARGUMENT, &error));
  const bent_instance stray = {.mesh = 9, .visibility = BENT_VISIBLE_ALL};
  CHECK(refused(bent_scene_add_instance(scene, &stray, &index, &error), BENT_ERROR_ARGUMENT, &error));
  bent_scene_free(scene);
  bent_scene_free(NULL);
}

static int opcode(const char *name)
{
  for (int i = 0; bent_opcode_info(i); i++)
    if (!strcmp(bent_opcode_info(i)->name, name)) return i;
  CHECK(!"an operation of this name");
  return -1;
}

/* Emission of radiance 1 as the world; refused edits leave it. */
static void light_up(bent_scene *scene)
{
  bent_error error = {0};
  const double constants[2][3] = {{1, 1, 1}, {NAN, 0, 0}};
  const int32_t emit[] = {opcode("emission"), 0, -1, -1, -1};
  const bent_program white = {.code_length = 5, .code = emit, .constant_count = 1, .constants = constants};
  CHECK(bent_scene_set_world(scene, &white, &error) == BENT_OK);

  const bent_program cut = {.code_length = 3, .code = emit, .constant_count = 1, .constants = constants};
  CHECK(refused(bent_scene_set_world(scene, &cut, &error), BENT_ERROR_ARGUMENT, &error));
  const int32_t unknown[] = {9999, 0};
  const bent_program alien = {.code_length = 2, .code = unknown};
  int index;
  CHECK(refused(bent_scene_add_material(scene, &alien, &index, &error), BENT_ERROR_ARGUMENT, &error));

  const uint8_t bytes[4][4] = {{255, 0, 0, 255}, {0, 255, 0, 255}, {0, 0, 255, 255}, {9, 9, 9, 0}};
  const bent_image image = {.width = 2, .height = 2, .bytes = bytes, .srgb = 1}, none = {.width = 2, .height = 2};
  CHECK(bent_scene_add_image(scene, &image, &index, &error) == BENT_OK);
  CHECK(refused(bent_scene_add_image(scene, &none, &index, &error), BENT_ERROR_ARGUMENT, &error));
}

enum { WIDTH = 16, HEIGHT = 12 };
typedef struct half_render {
  const bent_scene *scene;
  const bent_render_settings *settings;
  float combined[HEIGHT][WIDTH / 2][4];
  bent_render_statistics statistics;
  bent_progress progress;
  bent_status status;
  int right;
} half_render;

static void *render_half(void *argument)
{
  half_render *half = argument;
  float *channels[BENT_CHANNELS_MAX] = {0};
  size_t count;
  const bent_channel *table = bent_render_channels(&count);
  for (size_t i = 0; i < count; i++)
    if (!strcmp(table[i].name, "combined")) channels[i] = &half->combined[0][0][0];
  half->status = bent_scene_render_tile(half->scene, half->right ? WIDTH / 2 : 0, 0, WIDTH / 2, HEIGHT, half->settings,
                                        channels, NULL, NULL, &half->statistics, &half->progress, NULL);
  return NULL;
}

/* Two threads render the halves of an even white sky behind a hole: 1 where a ray escapes, 0 where it is captured. */
static void test_render(void)
{
  bent_error error = {0};
  bent_scene *scene = square_scene(1);
  CHECK(bent_scene_clear_instances(scene, &error) == BENT_OK);
  light_up(scene);
  const bent_camera camera = {.kind = BENT_CAMERA_PERSPECTIVE, .world_from_camera = {{1, 0, 0, 0}, {0, 1, 0, 0},
                              {0, 0, 1, 0}, {0, 0, 0, 1}}, .viewplane = {-1, 1, -0.75, 0.75}, .clip_start = 0.1,
                              .clip_end = 1000};
  CHECK(bent_scene_set_camera(scene, &camera, &error) == BENT_OK);
  CHECK(bent_scene_commit(scene, NULL, &error) == BENT_OK);

  bent_render_settings settings = {.width = WIDTH, .height = HEIGHT, .sample_count = 4, .max_bounces = 4,
                                   .diffuse_bounces = 4, .noise_threshold = 0.01, .min_samples = 2,
                                   .photon_ring_samples = 4, .roulette_start = 3, .tolerance = 1e-4, .filter_width = 3};
  half_render halves[2] = {{.scene = scene, .settings = &settings}, {.scene = scene, .settings = &settings, .right = 1}};
  pthread_t threads[2];
  for (int i = 0; i < 2; i++) CHECK(!pthread_create(&threads[i], NULL, render_half, &halves[i]));
  for (int i = 0; i < 2; i++) CHECK(!pthread_join(threads[i], NULL) && halves[i].status == BENT_OK);
  CHECK(fabsf(halves[0].combined[0][0][0] - 1) < 1e-5f);
  CHECK(halves[0].combined[HEIGHT / 2][WIDTH / 2 - 1][1] < 0.9f);
  CHECK(halves[1].combined[HEIGHT / 2][0][1] < 0.9f);

  atomic_store(&halves[0].progress.cancel, 1);
  render_half(&halves[0]);
  CHECK(halves[0].status == BENT_CANCELLED);
  settings.width = 0;
  atomic_store(&halves[0].progress.cancel, 0);
  render_half(&halves[0]);
  CHECK(halves[0].status == BENT_ERROR_ARGUMENT);
  bent_scene_free(scene);
}

/* Motion is copied, replaced and taken away; its views are not. */
static void test_motion(void)
{
  bent_error error = {0};
  bent_scene *scene = square_scene(1), *view = square_scene(1);
  const bent_camera camera = {.kind = BENT_CAMERA_PERSPECTIVE, .world_from_camera = {{1, 0, 0, 0}, {0, 1, 0, 0},
                              {0, 0, 1, 0}, {0, 0, 0, 1}}, .viewplane = {-1, 1, -1, 1}, .clip_end = 1000};
  const double places[2][4][4] = {{{5, 0, 0, 0}, {0, 5, 0, 0}, {0, 0, 1, -4}, {0, 0, 0, 1}}}; /* one too many */
  const float(*const vertices[1])[3] = {CORNERS};
  const bent_moment moment = {view, 2, 1, places, vertices}, bare = {.view = view};
  const bent_moment moments[] = {moment, bare};
  CHECK(refused(bent_scene_set_motion(scene, moments, &error), BENT_ERROR_STATE, &error));
  for (int i = 0; i < 2; i++) {
    CHECK(bent_scene_set_camera(i ? view : scene, &camera, &error) == BENT_OK);
    CHECK(bent_scene_commit(i ? view : scene, NULL, &error) == BENT_OK);
  }
  float vectors[HEIGHT * WIDTH][4], *channels[BENT_CHANNELS_MAX] = {0};
  size_t count;
  const bent_channel *table = bent_render_channels(&count);
  for (size_t i = 0; i < count; i++)
    if (!strcmp(table[i].name, "vector")) channels[i] = vectors[0];
  const bent_render_settings settings = {.width = WIDTH, .height = HEIGHT, .sample_count = 5, .min_samples = 2,
                                         .photon_ring_samples = 2, .tolerance = 1e-4, .filter_width = 1};
  for (int round = 0; round < 3; round++) {
    bent_render_statistics statistics;
    CHECK(bent_scene_set_motion(scene, round < 2 ? moments : NULL, &error) == BENT_OK);
    CHECK(bent_scene_render_tile(scene, 0, 0, WIDTH, HEIGHT, &settings, channels, NULL, NULL, &statistics, NULL, &error) ==
          BENT_OK);
    CHECK((vectors[0][1] != 0) == (round < 2));
  }
  CHECK(bent_scene_set_motion(scene, moments, &error) == BENT_OK);
  bent_scene_free(view);
  bent_scene_free(scene);
}

/* usage: bentlight_smoke [Embree's library] */
static void test_tables(void)
{
  bent_error error = {0};
  bent_table *table = NULL;
  bent_table_error measured;
  const bent_spacetime flat = bent_minkowski();
  CHECK(refused(bent_table_new(&flat, &table, &error), BENT_ERROR_ARGUMENT, &error));
  bent_table_free(NULL);
  bent_spacetime kinds[2];
  CHECK(bent_schwarzschild(1, BENT_CHART_ISOTROPIC, &kinds[0], &error) == BENT_OK);
  CHECK(bent_ellis(1, &kinds[1], &error) == BENT_OK);
  for (int k = 0; k < 2; k++) {
    CHECK(bent_table_new(&kinds[k], &table, &error) == BENT_OK);
    CHECK(refused(bent_table_measured(table, &measured, &error), BENT_ERROR_STATE, &error));
    CHECK(refused(bent_table_build(table, 1, 0, NULL, &error), BENT_ERROR_ARGUMENT, &error));
    CHECK(bent_table_build(table, 0, bent_table_rows(table), NULL, &error) == BENT_OK);
    CHECK(bent_table_measured(table, &measured, &error) == BENT_OK);
    const double delta = 1e-3;
    double angle;
    bent_table_total(table, 1, &delta, &angle);
    CHECK(angle > 3.2);
    const double origin[1][3] = {{10, 0, 0}}, direction[1][3] = {{-1, 0.9, 0}};
    uint8_t fate;
    bent_table_trace(table, 1, origin, direction, &(bent_trace_result){.fate = &fate});
    CHECK(fate == BENT_ESCAPED);
    bent_table_free(table);

    bent_sphere *sphere = NULL;
    CHECK(refused(bent_sphere_new(&kinds[k], 0.6, &sphere, &error), BENT_ERROR_ARGUMENT, &error));
    bent_sphere_free(NULL);
    CHECK(bent_sphere_new(&kinds[k], 10, &sphere, &error) == BENT_OK);
    double exit[1][3], outgoing[1][3], swept, length, ray_error;
    const bent_crossing crossing = {&fate, exit, outgoing, &swept, &length, &ray_error};
    bent_sphere_cross(sphere, 1, origin, direction, &crossing);
    CHECK(fate == BENT_ESCAPED && isfinite(exit[0][0]) && isfinite(outgoing[0][0]) && length > 10);
    bent_sphere_free(sphere);
  }
}

/* Equal holes share what their spheres are crossed by, whatever the order in which they come and go. */
static void test_shared_spheres(void)
{
  bent_error error = {0};
  bent_scene *scene = NULL;
  CHECK(bent_scene_new(&scene, &error) == BENT_OK);
  const double masses[][4] = {{0.1, 0.1, 0.2, 0.1}, {0.2, 0.1, 0.1, 0.2}, {0.1, 0.1, 0.1, 0.1}};
  for (int round = 0; round < 3; round++) {
    bent_spacetime_object objects[4];
    for (int i = 0; i < 4; i++) {
      objects[i] = (bent_spacetime_object){.sphere_radius = 2, .exit = -1};
      CHECK(bent_schwarzschild(masses[round][i], BENT_CHART_ISOTROPIC, &objects[i].spacetime, &error) == BENT_OK);
      for (int k = 0; k < 4; k++) objects[i].world_from_spacetime[k][k] = 1;
      objects[i].world_from_spacetime[0][3] = 5 * i;
    }
    CHECK(bent_scene_set_spacetimes(scene, 4, objects, &error) == BENT_OK);
    CHECK(bent_scene_commit(scene, NULL, &error) == BENT_OK);
    const bent_ray ray = {.origin = {-5, 0.5, 0}, .direction = {1, 0, 0}, .tolerance = 1e-6, .angular_tolerance = 1e-6,
                          .length_max = INFINITY, .source_instance = -1, .source_triangle = -1,
                          .visibility = BENT_VISIBLE_ALL};
    bent_hit hit;
    CHECK(bent_scene_intersect(scene, 1, &ray, &hit, NULL, &error) == BENT_OK);
    CHECK(hit.fate != BENT_UNRESOLVED && hit.swept > 1);
  }
  bent_scene_free(scene);
}

int main(int argc, char **argv)
{
  bent_error error = {0};
  if (argc > 1) CHECK(bent_embree_load(1, (const char *const[]){argv[1]}, &error) == BENT_OK);
  test_scene(0);
  test_scene(1);
  test_render();
  test_motion();
  test_errors();
  test_spacetimes();
  test_rays();
  test_tables();
  test_shared_spheres();
  printf("smoke: %d checks passed\n", checks);
  return 0;
}
