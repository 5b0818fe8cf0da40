/* All rays that join two places of a scene, or a place and a direction of the sky, as far as they are known in closed
 * form: the straight one where it meets no sphere, the images of a lone hole or wormhole (bentlight/connect.h), and those
 * by way of one of several holes or through one wormhole (join_lens.h). Rays that are not listed are found by scattering
 * alone. Lengths in world units, directions local in world axes. */
#ifndef BENT_LIGHT_JOIN_H
#define BENT_LIGHT_JOIN_H
#include "geometry/geometry.h"

enum { JOINTS_MAX = 16 };
/* Images fainter than this share of those before them, by way of the same lens, are not listed. */
#define JOINT_SHARE_MIN 1e-4

typedef struct joint {
  vec3 launch, arrival; /* of the ray from the first place */
  vec3 cone;     /* a small piece of surface at the second place, with area vector A, covers |A . cone| of the solid angle of
                    launch; 1 / area. In the sky: arrival */
  double spread; /* local area across the ray at the second place, or solid angle of sky, per solid angle of launch */
  /* Where it takes long to solve for a traced ray, multiple importance sampling weighs both of its ways to find such light
   * by an estimate of spread and cone instead, the straight line's. The weights add up to 1 all the same. */
  double weigh_spread;
  vec3 weigh_cone;
  double swept;  /* inside lenses, radians */
  int first_lens;   /* as in bent_hit; -1: straight */
  uint32_t borders; /* as in bent_hit, when it arrives */
  int through;      /* a throat */
  double chance;    /* with which such an image is listed */
  double way_chance; /* with which its way was tried, and with which it was listed in place of another for want of room */
} joint;

typedef struct joints {
  int count;
  int wanted, lost; /* curved images that were looked for, and those of them that exist but were not found as exactly as wanted */
  double rest; /* the number that decided what is listed, again even in [0, 1) */
  uint64_t dice; /* random bits for what is too much to be listed */
  joint list[JOINTS_MAX];
} joints;

static inline joints joints_none(uint64_t dice)
{
  joints none;
  none.count = none.wanted = none.lost = 0, none.rest = 0, none.dice = dice;
  return none;
}

/* What joins from[i] with to[i], i < n. The straight line and the first image by way of each lens are always listed. The
 * others are mostly faint: by u[i] in [0, 1) they are listed with a chance, never too small, that grows with the light that
 * they may have; u[i] = 0 lists them all. */
void join_points(const geometry *g, size_t n, const vec3 *from, const vec3 *to, const double *u, joints *out);
/* The same, or with sky that of join_sky, but ways are tried by chance, and what is not tried is not solved: joint_way number
 * k of pair i with the chance chances[i][k]; chances[i] NULL: all are. */
void join_by_chance(const geometry *g, size_t n, const vec3 *from, const vec3 *to, const double *u,
                    const double *const *chances, int sky, int far, joints *out);
/* What joins from[i] with the unit asymptotic direction to[i]. far: not 0 for the skies beyond wormholes without exit. */
void join_sky(const geometry *g, size_t n, const vec3 *from, const vec3 *to, const double *u, int far, joints *out);
/* Nonzero if a wormhole has a sky of its own beyond it. */
int join_has_far_sky(const geometry *g);
/* Nonzero if it takes much longer to join a pair than to trace its ray: around a lone hole that spins. */
int join_is_slow(const geometry *g);
static inline int joint_is_straight(const joint *j) { return j->first_lens < 0; }
/* Joints numbered by the way that they take: straight, or by way of each lens, on this side or through its throat. */
static inline size_t joint_ways(const geometry *g) { return 1 + 2 * g->lens_count; }
static inline size_t joint_way_by(int lens, int through) { return lens < 0 ? 0 : 1 + 2 * (size_t)lens + (through != 0); }
static inline size_t joint_way(const joint *j) { return joint_way_by(j->first_lens, j->through); }

/* A traced ray from the first place, as far as it tells which joint it is: bent_hit's values, summed over its pieces. */
typedef struct joint_trace {
  vec3 launch;
  double swept;
  int first_lens;
  uint32_t borders;
} joint_trace;

/* Of all joints of each pair (as above; `sky`: the ends are directions) the one that is a ray traced between them; spread 0
 * if none is. */
void join_traced(const geometry *g, size_t n, const vec3 *from, const vec3 *to, int sky, int far, const joint_trace *traces,
                 joint *out);
/* The length of a joint between two places as it is drawn in the scene, world units; around a spinning hole that of the
 * straight line, and elsewhere to about 1e-6, less for rays that are nearly critical. */
double join_length(const geometry *g, vec3 from, vec3 to, const joint *j);
/* The area, as a vector in world axes, that observers at rest see of a small flat piece of surface at `position`, whose
 * area vector in the scene is `area`. */
vec3 join_local_area(const geometry *g, vec3 position, vec3 area);
#endif
