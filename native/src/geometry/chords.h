/* Cutting an arc into chords, and asking Embree for each: the inner loop of the curved kernel.
 *
 * A chord may stray from the arc by the ray's tolerance. How far it does is measured at its middle: on so short a piece an
 * arc is nearly a parabola, whose largest distance from the chord is y / (4 s (1 - s)) if it is y at the fraction s. So
 * that chords may be long, they do not end on the arc but outside it, where the next one begins: both ends then stray to
 * the outside as far as the middle does to the inside, each by half of what the middle alone would. Chords of the sqrt 2
 * fold length do. The next chord is chosen from the last by the square-root law of that distance. Where a chord with all
 * that strays from it misses the bounding sphere of the geometry, it is not asked for, and may be long.
 */
#ifndef BENT_GEOMETRY_CHORDS_H
#define BENT_GEOMETRY_CHORDS_H
#include "geometry/landing.h"
#include "geometry/march.h"

/* A chord that is not asked for may stray by this fraction of its length: it only adds to the length of the ray. */
#define STRAY_UNSEEN 0.05
/* Chords are tried at this part of the length that should just do. */
#define SAFETY 0.97
#define TRIALS_MAX 200
/* Of lens_edge; most rays take 10. */
#define EDGE_STEPS 64

/* With u the distance of the arc's middle from a chord that ends on the arc: moving that end outward by u END_SHIFT leaves
 * the middle as far inside. Were the begin on the arc, the largest distance, beside the middle, would be u STRAY_SHIFTED. */
#define END_SHIFT (2.0 / 3)
#define STRAY_SHIFTED 0.7
/* An arc more curved than that, in distance from the chord over its length (about 10 degrees from end to end), is too
 * little like a parabola; then the chord ends on it. */
#define SHIFTED_MAX 0.02
/* The largest distance from a chord both of whose ends are shifted so, in sagittas of the arc. */
#define STRAY_SAGITTAS (0.75 * STRAY_SHIFTED)

/* A chord from m->here, at one offset, to end + shift, at another. */
typedef struct chord {
  lanes end[3], shift[3]; /* a point of the arc; how far outside it the chord ends */
  lanes span[3], size;    /* size = |span|, to second order in the shift */
  lanes sagitta, length;  /* of the arc, world units */
  lanes stray, allowed;
  lanes_mask unseen;
} chord;

/* `exact`: lanes whose chord must end on the arc. */
LANES_INLINE chord chord_measure(const march *m, const arc *arc, lanes from, lanes to, lanes_mask exact)
{
  chord c;
  lanes middle[3], center[3], off[3], straight[3];
  march_position(m, &m->ray, arc, 0.5 * (from + to), middle);
  march_position(m, &m->ray, arc, to, c.end);
  const double to_center[3] = {m->g->center.x, m->g->center.y, m->g->center.z};
  for (int k = 0; k < 3; k++) {
    c.span[k] = c.end[k] - m->here[k];
    straight[k] = c.span[k] + m->shift[k];
    off[k] = middle[k] - m->here[k];
    center[k] = to_center[k] - m->here[k];
  }
  const lanes size2 = lanes_max(lanes_dot(c.span, c.span), lanes_all(1e-300)), along = lanes_dot(off, c.span) / size2;
  const lanes part = lanes_clamp(along, 0.02, 0.98), largest = 0.25 / (part * (1 - part));
  for (int k = 0; k < 3; k++) off[k] = largest * (off[k] - along * c.span[k]);
  const lanes stray = lanes_sqrt(lanes_dot(off, off));
  c.size = lanes_sqrt(size2);
  const lanes nearest = lanes_clamp(lanes_dot(center, c.span) / size2, 0, 1);
  for (int k = 0; k < 3; k++) center[k] -= nearest * c.span[k];
  const lanes reach = m->g->radius + 2 * stray;
  c.unseen = (lanes_dot(center, center) > reach * reach) | m->blind | lanes_mask_all(m->g->radius < 0);
  c.allowed = lanes_select(c.unseen, lanes_max(STRAY_UNSEEN * c.size, m->tolerance), m->tolerance);
  exact |= c.unseen | (stray > SHIFTED_MAX * c.size);
  c.stray = lanes_select(exact, stray, STRAY_SHIFTED * stray);
  const lanes share = lanes_select(exact, lanes_all(0), lanes_all(END_SHIFT));
  lanes bow[3];
  for (int k = 0; k < 3; k++) {
    c.shift[k] = share * off[k];
    c.span[k] += c.shift[k];
    bow[k] = off[k] + 0.5 * m->shift[k];
  }
  const lanes sagitta2 = lanes_dot(bow, bow), base = lanes_sqrt(lanes_dot(straight, straight));
  c.sagitta = lanes_sqrt(sagitta2);
  c.length = base + 8.0 / 3 * sagitta2 / (base + 1e-300); /* of a flat parabola */
  return c;
}

/* Leaving lanes whose chord would end behind the source's plane: the arc comes back through it. */
LANES_INLINE lanes_mask chord_returns(const march *m, const chord *c)
{
  return m->leaving & (lanes_dot(c->span, m->source) <= 0);
}

/* Lanes whose chord leads to the throat, where the ray goes on elsewhere from just that point. */
LANES_INLINE lanes_mask chord_is_last(const march *m, lanes to, lanes limit)
{
  return lanes_mask_all(m->space.kind == BENT_ELLIS) & (to >= limit);
}

/* The longest good chord of each walking lane: from `from` to at most `*to`, which is shortened. */
LANES_INLINE chord chord_choose(const march *m, const arc *arc, lanes from, lanes *to, lanes limit,
                                lanes_mask walking)
{
  chord c;
  const lanes least = 1e-12 * (*to - from);
  for (int trial = 0; trial < TRIALS_MAX; trial++) {
    c = chord_measure(m, arc, from, *to, chord_is_last(m, *to, limit));
    const lanes_mask strays = c.stray > c.allowed, returns = chord_returns(m, &c);
    const lanes_mask again = walking & (strays | returns) & (*to - from > least);
    if (!lanes_any(again)) break;
    lanes factor = lanes_clamp(SAFETY * lanes_sqrt(c.allowed / c.stray), 0.1, SAFETY);
    factor = lanes_select(returns, lanes_min(factor, lanes_all(0.5)), factor);
    *to = lanes_select(again, from + factor * (*to - from), *to);
  }
  return c;
}

/* Where lanes in `out` leave the sphere of the lens between two offsets, by the Illinois variant of regula falsi, with a
 * bisection now and then: of rays that graze the sphere the edge lies far from `to` and close to `from`. There a leg may
 * begin, on the sphere, so that what is inside but for rounding counts as inside. Lanes stop on their own. */
LANES_INLINE lanes lens_edge(const march *m, const arc *arc, lanes from, lanes to, lanes_mask out)
{
  const double radius = m->lens->radius / m->lens->scale, radius2 = radius * radius;
  lanes low = from, high = to, low_value = {0}, high_value = {0};
  lanes_mask moving = out;
  for (int i = 0; i < EDGE_STEPS && lanes_any(moving); i++) {
    lanes x = i == 0 ? low : i == 1 ? high : low - low_value * (high - low) / (high_value - low_value);
    if (i > 1 && i % 3 == 0) x = 0.5 * (low + high);
    lanes numerator[3], w;
    lanes_mask far;
    arc_position(&m->space, &m->ray, arc, x, numerator, &w, &far);
    const lanes value = lanes_dot(numerator, numerator) - radius2 * w * w, rounding = 1e-15 * radius2 * w * w;
    if (i == 0) low_value = lanes_min(value, -rounding);
    else if (i == 1) high_value = value;
    else {
      const lanes_mask inside = value <= rounding;
      low_value = lanes_select(inside, lanes_min(value, -rounding), 0.5 * low_value);
      high_value = lanes_select(inside, 0.5 * high_value, value);
      low = lanes_select(moving & inside, x, low), high = lanes_select(moving & ~inside, x, high);
      moving &= (high - low) > 1e-13 * (to - from);
    }
  }
  return lanes_select(out, high, to);
}

/* Asks Embree for one lane's chord. Returns nonzero on a hit. `from`: the ray's length at the chord's beginning. */
static int chord_ask(march *m, int lane, const chord *c, double from, found *f)
{
  const bent_ray *ray = &m->rays[m->target[lane]];
  const double size = c->size[lane];
  if (from > ray->length_max) {
    m->blind[lane] = -1;
    return 0;
  }
  if (from + size <= ray->length_min) return 0;
  const int leaving = m->leaving[lane] != 0;
  query q = {.start = lane_vec3(m->here, lane), .span = lane_vec3(c->span, lane), .visibility = ray->visibility,
             .leaving = leaving ? ray : NULL, .departure = lane_vec3(m->departure, lane)};
  const double coordinate = fmax(fabs(q.start.x), fmax(fabs(q.start.y), fabs(q.start.z)));
  const double overlap = 0x1p-20 + 0x1p-22 * coordinate / size; /* so that nothing slips through a joint */
  q.near = leaving ? 0 : -overlap;
  q.far = 1 + overlap;
  if (from < ray->length_min) q.near = (ray->length_min - from) / size;
  if (from + size > ray->length_max) q.far = fmin(q.far, (ray->length_max - from) / size);
  return q.far > q.near && geometry_query(m->g, &q, f);
}

/* Walks the chords of every walking lane up to `limit` or to what comes first: a hit or the edge of the lens. */
LANES_INLINE void chords_walk(march *m, const arc *arc, lanes limit, lanes_mask walking, outcome *out)
{
  const double radius2 = m->lens->radius * m->lens->radius;
  const double center[3] = {m->lens->center.x, m->lens->center.y, m->lens->center.z};
  lanes from = {0};
  while (lanes_any(walking)) {
    const lanes rest = limit - from;
    /* two even chords rather than a long and a short one */
    lanes to = from + lanes_select(m->delta >= rest, rest, lanes_min(m->delta, 0.5 * rest));
    to = lanes_select(walking, lanes_select(m->delta >= rest, limit, to), from);
    chord c = chord_choose(m, arc, from, &to, limit, walking);
    lanes_mask edge = {0};
    if (!m->endless) {
      lanes outward[3];
      for (int k = 0; k < 3; k++) outward[k] = c.end[k] - center[k];
      edge = walking & (lanes_dot(outward, outward) > radius2);
      if (lanes_any(edge)) {
        to = lens_edge(m, arc, from, to, edge);
        c = chord_measure(m, arc, from, to, edge | chord_is_last(m, to, limit));
      }
    }
    const lanes growth = lanes_clamp(SAFETY * lanes_sqrt(c.allowed / (STRAY_SAGITTAS * c.sagitta + 1e-300)), 0.1, 4);
    m->delta = lanes_select(walking & ~edge, growth * (to - from), m->delta);
    const unsigned asked = lanes_bits(walking & ~c.unseen);
    unsigned hit = 0;
    for (unsigned left = asked; left; left &= left - 1) {
      const int lane = __builtin_ctz(left);
      found f;
      if (!chord_ask(m, lane, &c, m->length[lane], &f)) continue;
      landing_add(m, lane, arc, &f, from[lane], to[lane], c.span);
      hit |= 1u << lane;
    }
    const lanes_mask found = lanes_mask_from_bits(hit);
    out->hit |= hit;
    out->edge |= lanes_bits(edge & ~found);
    out->offset = lanes_select(walking, to, out->offset);
    m->length += lanes_select(walking & ~found, c.length, lanes_all(0));
    m->leaving &= ~walking;
    for (int k = 0; k < 3; k++) {
      m->here[k] = lanes_select(walking & ~found, c.end[k] + c.shift[k], m->here[k]);
      m->shift[k] = lanes_select(walking & ~found, c.shift[k], m->shift[k]);
    }
    from = lanes_select(walking, to, from);
    walking &= ~found & ~edge & (to < limit);
  }
}
#endif
