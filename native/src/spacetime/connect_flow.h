/* A Kerr ray and how it changes with its launch direction, for connect_kerr.kernel.c. Kernel code.
 *
 * The equations of motion of kerr.h, M = 1, and beside them their derivatives by two angles that turn the launch direction
 * d into d + x_0 e_0 + x_1 e_1 (variational equations; all of them carried in the same Taylor series). With the derivative
 * by Mino time, which is the motion itself, they say how the place at a given Mino time changes with the three numbers that
 * a ray is aimed by. The spin differs from lane to lane, so that a solution can be followed from spin 0.
 */
#ifndef BENT_SPACETIME_CONNECT_FLOW_H
#define BENT_SPACETIME_CONNECT_FLOW_H
#include "spacetime/arc.h"

enum { FLOW_ORDER = 12, FLOW_TURN_ORDER = 9, FLOW_STEPS_MAX = 100, FLOW_TURNS = 2 };
/* Rays this close to the horizon, in 1 - r_plus / r, have fallen in. */
#define FLOW_FALLEN 1e-13
/* A Newton step shorter than this, over the length of the arc, is the last: the next would be about its square. */
#define FLOW_THERE 1e-9

/* A hole of mass 1; spin as the traced ray sees it (arc.h). */
typedef struct flow_hole {
  lanes spin, outer, inner;
} flow_hole;

/* A place in Boyer-Lindquist coordinates. */
typedef struct flow_place {
  lanes n[3];  /* (sin th cos ph, sin th sin ph, cos th) */
  lanes w;     /* 1/r; 0 in the sky */
  lanes above; /* r - r_plus */
} flow_place;

/* Metric functions of a place, see kerr_place. */
typedef struct flow_metric {
  lanes sine, cosine, east[2]; /* of the polar angle; unit vector toward +phi (on the axis: +y) */
  lanes sigma, delta, area, lapse;
  lanes drag; /* angular velocity of the ZAMO */
} flow_metric;

/* A quantity and its derivatives by the two angles. */
typedef struct flow_number {
  lanes value, by[FLOW_TURNS];
} flow_number;

typedef struct flow_ray {
  flow_number energy, momentum, carter, curl; /* constants of the motion, see arc_ray */
  flow_number w, v, n[3], m[3], drag;
  lanes swept;
  lanes weight;
} flow_ray;

LANES_INLINE flow_hole flow_hole_of(lanes spin)
{
  flow_hole hole = {.spin = spin, .outer = 1 + lanes_sqrt((1 - spin) * (1 + spin))};
  hole.inner = spin * spin / hole.outer;
  return hole;
}

LANES_INLINE flow_metric flow_metric_at(const flow_hole *hole, const flow_place *at)
{
  flow_metric g;
  const lanes s = hole->spin, w = at->w, sw2 = s * s * w * w;
  const lanes horizontal = lanes_sqrt(at->n[0] * at->n[0] + at->n[1] * at->n[1]);
  const lanes_mask on_axis = horizontal == 0;
  const lanes inverse = 1 / lanes_select(on_axis, lanes_all(1), horizontal);
  g.sine = horizontal, g.cosine = at->n[2];
  g.east[0] = -at->n[1] * inverse, g.east[1] = lanes_select(on_axis, lanes_all(1), at->n[0] * inverse);
  g.sigma = 1 + sw2 * g.cosine * g.cosine;
  g.delta = lanes_select(w > 0, at->above * w * (1 - hole->inner * w), lanes_all(1));
  g.area = (1 + sw2) * (1 + sw2) - sw2 * g.delta * g.sine * g.sine;
  g.lapse = lanes_sqrt(g.sigma * g.delta / g.area);
  g.drag = 2 * s * w * w * w / g.area;
  return g;
}

/* Unit vectors e[0], e[1] that make a right-handed triple with the unit vector d (Duff et al. 2017). */
LANES_INLINE void flow_across(const lanes d[3], lanes e[2][3])
{
  const lanes sign = lanes_copysign(lanes_all(1), d[2]), a = -1 / (sign + d[2]), b = d[0] * d[1] * a;
  e[0][0] = 1 + sign * d[0] * d[0] * a, e[0][1] = sign * b, e[0][2] = -sign * d[0];
  e[1][0] = b, e[1][1] = sign + d[1] * d[1] * a, e[1][2] = -d[1];
}

/* Launches along the unit vector d, in components outward, south, east of the ZAMO's frame (all later arrays of three
 * local components are such); e: two unit vectors across it. Local energy 1. */
LANES_INLINE void flow_launch(const flow_hole *hole, const flow_place *at, const flow_metric *g, const lanes d[3],
                              const lanes e[2][3], flow_ray *ray)
{
  const lanes r = 1 / at->w, to_east = r * lanes_sqrt(g->area / g->sigma), to_south = r * lanes_sqrt(g->sigma);
  const lanes to_v = -lanes_sqrt(g->sigma * g->delta), s2 = hole->spin * hole->spin, c2 = g->cosine * g->cosine;
  const lanes east[3] = {g->east[0], g->east[1], lanes_all(0)};
  const lanes south[3] = {g->cosine * g->east[1], -g->cosine * g->east[0], -g->sine};
  const lanes toward = d[2] * to_east, polar = d[1] * to_south;
  ray->momentum.value = toward * g->sine;
  ray->energy.value = g->lapse + g->drag * ray->momentum.value;
  const lanes E = ray->energy.value, L = ray->momentum.value;
  ray->carter.value = polar * polar + c2 * (toward * toward - s2 * E * E);
  ray->curl.value = ray->carter.value + L * L;
  ray->v.value = to_v * d[0];
  for (int i = 0; i < 2; i++) {
    const lanes turn_east = e[i][2] * to_east, turn_south = e[i][1] * to_south;
    ray->momentum.by[i] = turn_east * g->sine;
    ray->energy.by[i] = g->drag * ray->momentum.by[i];
    ray->carter.by[i] = 2 * (polar * turn_south + c2 * (toward * turn_east - s2 * E * ray->energy.by[i]));
    ray->curl.by[i] = ray->carter.by[i] + 2 * L * ray->momentum.by[i];
    ray->v.by[i] = to_v * e[i][0];
    for (int k = 0; k < 3; k++) ray->m[k].by[i] = turn_south * south[k] + turn_east * east[k];
  }
  for (int k = 0; k < 3; k++) ray->m[k].value = polar * south[k] + toward * east[k];
  for (int k = 0; k < 3; k++) ray->n[k] = (flow_number){.value = at->n[k]};
  ray->w = (flow_number){.value = at->w};
  ray->drag = (flow_number){.value = {0}};
  ray->swept = lanes_all(0);
  const lanes size2 = lanes_max(ray->curl.value, lanes_all(0)) + (1 + s2) * E * E;
  ray->weight = lanes_min(lanes_sqrt(size2) / lanes_max(lanes_abs(E), lanes_all(1e-100)), 2 * r);
}

/* Series of one arc. */
typedef struct flow_series {
  lanes w[FLOW_ORDER + 1], n[3][FLOW_ORDER + 1], drag[FLOW_ORDER + 1];
  lanes dw[2][FLOW_TURN_ORDER + 1], dn[2][3][FLOW_TURN_ORDER + 1], ddrag[2][FLOW_TURN_ORDER + 1];
} flow_series;

/* Products of the series that the derivatives use again. */
typedef struct flow_products {
  lanes w2[FLOW_ORDER], w3[FLOW_ORDER], z2[FLOW_ORDER], z3[FLOW_ORDER];
  lanes bend[FLOW_ORDER]; /* c1 + 2 c2 w + 3 c3 w^2: w'' changes by it, times that of w */
  lanes turn[FLOW_ORDER]; /* x'' = -turn x, and y; of z that is a cubic */
  lanes delta[FLOW_ORDER], rate[FLOW_ORDER]; /* w^2 Delta without its 1, and drag' */
  lanes push[FLOW_ORDER]; /* drag' w^2 Delta changes by it, times the change of w */
} flow_products;

/* Here and below each recursion has a loop of its own, so that its series stay in registers, and the newest coefficient
 * comes last in its product: the next one waits for it. */
LANES_INLINE void flow_expand_motion(const flow_hole *hole, const flow_ray *ray, flow_series *s, flow_products *p)
{
  const lanes a = hole->spin, a2 = a * a, E = ray->energy.value, L = ray->momentum.value, Q = ray->carter.value;
  const lanes sE2 = a2 * E * E, K = (L - a * E) * (L - a * E) + Q, curl = ray->curl.value;
  const lanes c1 = sE2 - curl, c2 = 3 * K, c3 = -2 * a2 * Q;
  const lanes inverse = 1 / ((1 - hole->outer * ray->w.value) * (1 - hole->inner * ray->w.value));
  lanes *w = s->w, *z = s->n[2];
  w[0] = ray->w.value, w[1] = ray->v.value, s->drag[0] = ray->drag.value;
  for (int i = 0; i < 3; i++) s->n[i][0] = ray->n[i].value, s->n[i][1] = ray->m[i].value;
#pragma GCC unroll 32
  for (int k = 0; k < FLOW_ORDER; k++) {
    p->w2[k] = series_square(w, k);
    if (k + 2 > FLOW_ORDER) break;
    const double q = 1.0 / ((k + 1) * (k + 2));
    p->w3[k] = series_product(w, p->w2, k);
    w[k + 2] = (c1 * w[k] + c2 * p->w2[k] + c3 * p->w3[k]) * q;
    p->z2[k] = series_square(z, k);
    p->z3[k] = series_product(z, p->z2, k);
    z[k + 2] = (c1 * z[k] - 2 * sE2 * p->z3[k]) * q;
    p->turn[k] = 2 * sE2 * p->z2[k];
    if (k == 0) p->turn[k] += curl;
  }
#pragma GCC unroll 32
  for (int k = 0; k < FLOW_ORDER; k++) {
    p->delta[k] = a2 * p->w2[k] - 2 * w[k];
    p->rate[k] = (2 * a * E * w[k] - a2 * L * p->w2[k] - series_product_tail(p->delta, p->rate, k)) * inverse;
    s->drag[k + 1] = p->rate[k] * (1.0 / (k + 1));
  }
#pragma GCC unroll 32
  for (int k = 0; k + 2 <= FLOW_ORDER; k++)
    for (int i = 0; i < 2; i++) s->n[i][k + 2] = series_product(s->n[i], p->turn, k) * (-1.0 / ((k + 1) * (k + 2)));
}

/* How the rates of w and of the drag change with w. */
LANES_INLINE void flow_expand_slopes(const flow_hole *hole, const flow_ray *ray, const flow_series *s, flow_products *p)
{
  const lanes a = hole->spin, a2 = a * a, E = ray->energy.value, L = ray->momentum.value, Q = ray->carter.value;
  const lanes K = (L - a * E) * (L - a * E) + Q;
#pragma GCC unroll 32
  for (int k = 0; k < FLOW_TURN_ORDER; k++) {
    p->bend[k] = 6 * K * s->w[k] - 6 * a2 * Q * p->w2[k];
    p->push[k] = 2 * p->rate[k] - 2 * a2 * (L * s->w[k] + series_product(s->w, p->rate, k));
  }
  p->bend[0] += a2 * E * E - ray->curl.value, p->push[0] += 2 * a * E;
}

/* Changes of v, of m and of the drag by Mino time, where the ray is. */
LANES_INLINE void flow_rates(const flow_hole *hole, const flow_ray *ray, lanes rates[5])
{
  const lanes a = hole->spin, a2 = a * a, E = ray->energy.value, L = ray->momentum.value, Q = ray->carter.value;
  const lanes sE2 = a2 * E * E, K = (L - a * E) * (L - a * E) + Q, w = ray->w.value, z2 = ray->n[2].value * ray->n[2].value;
  const lanes turn = ray->curl.value + 2 * sE2 * z2;
  rates[0] = w * (sE2 - ray->curl.value + w * (3 * K - 2 * a2 * Q * w));
  for (int i = 0; i < 2; i++) rates[1 + i] = -turn * ray->n[i].value;
  rates[3] = (sE2 - turn) * ray->n[2].value;
  rates[4] = a * w * (2 * E - a * L * w) / ((1 - hole->outer * w) * (1 - hole->inner * w));
}

/* The derivatives by angle j. */
LANES_INLINE void flow_expand_turn(const flow_hole *hole, const flow_ray *ray, int j, const flow_products *p, flow_series *s)
{
  const lanes a = hole->spin, a2 = a * a, E = ray->energy.value, L = ray->momentum.value;
  const lanes dE = ray->energy.by[j], dL = ray->momentum.by[j], dQ = ray->carter.by[j], dC = ray->curl.by[j];
  const lanes curl = ray->curl.value, sE2 = a2 * E * E, dsE2 = 2 * a2 * E * dE;
  const lanes d1 = dsE2 - dC, d2 = 3 * (2 * (L - a * E) * (dL - a * dE) + dQ), d3 = -2 * a2 * dQ;
  const lanes inverse = 1 / ((1 - hole->outer * ray->w.value) * (1 - hole->inner * ray->w.value));
  const lanes *w = s->w, *z = s->n[2];
  lanes *dw = s->dw[j], *dz = s->dn[j][2], drate[FLOW_TURN_ORDER], dturn[FLOW_TURN_ORDER];
  dw[0] = ray->w.by[j], dw[1] = ray->v.by[j], s->ddrag[j][0] = ray->drag.by[j];
  for (int i = 0; i < 3; i++) s->dn[j][i][0] = ray->n[i].by[j], s->dn[j][i][1] = ray->m[i].by[j];
#pragma GCC unroll 32
  for (int k = 0; k + 2 <= FLOW_TURN_ORDER; k++) {
    const lanes own = d1 * w[k] + d2 * p->w2[k] + d3 * p->w3[k];
    dw[k + 2] = (own + series_product(dw, p->bend, k)) * (1.0 / ((k + 1) * (k + 2)));
  }
#pragma GCC unroll 32
  for (int k = 0; k < FLOW_TURN_ORDER; k++) {
    const lanes own = 2 * a * dE * w[k] - a2 * dL * p->w2[k];
    drate[k] = (own + series_product(dw, p->push, k) - series_product_tail(p->delta, drate, k)) * inverse;
    s->ddrag[j][k + 1] = drate[k] * (1.0 / (k + 1));
  }
#pragma GCC unroll 32
  for (int k = 0; k + 2 <= FLOW_TURN_ORDER; k++) {
    const lanes cubic = 2 * dsE2 * p->z3[k] + 6 * sE2 * series_product(dz, p->z2, k);
    dz[k + 2] = ((sE2 - curl) * dz[k] + (dsE2 - dC) * z[k] - cubic) * (1.0 / ((k + 1) * (k + 2)));
    dturn[k] = 2 * dsE2 * p->z2[k] + 4 * sE2 * series_product(dz, z, k);
    if (k == 0) dturn[k] += dC;
  }
  for (int i = 0; i < 2; i++) {
    lanes *dn = s->dn[j][i];
#pragma GCC unroll 32
    for (int k = 0; k + 2 <= FLOW_TURN_ORDER; k++)
      dn[k + 2] = (series_product(dturn, s->n[i], k) + series_product(dn, p->turn, k)) * (-1.0 / ((k + 1) * (k + 2)));
  }
}

/* The series about the ray's state, with its derivatives by the first `turns` angles. Returns the step that keeps their
 * truncation below `tolerance`, of angles and of relative deviations, and that of the derivatives, relative, below
 * `turn_tolerance`. */
LANES_INLINE lanes flow_expand(const flow_hole *hole, const flow_ray *ray, int turns, lanes tolerance, lanes turn_tolerance,
                               flow_series *s)
{
  flow_products products;
  flow_expand_motion(hole, ray, s, &products);
  if (turns) flow_expand_slopes(hole, ray, s, &products);
  for (int j = 0; j < turns; j++) flow_expand_turn(hole, ray, j, &products, s);
  lanes share[FLOW_TURNS];
  for (int j = 0; j < turns; j++) {
    lanes largest = lanes_abs(ray->drag.by[j]) + ray->weight * lanes_abs(ray->w.by[j]);
    for (int i = 0; i < 3; i++) largest = lanes_max(largest, lanes_abs(ray->n[i].by[j]));
    share[j] = 1 / (1 + largest);
  }
  lanes size[4], turn_size[4];
  for (int i = 0; i < 4; i++) {
    const int k = FLOW_ORDER - i, l = FLOW_TURN_ORDER - i;
    size[i] = lanes_abs(s->n[0][k]) + lanes_abs(s->n[1][k]) + lanes_abs(s->n[2][k]) + ray->weight * lanes_abs(s->w[k]) +
              lanes_abs(s->drag[k]);
    turn_size[i] = lanes_all(0);
    for (int j = 0; j < turns; j++)
      turn_size[i] += share[j] * (lanes_abs(s->dn[j][0][l]) + lanes_abs(s->dn[j][1][l]) + lanes_abs(s->dn[j][2][l]) +
                                  ray->weight * lanes_abs(s->dw[j][l]) + lanes_abs(s->ddrag[j][l]));
  }
  const lanes speed = lanes_sqrt(s->n[0][1] * s->n[0][1] + s->n[1][1] * s->n[1][1] + s->n[2][1] * s->n[2][1]);
  const lanes turn = ARC_TURN_MAX / (speed + lanes_abs(hole->spin * ray->energy.value) + 1e-200);
  const lanes twice = (ray->w.value + 1 / hole->outer) / (lanes_abs(ray->v.value) + 1e-200); /* no step passes infinity twice */
  const lanes longest = turns ? arc_step_length(turn_size, FLOW_TURN_ORDER, turn_tolerance) : turn;
  return lanes_min(lanes_min(arc_step_length(size, FLOW_ORDER, tolerance), longest), lanes_min(turn, twice));
}

/* The offset in [0, step] at which w reaches `level`, in lanes `wanted`, where it does: safeguarded Newton steps. A lane that
 * has come there is frozen, so that its value does not depend on its neighbors. */
LANES_INLINE lanes flow_crossing(const flow_series *s, lanes level, lanes step, lanes_mask wanted)
{
  const lanes begin = s->w[0] - level;
  lanes low = {0}, high = step, x = 0.5 * step;
  lanes_mask open = wanted;
  for (int i = 0; i < 8 && lanes_any(open); i++) {
    lanes value, slope;
    series_with_slope(s->w, FLOW_ORDER, x, &value, &slope);
    value -= level;
    const lanes_mask before = (value > 0) == (begin > 0);
    low = lanes_select(before, x, low), high = lanes_select(before, high, x);
    const lanes newton = x - value / slope;
    const lanes next = lanes_select((newton >= low) & (newton <= high), newton, 0.5 * (low + high));
    const lanes moved = lanes_abs(next - x);
    x = lanes_select(open, next, x);
    open &= moved > FLOW_THERE * step;
  }
  return x;
}

/* Moves the ray on; swept as kerr_advance has it. */
LANES_INLINE void flow_advance(const flow_hole *hole, const flow_series *s, int turns, lanes h, flow_ray *ray)
{
  const lanes aE = hole->spin * ray->energy.value, sE2 = aE * aE;
  lanes speed[2], bend[2];
  for (int end = 0; end < 2; end++) {
    if (end) {
      series_with_slope(s->w, FLOW_ORDER, h, &ray->w.value, &ray->v.value);
      for (int i = 0; i < 3; i++) series_with_slope(s->n[i], FLOW_ORDER, h, &ray->n[i].value, &ray->m[i].value);
    }
    speed[end] = lanes_sqrt(ray->m[0].value * ray->m[0].value + ray->m[1].value * ray->m[1].value +
                            ray->m[2].value * ray->m[2].value);
    bend[end] = ray->n[2].value * ray->m[2].value / (speed[end] + 1e-200);
  }
  ray->swept += h * (0.5 * (speed[0] + speed[1]) + h * sE2 * (bend[0] - bend[1]) * (1.0 / 12));
  ray->drag.value = series_at(s->drag, FLOW_ORDER, h);
  for (int j = 0; j < turns; j++) {
    series_with_slope(s->dw[j], FLOW_TURN_ORDER, h, &ray->w.by[j], &ray->v.by[j]);
    for (int i = 0; i < 3; i++) series_with_slope(s->dn[j][i], FLOW_TURN_ORDER, h, &ray->n[i].by[j], &ray->m[i].by[j]);
    ray->drag.by[j] = series_at(s->ddrag[j], FLOW_TURN_ORDER, h);
  }
}
#endif
