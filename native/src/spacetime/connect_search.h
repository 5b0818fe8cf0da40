/* Root search of connections: the launch slope with which an orbit reaches its other end. Kernel code.
 *
 * In the plane of the orbit no two rays from one point meet again before infinity or the horizon: so the end of a trial
 * grows with its slope, and the root is bracketed. The critical slope, of the ray that creeps up to the unstable orbit,
 * bounds the bracket on one side; distances to it count on a logarithmic scale, because that is how the swept angle
 * depends on them.
 */
#ifndef BENT_SPACETIME_CONNECT_SEARCH_H
#define BENT_SPACETIME_CONNECT_SEARCH_H
#include "spacetime/connect_orbit.h"

enum { SEARCH_TRIALS_MAX = 80 };
/* Truncation error of a step of the final trial, in units of the tolerance. */
#define SEARCH_TRUNCATION 1e-2

/* How well a root is wanted. */
typedef struct search_precision {
  double tolerance;
  int order;               /* of the series of an orbit */
  double first_truncation; /* error of a step of the first trial, and the largest of the final one */
} search_precision;

typedef struct orbit_root {
  lanes_mask found;
  lanes rate, size;    /* x'(0), and Phi / beta: size^2 = rate^2 + (lapse w Phi)^2 */
  lanes arrival_rate;  /* x'(1) */
  lanes eta;           /* deviation at the end per unit of x'(0) */
  lanes error;         /* estimated miss, radians */
} orbit_root;

typedef struct search_bracket {
  lanes low, high;
  lanes critical, side; /* slope of the critical ray; the root lies above it (1) or below (-1) */
} search_bracket;

/* x'' lies in [-1/12, 1/4] Phi^2 between infinity and the horizon (Ellis: within 1/2 Phi^2), which bounds x(1). */
LANES_INLINE search_bracket search_bracket_of(int ellis, const orbit_end *a, const orbit_end *b, lanes swept)
{
  const lanes straight = b->x - a->x, bend = swept * swept, gap = b->zeta - a->zeta * lanes_exp(-swept);
  search_bracket s = {.critical = swept * a->creep, .side = lanes_copysign(lanes_all(1), gap)};
  s.low = straight - bend * (ellis ? 0.25 : 0.125) - 1e-300;
  s.high = straight + bend * (ellis ? 0.25 : 1.0 / 24) + 1e-300;
  const lanes_mask above = s.side > 0;
  s.low = lanes_select(above, lanes_max(s.low, s.critical), s.low);
  s.high = lanes_select(above, s.high, lanes_min(s.high, s.critical));
  return s;
}

/* Weak lens with its second-order term: pi - Phi = b (w_a + w_b) - 4 / b - 15 pi / (4 b^2), by Newton for 1 / b. */
LANES_INLINE lanes search_weak_lens(lanes sum, lanes angle)
{
  lanes x = 0.125 * (lanes_sqrt(angle * angle + 16 * sum) - angle);
  x = lanes_min(x, lanes_all(0.19));
  for (int i = 0; i < 3; i++) {
    const lanes value = x * (angle + x * (4 + x * 11.78097245096172)) - sum;
    x -= value / (angle + x * (8 + x * 35.34291735288517));
  }
  return x;
}

/* First slope to try for a hole. Short way: the straight line of flat space. Longer: the weak lens. Long way: the
 * strong one, along the critical rays in and out, 1 / beta^2 - 1 / beta_c^2 = -16 zeta_a zeta_b e^-Phi. */
LANES_INLINE lanes search_guess_schwarzschild(const orbit_end *a, const orbit_end *b, lanes swept, lanes strong)
{
  lanes sine, cosine;
  lanes_sincos(swept, &sine, &cosine);
  const lanes_mask brief = swept < 2.5, lens = ~brief & (swept < 4.3) & (a->zeta < 0) & (b->zeta < 0);
  const lanes ratio = lanes_select(brief & (swept > 0), swept / sine, lanes_all(1));
  const lanes x = search_weak_lens(a->w + b->w, M_PI - swept);
  const lanes weak2 = x * x - a->w * a->w * (1 - 2 * a->w);
  const lanes weak = swept * lanes_sqrt(lanes_max(weak2, lanes_all(0)));
  return lanes_select(brief, ratio * (b->w - a->w * cosine), lanes_select(lens, weak, strong));
}

/* And for a wormhole. Short way: a straight line of the isotropic chart, whose radii are (1 + |side|) / w, or through
 * the throat a steady climb. Long way: the critical rays. */
LANES_INLINE lanes search_guess_ellis(const orbit_end *a, const orbit_end *b, lanes swept, lanes strong)
{
  lanes sine, cosine;
  lanes_sincos(swept, &sine, &cosine);
  const lanes_mask brief = swept < 2, same_side = a->side * b->side > 0;
  const lanes ratio = lanes_select(brief & (swept > 0), swept / sine, lanes_all(1));
  const lanes nearer = b->w * (1 + lanes_abs(a->side)) / (1 + lanes_abs(b->side));
  const lanes line = lanes_copysign(ratio, a->side) * (a->w * cosine - nearer);
  return lanes_select(brief, lanes_select(same_side, line, b->x - a->x), strong);
}

LANES_INLINE lanes search_guess(int ellis, const orbit_end *a, const orbit_end *b, lanes swept)
{
  const lanes strong2 = a->creep * a->creep - 16 * a->zeta * b->zeta * lanes_exp(-swept);
  const lanes strong = swept * lanes_copysign(lanes_sqrt(lanes_max(strong2, lanes_all(0))), a->creep);
  return ellis ? search_guess_ellis(a, b, swept, strong) : search_guess_schwarzschild(a, b, swept, strong);
}

/* Newton's step, taken in the logarithm of the distance to the critical slope where it shrinks that much. */
LANES_INLINE lanes search_step(const search_bracket *s, lanes rate, const orbit_shot *shot)
{
  const lanes newton = -shot->miss / shot->slope, gap = lanes_abs(rate - s->critical);
  const lanes relative = s->side * newton / lanes_max(gap, lanes_all(1e-300));
  const lanes exponent = lanes_min(lanes_max(relative, lanes_all(-30)), lanes_all(0));
  const lanes shrunk = s->side * gap * (lanes_exp(exponent) - 1);
  return lanes_select(relative < -0.5, shrunk, newton);
}

/* The middle of the bracket, of distances to the critical slope: geometric. */
LANES_INLINE lanes search_middle(const search_bracket *s)
{
  const lanes_mask above = s->side > 0;
  const lanes near = lanes_abs(lanes_select(above, s->low, s->high) - s->critical);
  const lanes away = lanes_abs(lanes_select(above, s->high, s->low) - s->critical);
  return s->critical + s->side * lanes_sqrt(away * lanes_max(near, 1e-3 * away));
}

/* The miss, as an angle, that rounding and truncation leave: errors on the way grow like the deviation, and a launch
 * direction is rounded to EPSILON. */
LANES_INLINE lanes search_floor(const orbit_end *a, lanes swept, lanes size, const orbit_shot *shot, lanes truncation)
{
  const lanes growth = 1 + lanes_abs(shot->eta) * swept;
  const lanes lever = lanes_abs(shot->eta) * size / (a->w * a->lapse); /* miss per angle at launch */
  return (truncation + 2 * EPSILON) * lanes_sqrt(shot->steps) * growth + EPSILON * (4 + lever);
}

/* Lanes that are done: the last step, if it stays in the bracket, is taken without another trial. */
LANES_INLINE void search_accept(orbit_root *root, lanes_mask done, lanes_mask inside, lanes rate, lanes step,
                                lanes missed, lanes floor, const orbit_shot *shot)
{
  const lanes last = lanes_select(inside, step, lanes_all(0));
  root->found |= done;
  root->rate = lanes_select(done, rate + last, root->rate);
  root->arrival_rate = lanes_select(done, shot->rate + last * shot->eta_rate, root->arrival_rate);
  root->eta = lanes_select(done, shot->eta, root->eta);
  root->error = lanes_select(done, floor + lanes_select(inside, missed * missed, missed), root->error);
}

/* guess: a first slope to try. Newton's steps need no better trial than their own error: a trial's truncation error follows
 * the square of the last miss down to the final one. */
LANES_INLINE orbit_root search_root(int ellis, const orbit_end *a, const orbit_end *b, lanes swept, lanes guess,
                                    search_precision precision, lanes_mask open)
{
  search_bracket s = search_bracket_of(ellis, a, b, swept);
  const lanes tangential = a->lapse * a->w * swept;
  const lanes calm = lanes_exp(lanes_min(M_PI - swept, lanes_all(0)));
  const double tolerance = precision.tolerance, first = precision.first_truncation;
  const lanes finest = lanes_max(lanes_min(SEARCH_TRUNCATION * tolerance * calm, lanes_all(first)), lanes_all(1e-16));
  lanes truncation = lanes_max(first * calm, finest);
  orbit_root root = {.found = {0}};
  lanes rate = lanes_select((guess > s.low) & (guess < s.high), guess, search_middle(&s));
  for (int i = 0; i < SEARCH_TRIALS_MAX && lanes_any(open); i++) {
    const lanes size = lanes_sqrt(rate * rate + tangential * tangential), weight = swept / size;
    const orbit_shot shot = orbit_shoot(ellis, a, b, swept, rate, weight, truncation, precision.order);
    const lanes missed = lanes_abs(shot.miss) * weight, floor = search_floor(a, swept, size, &shot, truncation);
    const lanes_mask sure = missed > floor;
    s.low = lanes_select(sure & (shot.miss < 0), rate, s.low);
    s.high = lanes_select(sure & (shot.miss > 0), rate, s.high);
    const lanes step = search_step(&s, rate, &shot), next = rate + step;
    const lanes_mask inside = (next > s.low) & (next < s.high), fine = truncation <= finest;
    const lanes_mask stuck = lanes_abs(step) <= 2 * EPSILON * lanes_abs(rate);
    const lanes_mask done = open & fine & shot.whole & ((missed <= 0.1 * tolerance) | ~sure | stuck);
    search_accept(&root, done, inside, rate, step, missed, floor, &shot);
    open &= ~done;
    rate = lanes_select(open, lanes_select(inside, next, search_middle(&s)), rate);
    const lanes wanted = lanes_max(1e-3 * missed * missed * calm, finest);
    const lanes better = lanes_select(sure, lanes_min(wanted, truncation), finest);
    truncation = lanes_select(open & shot.whole, better, truncation);
  }
  root.size = lanes_sqrt(root.rate * root.rate + tangential * tangential);
  return root;
}
#endif
