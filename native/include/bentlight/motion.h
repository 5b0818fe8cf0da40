/* Where things were in the frame before, and will be in the next: what the channel `vector` is told from. */
#ifndef BENTLIGHT_MOTION_H
#define BENTLIGHT_MOTION_H
#include "bentlight/scene.h"

/* Another moment of a scene. What is missing, as instances and meshes beyond the counts, is as in the scene itself. */
typedef struct bent_moment {
  /* The camera and the spacetime objects of the moment: a committed scene, of which nothing else matters. It is not copied,
   * and must live, without edits, while the other is rendered. */
  const bent_scene *view;
  size_t instance_count, mesh_count;
  const double (*world_from_mesh)[4][4]; /* of instances, in the order in which they were added */
  const float (*const *vertices)[3]; /* of meshes, likewise: as many as the mesh has, or NULL for the same */
} bent_moment;

/* Sets both moments, the one before and the one after; NULL: none, and the channel `vector` is 0. Copies what it is given but
 * for the views. Visible at once: not while the scene is being rendered. */
bent_status bent_scene_set_motion(bent_scene *scene, const bent_moment moments[2], bent_error *error);
#endif
