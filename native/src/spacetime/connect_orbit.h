/* Orbits between two radii at a given swept angle, for connect.kernel.c. Kernel code.
 *
 * With t from 0 to 1 along the ray and Phi the whole swept angle, x(t) obeys x'' = Phi^2 F(x):
 *     Schwarzschild: x = u = M/r,              F = 3 u^2 - u,      x'^2 = Phi^2 (1/beta^2 - u^2 + 2 u^3)
 *     Ellis:         x = chi = arctan(l/rho),  F = sin x cos x,    x'^2 = Phi^2 (1/beta^2 - cos^2 x)
 * (beta = b/M, b/rho). The deviation eta = dx / dx'(0) obeys eta'' = Phi^2 F'(x) eta. Both have an unstable orbit, the
 * photon sphere and the throat, and critical rays that creep up to it from either side. Radial rays are Phi = 0.
 */
#ifndef BENT_SPACETIME_CONNECT_ORBIT_H
#define BENT_SPACETIME_CONNECT_ORBIT_H
#include "base/lane_math.h"
#include "spacetime/arc.h"

enum { ORBIT_ORDER = 16, ORBIT_STEPS_MAX = 400 };
/* Rays at this u have fallen in. */
#define ORBIT_FALLEN 0.55
/* Longest step, radians: no excursion beyond infinity (u < 0, |chi| > pi/2) may fit in. */
#define ORBIT_TURN_MAX 1.5

/* One end of a ray. */
typedef struct orbit_end {
  lanes n[3];   /* angular position, a unit vector */
  lanes w;      /* M/r, Ellis: cos chi = rho/r; 0 in the sky */
  lanes side;   /* Ellis: sin chi = l/r */
  lanes x;      /* M/r, Ellis: chi */
  lanes lapse;
  lanes zeta;   /* place on the critical ray: falls like e^-phi along it; signed like x - x of the unstable orbit */
  lanes creep;  /* dx / dphi of the critical ray through this end, toward the unstable orbit */
} orbit_end;

/* Where a trial ends. */
typedef struct orbit_shot {
  lanes_mask whole;    /* reached the swept angle; otherwise it left the spacetime before */
  lanes miss, slope;   /* x(1) - x of the wanted end, and its derivative by x'(0) */
  lanes rate;          /* x'(1) */
  lanes eta, eta_rate; /* at 1 */
  lanes steps;
} orbit_shot;

LANES_INLINE lanes lanes_atan2(lanes y, lanes x)
{
  lanes angle = {0};
  for (int i = 0; i < LANES; i++) angle[i] = atan2(y[i], x[i]);
  return angle;
}

/* The end at radius |position| of the chart; the sky if `sky` is not 0: then position is any vector toward it. */
LANES_INLINE void schwarzschild_end(const bent_spacetime *s, const lanes position[3], int sky, orbit_end *end)
{
  const double M = s->mass;
  const lanes radius = lanes_sqrt(lanes_dot(position, position));
  for (int k = 0; k < 3; k++) end->n[k] = position[k] / radius;
  const schwarzschild_place at = schwarzschild_place_at(M, s->chart == BENT_CHART_ISOTROPIC, radius);
  end->w = sky ? lanes_all(0) : M * at.w, end->lapse = sky ? lanes_all(1) : at.lapse;
  end->x = end->w, end->side = lanes_all(0);
  /* The critical ray is d = u - 1/3 = 2 zeta / (1 - zeta)^2, zeta = zeta_0 e^-phi (Chandrasekhar 1983, section 20). */
  const lanes d = sky ? lanes_all(-1.0 / 3) : M * at.above;
  end->zeta = d / (1 + d + lanes_sqrt(1 + 2 * d));
  end->creep = -d * lanes_sqrt(1 + 2 * d);
}

LANES_INLINE void ellis_end(const bent_spacetime *s, const lanes position[3], int sky, int far, orbit_end *end)
{
  const lanes radius = lanes_sqrt(lanes_dot(position, position));
  for (int k = 0; k < 3; k++) end->n[k] = position[k] / radius;
  if (sky) {
    end->w = lanes_all(0), end->side = lanes_all(far ? -1 : 1);
  } else {
    const lanes half = 0.5 * s->throat_radius / radius, inverse = 1 / (1 + half * half);
    end->w = 2 * half * inverse, end->side = (1 - half) * (1 + half) * inverse;
  }
  end->lapse = lanes_all(1);
  end->x = lanes_atan2(end->side, end->w);
  /* The critical ray is tan(chi/2) = zeta = zeta_0 e^-phi. */
  end->zeta = end->side / (1 + end->w);
  end->creep = -end->side;
}

/* State along a trial. Ellis carries sin and cos of 2 chi: with them the equations are polynomial,
 * x'' = Phi^2 sin(2 chi) / 2, and radii far from the throat keep their digits. */
typedef struct orbit_state {
  lanes x, rate;
  lanes sine, cosine; /* Ellis */
  lanes eta, eta_rate;
} orbit_state;

/* Taylor series of one step. */
typedef struct orbit_series {
  lanes x[ORBIT_ORDER + 1], sine[ORBIT_ORDER + 1], cosine[ORBIT_ORDER + 1], rate[ORBIT_ORDER + 1];
  lanes eta[ORBIT_ORDER + 1];
} orbit_series;

/* The series about `now`; returns the step in t that keeps their truncation below `tolerance` radians of missed angle.
 * weight: missed angle per error of x. */
LANES_INLINE lanes orbit_expand_schwarzschild(const orbit_state *now, lanes swept2, lanes weight, lanes tolerance,
                                              int order, orbit_series *s)
{
  lanes *u = s->x, *eta = s->eta;
  u[0] = now->x, u[1] = now->rate, eta[0] = now->eta, eta[1] = now->eta_rate;
#pragma GCC unroll 32
  for (int k = 0; k + 2 <= order; k++) {
    const lanes factor = swept2 * (1.0 / ((k + 1) * (k + 2)));
    u[k + 2] = factor * (3 * series_square(u, k) - u[k]);
    eta[k + 2] = factor * (6 * series_product(u, eta, k) - eta[k]);
  }
  const lanes eta_weight = 1 / (1 + lanes_abs(now->eta));
  lanes size[4];
  for (int i = 0; i < 4; i++)
    size[i] = weight * lanes_abs(u[order - i]) + eta_weight * lanes_abs(eta[order - i]);
  return arc_step_length(size, order, tolerance);
}

LANES_INLINE lanes orbit_expand_ellis(const orbit_state *now, lanes swept2, lanes weight, lanes tolerance,
                                      int order, orbit_series *s)
{
  lanes *sine = s->sine, *cosine = s->cosine, *v = s->rate, *eta = s->eta;
  sine[0] = now->sine, cosine[0] = now->cosine, v[0] = now->rate, eta[0] = now->eta, eta[1] = now->eta_rate;
#pragma GCC unroll 32
  for (int k = 0; k < order; k++) {
    sine[k + 1] = series_product(cosine, v, k) * (2.0 / (k + 1));
    cosine[k + 1] = series_product(sine, v, k) * (-2.0 / (k + 1));
    v[k + 1] = swept2 * sine[k] * (0.5 / (k + 1));
    if (k + 2 <= order)
      eta[k + 2] = swept2 * series_product(cosine, eta, k) * (1.0 / ((k + 1) * (k + 2)));
  }
  s->x[0] = now->x;
  for (int k = 0; k < order; k++) s->x[k + 1] = v[k] * (1.0 / (k + 1));
  const lanes eta_weight = 1 / (1 + lanes_abs(now->eta));
  lanes size[4];
  for (int i = 0; i < 4; i++) {
    const int k = order - i;
    size[i] = weight * (0.5 * (lanes_abs(sine[k]) + lanes_abs(cosine[k])) + lanes_abs(s->x[k])) +
              eta_weight * lanes_abs(eta[k]);
  }
  return arc_step_length(size, order, tolerance);
}

/* The state at offset h of the series. */
LANES_INLINE void orbit_advance(int ellis, const orbit_series *s, int order, lanes h, orbit_state *now)
{
  series_with_slope(s->x, order, h, &now->x, &now->rate);
  series_with_slope(s->eta, order, h, &now->eta, &now->eta_rate);
  if (!ellis) return;
  now->sine = series_at(s->sine, order, h), now->cosine = series_at(s->cosine, order, h);
  now->rate = series_at(s->rate, order, h);
}

/* x(1) - b->x, by the difference of angles to full relative accuracy where that counts, and its derivative by x'(0). */
LANES_INLINE void orbit_compare_ellis(const orbit_state *now, const orbit_end *b, orbit_shot *shot)
{
  const lanes b_sine = 2 * b->side * b->w, b_cosine = (b->w - b->side) * (b->w + b->side);
  const lanes sine = now->sine * b_cosine - now->cosine * b_sine, cosine = now->cosine * b_cosine + now->sine * b_sine;
  const lanes apart = now->x - b->x;
  const lanes_mask near = lanes_abs(apart) < 0.1;
  shot->miss = lanes_select(near, 0.5 * sine, apart), shot->slope = lanes_select(near, cosine, lanes_all(1)) * now->eta;
}

/* The trial from `a` with launch slope x'(0) = rate. A ray that leaves the spacetime before its end is extended with
 * its last slope: it misses on the right side, and by more the earlier it left. */
LANES_INLINE orbit_shot orbit_shoot(int ellis, const orbit_end *a, const orbit_end *b, lanes swept, lanes rate,
                                    lanes weight, lanes tolerance, int order)
{
  orbit_state now = {.x = a->x, .rate = rate, .sine = 2 * a->side * a->w,
                     .cosine = (a->w - a->side) * (a->w + a->side), .eta = {0}, .eta_rate = lanes_all(1)};
  const lanes swept2 = swept * swept, longest = ORBIT_TURN_MAX / lanes_max(swept, lanes_all(1e-100));
  lanes left = lanes_all(1), steps = {0};
  lanes_mask open = lanes_mask_all(1);
  for (int i = 0; i < ORBIT_STEPS_MAX && lanes_any(open); i++) {
    orbit_series series;
    lanes h = ellis ? orbit_expand_ellis(&now, swept2, weight, tolerance, order, &series)
                    : orbit_expand_schwarzschild(&now, swept2, weight, tolerance, order, &series);
    h = lanes_select(open, lanes_min(lanes_min(h, longest), left), lanes_all(0));
    orbit_advance(ellis, &series, order, h, &now);
    left -= h, steps += lanes_select(open, lanes_all(1), lanes_all(0));
    open &= (left > 0) & (ellis ? lanes_abs(now.x) <= 0.5 * M_PI : (now.x >= 0) & (now.x <= ORBIT_FALLEN));
  }
  orbit_shot shot = {.whole = left == 0, .rate = now.rate, .eta_rate = now.eta_rate, .steps = steps};
  shot.eta = now.eta + left * now.eta_rate;
  shot.miss = now.x - b->x, shot.slope = now.eta;
  if (ellis) orbit_compare_ellis(&now, b, &shot);
  shot.miss += left * now.rate, shot.slope += left * now.eta_rate;
  return shot;
}
#endif
