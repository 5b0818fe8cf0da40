/* All rays that join two places of a scene, or a place and a direction of the sky, as far as they are known in closed
 * form: the straight one where space is flat, the images of a lone hole or wormhole (bentlight/connect.h).
 * Where several spheres bend space, a straight line that meets none of them. Rays that are not listed are found by
 * scattering alone. Lengths in world units, directions local in world axes. */
#ifndef BENT_LIGHT_JOIN_H
#define BENT_LIGHT_JOIN_H
#include "geometry/geometry.h"

enum { JOINTS_MAX = 4 };
/* Images fainter than this share of those before them are not listed. */
#define JOINT_SHARE_MIN 1e-4

typedef struct joint {
  vec3 launch, arrival; /* of the ray from the first place */
  vec3 cone;     /* a small piece of surface at the second place, with area vector A, covers |A . cone| of the solid angle of
                    launch; 1 / area. In the sky: arrival */
  double spread; /* local area across the ray at the second place, or solid angle of sky, per solid angle of launch */
  double swept;  /* about the lens, radians; 0: straight */
  double chance; /* with which such an image is listed */
} joint;

typedef struct joints {
  int count;
  int straight; /* space is flat all along */
  double rest;  /* the number that decided what is listed, again even in [0, 1) */
  joint list[JOINTS_MAX];
} joints;

/* What joins from[i] with to[i], i < n. The first image is always listed. The others are mostly faint: by u[i] in [0, 1) they
 * are listed with a chance, never too small, that grows with the light that they may have; u[i] = 0 lists them all. */
void join_points(const geometry *g, size_t n, const vec3 *from, const vec3 *to, const double *u, joints *out);
/* What joins from[i] with the unit asymptotic direction to[i]. far: not 0 for the sky beyond a lone wormhole. */
void join_sky(const geometry *g, size_t n, const vec3 *from, const vec3 *to, const double *u, int far, joints *out);
/* Nonzero if a wormhole has a sky of its own beyond it. */
int join_has_far_sky(const geometry *g);
/* Whether a traced ray, which swept `swept`, can only be the first image; never if it arrived in a far sky. */
int join_is_first(const geometry *g, vec3 from, vec3 to, int sky, double swept);
/* The joint that is the traced ray which left in `direction` and swept `swept`; NULL if none is. */
const joint *joints_find(const joints *joints, vec3 direction, double swept);
/* The area, as a vector in world axes, that observers at rest see of a small flat piece of surface at `position`, whose
 * area vector in the scene is `area`. */
vec3 join_local_area(const geometry *g, vec3 position, vec3 area);
#endif
