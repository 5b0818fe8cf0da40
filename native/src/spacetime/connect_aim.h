/* Aiming Kerr rays: the launch direction and Mino time with which a ray from a comes to b. Kernel code.
 *
 * Three numbers aim a ray, two angles of its launch direction and the Mino time at which it stops, and three say where it
 * has come: w = 1/r and the angular position. Newton's method solves for them, damped by the natural monotonicity test
 * (Deuflhard 2011, Newton Methods for Nonlinear Problems, section 3.2): a step counts if the next one, taken with the same
 * Jacobian, is shorter. Where a ray surely passes the radius of b once on its last way, it stops there instead: beside the
 * horizon frame dragging hardly knows a Mino time. And rays are aimed inward, because outward ones leave the neighborhood of
 * the horizon only if they are launched well: where a is the inner end, b aims at a in the hole that spins the other way
 * (time runs backwards), and once that ray misses by no more than AIM_TURN_ROUND it turns round, and Newton goes on from a. The
 * last trial proves that the ray comes to b, up to a step of Newton's that is as short as the tolerance, and its derivatives
 * are the spread.
 */
#ifndef BENT_SPACETIME_CONNECT_AIM_H
#define BENT_SPACETIME_CONNECT_AIM_H
#include "base/lane_math.h"
#include "spacetime/connect_flow.h"

enum { AIM_TRIALS_MAX = 24 };
/* Smallest part of a step of Newton's that is tried, and how it grows from one accepted trial to the next. */
#define AIM_DAMPING_MIN 0.015
#define AIM_DAMPING_GROWS 2
/* A ray that misses by less has hit, in units of the tolerance: its derivatives are good enough for the spread, and Newton's
 * last step is taken without another trial, if it leaves less than the second; the rest is left to truncation and rounding. */
#define AIM_HIT 1
#define AIM_LEFT 0.5
/* Longest steps: radians, and relative in Mino time. */
#define AIM_TURN_MAX 0.5
#define AIM_STRETCH_MAX 0.6
/* A miss from which on Newton's steps need no proof; one at which exchanged ends turn round. */
#define AIM_NEAR 1e-5
#define AIM_TURN_ROUND 1e-2
/* Truncation error of derivatives that become a spread, relative: the first in units of the tolerance, and at most the
 * second in units of its square root. */
#define AIM_TURN_FINEST 20
#define AIM_TURN_FINEST_ROOT 0.02
/* Truncation error of a step of the first trial, of later ones in units of their expected miss, and of the final one in
 * units of the tolerance; of derivatives that only aim first, relative. */
#define AIM_TRUNCATION_FIRST 1e-2
#define AIM_TRUNCATION_NEXT 0.1
#define AIM_TRUNCATION 5e-3
#define AIM_TURN_TRUNCATION 0.1

/* What a ray is aimed by. */
typedef struct aim_setting {
  lanes d[3]; /* launch direction, local components */
  lanes time; /* Mino time */
} aim_setting;

/* One search a lane. All members are lanes, masks too: see aim_load. */
typedef struct aim_task {
  flow_place a, b;
  lanes spin, sky;              /* spin as the ray sees it; mask: b is in the sky */
  lanes exchanged, was_sky;     /* masks: a and b have changed places; a stands for the sky */
  lanes lands;                  /* the ray stops at the radius of b: where w grows (1) or falls (-1); at a Mino time (0) */
  lanes swept, calm;            /* angle to be swept, about; precision that trials need beyond the wanted one, e^-swept */
  aim_setting base, trial;      /* where Newton stands, and what is tried */
  lanes jacobian[3][3], step[3], length; /* at the base: of the end, see aim_shot; Newton's step and its size */
  lanes fresh;                  /* mask: there is no base */
  lanes damping, truncation, turn_truncation, trials;
} aim_task;

/* A trial on its way. */
typedef struct aim_flight {
  flow_hole hole;
  flow_ray ray;
  lanes lands, level;                 /* see aim_task; 1 / r of b */
  lanes truncation, turn_truncation;
  lanes left, time, steps;            /* Mino time until its end, and since launch */
  lanes narrow;                       /* least w^2 Delta on the way: dragging magnifies errors by its inverse */
  lanes_mask open, whole, beyond;     /* it goes on; has not fallen in; has passed infinity: no ray, however well it meets */
} aim_flight;

/* Where a trial has come. */
typedef struct aim_shot {
  lanes_mask whole, beyond; /* it has come to its end; see aim_flight */
  lanes narrow;
  flow_ray ray;
  lanes error[3];         /* b minus the end: w, and two angles */
  lanes jacobian[3][3];   /* of the end: rows w and two angles; columns two launch angles and Mino time */
  lanes missed, lever;    /* miss over the radius of b, in the sky an angle; its size per angle of launch */
  lanes steps;
} aim_shot;

/* A search at rest, and its trial. */
enum { AIM_WORDS = sizeof(aim_task) / sizeof(lanes), AIM_FLIGHT_WORDS = sizeof(aim_flight) / sizeof(lanes) };
typedef struct aim_record {
  double task[AIM_WORDS], flight[AIM_FLIGHT_WORDS];
} aim_record;

/* One lane of a struct of so many lanes, from words. Whole lanes are stored: loads that follow at once need not wait. */
LANES_INLINE void aim_load(void *batch, size_t words, int lane, const double *from)
{
  typedef lanes __attribute__((may_alias)) word;
  const lanes_mask here = lanes_mask_from_bits(1u << lane);
  for (size_t k = 0; k < words; k++) ((word *)batch)[k] = lanes_select(here, lanes_all(from[k]), ((word *)batch)[k]);
}

/* All lanes, lane i from from[i]. */
LANES_INLINE void aim_load_all(void *batch, size_t words, const double *const from[LANES])
{
  typedef lanes __attribute__((may_alias)) word;
  for (size_t k = 0; k < words; k++) {
    lanes all;
    for (int i = 0; i < LANES; i++) all[i] = from[i][k];
    ((word *)batch)[k] = all;
  }
}

/* One lane, to words. */
LANES_INLINE void aim_save(const void *batch, size_t words, int lane, double *to)
{
  typedef double __attribute__((may_alias)) word;
  const word *from = (const word *)batch + lane;
  for (size_t k = 0; k < words; k++) to[k] = from[k * LANES];
}

LANES_INLINE void aim_select(lanes_mask mask, const aim_setting *from, aim_setting *to)
{
  for (int k = 0; k < 3; k++) to->d[k] = lanes_select(mask, from->d[k], to->d[k]);
  to->time = lanes_select(mask, from->time, to->time);
}

/* A vector turned about the axis. */
LANES_INLINE void aim_turn(lanes angle, const lanes in[3], lanes out[3])
{
  lanes sine, cosine;
  lanes_sincos(angle, &sine, &cosine);
  const lanes x = in[0], y = in[1];
  out[0] = cosine * x - sine * y, out[1] = sine * x + cosine * y, out[2] = in[2];
}

/* angle / sin(angle) in [0, pi); for small angles by its series. */
LANES_INLINE lanes aim_angle_over_sine(lanes sine, lanes cosine)
{
  lanes ratio = 1 + sine * sine * (1.0 / 6 + sine * sine * 0.075);
  for (int i = 0; i < LANES; i++)
    if (cosine[i] < 0.99999) ratio[i] = atan2(sine[i], cosine[i]) / sine[i];
  return ratio;
}

/* The miss: the error across the ray. Lengths over the radius; in the sky angles at w = 0. */
LANES_INLINE void aim_measure(const flow_place *b, lanes_mask sky, aim_shot *shot)
{
  const lanes scale = lanes_select(sky, lanes_all(1e30), 1 / lanes_select(sky, lanes_all(1), b->w));
  const lanes(*j)[3] = shot->jacobian;
  const lanes along[3] = {scale * j[0][2], j[1][2], j[2][2]};
  const lanes inverse = 1 / lanes_max(lanes_dot(along, along), lanes_all(1e-300));
  lanes size2[3];
  for (int k = 0; k < 3; k++) {
    const lanes x[3] = {scale * (k < 2 ? j[0][k] : shot->error[0]), k < 2 ? j[1][k] : shot->error[1],
                        k < 2 ? j[2][k] : shot->error[2]};
    const lanes part = lanes_dot(x, along) * inverse;
    const lanes across[3] = {lanes_select(sky, lanes_all(0), x[0] - part * along[0]), x[1] - part * along[1],
                             x[2] - part * along[2]};
    size2[k] = lanes_dot(across, across);
  }
  shot->missed = lanes_sqrt(size2[2]), shot->lever = lanes_sqrt(size2[0] + size2[1]);
}

/* Compares the end of the ray, which has its derivatives, with b. */
LANES_INLINE void aim_compare(const flow_hole *hole, const flow_place *b, lanes_mask sky, aim_shot *shot)
{
  const lanes *target = b->n;
  const flow_ray *ray = &shot->ray;
  const lanes a = hole->spin, w = ray->w.value;
  const lanes delta = (1 - hole->outer * w) * (1 - hole->inner * w);
  const lanes drag_rate = a * w * (2 * ray->energy.value - a * ray->momentum.value * w) / delta;
  lanes u[3], across[2][3], toward[3];
  const lanes n[3] = {ray->n[0].value, ray->n[1].value, ray->n[2].value};
  aim_turn(ray->drag.value, n, u);
  const lanes cosine = lanes_dot(u, target);
  for (int k = 0; k < 3; k++) toward[k] = target[k] - cosine * u[k];
  const lanes ratio = aim_angle_over_sine(lanes_sqrt(lanes_dot(toward, toward)), cosine);
  /* the target's basis, moved along the great circle to the ray's end */
  flow_across(target, across);
  for (int i = 0; i < 2; i++) {
    const lanes shift = lanes_dot(across[i], u) / lanes_max(1 + cosine, lanes_all(1e-12));
    for (int k = 0; k < 3; k++) across[i][k] -= shift * (u[k] + target[k]);
    shot->error[1 + i] = ratio * lanes_dot(across[i], toward);
  }
  shot->error[0] = b->w - w;
  for (int j = 0; j < 3; j++) {
    const lanes turn = j < 2 ? ray->drag.by[j < 2 ? j : 0] : drag_rate;
    lanes change[3], moved[3];
    for (int k = 0; k < 3; k++) change[k] = j < 2 ? ray->n[k].by[j < 2 ? j : 0] : ray->m[k].value;
    change[0] -= turn * n[1], change[1] += turn * n[0];
    aim_turn(ray->drag.value, change, moved);
    shot->jacobian[0][j] = j < 2 ? ray->w.by[j < 2 ? j : 0] : ray->v.value;
    for (int i = 0; i < 2; i++) shot->jacobian[1 + i][j] = lanes_dot(across[i], moved);
  }
  aim_measure(b, sky, shot);
  /* an angle is longest in the scene, over the radius there, across the axis */
  const lanes flat = a * a * w * w, sine2 = target[0] * target[0] + target[1] * target[1];
  const lanes stretch = lanes_select(sky, lanes_all(1), lanes_sqrt((1 + flat) / (1 + flat * sine2)));
  shot->missed *= stretch, shot->lever *= stretch;
}

/* Launches the trial. */
LANES_INLINE void aim_launch(const aim_task *t, aim_flight *f)
{
  f->hole = flow_hole_of(t->spin);
  const flow_metric metric = flow_metric_at(&f->hole, &t->a);
  lanes e[2][3];
  flow_across(t->trial.d, e);
  flow_launch(&f->hole, &t->a, &metric, t->trial.d, e, &f->ray);
  f->lands = t->lands, f->level = t->b.w;
  f->truncation = t->truncation, f->turn_truncation = t->turn_truncation;
  f->left = t->trial.time, f->time = f->steps = lanes_all(0), f->narrow = lanes_all(1);
  f->open = f->whole = f->left > 0, f->beyond = (lanes_mask){0};
}

/* Its next step, with derivatives by `turns` launch angles. */
LANES_INLINE void aim_fly(aim_flight *f, int turns)
{
  const lanes_mask lands = f->lands != 0, open = f->open;
  flow_series series;
  f->beyond |= open & (f->ray.w.value < 0);
  lanes h = flow_expand(&f->hole, &f->ray, turns, f->truncation, f->turn_truncation, &series);
  const lanes before = f->lands * (series.w[0] - f->level), after = f->lands * (series_at(series.w, FLOW_ORDER, h) - f->level);
  const lanes_mask over = lands & (before < 0) & (after >= 0);
  if (lanes_any(over & open)) h = lanes_select(over, flow_crossing(&series, f->level, h, over & open), h);
  h = lanes_select(open, lanes_select(lands, h, lanes_min(h, f->left)), lanes_all(0));
  flow_advance(&f->hole, &series, turns, h, &f->ray);
  f->time += h, f->steps += lanes_select(open, lanes_all(1), lanes_all(0));
  const lanes ahead = lanes_select(over, lanes_all(0), lanes_all(1));
  f->left = lanes_select(open, lanes_select(lands, ahead, f->left - h), f->left);
  const lanes w = f->ray.w.value;
  f->narrow = lanes_min((1 - f->hole.outer * w) * (1 - f->hole.inner * w), f->narrow);
  f->whole &= ~open | ((1 - f->hole.outer * w > FLOW_FALLEN) & ((w > 0) | ~lands | over));
  f->open &= (f->left > 0) & f->whole & (f->steps < FLOW_STEPS_MAX);
}

/* What has come of a trial that is over, but for its comparison with b. A ray that lands sets its Mino time. */
LANES_INLINE void aim_end(aim_task *t, const aim_flight *f, aim_shot *shot)
{
  shot->whole = f->whole & (f->left == 0);
  shot->beyond = f->beyond | ((lanes_mask)t->sky & (f->ray.v.value >= 0));
  shot->narrow = f->narrow, shot->steps = f->steps, shot->ray = f->ray;
  t->trial.time = lanes_select((f->lands != 0) & shot->whole, f->time, t->trial.time);
}

/* A whole trial without derivatives; only for where it goes. */
LANES_INLINE aim_shot aim_shoot(aim_task *t)
{
  aim_flight flight;
  aim_shot shot;
  aim_launch(t, &flight);
  while (lanes_any(flight.open)) aim_fly(&flight, 0);
  aim_end(t, &flight, &shot);
  return shot;
}

/* The inverse of the Jacobian, for relative steps in Mino time; not finite if there is none. */
LANES_INLINE void aim_invert(const lanes jacobian[3][3], lanes time, lanes inverse[3][3])
{
  lanes m[3][3];
  for (int i = 0; i < 3; i++) m[i][0] = jacobian[i][0], m[i][1] = jacobian[i][1], m[i][2] = jacobian[i][2] * time;
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) {
      const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      inverse[j][i] = m[i1][j1] * m[i2][j2] - m[i1][j2] * m[i2][j1];
    }
  const lanes determinant = m[0][0] * inverse[0][0] + m[0][1] * inverse[1][0] + m[0][2] * inverse[2][0];
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) inverse[i][j] /= determinant;
}

LANES_INLINE lanes aim_step(const lanes inverse[3][3], const lanes error[3], lanes step[3])
{
  for (int i = 0; i < 3; i++) step[i] = lanes_dot(inverse[i], error);
  return lanes_sqrt(lanes_dot(step, step));
}

/* The setting that lies a step from another. */
LANES_INLINE aim_setting aim_moved(const aim_setting *from, const lanes step[3])
{
  aim_setting to;
  lanes e[2][3];
  flow_across(from->d, e);
  for (int k = 0; k < 3; k++) to.d[k] = from->d[k] + step[0] * e[0][k] + step[1] * e[1][k];
  const lanes length = lanes_sqrt(lanes_dot(to.d, to.d));
  for (int k = 0; k < 3; k++) to.d[k] /= length;
  to.time = from->time * (1 + step[2]);
  return to;
}

/* The largest part of a step that is not too long. */
LANES_INLINE lanes aim_longest(const lanes step[3])
{
  const lanes turn = lanes_sqrt(step[0] * step[0] + step[1] * step[1]) * (1 / AIM_TURN_MAX);
  return 1 / lanes_max(lanes_all(1), lanes_max(turn, lanes_abs(step[2]) * (1 / AIM_STRETCH_MAX)));
}

/* How a ray arrives at b: returns its local energy there; d: its local unit direction. */
LANES_INLINE lanes aim_arrival(const flow_hole *hole, const flow_place *b, const flow_ray *ray, lanes d[3])
{
  const flow_metric g = flow_metric_at(hole, b);
  lanes m[3], from[3] = {ray->m[0].value, ray->m[1].value, ray->m[2].value};
  aim_turn(ray->drag.value, from, m);
  const lanes south[3] = {g.cosine * g.east[1], -g.cosine * g.east[0], -g.sine}, root = lanes_sqrt(g.sigma);
  d[0] = -ray->v.value / (root * lanes_sqrt(g.delta));
  d[1] = lanes_dot(m, south) * b->w / root;
  d[2] = (m[0] * g.east[0] + m[1] * g.east[1]) * b->w * root / lanes_sqrt(g.area);
  const lanes length = lanes_sqrt(lanes_dot(d, d));
  for (int k = 0; k < 3; k++) d[k] /= length;
  return (ray->energy.value - g.drag * ray->momentum.value) / g.lapse;
}

/* Ends of lanes `which` change places, and time runs backwards. */
LANES_INLINE void aim_exchange(aim_task *t, lanes_mask which)
{
  lanes *const a = (lanes *)&t->a, *const b = (lanes *)&t->b;
  for (size_t k = 0; k < sizeof(flow_place) / sizeof(lanes); k++) {
    const lanes other = a[k];
    a[k] = lanes_select(which, b[k], other), b[k] = lanes_select(which, other, b[k]);
  }
  t->spin = lanes_select(which, -t->spin, t->spin);
  t->exchanged = (lanes)((lanes_mask)t->exchanged ^ which);
}

/* Moves the end of a ray as a step of its launch does, to first order: what aim_arrival asks of it. time: its Mino time. */
LANES_INLINE void aim_follow(const flow_hole *hole, const lanes step[3], lanes time, flow_ray *ray)
{
  lanes rates[5]; /* by Mino time: of v, m, drag */
  flow_rates(hole, ray, rates);
  const lanes later = step[2] * time;
  flow_number *const moving[7] = {&ray->v, &ray->m[0], &ray->m[1], &ray->m[2], &ray->drag, &ray->energy, &ray->momentum};
  for (int i = 0; i < 7; i++) {
    moving[i]->value += step[0] * moving[i]->by[0] + step[1] * moving[i]->by[1];
    if (i < 5) moving[i]->value += later * rates[i];
  }
}

/* Exchanged ends take their own places again: the ray is launched from where it arrives, its last step taken. To first
 * order that needs no trial. */
LANES_INLINE void aim_turn_round(aim_task *t, const aim_shot *shot, lanes_mask which)
{
  lanes d[3];
  const flow_hole hole = flow_hole_of(t->spin);
  const lanes energy = aim_arrival(&hole, &t->b, &shot->ray, d);
  const lanes_mask sky = (lanes_mask)t->was_sky & which;
  const lanes beyond = lanes_select(sky, t->a.w / shot->ray.energy.value, lanes_all(0));
  for (int k = 0; k < 3; k++) t->trial.d[k] = lanes_select(which, -d[k], t->trial.d[k]);
  t->trial.time = lanes_select(which, (t->trial.time + beyond) * energy, t->trial.time);
  aim_exchange(t, which);
  t->b.w = lanes_select(sky, lanes_all(0), t->b.w);
  t->sky = (lanes)((lanes_mask)t->sky | sky);
  t->lands = lanes_select(which, lanes_all(0), t->lands);
  t->fresh = (lanes)((lanes_mask)t->fresh | which);
}

/* Estimated miss that truncation and rounding leave, see search_floor. */
LANES_INLINE lanes aim_floor(const aim_task *t, const aim_shot *shot)
{
  const lanes growth = 1 + shot->lever * t->a.w * shot->ray.swept / t->trial.time;
  return (t->truncation + 4 * EPSILON) * lanes_sqrt(shot->steps) * growth / shot->narrow + EPSILON * (8 + shot->lever);
}

/* What has become of a trial. */
typedef struct aim_result {
  lanes_mask found, lost; /* the search is over */
  lanes error;            /* estimated miss */
} aim_result;

/* The truncation error that the last trial must keep below. */
LANES_INLINE lanes aim_finest(const aim_task *t, const aim_shot *shot, double tolerance)
{
  const lanes share = AIM_TRUNCATION * tolerance * t->calm * shot->narrow;
  return lanes_max(lanes_min(share, lanes_all(1e-6)), lanes_all(1e-16));
}

/* See AIM_TURN_FINEST. */
LANES_INLINE lanes aim_turn_finest(double tolerance)
{
  return lanes_all(fmin(AIM_TURN_FINEST * tolerance, AIM_TURN_FINEST_ROOT * sqrt(tolerance)));
}

/* Sets the step that follows an accepted trial, whose Newton step is `step` where that is known. */
LANES_INLINE void aim_accept(aim_task *t, const aim_shot *shot, lanes_mask accept, lanes_mask known, const lanes step[3],
                             lanes length)
{
  aim_select(accept, &t->trial, &t->base);
  for (int i = 0; i < 3; i++) {
    for (int j = 0; j < 3; j++) t->jacobian[i][j] = lanes_select(accept, shot->jacobian[i][j], t->jacobian[i][j]);
    t->step[i] = lanes_select(accept, lanes_select(known, step[i], lanes_all(0)), t->step[i]);
  }
  t->length = lanes_select(accept, length, t->length);
  const lanes grown = lanes_min(lanes_select((lanes_mask)t->fresh, lanes_all(1), AIM_DAMPING_GROWS * t->damping),
                                aim_longest(t->step));
  t->damping = lanes_select(accept, grown, 0.3 * t->damping);
  t->fresh = (lanes)((lanes_mask)t->fresh & ~accept);
}

/* How well the next trial is traced, where this one was accepted; forward: lanes that launch it from a. Newton's step brings
 * a miss to about its square: truncation errors follow that, and are the final ones as soon as the next trial may be the
 * last. */
LANES_INLINE void aim_refine(aim_task *t, const aim_shot *shot, lanes_mask accept, lanes_mask forward, double tolerance)
{
  const lanes expected = shot->missed * shot->missed, finest = aim_finest(t, shot, tolerance);
  const lanes turn_finest = aim_turn_finest(tolerance), next = AIM_TRUNCATION_NEXT * expected * t->calm * shot->narrow;
  const lanes_mask last = forward & (expected <= tolerance);
  const lanes wanted = lanes_select(last, finest, lanes_max(next, finest));
  const lanes turn_wanted = lanes_select(last, turn_finest, lanes_max(expected, turn_finest));
  t->truncation = lanes_select(accept & forward, lanes_min(wanted, t->truncation), t->truncation);
  t->turn_truncation = lanes_select(accept, lanes_min(turn_wanted, t->turn_truncation), t->turn_truncation);
}

/* Judges a trial of the lanes in `busy` that is over, and chooses the next; shot->ray is moved there, to first order: a ray
 * that is found needs no more, one that turns round is launched from its end. A ray on the axis that comes to the axis may
 * be turned about it: it has no step in that direction, and needs none. */
LANES_INLINE aim_result aim_judge(aim_task *t, const aim_flight *flight, double tolerance, lanes_mask busy, aim_shot *shot)
{
  aim_end(t, flight, shot);
  const flow_hole hole = flow_hole_of(t->spin);
  aim_compare(&hole, &t->b, (lanes_mask)t->sky, shot);
  lanes inverse[3][3], at_base[3][3], step[3], moved[3];
  aim_invert(shot->jacobian, t->trial.time, inverse);
  aim_invert(t->jacobian, t->base.time, at_base);
  const lanes length = aim_step(inverse, shot->error, step), shorter = aim_step(at_base, shot->error, moved);
  const lanes_mask fresh = (lanes_mask)t->fresh, exchanged = (lanes_mask)t->exchanged;
  const lanes floor = aim_floor(t, shot), missed = shot->missed;
  const lanes_mask fine = (t->truncation <= 1.1 * aim_finest(t, shot, tolerance)) &
                          (t->turn_truncation <= aim_turn_finest(tolerance));
  const lanes_mask better = fresh | (shorter <= (1 - 0.25 * t->damping) * t->length) | (missed <= AIM_NEAR);
  const lanes_mask known = lanes_is_finite(length);
  const lanes effect = (1 + shot->lever) * length, rest = effect * effect; /* of a step; what it leaves, about */
  const lanes left = lanes_min(rest, missed);
  const lanes_mask hit = ((missed <= AIM_HIT * tolerance) & (left <= AIM_LEFT * tolerance)) | (missed <= floor);
  const lanes_mask accept = busy & shot->whole & better & (known | hit);
  aim_result result = {.error = floor + left};
  result.found = accept & hit & fine & ~exchanged & ~shot->beyond;
  const lanes_mask turns = accept & exchanged & (missed < AIM_TURN_ROUND);

  aim_accept(t, shot, accept, known, step, length);
  const lanes last = lanes_select(rest < missed, lanes_all(1), lanes_all(0));
  const lanes part = lanes_select(result.found, last, t->damping);
  for (int i = 0; i < 3; i++) moved[i] = part * t->step[i];
  t->trial = aim_moved(&t->base, moved);
  aim_follow(&hole, moved, t->base.time, &shot->ray);
  aim_refine(t, shot, accept, turns | ~exchanged, tolerance);
  t->trials += 1;
  if (lanes_any(turns)) aim_turn_round(t, shot, turns);
  result.lost = busy & ~turns & ~result.found &
                ((fresh & ~accept) | (t->damping < AIM_DAMPING_MIN) | (t->trials >= AIM_TRIALS_MAX));
  return result;
}
#endif
