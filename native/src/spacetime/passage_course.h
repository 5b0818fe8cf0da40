/* The course of a ray through a lens sphere as a function of one angle, for passage.kernel.c. Kernel code.
 *
 * psi is the angle at a, or where a's straight piece meets the sphere: to the outward radial if a is inside and b on the
 * same side, else to the inward one. With b / L the local sine, L = r / lapse, all other angles follow.
 */
#ifndef BENT_SPACETIME_PASSAGE_COURSE_H
#define BENT_SPACETIME_PASSAGE_COURSE_H
#include <string.h>

#include "spacetime/endpoint_ellis.h"
#include "spacetime/endpoint_schwarzschild.h"
#include "spacetime/passage.h"

#define ROOT_27 5.19615242270663188058

LANES_INLINE lanes lanes_angle(lanes sine, lanes cosine)
{
  lanes angle = {0};
  for (int i = 0; i < LANES; i++) angle[i] = atan2(sine[i], cosine[i]);
  return angle;
}

/* A radius inside a lens. */
typedef struct shell {
  lanes radius;                  /* of the chart */
  lanes size, lever;             /* r, and L = r / lapse */
  lanes_mask within;             /* inside the photon sphere */
  lanes critical_sine, critical; /* the acute angle of the critical ray to the radial */
  lanes zeta;                    /* size of the place on the critical ray, as in connect_orbit.h */
} shell;

LANES_INLINE shell shell_at(const bent_spacetime *s, lanes radius)
{
  shell at = {.radius = radius, .within = {0}};
  lanes cosine;
  if (s->kind == BENT_ELLIS) {
    const lanes half = 0.5 * s->throat_radius / radius, inverse = 1 / (1 + half * half);
    at.critical_sine = 2 * half * inverse, cosine = (1 - half) * (1 + half) * inverse;
    at.size = at.lever = s->throat_radius / at.critical_sine;
    at.zeta = cosine / (1 + at.critical_sine);
  } else {
    const schwarzschild_place place = schwarzschild_place_at(s->mass, s->chart == BENT_CHART_ISOTROPIC, radius);
    const lanes d = s->mass * place.above, root = lanes_sqrt(lanes_max(1 + 2 * d, lanes_all(0)));
    at.size = 1 / place.w, at.lever = at.size / place.lapse;
    at.critical_sine = ROOT_27 * s->mass / at.lever, cosine = ROOT_27 * lanes_abs(d) * root;
    at.zeta = lanes_abs(d / (1 + d + root)), at.within = d > 0;
  }
  at.critical = lanes_angle(at.critical_sine, cosine);
  return at;
}

/* E(r, x), odd in x. */
LANES_INLINE lanes sweep(const bent_spacetime *s, const shell *at, lanes cosine, lanes sine)
{
  aim a;
  memset(&a, 0, sizeof a);
  a.radius = at->radius, a.cosine = cosine, a.sine = lanes_abs(sine);
  const endpoint end = s->kind == BENT_ELLIS
                           ? endpoint_ellis(s->throat_radius, &a)
                           : endpoint_schwarzschild(s->mass, s->chart == BENT_CHART_ISOTROPIC, &a);
  return lanes_copysign(lanes_abs(end.swept), sine);
}

/* dE/dx by a difference over +-h. */
LANES_INLINE lanes sweep_rate(const bent_spacetime *s, const shell *at, lanes cosine, lanes sine, lanes h)
{
  const lanes ch = 1 - 0.5 * h * h, sh = h * (1 - h * h * (1.0 / 6));
  return (sweep(s, at, cosine * ch - sine * sh, sine * ch + cosine * sh) -
          sweep(s, at, cosine * ch + sine * sh, sine * ch - cosine * sh)) / (2 * h);
}

/* The pairs of one group of lanes. */
typedef struct route {
  const bent_spacetime *spacetime;
  passage_kind kind;
  int endless;              /* b has no sphere on its side */
  shell first, last;        /* where a and b stand, or where the straight pieces to them begin */
  lanes_mask out_a, out_b;  /* there are such pieces */
  lanes lever_a, lever_b;   /* L d / R of ends outside; INFINITY in the sky */
  lanes critical;           /* psi of the critical ray */
} route;

/* A trial. */
typedef struct course {
  lanes sine, cosine;           /* of psi */
  lanes last_sine, last_cosine; /* to the outward radial at `last` */
  lanes a_cosine, b_cosine;     /* sizes, at ends outside */
  lanes straight;               /* swept outside */
} course;

/* The cosine where L is `ratio` times smaller: exact to rounding also where the sine is near 1. */
LANES_INLINE lanes other_cosine(lanes ratio, lanes cosine)
{
  return lanes_sqrt(lanes_max((1 - ratio) * (1 + ratio) + ratio * ratio * cosine * cosine, lanes_all(0)));
}

LANES_INLINE course course_at(const route *r, lanes psi)
{
  course c;
  lanes_sincos(psi, &c.sine, &c.cosine);
  const lanes last = r->endless ? lanes_all(0) : r->first.lever / r->last.lever;
  const lanes a = r->first.lever / r->lever_a, b = r->first.lever / r->lever_b;
  c.last_sine = lanes_min(last * c.sine, lanes_all(1)), c.last_cosine = other_cosine(last, c.cosine);
  c.a_cosine = other_cosine(a, c.cosine), c.b_cosine = other_cosine(b, c.cosine);
  /* asin(p / R) - asin(p / d) of both ends, as the angle of a product of complex numbers */
  const lanes a_sine = a * c.sine, b_sine = b * c.sine, one = lanes_all(1), none = lanes_all(0);
  const lanes ax = lanes_select(r->out_a, c.cosine * c.a_cosine + c.sine * a_sine, one);
  const lanes ay = lanes_select(r->out_a, c.sine * c.a_cosine - c.cosine * a_sine, none);
  const lanes bx = lanes_select(r->out_b, c.last_cosine * c.b_cosine + c.last_sine * b_sine, one);
  const lanes by = lanes_select(r->out_b, c.last_sine * c.b_cosine - c.last_cosine * b_sine, none);
  c.straight = lanes_angle(ax * by + ay * bx, ax * bx - ay * by);
  return c;
}

LANES_INLINE lanes first_cosine(const route *r, const course *c) { return r->kind == PASSAGE_OUT ? c->cosine : -c->cosine; }

LANES_INLINE lanes course_swept(const route *r, const course *c)
{
  lanes swept = sweep(r->spacetime, &r->first, first_cosine(r, c), c->sine) + c->straight;
  if (!r->endless) swept -= sweep(r->spacetime, &r->last, c->last_cosine, c->last_sine);
  return swept;
}

/* d(swept)/d(psi); gap: of psi to the critical ray. */
LANES_INLINE lanes course_rate(const route *r, const course *c, lanes gap)
{
  const double step = 3e-4; /* of the distance to the critical ray, up to which E is smooth: an error of 3e-8 */
  const lanes sign = lanes_all(r->kind == PASSAGE_OUT ? 1 : -1), one = lanes_all(1), none = lanes_all(0);
  const lanes first = sweep_rate(r->spacetime, &r->first, first_cosine(r, c), c->sine, step * lanes_min(gap, one));
  const lanes a = r->first.lever / r->lever_a * c->cosine, b = r->first.lever / r->lever_b * c->cosine;
  lanes rate = sign * first + lanes_select(r->out_a, 1 - a / c->a_cosine, none);
  if (r->endless) return rate;
  const lanes critical = lanes_select(r->last.within, r->last.critical, M_PI - r->last.critical);
  const lanes h = step * lanes_min(critical - lanes_angle(c->last_sine, c->last_cosine), one);
  const lanes last = sweep_rate(r->spacetime, &r->last, c->last_cosine, c->last_sine, h);
  const lanes chain = r->first.lever / r->last.lever * c->cosine / c->last_cosine;
  rate += lanes_select(r->out_b, chain - b / c->b_cosine, none) - last * chain;
  return rate;
}
#endif
