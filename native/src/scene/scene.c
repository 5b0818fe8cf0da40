/* Life and commit of a scene; each part's work is done by its own folder. */
#include "scene/scene.h"

#include <stdlib.h>

#include "geometry/geometry.h"
#include "render/camera.h"
#include "light/lights.h"
#include "render/portal.h"
#include "scene/labels.h"
#include "scene/motion.h"
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
  portals_free(scene->portals);
  lights_free(scene->lights);
  lamps_free(scene->lamps);
  suns_free(scene->suns);
  labels_free(scene->labels);
  motion_free(scene->motion);
  shading_free(scene->shading);
  geometry_free(scene->geometry);
  free(scene);
}

/* What commit makes of the scene's light. */
static bent_status commit_light(bent_scene *scene, bent_progress *progress, bent_error *error)
{
  lights *lights;
  bent_status status = lights_new(scene, &lights, error);
  if (status) return status;
  lights_free(scene->lights);
  portals_free(scene->portals);
  scene->lights = lights;
  scene->sky_valid = 1;
  scene->portals = NULL;
  scene->committed = 1; /* as far as rays are concerned */
  status = portals_new(scene, &scene->portals, progress, error);
  scene->lights_valid = !status;
  return status;
}

bent_status bent_scene_commit(bent_scene *scene, bent_progress *progress, bent_error *error)
{
  bent_status status = geometry_commit(scene->geometry, progress, error);
  if (!status && !scene->lights_valid) status = commit_light(scene, progress, error);
  scene->committed = !status;
  return status;
}
