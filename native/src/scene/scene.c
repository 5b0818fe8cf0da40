/* Life and commit of a scene; each part's work is done by its own folder. */
#include "scene/scene.h"

#include <stdlib.h>

#include "geometry/geometry.h"
#include "render/camera.h"
#include "light/lights.h"
#include "scene/shading.h"

bent_status bent_scene_new(bent_scene **out, bent_error *error)
{
  *out = calloc(1, sizeof **out);
  if (!*out) return bent_fail(error, BENT_ERROR_MEMORY, "scene: out of memory");
  bent_status status = geometry_new(&(*out)->geometry, error);
  if (!status) status = shading_new(&(*out)->shading, error);
  if (status) {
    bent_scene_free(*out);
    *out = NULL;
  }
  return status;
}

void bent_scene_free(bent_scene *scene)
{
  if (!scene) return;
  camera_free(scene->camera);
  lights_free(scene->lights);
  lamps_free(scene->lamps);
  suns_free(scene->suns);
  shading_free(scene->shading);
  geometry_free(scene->geometry);
  free(scene);
}

bent_status bent_scene_commit(bent_scene *scene, bent_progress *progress, bent_error *error)
{
  bent_status status = geometry_commit(scene->geometry, progress, error);
  if (!status && !scene->lights_valid) {
    lights *lights;
    status = lights_new(scene, &lights, error);
    if (!status) {
      lights_free(scene->lights);
      scene->lights = lights;
      scene->lights_valid = 1;
    }
  }
  scene->committed = !status;
  return status;
}
