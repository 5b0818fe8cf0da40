/* The plane of two ends of a ray and the center, and directions in it, for connect.kernel.c and connect_kerr.kernel.c. */
#ifndef BENT_SPACETIME_CONNECT_PLANE_H
#define BENT_SPACETIME_CONNECT_PLANE_H
#include "spacetime/connect_orbit.h"

/* Ends whose directions from the center differ by less, or are that nearly opposite, are in line. */
#define IN_LINE (4 * EPSILON)

/* The plane of a pair and the angle between its ends. */
typedef struct pair_plane {
  orbit_end a, b;
  lanes angle, sine;             /* between the ends, in [0, pi]; its sine */
  lanes toward_a[3], toward_b[3]; /* unit vectors across a.n and b.n in which the short way turns */
} pair_plane;

LANES_INLINE void cross(const lanes a[3], const lanes b[3], lanes out[3])
{
  for (int k = 0; k < 3; k++) out[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

LANES_INLINE void cross_unit(const lanes a[3], const lanes b[3], lanes out[3])
{
  cross(a, b, out);
  const lanes length = lanes_sqrt(lanes_dot(out, out));
  for (int k = 0; k < 3; k++) out[k] /= length;
}

/* Ends in line share every plane; one is as good as another: that across the axis which is least along them. Their
 * sine, which is rounding, counts as 0, so that rings have spread 0 and coincident ends are told apart from close ones.
 * */
LANES_INLINE void plane_of(pair_plane *pair)
{
  const lanes *n = pair->a.n;
  lanes axis[3];
  cross(n, pair->b.n, axis);
  const lanes area = lanes_sqrt(lanes_dot(axis, axis));
  const lanes_mask in_line = area <= IN_LINE;
  pair->sine = lanes_select(in_line, lanes_all(0), area);
  pair->angle = lanes_atan2(pair->sine, lanes_dot(n, pair->b.n));
  const lanes_mask x_least = (lanes_abs(n[0]) <= lanes_abs(n[1])) & (lanes_abs(n[0]) <= lanes_abs(n[2]));
  const lanes_mask y_least = ~x_least & (lanes_abs(n[1]) <= lanes_abs(n[2]));
  const lanes one = lanes_all(1), none = lanes_all(0);
  const lanes least[3] = {lanes_select(x_least, one, none), lanes_select(y_least, one, none),
                          lanes_select(x_least | y_least, none, one)};
  lanes any[3];
  cross(n, least, any);
  for (int k = 0; k < 3; k++) axis[k] = lanes_select(in_line, any[k], axis[k]);
  cross_unit(axis, n, pair->toward_a);
  cross_unit(n, pair->toward_a, axis); /* again: the first one of nearly parallel vectors is askew */
  cross_unit(axis, pair->b.n, pair->toward_b);
}

/* The local unit direction of travel where x' = rate; x grows inward in a hole, outward in a wormhole. */
LANES_INLINE void direction_of(int ellis, const orbit_end *end, const lanes toward[3], lanes turn, lanes swept,
                               lanes size, lanes rate, lanes out[3])
{
  const lanes sine = end->lapse * end->w * swept / size, inward = ellis ? -rate : rate;
  /* the invariant is better than the integrated slope, except near a turning point */
  const lanes exact = lanes_copysign(lanes_sqrt(lanes_max((1 - sine) * (1 + sine), lanes_all(0))), inward);
  const lanes cosine = -lanes_select(sine < 0.9, exact, inward / size);
  for (int k = 0; k < 3; k++) out[k] = cosine * end->n[k] + turn * sine * toward[k];
  const lanes length = lanes_sqrt(lanes_dot(out, out));
  for (int k = 0; k < 3; k++) out[k] /= length;
}
#endif
