/* See suns.h. */
#include "light/suns.h"

#include <stdlib.h>

#include "scene/scene.h"

int sun_covers(const sun *sun, vec3 direction) { return sun->solid_angle > 0 && cap_covers(&sun->disk, direction); }

void suns_free(suns *suns) { free(suns); }

static bent_status make_sun(const bent_sun *given, sun *out, bent_error *error)
{
  const vec3 direction = v3_from(given->direction), radiance = v3_from(given->radiance);
  if (!v3_is_finite(direction) || !(v3_length(direction) > 0) || !isfinite(v3_length(direction)))
    return bent_fail(error, BENT_ERROR_ARGUMENT, "sun: the direction must be finite and not 0");
  if (!v3_is_finite(radiance) || radiance.x < 0 || radiance.y < 0 || radiance.z < 0)
    return bent_fail(error, BENT_ERROR_ARGUMENT, "sun: the radiance must be finite and not negative");
  if (!(given->angle >= 0 && given->angle <= M_PI))
    return bent_fail(error, BENT_ERROR_ARGUMENT, "sun: the angle must lie in [0, pi], got %g", given->angle);
  const double chord = 2 * sin(given->angle / 4);
  const cap disk = {v3_normalize(direction), chord * chord};
  *out = (sun){disk, radiance, cap_solid_angle(&disk), given->visibility, given->influence};
  return BENT_OK;
}

bent_status bent_scene_set_suns(bent_scene *scene, size_t count, const bent_sun *given, bent_error *error)
{
  suns *made = calloc(1, sizeof *made + count * sizeof *made->list);
  if (!made) return bent_fail(error, BENT_ERROR_MEMORY, "suns: out of memory");
  made->count = count;
  for (size_t i = 0; i < count; i++) {
    const bent_status status = make_sun(&given[i], &made->list[i], error);
    if (status) return free(made), status;
  }
  suns_free(scene->suns);
  scene->suns = made;
  scene_edited(scene);
  return BENT_OK;
}
