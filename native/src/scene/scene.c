/* Life and commit of a scene; each part's work is done by its own folder. */
#include "scene/scene.h"

#include <stdlib.h>

#include "render/camera.h"
#include "render/suns.h"
#include "scene/shading.h"

bent_status bent_scene_new(bent_scene **out, bent_error *error)
{
  *out = calloc(1, sizeof **out);
  if (!*out) return bent_fail(error, BENT_ERROR_MEMORY, "scene: out of memory");
  const bent_status status = shading_new(&(*out)->shading, error);
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
  free(scene);
}
