/* A scene's motion (bentlight/motion.h), looked up. */
#ifndef BENT_SCENE_MOTION_H
#define BENT_SCENE_MOTION_H
#include "base/vec3.h"
#include "bentlight/motion.h"

enum { MOMENTS = 2 }; /* before, after */

typedef struct moment {
  const bent_scene *view;
  size_t instance_count, mesh_count;
  mat4 *world_from_mesh;
  float (**vertices)[3]; /* NULL for those that are the same */
} moment;

typedef struct motion {
  moment moments[MOMENTS];
} motion;

/* Where the place on a triangle, which is at the world `position` now, is in a moment. A place that does not move stays what it
 * is to the last bit. */
vec3 moment_place(const moment *moment, const bent_scene *scene, int instance, int triangle, const double barycentric[2],
                  vec3 position);
/* Whether the camera, and all that bends light, is in a moment as it is now. */
int moment_view_stands(const moment *moment, const bent_scene *scene);
void motion_free(motion *motion);
#endif
