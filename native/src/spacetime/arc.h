/* Taylor arcs: light rays as pieces of polynomials in Mino time, LANES rays side by side, in every curved spacetime.
 *
 * The equations of motion are separable (Carter 1968) and polynomial in Mino time: w = 1/r, a unit vector n on the sphere
 * and, with spin, one rotation angle about the axis (Kerr); in a plane through the center, n only turns at a constant rate
 * (Schwarzschild, Ellis). One arc is the Taylor series of that motion with the longest step that keeps a tolerance. Life
 * of a batch:
 *
 *     arc_space space = arc_space_make(&spacetime);
 *     arc_launch(&space, origin, direction, &ray);
 *     for (;;) {
 *       arc_expand(&space, &ray, tolerance, &arc);        // arc.step: the arc is good on offsets [0, step]
 *       arc_land(&space, &ray, &arc);                     // shortens step where the ray ends: arc.escapes, arc.falls
 *       ... arc_position, arc_direction at any offset of [0, step] ...
 *       arc_advance(&space, &arc, offset, &ray);          // on from there; a lane with offset 0 stays
 *     }
 *
 * Everything is per lane: lanes that are over may be kept, refilled (arc_ray_copy_lane) or advanced by 0. Units: lengths
 * of the spacetime, G = c = 1; directions are local unit directions (bentlight/spacetime.h). Flat space, and holes of mass
 * 0, have no arcs: ask bent_spacetime_is_flat first.
 */
#ifndef BENT_SPACETIME_ARC_H
#define BENT_SPACETIME_ARC_H
#include <math.h>

#include "base/lanes.h"
#include "bentlight/spacetime.h"
#include "bentlight/trace.h"
#include "spacetime/series.h"

/* What arcs need to know of a spacetime. A Kerr hole without spin counts as Schwarzschild in the areal chart. */
typedef struct arc_space {
  bent_spacetime_kind kind;
  bent_chart chart;
  double mass;
  double spin;           /* s = -a: rays are traced backwards in time, which turns the spin round */
  double throat_radius;
  double outer, inner;   /* radii r of the horizons */
  double horizon;        /* w = 1/r of the outer horizon; Ellis: of the throat */
  int ends_only;         /* set by a consumer that needs no path: frame dragging of falling rays is not resolved */
} arc_space;

/* Constants of the motion and the state at the beginning of an arc. All members are lanes: see arc_ray_copy_lane. */
typedef struct arc_ray {
  lanes energy, momentum; /* E, and L about the axis (Kerr) or b = |r x p| (planar); Ellis: E = 1 */
  lanes carter;           /* Carter's constant Q (Kerr) */
  lanes curl;             /* Q + L^2 (Kerr), L^2 (planar): |n'|^2 = curl + (sE n_z)^2 */
  lanes weight;           /* angle at infinity per error of w, about the impact parameter */
  lanes depth;            /* how far the ray keeps from the critical one, 0 to 1: errors grow like 1/depth */
  lanes doubt;            /* angular error that rounding at launch brings, before division by depth, radians */
  lanes drag_doubt;       /* Kerr: relative error that rounding brings to `drag`, if the ray escapes */
  lanes peak;             /* w where the radial barrier stands, the photon sphere of this ray; Ellis: the throat */
  lanes_mask doomed;      /* must fall through the horizon */
  lanes w, v;             /* 1/r and its rate dw/dlambda; Ellis: v = dchi/dlambda */
  lanes base, rise;       /* Schwarzschild: w = base + rise, with base = peak where a rounding of w would grow, else 0 */
  lanes side;             /* Ellis: p = sin chi = l/r; negative beyond the throat */
  lanes n[3], m[3];       /* Kerr: n and n'. Planar: n at launch and the unit vector it turns towards */
  lanes drag;             /* Kerr: frame dragging so far, radians about +z */
  lanes swept;            /* length of the path of n on the unit sphere so far, radians, without frame dragging */
} arc_ray;

/* Orders to expand to: low ones are cheapest down to a tolerance of about 1e-9, below it high ones. */
enum { ARC_ORDER_LOW = 12, ARC_ORDER_MAX = 20 };
#define ARC_LOW_TOLERANCE 1e-9
/* The truncation error to allow an arc of a ray, in units of the error wanted of the ray: it has 5 to 20 arcs. */
#define ARC_SHARE 0.2
/* More arcs than any ray needs that double precision can resolve. */
#define ARC_STEPS_MAX 2000

/* The series of an arc: Schwarzschild has the first, Ellis w, side and rate (v), Kerr all five. */
enum { ARC_W, ARC_NX, ARC_NY, ARC_NZ, ARC_DRAG, ARC_SERIES_COUNT, ARC_SIDE = ARC_NX, ARC_RATE = ARC_NY };

/* Coefficients in the offset from the arc's beginning, in Mino time. Valid on [0, step]. */
typedef struct arc {
  int order; /* the same for all lanes */
  lanes series[ARC_SERIES_COUNT][ARC_ORDER_MAX + 1];
  lanes step;
  lanes_mask escapes, falls; /* after arc_land: the ray reaches infinity, the horizon, at offset `step` */
} arc;

/* Spacing of doubles at 1. */
#define EPSILON 2.220446049250313e-16
/* Longest turn of n in one arc, radians; a bound for chords, and no step may pass infinity twice. */
#define ARC_TURN_MAX 2.0
/* An arc ends at this fraction of the horizon's w: frame dragging has a pole there, and no surface can stand beyond. */
#define ARC_HORIZON (1 - 1e-7)

LANES_INLINE arc_space arc_space_make(const bent_spacetime *s)
{
  arc_space space = {.kind = s->kind, .chart = s->chart, .mass = s->mass, .throat_radius = s->throat_radius};
  if (s->kind == BENT_KERR && s->spin == 0) space.kind = BENT_SCHWARZSCHILD, space.chart = BENT_CHART_AREAL;
  if (space.kind == BENT_KERR) space.spin = -s->spin;
  space.outer = s->mass + sqrt((s->mass - space.spin) * (s->mass + space.spin));
  space.inner = space.spin * space.spin / space.outer;
  space.horizon = 1 / (s->kind == BENT_ELLIS ? s->throat_radius : space.outer);
  return space;
}

/* Copies one lane of a batch into a lane of another. */
LANES_INLINE void arc_ray_copy_lane(arc_ray *to, int to_lane, const arc_ray *from, int from_lane)
{
  typedef double __attribute__((may_alias)) word;
  const word *source = (const word *)from + from_lane;
  word *target = (word *)to + to_lane;
  for (size_t k = 0; k < sizeof(arc_ray) / sizeof(lanes); k++) target[k * LANES] = source[k * LANES];
}

LANES_INLINE void arc_copy_lane(const arc_space *space, arc *to, int to_lane, const arc *from, int from_lane)
{
  const int count = space->kind == BENT_KERR ? ARC_SERIES_COUNT : space->kind == BENT_ELLIS ? ARC_RATE + 1 : 1;
  to->order = from->order;
  for (int i = 0; i < count; i++)
    for (int k = 0; k <= from->order; k++) to->series[i][k][to_lane] = from->series[i][k][from_lane];
  to->step[to_lane] = from->step[from_lane];
  to->escapes[to_lane] = from->escapes[from_lane], to->falls[to_lane] = from->falls[from_lane];
}

/* Rays first .. of arrays of origins and directions (of index[first ..] if given), directions normalized. */
LANES_INLINE void arc_load(const double (*origins)[3], const double (*directions)[3], const uint32_t *index,
                           size_t first, size_t n, lanes origin[3], lanes direction[3])
{
  lanes_load_rows(origins, index, first, n, origin);
  lanes_load_rows(directions, index, first, n, direction);
  const lanes length = lanes_sqrt(lanes_dot(direction, direction));
  for (int k = 0; k < 3; k++) direction[k] /= length;
}

/* The Mino-time step that brings the last term of a series to `tolerance`, from the sizes of the last four: size[i]
 * belongs to order - i. Each is an estimate of the radius of convergence, size^(-1 / order). The last two would do for
 * most rays, but symmetric ones (at a turning point, at r = 6M) have up to three vanishing terms in a row. */
LANES_INLINE lanes arc_step_length(const lanes size[4], int order, lanes tolerance)
{
  lanes inverse_radius = lanes_all(1e-100);
#pragma GCC unroll 4
  for (int i = 0; i < 4; i++)
    inverse_radius = lanes_max(inverse_radius, lanes_rough_root(size[i], 1.0 / (order - i)));
  return 0.9 * lanes_rough_root(tolerance, 1.0 / order) / inverse_radius;
}

/* The plane of an orbit: n along the origin, m the unit vector in which the ray leaves it, L = r |tangential direction|.
 * Needs ray->w. Cross products keep m exact for nearly radial rays. */
LANES_INLINE void arc_launch_planar(const lanes origin[3], const lanes direction[3], lanes radius, arc_ray *ray)
{
  lanes *n = ray->n, *m = ray->m, normal[3];
  for (int k = 0; k < 3; k++) n[k] = origin[k] / radius;
  for (int k = 0; k < 3; k++)
    normal[k] = direction[(k + 1) % 3] * n[(k + 2) % 3] - direction[(k + 2) % 3] * n[(k + 1) % 3];
  for (int k = 0; k < 3; k++) m[k] = n[(k + 1) % 3] * normal[(k + 2) % 3] - n[(k + 2) % 3] * normal[(k + 1) % 3];
  const lanes tangential = lanes_sqrt(lanes_dot(m, m));
  for (int k = 0; k < 3; k++) m[k] /= lanes_select(tangential > 0, tangential, lanes_all(1));
  ray->momentum = tangential / ray->w;
  ray->curl = ray->momentum * ray->momentum;
  ray->carter = ray->drag = ray->swept = lanes_all(0);
}

/* n and the unit vector along n' at an offset of a planar ray. */
LANES_INLINE void arc_planar_basis(const arc_ray *ray, lanes offset, lanes n[3], lanes m[3])
{
  lanes sine, cosine;
  lanes_sincos(ray->swept + ray->momentum * offset, &sine, &cosine);
  for (int k = 0; k < 3; k++) {
    n[k] = cosine * ray->n[k] + sine * ray->m[k];
    m[k] = cosine * ray->m[k] - sine * ray->n[k];
  }
}

/* Rounding of the direction moves the impact parameter b by eps r, and the angle of arrival by that times about
 * size / (b^2 + size^2), where `size` is the length on which the object bends rays. */
LANES_INLINE lanes arc_launch_doubt(const arc_ray *ray, double size)
{
  const lanes E2 = ray->energy * ray->energy, b2 = lanes_abs(ray->curl), size2 = size * size * E2;
  return EPSILON * (1 + E2 * size / ((b2 + size2) * ray->w + 1e-300));
}

/* Fate and conditioning of a ray outside a hole, known at launch. w'^2 = P(w) has one barrier between infinity and the
 * horizon, at ray->peak: P there, `barrier`, tells whether the ray can pass. `scale`: the size of the terms of P.
 * Near the top of the barrier the motion is x'' = k^2 x with x = w - peak, and P = barrier + (kx)^2: an error e of a ray at
 * distance x0 from the top (its speed counts as distance too) has grown to e x0 / barrier when the ray leaves, to e / x0
 * if it does not come closer. `gain`: the growth that frame dragging adds. */
LANES_INLINE void arc_judge(arc_ray *ray, lanes barrier, lanes scale, lanes gain)
{
  const lanes_mask inward = ray->v > 0, outward = ray->v < 0, inside = ray->w > ray->peak, open = barrier > 0;
  const lanes_mask toward = (inward & ~inside) | (outward & inside);
  const lanes apart = lanes_abs(ray->w - ray->peak) / lanes_max(ray->peak, lanes_all(1e-300)) +
                      lanes_abs(ray->v) / lanes_sqrt(scale);
  ray->doomed = (inward & (inside | open)) | (inside & ~inward & ~(outward & open));
  ray->side = lanes_all(1);
  const lanes near = lanes_min(apart, lanes_all(1)), closest = lanes_abs(barrier) / (scale * near);
  ray->depth = lanes_min(lanes_select(toward, closest, near) / gain, lanes_all(1));
}

#include "spacetime/ellis.h"
#include "spacetime/kerr.h"
#include "spacetime/schwarzschild.h"

/* Launches LANES rays. origin: in spacetime axes, outside the horizon; direction: local, unit length. */
LANES_INLINE void arc_launch(const arc_space *space, const lanes origin[3], const lanes direction[3], arc_ray *ray)
{
  if (space->kind == BENT_KERR) kerr_launch(space, origin, direction, ray);
  else if (space->kind == BENT_ELLIS) ellis_launch(space, origin, direction, ray);
  else schwarzschild_launch(space, origin, direction, ray);
}

/* The Taylor series at the ray's state and the step that keeps the angular `tolerance` (radians, per arc; rays near the
 * critical one get what their conditioning asks for). order: a constant up to ARC_ORDER_MAX. */
LANES_INLINE void arc_expand_to(const arc_space *space, const arc_ray *ray, lanes tolerance, int order, arc *arc)
{
  const lanes wanted = lanes_max(tolerance * ray->depth, lanes_all(3e-17));
  arc->order = order;
  if (space->kind == BENT_KERR) kerr_expand(space, ray, wanted, order, arc);
  else if (space->kind == BENT_ELLIS) ellis_expand(space, ray, wanted, order, arc);
  else schwarzschild_expand(space, ray, wanted, order, arc);
}

LANES_INLINE void arc_expand(const arc_space *space, const arc_ray *ray, lanes tolerance, arc *arc)
{
  arc_expand_to(space, ray, tolerance, ARC_ORDER_LOW, arc);
}

/* The offset in [0, step] at which `series` reaches `level`, for lanes in `wanted`, which do cross it before the end, where
 * its value is `end`; `step` for the others. Safeguarded Newton steps, six or until the next would change no digit; lanes
 * stop on their own, so that their neighbors do not matter. */
LANES_INLINE lanes arc_crossing(const arc *arc, const lanes *series, lanes level, lanes end, lanes_mask wanted)
{
  lanes low = {0}, high = arc->step;
  const lanes start = series[0] - level;
  lanes x = lanes_select(wanted, high * start / (series[0] - end), high);
  lanes_mask moving = wanted;
  for (int i = 0; i < 6 && lanes_any(moving); i++) {
    lanes value, slope;
    series_with_slope(series, arc->order, x, &value, &slope);
    value -= level;
    const lanes_mask before = (value > 0) == (start > 0);
    low = lanes_select(before, x, low), high = lanes_select(before, high, x);
    const lanes next = x - value / slope;
    const lanes_mask inside = (next >= low) & (next <= high);
    const lanes_mask last = inside & (lanes_abs(next - x) <= 1e-9 * high);
    x = lanes_select(moving, lanes_select(inside, next, 0.5 * (low + high)), x);
    moving &= ~last;
  }
  return x;
}

/* Ends the arc exactly at infinity (w = 0) or just above the horizon (ARC_HORIZON) where it passes them. */
LANES_INLINE void arc_land(const arc_space *space, const arc_ray *ray, arc *arc)
{
  const lanes *w = arc->series[ARC_W];
  const lanes end = series_at(w, arc->order, arc->step), bottom = lanes_all(space->horizon * ARC_HORIZON);
  arc->escapes = end <= 0;
  arc->falls = space->kind == BENT_ELLIS ? (lanes_mask){0} : (end >= bottom) | (ray->w >= bottom);
  const lanes_mask ends = arc->escapes | arc->falls;
  if (!lanes_any(ends)) return;
  const lanes level = lanes_select(arc->falls, bottom, lanes_all(0));
  arc->step = arc_crossing(arc, w, level, end, ends);
  arc->step = lanes_select(arc->falls & (ray->w >= bottom), lanes_all(0), arc->step);
}

/* Scene position at an offset, as a point [numerator, w] of projective space: position = numerator / w. At infinity w is 0
 * and the numerator points to the ray's asymptotic direction. Ellis, beyond the throat (`far` nonzero): the radius is the
 * other mouth's, the axes are still this one's, so that the position is continuous (ellis_mirror turns to the other's). */
LANES_INLINE void arc_position(const arc_space *space, const arc_ray *ray, const arc *arc, lanes offset,
                               lanes numerator[3], lanes *w, lanes_mask *far)
{
  *far = (lanes_mask){0};
  *w = series_at(arc->series[ARC_W], arc->order, offset);
  if (space->kind == BENT_KERR) kerr_position(space, ray, arc, offset, *w, numerator);
  else if (space->kind == BENT_ELLIS) ellis_position(ray, arc, offset, numerator, far);
  else schwarzschild_position(space, ray, offset, *w, numerator);
}

/* Local unit direction of travel at an offset, written in the axes of arc_position, outward beyond a throat. */
LANES_INLINE void arc_direction(const arc_space *space, const arc_ray *ray, const arc *arc, lanes offset,
                                lanes direction[3])
{
  if (space->kind == BENT_KERR) kerr_direction(space, ray, arc, offset, direction);
  else if (space->kind == BENT_ELLIS) ellis_direction(space, ray, arc, offset, direction);
  else schwarzschild_direction(space, ray, arc, offset, direction);
  const lanes length = lanes_sqrt(lanes_dot(direction, direction));
  for (int k = 0; k < 3; k++) direction[k] /= length;
}

/* Moves the state to an offset of the arc. */
LANES_INLINE void arc_advance(const arc_space *space, const arc *arc, lanes offset, arc_ray *ray)
{
  if (space->kind == BENT_KERR) kerr_advance(space, arc, offset, ray);
  else if (space->kind == BENT_ELLIS) ellis_advance(arc, offset, ray);
  else schwarzschild_advance(arc, offset, ray);
}

/* Asymptotic direction of a ray that has been advanced to infinity (Ellis: angular position, no mirror). */
LANES_INLINE void arc_asymptote(const arc_space *space, const arc_ray *ray, lanes direction[3])
{
  lanes sine, cosine;
  if (space->kind == BENT_KERR) {
    lanes_sincos(ray->drag, &sine, &cosine);
    direction[0] = cosine * ray->n[0] - sine * ray->n[1];
    direction[1] = sine * ray->n[0] + cosine * ray->n[1];
    direction[2] = ray->n[2];
  } else {
    lanes_sincos(ray->swept, &sine, &cosine);
    for (int k = 0; k < 3; k++) direction[k] = cosine * ray->n[k] + sine * ray->m[k];
  }
}

/* Estimated angular error of the state, radians, from how far the invariants have drifted, times the ray's own
 * amplification 1/depth, rounding at launch included. `steps`: arcs so far; the rounding of their few operations adds up like
 * a random walk. Measured against 113-bit arithmetic, at spins up to the largest double below the mass: true errors are at
 * most 1.7 times as large, mostly a tenth. */
LANES_INLINE lanes arc_error(const arc_space *space, const arc_ray *ray, lanes steps)
{
  lanes drift, drag = {0};
  if (space->kind == BENT_KERR) {
    drift = kerr_drift(space, ray);
    drag = lanes_select(ray->doomed, drag, lanes_abs(ray->drag) * ray->drag_doubt);
  } else if (space->kind == BENT_ELLIS) {
    drift = ellis_drift(space, ray);
  } else {
    drift = schwarzschild_drift(space, ray);
  }
  return (drift + ray->doubt + EPSILON * (4 + lanes_sqrt(steps))) / ray->depth + drag;
}
#endif
