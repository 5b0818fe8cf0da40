/* The Schwarzschild metric for arc.h: planar orbits, in the isotropic and the areal chart.
 *
 * With w = 1/r in Mino time (physics: Darwin 1959; Chandrasekhar 1983, section 20):
 *     w'^2 = E^2 - L^2 w^2 + 2M L^2 w^3,    w'' = -L^2 w + 3M L^2 w^2,
 * and n turns at the constant rate L in the plane of the ray. Isotropic chart: R = (r - M + sqrt(r^2 - 2Mr)) / 2.
 *
 * Near the photon sphere the motion runs away from w = 1/(3M) exponentially, and with it a rounding of w. There we march
 * x = w - 1/(3M), which has all digits: x'' = +L^2 x + 3M L^2 x^2, the same equation but for one sign.
 */
#ifndef BENT_SPACETIME_SCHWARZSCHILD_H
#define BENT_SPACETIME_SCHWARZSCHILD_H
#ifndef BENT_SPACETIME_ARC_H
#error "include spacetime/arc.h"
#endif
#include "spacetime/schwarzschild_place.h"

LANES_INLINE void schwarzschild_launch(const arc_space *space, const lanes origin[3], const lanes direction[3],
                                       arc_ray *ray)
{
  const double M = space->mass, peak = 1 / (3 * M);
  const lanes radius = lanes_sqrt(lanes_dot(origin, origin));
  const schwarzschild_place at = schwarzschild_place_at(M, space->chart == BENT_CHART_ISOTROPIC, radius);
  const lanes lapse = at.lapse, x = at.above;
  ray->w = at.w;
  ray->base = lanes_select(lanes_abs(x) < 0.5 * peak, lanes_all(peak), lanes_all(0));
  ray->rise = lanes_select(ray->base > 0, x, ray->w);
  arc_launch_planar(origin, direction, radius, ray);
  ray->energy = lapse;
  ray->v = -lapse * lanes_dot(direction, ray->n);
  ray->weight = lanes_sqrt(ray->curl + M * M * lapse * lapse) / lapse;
  ray->doubt = arc_launch_doubt(ray, 5 * M) + EPSILON / (lapse * lapse);
  ray->peak = lanes_all(peak);
  /* P(peak) = E^2 - L^2 / (27 M^2), written so that it keeps its digits near the photon sphere */
  const lanes barrier = ray->v * ray->v - ray->curl * x * x * (1 + 2 * M * x);
  arc_judge(ray, barrier, lapse * lapse + ray->curl * (1 / (9 * M * M)), lanes_all(1));
}

LANES_INLINE void schwarzschild_expand(const arc_space *space, const arc_ray *ray, lanes tolerance, int order, arc *arc)
{
  lanes *w = arc->series[ARC_W], square[ARC_ORDER_MAX];
  const lanes linear = lanes_select(ray->base > 0, ray->curl, -ray->curl), quadratic = 3 * space->mass * ray->curl;
  w[0] = ray->rise, w[1] = ray->v;
#pragma GCC unroll 32
  for (int k = 0; k + 2 <= order; k++) {
    square[k] = series_square(w, k);
    w[k + 2] = (linear * w[k] + quadratic * square[k]) * (1.0 / ((k + 1) * (k + 2)));
  }
  w[0] = ray->w;
  const lanes weight = lanes_min(ray->weight, 2 / lanes_max(ray->w, lanes_all(1e-300)));
  lanes size[4];
  for (int i = 0; i < 4; i++) size[i] = weight * lanes_abs(w[order - i]);
  const lanes step = arc_step_length(size, order, tolerance);
  const lanes turn = ARC_TURN_MAX / (ray->momentum + 1e-200);
  arc->step = lanes_min(step, lanes_min(turn, (ray->w + space->horizon) / (lanes_abs(ray->v) + 1e-200)));
}

LANES_INLINE void schwarzschild_advance(const arc *arc, lanes offset, arc_ray *ray)
{
  lanes change;
  series_change_with_slope(arc->series[ARC_W], arc->order, offset, &change, &ray->v);
  ray->rise += change;
  ray->w = ray->base + ray->rise;
  ray->swept += ray->momentum * offset;
}

/* 1 - 2M w = -g_tt, zero at the horizon. */
LANES_INLINE lanes schwarzschild_redshift(const arc_space *space, lanes w)
{
  return lanes_max(1 - 2 * space->mass * w, lanes_all(0));
}

LANES_INLINE void schwarzschild_position(const arc_space *space, const arc_ray *ray, lanes offset, lanes w,
                                         lanes numerator[3])
{
  lanes scale = lanes_all(1), n[3], m[3];
  if (space->chart == BENT_CHART_ISOTROPIC)
    scale = 0.5 * (1 - space->mass * w + lanes_sqrt(schwarzschild_redshift(space, w)));
  arc_planar_basis(ray, offset, n, m);
  for (int k = 0; k < 3; k++) numerator[k] = scale * n[k];
}

/* The tetrad components are dr/dlambda / (r^2 sqrt(1 - 2Mw)) and n' / r. */
LANES_INLINE void schwarzschild_direction(const arc_space *space, const arc_ray *ray, const arc *arc, lanes offset,
                                          lanes direction[3])
{
  lanes w, v, n[3], m[3];
  series_with_slope(arc->series[ARC_W], arc->order, offset, &w, &v);
  arc_planar_basis(ray, offset, n, m);
  const lanes along = w * lanes_sqrt(schwarzschild_redshift(space, w)) * ray->momentum;
  for (int k = 0; k < 3; k++) direction[k] = along * m[k] - v * n[k];
}

LANES_INLINE lanes schwarzschild_drift(const arc_space *space, const arc_ray *ray)
{
  const lanes w = ray->w, E2 = ray->energy * ray->energy;
  const lanes turning = ray->curl * w * w;
  return lanes_abs(ray->v * ray->v - E2 + turning * (1 - 2 * space->mass * w)) / (E2 + turning);
}
#endif
