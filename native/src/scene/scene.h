/* The inside of a bent_scene: one part per topic, each owned by the folder that understands it. */
#ifndef BENT_SCENE_SCENE_H
#define BENT_SCENE_SCENE_H
#include "bentlight/scene.h"

typedef struct geometry geometry;     /* meshes, instances, spacetime objects and Embree: geometry/geometry.h */
typedef struct shading shading;       /* images, materials, world program: scene/shading.h */
typedef struct camera camera;         /* render/camera.h */
typedef struct suns suns;             /* light/suns.h */
typedef struct lamps lamps;           /* light/lamps.h */
typedef struct portals portals;       /* what is known of wormholes' throats, made by commit: render/portal.h */
typedef struct labels labels;         /* scene/labels.h */
typedef struct motion motion;         /* scene/motion.h */
typedef struct lights lights;         /* all that shines, made by commit: light/lights.h */

struct bent_scene {
  geometry *geometry;
  shading *shading;
  camera *camera;
  suns *suns;   /* NULL: none, as the lamps */
  lamps *lamps;
  labels *labels; /* NULL: none */
  motion *motion; /* NULL: none */
  lights *lights; /* NULL before the first commit */
  portals *portals; /* NULL without wormholes */
  int committed;
  int lights_valid; /* nothing that shines, or where it stands, has changed since they were made */
  int sky_valid;    /* nor has the world */
};

/* Marks a scene that takes a commit for more than its camera. */
static inline void scene_edited(bent_scene *scene) { scene->committed = scene->lights_valid = 0; }
#endif
