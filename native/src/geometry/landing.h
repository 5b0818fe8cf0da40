/* Moving hits from chords onto the arc itself: part of the curved kernel.
 *
 * The arc meets the triangle's plane where N . X(lambda) = D. With the chart's positions in projective form that is
 * N . numerator - D w = 0, regular everywhere; it is solved by secant steps from the chord's own hit, all lanes at once.
 */
#ifndef BENT_GEOMETRY_LANDING_H
#define BENT_GEOMETRY_LANDING_H
#include "geometry/march.h"

/* Secant steps at most; a lane stops when it moves by no more than this fraction of its offset. */
#define SECANT_STEPS 12
#define SECANT_CHANGE 1e-12
/* The arc meets the plane where it is no farther from it than this part of the tolerance. */
#define OFF_PLANE_MAX 1e-3
/* A point this far outside its triangle, in barycentric terms, has another triangle looked for. */
#define OUTSIDE_MAX 1e-9
#define REFINEMENTS_MAX 3

/* The planes of the lanes' triangles in the axes of the spacetime; zero in other lanes. */
typedef struct planes {
  lanes normal[3], distance;
} planes;

LANES_INLINE void set_plane(const march *m, int lane, const triangle *t, planes *p)
{
  const mat4 *a = &m->lens->world_from_spacetime;
  const vec3 normal = v3_normalize(mat4_transposed_vector(a, t->normal));
  set_lane_vec3(p->normal, lane, normal);
  p->distance[lane] = v3_dot(normal, mat4_point(&m->lens->spacetime_from_world, t->v0));
}

LANES_INLINE lanes plane_value(const march *m, const arc *arc, const planes *p, lanes offset, lanes *w)
{
  lanes numerator[3];
  lanes_mask far;
  arc_position(&m->space, &m->ray, arc, offset, numerator, w, &far);
  return lanes_dot(p->normal, numerator) - p->distance * *w;
}

/* Offsets at which the arc meets the planes, from the chords' guesses; NaN where it does not, near the chord. `rise`:
 * N . (change of X) over the chord. Steps may leave the chord by half of it, but not the arc where it ends for good. */
LANES_INLINE lanes plane_crossing(const march *m, const arc *arc, const planes *p, lanes low, lanes high, lanes guess,
                                  lanes rise)
{
  const lanes margin = 0.5 * (high - low), lowest = lanes_max(low - margin, lanes_all(0));
  const lanes highest = lanes_select(arc->falls, lanes_min(high + margin, arc->step), high + margin);
  lanes w, x0 = guess, f0 = plane_value(m, arc, p, x0, &w), x1 = x0 - f0 * (high - low) / (w * rise), f1 = f0;
  lanes_mask moving = f0 != 0; /* lanes stop on their own, so that their neighbors do not matter */
  x1 = lanes_select(moving, x1, x0);
  for (int i = 1; i < SECANT_STEPS && lanes_any(moving); i++) {
    x1 = lanes_min(lanes_max(x1, lowest), highest);
    f1 = lanes_select(moving, plane_value(m, arc, p, x1, &w), f1);
    const lanes step = f1 * (x1 - x0) / (f1 - f0);
    moving &= lanes_abs(step) > SECANT_CHANGE * highest;
    x0 = lanes_select(moving, x1, x0), f0 = lanes_select(moving, f1, f0);
    x1 = lanes_select(moving, x1 - step, x1);
  }
  const double scale = m->lens->scale;
  return lanes_select(lanes_abs(f1) * scale <= OFF_PLANE_MAX * m->tolerance * w, x1, lanes_all(NAN));
}

/* How far along the chord a point beside it is. */
static double length_along(const outcome *out, int lane, vec3 point)
{
  const vec3 span = lane_vec3(out->span, lane);
  return v3_dot(v3_sub(point, lane_vec3(out->begin, lane)), span) / v3_length(span);
}

/* Looks again where the arc leaves the first triangle's plane beside it: on a chord so short that it is the arc. */
static unsigned look_again(const march *m, const arc *arc, unsigned again, lanes offset, double part, outcome *out)
{
  const lanes reach = part * (out->high - out->low);
  const lanes low = lanes_max(offset - reach, out->low), high = lanes_min(offset + reach, out->high);
  lanes begin[3], end[3];
  march_position(m, arc, low, begin);
  march_position(m, arc, high, end);
  unsigned changed = 0;
  for (unsigned left = again; left; left &= left - 1) {
    const int lane = __builtin_ctz(left);
    const query q = {.start = lane_vec3(begin, lane),
                     .span = v3_sub(lane_vec3(end, lane), lane_vec3(begin, lane)),
                     .near = -0x1p-20,
                     .far = 1 + 0x1p-20,
                     .visibility = m->rays[m->target[lane]].visibility};
    found f;
    if (!(high[lane] > low[lane]) || !geometry_query(m->g, &q, &f)) continue;
    out->found[lane] = f;
    out->from[lane] += length_along(out, lane, q.start);
    out->low[lane] = low[lane], out->high[lane] = high[lane];
    set_lane_vec3(out->begin, lane, q.start);
    set_lane_vec3(out->span, lane, q.span);
    changed |= 1u << lane;
  }
  return changed;
}

/* One lane's hit: its triangle and point. Returns nonzero if the arc does not meet the triangle itself. */
static int settle(march *m, const outcome *out, const triangle *t, int lane, int met, vec3 point)
{
  bent_hit *hit = &m->hits[m->target[lane]];
  const found *f = &out->found[lane];
  double b[2];
  triangle_barycentric(t, point, b);
  const int outside = !met || !(barycentric_outside(b) <= OUTSIDE_MAX);
  triangle_clamp(t, b);
  vec3 position = triangle_point(t, b);
  if (!met || !(v3_length(v3_sub(position, point)) <= m->tolerance[lane])) { /* the chord's own point stands */
    b[0] = f->b[0], b[1] = f->b[1];
    triangle_clamp(t, b);
    position = triangle_point(t, b);
  }
  hit->instance = f->instance, hit->triangle = f->triangle;
  hit->barycentric[0] = b[0], hit->barycentric[1] = b[1];
  v3_to(hit->position, position);
  hit->length = out->from[lane] + length_along(out, lane, position);
  return outside;
}

/* Lands every lane of out->hit and sets out->offset there. */
LANES_INLINE void land_hits(march *m, const arc *arc, lanes_mask leaving, outcome *out)
{
  planes p = {0};
  triangle t[LANES];
  unsigned todo = out->hit;
  const unsigned first_chord = lanes_bits(leaving);
  double part = 1.0 / 16;
  for (int round = 0; todo; round++) {
    lanes guess = out->low, rise = lanes_all(1), point[3];
    for (unsigned left = todo; left; left &= left - 1) found_fetch(m->g, &out->found[__builtin_ctz(left)]);
    for (unsigned left = todo; left; left &= left - 1) {
      const int lane = __builtin_ctz(left);
      const found *f = &out->found[lane];
      t[lane] = triangle_of(m->g, f->instance, f->triangle);
      set_plane(m, lane, &t[lane], &p);
      guess[lane] += fmin(fmax(f->at, 0), 1) * (out->high[lane] - out->low[lane]);
      const vec3 span = mat4_vector(&m->lens->spacetime_from_world, lane_vec3(out->span, lane));
      rise[lane] = v3_dot(lane_vec3(p.normal, lane), span);
    }
    const lanes crossing = plane_crossing(m, arc, &p, out->low, out->high, guess, rise);
    const lanes_mask met = (crossing >= 0) & (crossing <= out->high + 0.5 * (out->high - out->low));
    const lanes offset = lanes_select(met, crossing, guess);
    march_position(m, arc, offset, point);
    unsigned again = 0;
    for (unsigned left = todo; left; left &= left - 1) {
      const int lane = __builtin_ctz(left);
      if (settle(m, out, &t[lane], lane, met[lane] != 0, lane_vec3(point, lane))) again |= 1u << lane;
      out->offset[lane] = offset[lane];
    }
    again &= ~first_chord;
    todo = again && round < REFINEMENTS_MAX ? look_again(m, arc, again, guess, part, out) : 0;
    part *= 0.25;
  }
}
#endif
