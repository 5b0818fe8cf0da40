/* What the endpoint solvers share: how a ray stands to the center, and what they answer. Kernel code. */
#ifndef BENT_SPACETIME_ENDPOINT_LANES_H
#define BENT_SPACETIME_ENDPOINT_LANES_H
#include <float.h>
#include <math.h>

#include "base/lane_math.h"
#include "bentlight/trace.h"

/* A ray from position X along the local direction d in a spherically symmetric, conformally flat or areal chart. */
typedef struct aim {
  lanes radius;      /* |X| */
  lanes outward[3];  /* X / |X| */
  lanes sideward[3]; /* unit vector of the part of d across X, 0 for a radial ray */
  lanes cosine;      /* of the angle from outward to d */
  lanes sine;        /* >= 0, relative accuracy limited by the cross product: about DBL_EPSILON / sine */
} aim;

typedef struct endpoint {
  lanes_mask fate; /* bent_fate in each lane; BENT_UNRESOLVED: declined */
  lanes direction[3], error, swept;
} endpoint;

LANES_INLINE aim aim_from(const lanes position[3], const lanes direction[3])
{
  const lanes r2 = lanes_dot(position, position), d2 = lanes_dot(direction, direction);
  const lanes c[3] = {position[1] * direction[2] - position[2] * direction[1],
                      position[2] * direction[0] - position[0] * direction[2],
                      position[0] * direction[1] - position[1] * direction[0]};
  const lanes radius = lanes_sqrt(r2), c2 = lanes_dot(c, c), inverse_r = 1 / radius, inverse_rd = 1 / lanes_sqrt(r2 * d2);
  const lanes inverse_side = inverse_r / lanes_sqrt(lanes_max(c2, lanes_all(DBL_MIN)));
  aim a;
  a.radius = radius;
  a.cosine = lanes_dot(position, direction) * inverse_rd;
  a.sine = lanes_sqrt(c2) * inverse_rd;
  for (int i = 0; i < 3; i++) a.outward[i] = position[i] * inverse_r;
  a.sideward[0] = (c[1] * position[2] - c[2] * position[1]) * inverse_side;
  a.sideward[1] = (c[2] * position[0] - c[0] * position[2]) * inverse_side;
  a.sideward[2] = (c[0] * position[1] - c[1] * position[0]) * inverse_side;
  return a;
}

/* Turns the outward direction by the swept angle in the plane of the orbit. */
LANES_INLINE void endpoint_turn(endpoint *end, const aim *a)
{
  lanes sine, cosine;
  lanes_sincos(end->swept, &sine, &cosine);
  for (int i = 0; i < 3; i++) end->direction[i] = a->outward[i] * cosine + a->sideward[i] * sine;
}

/* Lane i of `end` is ray `at` of `out`. */
LANES_INLINE void endpoint_store_ray(const endpoint *end, size_t i, size_t at, const bent_trace_result *out)
{
  const bent_fate fate = (bent_fate)end->fate[i];
  const int escaped = fate == BENT_ESCAPED || fate == BENT_ESCAPED_FAR;
  if (out->fate) out->fate[at] = (uint8_t)fate;
  if (out->error) out->error[at] = escaped ? end->error[i] : fate == BENT_CAPTURED ? 0 : NAN;
  if (out->swept) out->swept[at] = escaped ? end->swept[i] : NAN;
  if (out->steps) out->steps[at] = 0;
  for (int k = 0; out->direction && k < 3; k++) out->direction[at][k] = escaped ? end->direction[k][i] : NAN;
}

LANES_INLINE void endpoint_store(const endpoint *end, size_t first, size_t count, const bent_trace_result *out)
{
  for (size_t i = 0; i < count; i++) endpoint_store_ray(end, i, first + i, out);
}

#endif
