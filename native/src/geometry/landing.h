/* Moving hits from chords onto the arc itself: part of the curved kernel.
 *
 * Hits are gathered, each with a copy of its lane's arc, until all lanes are full: then their triangles have come from
 * memory, and no lane is idle. The arc meets the triangle's plane where N . X(lambda) = D. With the chart's positions in projective form that is
 * N . numerator - D w = 0, regular everywhere; it is solved by secant steps from the chord's own hit.
 */
#ifndef BENT_GEOMETRY_LANDING_H
#define BENT_GEOMETRY_LANDING_H
#include "geometry/march.h"

/* Secant steps at most; a lane stops when it is no farther from the plane than this part of its tolerance. */
#define SECANT_STEPS 12
#define OFF_PLANE_MAX 1e-3
/* A point that lies outside its triangle by more than this part of the tolerance has another triangle looked for. */
#define OUTSIDE_MAX 0.5
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

/* Where along its arc a lane meets a plane: offset and world position. */
typedef struct crossing {
  lanes offset, point[3];
  lanes_mask met; /* the others do not meet it near the chord */
} crossing;

/* From the chord's guesses. `rise`: N . (change of X) over the chord. Steps may leave the chord by half of it, but not the
 * arc where it ends for good. Lanes stop on their own, so that their neighbors do not matter. */
LANES_INLINE crossing plane_crossing(const march *m, const planes *p, unsigned wanted, lanes guess, lanes rise)
{
  const landing *l = &m->landing;
  const lanes margin = 0.5 * (l->high - l->low), highest = l->high + margin;
  const lanes first = lanes_max(l->low - margin, lanes_all(0));
  const lanes last = lanes_select(l->arc.falls, lanes_min(highest, l->arc.step), highest);
  const lanes near = l->tolerance * (OFF_PLANE_MAX / m->lens->scale);
  lanes numerator[3], w, x = guess, before = guess, value_before = {0};
  lanes_mask far, moving = lanes_mask_from_bits(wanted);
  for (int i = 0; i < SECANT_STEPS; i++) {
    arc_position(&m->space, &l->ray, &l->arc, x, numerator, &w, &far);
    const lanes value = lanes_dot(p->normal, numerator) - p->distance * w;
    moving &= ~(lanes_abs(value) <= near * w);
    if (!lanes_any(moving)) break;
    const lanes step = value * (i ? (x - before) / (value - value_before) : 2 * margin / (w * rise));
    before = x, value_before = value;
    x = lanes_select(moving, lanes_min(lanes_max(x - step, first), last), x);
  }
  crossing c = {.offset = x, .met = ~moving};
  march_to_world(m, numerator, w, c.point);
  return c;
}

/* How far along the chord a point beside it is. */
static double length_along(const landing *l, int lane, vec3 point)
{
  const vec3 span = lane_vec3(l->span, lane);
  return v3_dot(v3_sub(point, lane_vec3(l->begin, lane)), span) / v3_length(span);
}

/* Looks again where the arc leaves the first triangle's plane beside it: on a chord so short that it is the arc. */
static unsigned look_again(march *m, unsigned again, lanes offset, double part)
{
  landing *l = &m->landing;
  const lanes reach = part * (l->high - l->low);
  const lanes low = lanes_max(offset - reach, l->low), high = lanes_min(offset + reach, l->high);
  lanes begin[3], end[3];
  march_position(m, &l->ray, &l->arc, low, begin);
  march_position(m, &l->ray, &l->arc, high, end);
  unsigned changed = 0;
  for (unsigned left = again; left; left &= left - 1) {
    const int lane = __builtin_ctz(left);
    const query q = {.start = lane_vec3(begin, lane),
                     .span = v3_sub(lane_vec3(end, lane), lane_vec3(begin, lane)),
                     .near = -0x1p-20,
                     .far = 1 + 0x1p-20,
                     .visibility = m->rays[l->target[lane]].visibility};
    if (!(high[lane] > low[lane]) || !geometry_query(m->g, &q, &l->found[lane])) continue;
    l->from[lane] += length_along(l, lane, q.start);
    l->low[lane] = low[lane], l->high[lane] = high[lane];
    set_lane_vec3(l->begin, lane, q.start);
    set_lane_vec3(l->span, lane, q.span);
    changed |= 1u << lane;
  }
  return changed;
}

/* One lane's hit: its triangle and point. Returns nonzero if the arc passes the triangle by. */
static int settle(march *m, const triangle *t, int lane, int met, vec3 point)
{
  const landing *l = &m->landing;
  bent_hit *hit = &m->hits[l->target[lane]];
  const found *f = &l->found[lane];
  double b[2];
  triangle_barycentric(t, point, b);
  triangle_clamp(t, b);
  vec3 position = triangle_point(t, b);
  const int outside = !met || !(v3_length(v3_sub(position, point)) <= OUTSIDE_MAX * l->tolerance[lane]);
  if (outside) { /* the chord's own point stands */
    b[0] = f->b[0], b[1] = f->b[1];
    triangle_clamp(t, b);
    position = triangle_point(t, b);
  }
  hit->instance = f->instance, hit->triangle = f->triangle;
  hit->barycentric[0] = b[0], hit->barycentric[1] = b[1];
  v3_to(hit->position, position);
  hit->length = l->from[lane] + length_along(l, lane, position);
  return outside;
}

/* Settles every lane; returns the offsets. */
LANES_INLINE lanes settle_all(march *m)
{
  landing *l = &m->landing;
  planes p = {0};
  triangle t[LANES];
  lanes offset = {0};
  double part = 1.0 / 16;
  unsigned todo = (1u << l->count) - 1;
  for (int round = 0; todo; round++) {
    lanes guess = l->low, rise = lanes_all(1);
    for (unsigned left = todo; left; left &= left - 1) {
      const int lane = __builtin_ctz(left);
      const found *f = &l->found[lane];
      t[lane] = triangle_of(m->g, f->instance, f->triangle);
      set_plane(m, lane, &t[lane], &p);
      guess[lane] += fmin(fmax(f->at, 0), 1) * (l->high[lane] - l->low[lane]);
      const vec3 span = mat4_vector(&m->lens->spacetime_from_world, lane_vec3(l->span, lane));
      rise[lane] = v3_dot(lane_vec3(p.normal, lane), span);
    }
    const crossing c = plane_crossing(m, &p, todo, guess, rise);
    unsigned again = 0;
    for (unsigned left = todo; left; left &= left - 1) {
      const int lane = __builtin_ctz(left);
      if (settle(m, &t[lane], lane, c.met[lane] != 0, lane_vec3(c.point, lane))) again |= 1u << lane;
      offset[lane] = c.met[lane] ? c.offset[lane] : guess[lane];
    }
    again &= ~l->leaving;
    todo = again && round < REFINEMENTS_MAX ? look_again(m, again, guess, part) : 0;
    part *= 0.25;
  }
  return offset;
}

/* Lands all the hits that wait, and reports them. */
static void land(march *m)
{
  landing *l = &m->landing;
  if (!l->count) return;
  const lanes offset = settle_all(m);
  lanes direction[3];
  arc_direction(&m->space, &l->ray, &l->arc, offset, direction);
  arc_advance(&m->space, &l->arc, offset, &l->ray);
  const lanes error = arc_error(&m->space, &l->ray, l->steps + 1);
  for (int lane = 0; lane < l->count; lane++) {
    traveler *t = &m->travelers[l->target[lane]];
    bent_hit *hit = &m->hits[l->target[lane]];
    hit->fate = BENT_HIT;
    v3_to(hit->direction, march_direction(m, direction, lane));
    hit->error += error[lane];
    hit->swept += l->ray.swept[lane];
    t->leaving = 0;
    t->leg = LEG_OVER;
  }
  l->count = 0, l->leaving = 0;
}

/* A hit of the chord from m->here[lane], by `span`, between two offsets of an arc. */
LANES_INLINE void landing_add(march *m, int lane, const arc *arc, const found *f, double low, double high,
                              const lanes span[3])
{
  landing *l = &m->landing;
  const int slot = l->count++;
  found_fetch_indices(m->g, f);
  if (slot) found_fetch_vertices(m->g, &l->found[slot - 1]); /* its indices have come by now */
  if (m->leaving[lane]) l->leaving |= 1u << slot;
  l->target[slot] = m->target[lane];
  l->found[slot] = *f;
  arc_copy_lane(&m->space, &l->arc, slot, arc, lane);
  arc_ray_copy_lane(&l->ray, slot, &m->ray, lane);
  l->steps[slot] = m->steps[lane], l->tolerance[slot] = m->tolerance[lane];
  l->low[slot] = low, l->high[slot] = high, l->from[slot] = m->length[lane];
  set_lane_vec3(l->begin, slot, lane_vec3(m->here, lane));
  set_lane_vec3(l->span, slot, lane_vec3(span, lane));
  if (l->count == LANES) land(m);
}
#endif
