/* First guesses for Kerr connections: the orbit of a hole without spin between corresponding places. Kernel code.
 *
 * Around a spinning hole the path of n, in axes that the hole drags along, is nearly a great circle again. So b is turned
 * back by the frame dragging to expect, radii are mapped so that the horizon and the photon orbit of the ray's inclination
 * come to where they are without spin, and the launch direction of that orbit is turned until the ray passes as close to the
 * critical ones. What dragging that ray meets, and how far it winds, mends the guess, until both agree: so the guess knows
 * on which side of the hole, and how often about it, the ray goes.
 */
#ifndef BENT_SPACETIME_CONNECT_GUESS_H
#define BENT_SPACETIME_CONNECT_GUESS_H
#include "spacetime/connect_aim.h"
#include "spacetime/connect_plane.h"
#include "spacetime/connect_search.h"

/* How often a guess is mended, and turned to match, for the first image, the second, and those that are hard to find. */
enum { GUESS_PASSES_FIRST = 1, GUESS_PASSES = 2, GUESS_PASSES_MORE = 6 };
enum { GUESS_MATCHES_FIRST = 2, GUESS_MATCHES = 3, GUESS_MATCHES_MORE = 6 };
/* Where rays stop at the radius of b: where that is surely well conditioned, wherever the orbit without spin is steep
 * there, nowhere. */
typedef enum guess_landings { LANDS_SURELY, LANDS_STEEP, LANDS_NOWHERE } guess_landings;

/* One attempt, for pairs that those before have failed. */
typedef struct guess_rule {
  int exchanges; /* the inner end may be aimed at; 2: the outer one is */
  guess_landings landings;
  double dragging; /* to begin with, over that of a straight fall */
} guess_rule;

enum { GUESS_ATTEMPTS = 14, GUESS_ATTEMPTS_FAINT = 3 };
static const guess_rule GUESS_RULES[GUESS_ATTEMPTS] = {
    {1, LANDS_SURELY, 1},  {1, LANDS_STEEP, 1},   {1, LANDS_NOWHERE, 1}, {0, LANDS_NOWHERE, 1},
    {1, LANDS_STEEP, 0.3}, {1, LANDS_STEEP, 0.6}, {1, LANDS_STEEP, 0.8}, {1, LANDS_STEEP, 0.1},
    {1, LANDS_STEEP, 1.3}, {0, LANDS_NOWHERE, 0.6}, {1, LANDS_NOWHERE, 0.6}, {0, LANDS_NOWHERE, 0.3},
    {2, LANDS_NOWHERE, 1}, {2, LANDS_NOWHERE, 0.6}};
/* Precision of the orbit without spin, for the first attempt, and for the others. The first aims as well by an orbit that
 * misses by a tenth of a radian before its last step: it differs more from the ray that is looked for. */
static const search_precision GUESS_PRECISION = {1, 12, 1e-2}, GUESS_PRECISION_MORE = {1e-4, 12, 1e-6};
/* Dragging and swept angle agree, radians, at right angles; in line with the center they must much better. */
#define GUESS_SETTLED 0.05
#define GUESS_SETTLED_IN_LINE 1e-3
/* Rays land where their direction is steeper than this, sine, and at these depths. */
#define GUESS_STEEP 0.2
#define GUESS_DEPTH_INNER 0.6
#define GUESS_DEPTH_OUTER 6.0
/* Angle of a fall to the photon orbit, from r - r_plus = M or beyond; dragging per radian that a ray winds besides, over the
 * spin, and how it grows with spin and tilt. */
#define GUESS_FALL 1.45
#define GUESS_WINDING 0.385
#define GUESS_WINDING_TILT 0.76
/* r - r_plus below which the inner end is aimed at, in M; what stands for the sky then: 1 / r. */
#define GUESS_INNER 3.0
#define GUESS_SKY 1e-4

/* What a guess is made from. */
typedef struct guess_state {
  lanes photon[2];  /* radii of the equatorial photon orbits, with and against the spin */
  lanes dragging;   /* frame dragging to expect */
  lanes closer;     /* logarithm: how much closer to the critical ray than the orbit without spin */
  lanes slope;      /* at launch, per radian, that the search for the orbit without spin begins with; NaN: its own */
  lanes found;      /* slope of the orbit */
} guess_state;

/* Radius of the spherical photon orbit whose angular momentum L is tilted by this cosine = L / sqrt(L^2 + Q), by bisection
 * between the equatorial ones: L and Q of Bardeen, Press & Teukolsky 1972. range: their radii. */
LANES_INLINE lanes guess_photon_radius(const flow_hole *hole, const lanes range[2], lanes tilt)
{
  const lanes a = lanes_abs(hole->spin), a2 = a * a, x = lanes_copysign(tilt, tilt * hole->spin);
  lanes low = range[0], high = range[1];
  for (int i = 0; i < 14; i++) {
    const lanes r = 0.5 * (low + high), L = -(r * r * (r - 3) + a2 * (r + 1)), Q = r * r * r * (4 * a2 - r * (r - 3) * (r - 3));
    const lanes norm = lanes_sqrt(lanes_max(L * L + Q, lanes_all(0)));
    const lanes_mask inward = L > x * norm;
    low = lanes_select(inward, r, low), high = lanes_select(inward, high, r);
  }
  return 0.5 * (low + high);
}

/* r - 2 at the corresponding place of the hole without spin: photon orbits lie at depth 1, the horizon at 0. */
LANES_INLINE lanes guess_depth(lanes above, const flow_hole *hole, lanes photon)
{
  const lanes width = photon - hole->outer;
  return lanes_select(above < width, above / width, 1 + (above - width));
}

/* Frame dragging of a ray that comes straight in from infinity to r = r_plus + above, radians; odd in the spin. */
LANES_INLINE lanes guess_dragging(const flow_hole *hole, lanes above)
{
  const lanes w = 1 / (hole->outer + above), x = hole->inner * w;
  /* log(1 - x) / inner, also for inner = 0 */
  const lanes series = -w * (1 + x * (0.5 + x * (1.0 / 3 + x * (0.25 + 0.2 * x))));
  const lanes inner = lanes_select(x < 1e-3, series, lanes_log(1 - x) / lanes_max(hole->inner, lanes_all(1e-100)));
  return 2 * hole->spin / (hole->outer - hole->inner) * (inner - lanes_log(above * w) / hole->outer);
}

/* The frame dragging to expect of image `order`: that of a straight fall from one place to the other, and of each radian that
 * the ray winds beyond one. At the photon orbit that is 2 a / sqrt(27) for small spin; how it grows with the spin and falls
 * with the tilt of the plane is fitted to rays, as is the angle of a fall. */
LANES_INLINE lanes guess_dragging_between(const flow_hole *hole, int order, const flow_place *a, const flow_place *b,
                                          lanes_mask sky)
{
  const lanes far = lanes_select(sky, lanes_all(0), guess_dragging(hole, b->above));
  const lanes fall = lanes_abs(guess_dragging(hole, a->above) - far), turn = lanes_all(order & 1 ? -1 : 1);
  lanes axis[3];
  cross(a->n, b->n, axis);
  const lanes sine = lanes_sqrt(lanes_dot(axis, axis));
  const lanes swept = 2 * M_PI * ((order + 1) / 2) + turn * lanes_atan2(sine, lanes_dot(a->n, b->n));
  const lanes tilt = lanes_copysign(turn, turn * hole->spin) * axis[2] / lanes_max(sine, lanes_all(1e-100));
  const lanes one = lanes_all(1), from_a = GUESS_FALL * lanes_min(a->above, one);
  const lanes from_b = GUESS_FALL * lanes_select(sky, one, lanes_min(b->above, one));
  const lanes spin = lanes_abs(hole->spin), rate = spin * GUESS_WINDING / (1 - GUESS_WINDING_TILT * spin * tilt);
  const lanes winds = (swept - from_a - from_b - tilt * fall) / (1 + rate * tilt); /* dragging along shortens the way */
  return lanes_copysign(fall + rate * lanes_max(winds, lanes_all(0)), hole->spin);
}

/* P at its stationary point nearest to infinity (see kerr_find_barrier) over E^2: how far a ray stays from the critical ones,
 * negative if it turns round. Its derivatives by the launch angles come from those of the constants, because P is stationary.
 * *rate: at which rays leave the photon orbit there, per angle swept. */
LANES_INLINE lanes guess_barrier(const flow_hole *hole, const flow_ray *ray, lanes slope[2], lanes *rate)
{
  const lanes s = hole->spin, s2 = s * s, E = ray->energy.value, L = ray->momentum.value, Q = ray->carter.value;
  const lanes A = s2 * E * E - ray->curl.value, K = (L - s * E) * (L - s * E) + Q, B = s2 * Q;
  const lanes root = lanes_sqrt(lanes_max(9 * K * K + 8 * A * B, lanes_all(0)));
  const lanes w = lanes_min(lanes_max(-2 * A / (3 * K + root), lanes_all(0)), 1 / hole->outer), w2 = w * w;
  const lanes inverse = 1 / (E * E), P = E * E + w2 * (A + w * (2 * K - B * w));
  for (int j = 0; j < 2; j++) {
    const lanes dE = ray->energy.by[j], dQ = ray->carter.by[j], dK = 2 * (L - s * E) * (ray->momentum.by[j] - s * dE) + dQ;
    const lanes change = 2 * E * dE + w2 * (2 * s2 * E * dE - ray->curl.by[j] + w * (2 * dK - s2 * dQ * w));
    slope[j] = (change - 2 * P / E * dE) * inverse;
  }
  const lanes bend2 = lanes_max(A + w * (6 * K - 6 * B * w), lanes_all(0));
  *rate = lanes_sqrt(bend2 / lanes_max(lanes_abs(ray->curl.value), lanes_all(1e-100)));
  return P * inverse;
}

/* The end of an orbit around the hole without spin. */
LANES_INLINE orbit_end guess_end(const lanes n[3], lanes depth, lanes_mask sky)
{
  orbit_end end;
  const lanes r = 2 + depth, d = lanes_select(sky, lanes_all(-1.0 / 3), (1 - depth) / (3 * r));
  for (int k = 0; k < 3; k++) end.n[k] = n[k];
  end.w = end.x = lanes_select(sky, lanes_all(0), 1 / r);
  end.side = lanes_all(0);
  end.lapse = lanes_select(sky, lanes_all(1), lanes_sqrt(depth / r));
  end.zeta = d / (1 + d + lanes_sqrt(1 + 2 * d));
  end.creep = -d * lanes_sqrt(1 + 2 * d);
  return end;
}

/* Turns a launch direction until its ray is as far from the critical ones as it should: the swept angle goes with the
 * logarithm of the barrier over the rate. Returns C = Q + L^2. */
LANES_INLINE lanes guess_match(const flow_hole *hole, const flow_place *at, lanes barrier, lanes closer, int matches,
                               aim_setting *setting)
{
  const flow_metric metric = flow_metric_at(hole, at);
  const lanes_mask near = lanes_abs(barrier) < 1;
  const lanes depth = lanes_log(lanes_max(lanes_min(lanes_abs(barrier), lanes_all(1)), lanes_all(1e-100))) + closer;
  flow_ray ray;
  for (int i = 0; i < matches; i++) {
    lanes e[2][3], slope[2], rate;
    flow_across(setting->d, e);
    flow_launch(hole, at, &metric, setting->d, e, &ray);
    const lanes now = guess_barrier(hole, &ray, slope, &rate);
    const lanes exponent = depth * lanes_max(lanes_min(rate, lanes_all(1.5)), lanes_all(0.3));
    const lanes wanted = lanes_copysign(lanes_exp(lanes_max(exponent, lanes_all(-40))), barrier);
    const lanes size2 = lanes_max(slope[0] * slope[0] + slope[1] * slope[1], lanes_all(1e-100));
    const lanes change = lanes_select(near, (wanted - now) / size2, lanes_all(0));
    const lanes limited = change / lanes_max(lanes_all(1), 4 * lanes_abs(change) * lanes_sqrt(size2));
    const lanes step[3] = {limited * slope[0], limited * slope[1], lanes_all(0)};
    *setting = aim_moved(setting, step);
  }
  return ray.curl.value;
}

/* Local components of a vector at angular position n. */
LANES_INLINE void guess_components(const lanes n[3], const lanes vector[3], lanes d[3])
{
  const lanes horizontal = lanes_sqrt(n[0] * n[0] + n[1] * n[1]);
  const lanes_mask on_axis = horizontal == 0;
  const lanes inverse = 1 / lanes_select(on_axis, lanes_all(1), horizontal);
  const lanes x = lanes_select(on_axis, lanes_all(1), n[0] * inverse), y = n[1] * inverse;
  const lanes south[3] = {n[2] * x, n[2] * y, -horizontal};
  d[0] = lanes_dot(vector, n), d[1] = lanes_dot(vector, south), d[2] = x * vector[1] - y * vector[0];
  const lanes length = lanes_sqrt(lanes_dot(d, d));
  for (int k = 0; k < 3; k++) d[k] /= length;
}

/* Whether and how the ray should land, if its orbit comes to b with dw = speed. */
LANES_INLINE lanes guess_landing(const aim_task *t, lanes depth, lanes speed, guess_landings landings)
{
  const lanes_mask sky = (lanes_mask)t->sky, wide = t->swept > 2, inward = speed > 0;
  const lanes_mask passes = wide | ((t->a.w < t->b.w) == inward); /* the radius of b only once, on its last way */
  const lanes_mask steep = lanes_abs(speed) > GUESS_STEEP;
  const lanes_mask inner = inward & (depth < GUESS_DEPTH_INNER) & ~sky;
  const lanes_mask outer = ~inward & wide & ((depth > GUESS_DEPTH_OUTER) | sky);
  const lanes_mask lands = steep & passes & (landings == LANDS_SURELY ? inner | outer : lanes_mask_all(landings == LANDS_STEEP));
  return lanes_select(lands, lanes_select(inward, lanes_all(1), lanes_all(-1)), lanes_all(0));
}

/* Sets the first trial of image `order`. */
LANES_INLINE void guess_make(guess_state *g, const flow_hole *hole, int order, const guess_rule *rule,
                             int matches, aim_task *t)
{
  const lanes_mask sky = (lanes_mask)t->sky;
  lanes launch[3], axis[3];
  pair_plane pair;
  for (int k = 0; k < 3; k++) pair.a.n[k] = t->a.n[k];
  aim_turn(-g->dragging, t->b.n, pair.b.n);
  plane_of(&pair);
  const lanes turn = lanes_all(order & 1 ? -1 : 1), swept = 2 * M_PI * ((order + 1) / 2) + turn * pair.angle;
  cross(t->a.n, pair.toward_a, axis);
  const lanes photon = guess_photon_radius(hole, g->photon, turn * axis[2]);
  const lanes depth_a = guess_depth(t->a.above, hole, photon), depth_b = guess_depth(t->b.above, hole, photon);
  pair.a = guess_end(t->a.n, depth_a, (lanes_mask){0}), pair.b = guess_end(pair.b.n, depth_b, sky);
  const search_precision precision = rule == GUESS_RULES ? GUESS_PRECISION : GUESS_PRECISION_MORE;
  const lanes begin = lanes_select(lanes_is_finite(g->slope), g->slope * swept, search_guess(0, &pair.a, &pair.b, swept));
  const orbit_root root = search_root(0, &pair.a, &pair.b, swept, begin, precision, lanes_mask_all(1));
  g->found = root.rate / swept;
  direction_of(0, &pair.a, pair.toward_a, turn, swept, root.size, root.rate, launch);
  guess_components(t->a.n, launch, t->trial.d);
  t->swept = swept, t->calm = lanes_exp(lanes_min(M_PI - swept, lanes_all(0)));
  t->lands = guess_landing(t, depth_b, root.arrival_rate / root.size, rule->landings);
  t->fresh = (lanes)lanes_mask_all(1), t->truncation = AIM_TRUNCATION_FIRST * t->calm;
  t->turn_truncation = lanes_all(AIM_TURN_TRUNCATION);
  const lanes beta = swept / root.size, barrier = lanes_select(swept > 0, 1 - beta * beta * (1.0 / 27), lanes_all(2));
  const lanes curl = guess_match(hole, &t->a, barrier, g->closer, matches, &t->trial);
  const lanes_mask winds = (swept > 1) & (lanes_abs(barrier) < 1);
  t->trial.time = lanes_select(winds, swept / lanes_sqrt(lanes_abs(curl)), root.size / pair.a.lapse);
}

/* The inner end is aimed at. What is in the sky becomes a far place. */
LANES_INLINE void guess_exchange(const flow_hole *hole, int outer, aim_task *t)
{
  const lanes_mask sky = (lanes_mask)t->sky, near = (t->a.above < GUESS_INNER) & ((t->a.above < t->b.above) | sky);
  const lanes_mask inner = outer ? ~sky & (t->a.above >= t->b.above) : near;
  const lanes_mask moved = sky & inner;
  t->b.w = lanes_select(moved, lanes_all(GUESS_SKY), t->b.w);
  t->b.above = lanes_select(moved, 1 / GUESS_SKY - hole->outer, t->b.above);
  t->was_sky = (lanes)moved, t->sky = (lanes)(sky & ~moved);
  aim_exchange(t, inner);
}

/* The first trial of image `order` of pairs whose places, spin and sky are set. Dragging depends on the course, and the
 * course on dragging: the fixed point is found by secants. */
LANES_INLINE void guess_first(int order, const guess_rule *rule, aim_task *t)
{
  flow_hole hole = flow_hole_of(t->spin);
  if (rule->exchanges) guess_exchange(&hole, rule->exchanges > 1, t);
  hole = flow_hole_of(t->spin);
  const int easy = rule == GUESS_RULES && order < 2, first = easy && order == 0;
  const int passes = first ? GUESS_PASSES_FIRST : easy ? GUESS_PASSES : GUESS_PASSES_MORE;
  const int matches = first ? GUESS_MATCHES_FIRST : easy ? GUESS_MATCHES : GUESS_MATCHES_MORE;
  const double spin = fabs(t->spin[0]);
  guess_state g = {.photon = {lanes_all(2 + 2 * cos(2.0 / 3 * acos(-spin))), lanes_all(2 + 2 * cos(2.0 / 3 * acos(spin)))},
                   .dragging = guess_dragging_between(&hole, order, &t->a, &t->b, (lanes_mask)t->sky), .slope = lanes_all(NAN)};
  g.dragging *= rule->dragging;
  guess_make(&g, &hole, order, rule, matches, t);
  lanes last = {0}, met = {0};
  for (int i = 0; i < passes; i++) {
    const aim_shot shot = aim_shoot(t);
    const lanes drag = shot.ray.drag.value, off = drag - g.dragging;
    const lanes over = lanes_min(lanes_max(shot.ray.swept - t->swept, lanes_all(-2)), lanes_all(2));
    const lanes_mask known = shot.whole & lanes_is_finite(drag), lands = t->lands != 0;
    lanes sine, cosine;
    lanes_sincos(t->swept, &sine, &cosine);
    const lanes settled = GUESS_SETTLED * lanes_abs(sine) + GUESS_SETTLED_IN_LINE;
    const lanes_mask moves = known & ((lanes_abs(off) > settled) | (lands & (lanes_abs(over) > settled)));
    if (!lanes_any(moves)) break;
    const lanes slope = (drag - met) / (g.dragging - last);
    const lanes secant = lanes_min(lanes_max(1 / (1 - slope), lanes_all(0.2)), lanes_all(1.5));
    const lanes gain = lanes_select((slope < 0.9) & lanes_is_finite(slope) & lanes_mask_all(i > 0), secant, lanes_all(1));
    last = g.dragging, met = drag;
    g.dragging += lanes_select(moves, gain * off, lanes_all(0));
    g.closer += lanes_select(moves & lands, over, lanes_all(0));
    g.slope = lanes_select(moves, g.found, g.slope); /* the others find the same orbit again */
    guess_make(&g, &hole, order, rule, matches, t);
  }
}
#endif
