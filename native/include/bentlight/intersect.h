/* The nearest surface along each curved ray. */
#ifndef BENTLIGHT_INTERSECT_H
#define BENTLIGHT_INTERSECT_H
#include "bentlight/scene.h"
#include "bentlight/trace.h"

typedef struct bent_ray {
  double origin[3];          /* world */
  double direction[3];       /* local unit direction, world axes */
  double tolerance;          /* largest distance of the reported hit from the true ray, world units */
  double angular_tolerance;  /* wanted error of the ray's direction, radians */
  double length_min, length_max; /* only hits in this range of scene length along the ray count; 0 and INFINITY */
  int32_t source_instance, source_triangle; /* the surface that the ray leaves, or -1: never hit again at length 0 */
  uint32_t visibility;       /* bent_visibility bits an instance must share to be seen; BENT_VISIBLE_ALL */
} bent_ray;

typedef struct bent_hit {
  uint8_t fate;             /* bent_fate */
  int32_t instance, triangle; /* -1 unless fate is BENT_HIT */
  double barycentric[2];    /* weights of the triangle's vertices 1 and 2 */
  double position[3];       /* world; NaN unless hit */
  double direction[3];      /* local unit direction of travel at the hit, world axes; asymptotic direction if escaped */
  double length;            /* scene length travelled (world units, measured along the drawn curve); INFINITY if
                             * escaped */
  double swept;             /* angle swept about spacetime objects, radians */
  double error;             /* estimated angular error of direction, radians */
  int32_t first_lens;       /* spacetime object whose sphere it started in, or entered first; -1: none */
  uint32_t borders;         /* spheres entered and left, and throats gone through to another mouth, on the way */
  int32_t sky;              /* if escaped: -1 the scene's own sky, else the wormhole object whose far sky it is */
} bent_hit;

/* rays and hits: n entries. The scene must be committed. Deterministic: a ray's answer depends on that ray alone. A ray
 * that starts inside a horizon is an error, unless it leaves a surface there (rounding can put a hit just inside, and
 * meshes may reach in): that one is captured. */
bent_status bent_scene_intersect(const bent_scene *scene, size_t n, const bent_ray *rays, bent_hit *hits,
                                 bent_progress *progress, bent_error *error);
#endif
