/* See suns.h. */
#include "render/suns.h"

#include <stdlib.h>

#include "scene/scene.h"

typedef struct disk {
  vec3 direction, radiance;
  double chord2; /* squared distance on the unit sphere from center to rim: precise for small suns, unlike a cosine */
  uint32_t visibility;
} disk;

struct suns {
  size_t count;
  disk disks[];
};

vec3 suns_radiance(const suns *suns, vec3 direction, uint32_t kind)
{
  vec3 sum = v3(0, 0, 0);
  for (size_t i = 0; suns && i < suns->count; i++) {
    const disk *d = &suns->disks[i];
    const vec3 chord = v3_sub(direction, d->direction);
    if ((d->visibility & kind) && v3_dot(chord, chord) <= d->chord2) sum = v3_add(sum, d->radiance);
  }
  return sum;
}

void suns_free(suns *suns) { free(suns); }

static bent_status make_disk(const bent_sun *sun, disk *out, bent_error *error)
{
  const vec3 direction = v3_from(sun->direction), radiance = v3_from(sun->radiance);
  if (!v3_is_finite(direction) || !(v3_length(direction) > 0) || !isfinite(v3_length(direction)))
    return bent_fail(error, BENT_ERROR_ARGUMENT, "sun: the direction must be finite and not 0");
  if (!v3_is_finite(radiance) || radiance.x < 0 || radiance.y < 0 || radiance.z < 0)
    return bent_fail(error, BENT_ERROR_ARGUMENT, "sun: the radiance must be finite and not negative");
  if (!(sun->angle > 0 && sun->angle <= M_PI))
    return bent_fail(error, BENT_ERROR_ARGUMENT, "sun: the angle must lie in (0, pi], got %g", sun->angle);
  const double chord = 2 * sin(sun->angle / 4);
  *out = (disk){v3_normalize(direction), radiance, chord * chord, sun->visibility};
  return BENT_OK;
}

bent_status bent_scene_set_suns(bent_scene *scene, size_t count, const bent_sun *given, bent_error *error)
{
  suns *made = calloc(1, sizeof *made + count * sizeof *made->disks);
  if (!made) return bent_fail(error, BENT_ERROR_MEMORY, "suns: out of memory");
  made->count = count;
  for (size_t i = 0; i < count; i++) {
    const bent_status status = make_disk(&given[i], &made->disks[i], error);
    if (status) return free(made), status;
  }
  suns_free(scene->suns);
  scene->suns = made;
  scene->committed = 0;
  return BENT_OK;
}
