/* The store of images, materials and the world, and their evaluation. */
#include "scene/shading.h"

#include <stdlib.h>
#include <string.h>

#include "scene/disk.h"
#include "scene/fresnel.h"
#include "scene/microfacet_energy.h"
#include "scene/program.h"
#include "scene/scene.h"
#include "scene/sky_levels.h"

struct shading {
  int image_count, material_count;
  image *images;
  program *materials;
  program world;
  int has_world;
  double gravitational; /* power to which the shift of frequency is raised */
};

bent_status shading_new(shading **out, bent_error *error)
{
  *out = calloc(1, sizeof **out);
  return *out ? BENT_OK : bent_fail(error, BENT_ERROR_MEMORY, "scene: out of memory");
}

void shading_free(shading *shading)
{
  if (!shading) return;
  for (int i = 0; i < shading->image_count; i++) image_free(&shading->images[i]);
  for (int i = 0; i < shading->material_count; i++) program_free(&shading->materials[i]);
  program_free(&shading->world);
  free(shading->images);
  free(shading->materials);
  free(shading);
}

/* Makes room for one more zeroed item of `size` bytes in *array. */
static bent_status grow(void **array, int count, size_t size, bent_error *error)
{
  char *larger = realloc(*array, (size_t)(count + 1) * size);
  if (!larger) return bent_fail(error, BENT_ERROR_MEMORY, "scene: out of memory");
  memset(larger + (size_t)count * size, 0, size);
  *array = larger;
  return BENT_OK;
}

bent_status bent_scene_add_image(bent_scene *scene, const bent_image *source, int *index, bent_error *error)
{
  shading *s = scene->shading;
  bent_status status = grow((void **)&s->images, s->image_count, sizeof *s->images, error);
  if (!status) status = image_make(&s->images[s->image_count], source, error);
  if (!status) *index = s->image_count++;
  return status;
}

bent_status bent_scene_update_image(bent_scene *scene, int index, const bent_image *source, bent_error *error)
{
  shading *s = scene->shading;
  if (index < 0 || index >= s->image_count)
    return bent_fail(error, BENT_ERROR_ARGUMENT, "update_image: no image %d", index);
  scene_edited(scene);
  scene->sky_valid = 0; /* the world may show it */
  const int is_sky = s->images[index].levels != NULL;
  const bent_status status = image_make(&s->images[index], source, error);
  return status || !is_sky ? status : sky_levels_new(&s->images[index], &s->images[index].levels, error);
}

bent_status bent_scene_add_material(bent_scene *scene, const bent_program *source, int *index, bent_error *error)
{
  shading *s = scene->shading;
  microfacet_energy_prepare();
  bent_status status = grow((void **)&s->materials, s->material_count, sizeof *s->materials, error);
  if (!status) status = program_make(&s->materials[s->material_count], source, s->image_count, error);
  if (!status) *index = s->material_count++;
  return status;
}

bent_status bent_scene_update_material(bent_scene *scene, int index, const bent_program *source, bent_error *error)
{
  shading *s = scene->shading;
  if (index < 0 || index >= s->material_count)
    return bent_fail(error, BENT_ERROR_ARGUMENT, "update_material: no material %d", index);
  scene_edited(scene);
  return program_make(&s->materials[index], source, s->image_count, error);
}

bent_status bent_scene_set_world(bent_scene *scene, const bent_program *source, bent_error *error)
{
  shading *s = scene->shading;
  scene_edited(scene);
  scene->sky_valid = 0;
  if (!source) {
    program_free(&s->world);
    s->has_world = 0;
    return BENT_OK;
  }
  bent_status status = program_make(&s->world, source, s->image_count, error);
  if (!status) s->has_world = 1;
  for (size_t at = 0; !status;) {
    const int index = program_next_sky_image(&s->world, &at);
    if (index < 0) break;
    if (!s->images[index].levels) status = sky_levels_new(&s->images[index], &s->images[index].levels, error);
  }
  return status;
}

bent_status bent_scene_set_gravitational(bent_scene *scene, double amount, bent_error *error)
{
  if (!(amount >= 0 && amount <= 1))
    return bent_fail(error, BENT_ERROR_ARGUMENT, "set_gravitational: the amount must lie in [0, 1], got %g", amount);
  scene_edited(scene);
  scene->shading->gravitational = amount;
  return BENT_OK;
}

int shading_shifts(const shading *shading) { return shading->gravitational > 0; }

vec3 shading_shifted(const shading *shading, vec3 light, const ray_history *ray)
{
  if (!shading_shifts(shading) || !(ray->frequency > 0)) return light;
  return v3_scale(light, shifted_brightness(pow(ray->frequency, shading->gravitational)));
}

static const program *material_program(const shading *shading, int material)
{
  return material >= 0 && material < shading->material_count ? &shading->materials[material] : NULL;
}

static void run(const shading *shading, const program *program, const shade_point *point, closure_set *out,
                int emission_only)
{
  program_context context = {.point = point, .images = shading->images, .set = out, .emission_only = emission_only};
  out->count = out->delta_count = 0;
  out->emission = out->holdout = v3(0, 0, 0);
  program_run(program, &context);
}

void shading_evaluate(const shading *shading, int material, const shade_point *point, closure_set *out)
{
  const program *program = material_program(shading, material);
  if (program) {
    run(shading, program, point, out, 0);
    if (!program->asks_frequency) out->emission = shading_shifted(shading, out->emission, &point->ray);
  } else { /* Blender's look of an object without a material */
    out->count = out->delta_count = 0;
    out->emission = out->holdout = v3(0, 0, 0);
    closure_add_diffuse(out, point, v3_splat(1), v3_splat(0.8), 0, point->normal);
  }
  closure_set_finish(out);
}

vec3 shading_emission(const shading *shading, int material, const shade_point *point)
{
  const program *program = material_program(shading, material);
  if (!program || !program->may_emit) return v3(0, 0, 0);
  closure_set set = {.closures = NULL};
  run(shading, program, point, &set, 1);
  return program->asks_frequency ? set.emission : shading_shifted(shading, set.emission, &point->ray);
}

const vec3 *shading_even_emission(const shading *shading, int material)
{
  static const vec3 dark = {0, 0, 0};
  const program *program = material_program(shading, material);
  if (!program) return &dark;
  return program->emits_evenly && !(program->may_emit && shading_shifts(shading)) ? &program->emission : NULL;
}

/* Light of the sky as its material gives it. */
static vec3 run_sky(const shading *shading, vec3 direction, const vec3 across[2], const ray_history *ray,
                    const aov_sink *aovs)
{
  if (!shading->has_world) return v3(0, 0, 0);
  const vec3 back = v3_scale(direction, -1);
  shade_point point = {.position = direction, .generated = direction, .wo = back, .geometric_normal = back,
                       .normal = back, .ray_length = SKY_LENGTH, .across_sky = across, .ray = *ray, .aovs = aovs};
  point.ray.bounces++; /* Cycles counts the sky as one further */
  closure_set set = {.closures = NULL};
  run(shading, &shading->world, &point, &set, 1);
  return set.emission;
}

vec3 shading_sky(const shading *shading, vec3 direction, const vec3 across[2], const ray_history *ray)
{
  return shading_shifted(shading, run_sky(shading, direction, across, ray, NULL), ray);
}

void shading_sky_aovs(const shading *shading, vec3 direction, const ray_history *ray, const aov_sink *aovs)
{
  run_sky(shading, direction, NULL, ray, aovs);
}

int shading_sky_has_levels(const shading *shading)
{
  size_t at = 0;
  return shading->has_world && program_next_sky_image(&shading->world, &at) >= 0;
}

int shading_may_be_transparent(const shading *shading, int material)
{
  const program *program = material_program(shading, material);
  return program && program->may_be_transparent;
}

int shading_may_emit(const shading *shading, int material)
{
  const program *program = material_program(shading, material);
  return program && program->may_emit;
}

int shading_asks_scattering(const shading *shading, int material)
{
  const program *program = material_program(shading, material);
  return program && program->asks_scattering;
}

int shading_asks_length(const shading *shading, int material)
{
  const program *program = material_program(shading, material);
  return program && program->asks_length;
}

int shading_asks_tangent(const shading *shading, int material)
{
  const program *program = material_program(shading, material);
  return program && program->asks_tangent;
}

int shading_asks_frequency(const shading *shading, int material)
{
  const program *program = material_program(shading, material);
  return (program && program->asks_frequency) || shading_shifts(shading);
}

int shading_any_asks_frequency(const shading *shading)
{
  for (int i = 0; i < shading->material_count; i++)
    if (shading->materials[i].asks_frequency) return 1;
  return shading_shifts(shading);
}

int shading_sky_asks_scattering(const shading *shading) { return shading->has_world && shading->world.asks_scattering; }

int shading_any_asks_scattering(const shading *shading)
{
  int any = shading_sky_asks_scattering(shading);
  for (int i = 0; i < shading->material_count; i++) any |= shading->materials[i].asks_scattering;
  return any;
}

int shading_any_asks_history(const shading *shading)
{
  for (int i = 0; i < shading->material_count; i++)
    if (shading->materials[i].asks_history) return 1;
  return 0;
}

int shading_lobe_max(const shading *shading)
{
  int most = 1;
  for (int i = 0; i < shading->material_count; i++)
    if (shading->materials[i].lobe_count > most) most = shading->materials[i].lobe_count;
  return most;
}
