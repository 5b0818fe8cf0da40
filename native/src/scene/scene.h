/* The inside of a bent_scene: one part per topic, each owned by the folder that understands it. */
#ifndef BENT_SCENE_SCENE_H
#define BENT_SCENE_SCENE_H
#include "bentlight/scene.h"

typedef struct geometry geometry;     /* meshes, instances, spacetime objects and Embree: geometry/geometry.h */
typedef struct shading shading;       /* images, materials, world program: scene/shading.h */
typedef struct camera camera;         /* render/camera.h */
typedef struct suns suns;             /* render/suns.h */

struct bent_scene {
  geometry *geometry;
  shading *shading;
  camera *camera;
  suns *suns;
  int committed;
};
#endif
