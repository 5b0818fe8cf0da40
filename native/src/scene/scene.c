/* Life and commit of a scene; each part's work is done by its own folder. */
#include "scene/scene.h"

#include <stdlib.h>

#include "geometry/geometry.h"
#include "render/camera.h"
#include "render/suns.h"
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
  suns_free(scene->suns);
  shading_free(scene->shading);
  geometry_free(scene->geometry);
  free(scene);
}

bent_status bent_scene_commit(bent_scene *scene, bent_progress *progress, bent_error *error)
{
  const bent_status status = geometry_commit(scene->geometry, progress, error);
  scene->committed = !status;
  return status;
}
