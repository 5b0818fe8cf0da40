/* Curved rays inside one lens, LANES at a time: Taylor arcs, cut into chords, hits moved onto the arc. A lane whose ray is
 * done with the lens takes the next one. */
#include "geometry/chords.h"
#include "geometry/landing.h"
#include "geometry/march.h"

/* Chords need no better series. */
#define ARC_ORDER ARC_ORDER_LOW

/* w = 1/r of a chart radius; positions with smaller w lie outside the sphere of that radius. */
static double w_of_radius(const arc_space *s, double radius)
{
  if (s->kind == BENT_ELLIS) {
    radius = fmax(radius, 0.5 * s->throat_radius);
    return 1 / (radius + 0.25 * s->throat_radius * s->throat_radius / radius);
  }
  if (s->chart != BENT_CHART_ISOTROPIC) return fmin(1 / radius, s->horizon);
  radius = fmax(radius, 0.5 * s->mass);
  return radius / ((radius + 0.5 * s->mass) * (radius + 0.5 * s->mass));
}

static march march_make(const geometry *g, int lens_index)
{
  const lens *l = &g->lenses[lens_index];
  march m = {.g = g, .lens = l, .space = arc_space_make(&l->spacetime), .endless = isinf(l->radius)};
  const double to_geometry = v3_length(v3_sub(g->center, l->center)) + fmax(g->radius, 0);
  m.reach_w = w_of_radius(&m.space, 1.1 * (m.endless ? to_geometry : l->radius) / l->scale);
  return m;
}

static void launch_more(march *m)
{
  lanes origin[3], direction[3];
  m->ready_at = 0;
  m->ready_count = m->count - m->loaded < LANES ? (int)(m->count - m->loaded) : LANES;
  for (int lane = 0; lane < LANES; lane++) {
    const int which = lane < m->ready_count ? lane : m->ready_count - 1;
    const traveler *t = &m->travelers[m->index[m->loaded + which]];
    set_lane_vec3(origin, lane, mat4_point(&m->lens->spacetime_from_world, t->position));
    set_lane_vec3(direction, lane, v3_normalize(mat4_transposed_vector(&m->lens->world_from_spacetime, t->direction)));
  }
  arc_launch(&m->space, origin, direction, &m->ready);
}

/* The tolerance of the series: as an angle, and as a distance over the size of what can be hit. */
static double series_tolerance(const march *m, const bent_ray *ray)
{
  const double size = m->endless ? 2 * fmax(m->g->radius, 0) : 2 * m->lens->radius;
  return ARC_SHARE * fmin(ray->angular_tolerance, 0.5 * ray->tolerance / fmax(size, 1e-300));
}

/* Gives every idle lane the next ray, while there are any. */
static void refill(march *m)
{
  for (int lane = 0; lane < LANES && m->loaded < m->count; lane++) {
    if (m->busy >> lane & 1) continue;
    if (m->ready_at == m->ready_count) launch_more(m);
    arc_ray_copy_lane(&m->ray, lane, &m->ready, m->ready_at++);
    const uint32_t target = m->index[m->loaded++];
    const traveler *t = &m->travelers[target];
    const bent_ray *ray = &m->rays[target];
    m->target[lane] = target;
    m->steps[lane] = 0;
    m->tolerance[lane] = ray->tolerance;
    m->arc_tolerance[lane] = series_tolerance(m, ray);
    set_lane_vec3(m->here, lane, t->position);
    set_lane_vec3(m->shift, lane, v3(0, 0, 0));
    m->length[lane] = m->hits[target].length;
    m->delta[lane] = INFINITY;
    m->blind[lane] = m->g->radius < 0 || !ray->visibility ? -1 : 0;
    m->leaving[lane] = t->leaving ? -1 : 0;
    m->busy |= 1u << lane;
  }
}

/* For lanes that leave a surface: the direction in which the ray is drawn, which in the areal and oblate charts is not the
 * local one, and the normal on its side. By differences along the arc, extrapolated to its beginning. */
LANES_INLINE void set_departure(march *m, const arc *arc, lanes limit)
{
  const lanes h = 1e-4 * lanes_min(limit, m->delta);
  lanes half[3], full[3], origin[3];
  march_position(m, &m->ray, arc, lanes_all(0), origin);
  march_position(m, &m->ray, arc, 0.5 * h, half);
  march_position(m, &m->ray, arc, h, full);
  for (unsigned left = lanes_bits(m->leaving) & m->busy; left; left &= left - 1) {
    const int lane = __builtin_ctz(left);
    const bent_ray *ray = &m->rays[m->target[lane]];
    const vec3 o = lane_vec3(origin, lane), a = v3_sub(lane_vec3(half, lane), o), b = v3_sub(lane_vec3(full, lane), o);
    const vec3 departure = v3_normalize(v3_sub(v3_scale(a, 4), b));
    const triangle t = triangle_of(m->g, ray->source_instance, ray->source_triangle);
    set_lane_vec3(m->departure, lane, departure);
    set_lane_vec3(m->source, lane, v3_dot(departure, t.normal) < 0 ? v3_scale(t.normal, -1) : t.normal);
  }
}

/* What lies ahead on the arcs: up to where chords are needed. */
typedef struct plan {
  lanes limit;
  lanes_mask walking; /* lanes that need chords */
  lanes_mask throat;  /* `limit` is the throat, and beyond it another mouth */
  lanes_mask away;    /* beyond `limit` nothing can be met, and the ray goes to infinity */
} plan;

/* Lanes in `turning` begin and end beyond the reach and turn round in between. Where the turn is beyond it too nothing can
 * be met: returned. The arcs of the others end at the turn, and so within reach: the next one cannot turn again. */
LANES_INLINE lanes_mask end_at_turning(const march *m, arc *arc, lanes v_end, lanes_mask turning)
{
  lanes slope[ARC_ORDER_MAX + 1];
  const lanes *rate = arc->series[ARC_RATE];
  if (m->space.kind != BENT_ELLIS) {
    for (int k = 0; k < ARC_ORDER; k++) slope[k] = (k + 1) * arc->series[ARC_W][k + 1];
    slope[ARC_ORDER] = lanes_all(0);
    rate = slope;
  }
  const lanes turn = arc_crossing(arc, rate, lanes_all(0), v_end, turning);
  const lanes_mask clear = turning & (series_at(arc->series[ARC_W], ARC_ORDER, turn) < lanes_all(m->reach_w));
  arc->step = lanes_select(turning & ~clear, turn, arc->step);
  arc->escapes &= clear | ~turning;
  return clear;
}

LANES_INLINE plan plan_arc(march *m, arc *arc)
{
  const int wormhole = m->space.kind == BENT_ELLIS;
  const lanes reach = lanes_all(m->reach_w);
  lanes w_end, v_end, p_end = lanes_all(1);
  series_with_slope(arc->series[ARC_W], ARC_ORDER, arc->step, &w_end, &v_end);
  if (wormhole) {
    v_end = series_at(arc->series[ARC_RATE], ARC_ORDER, arc->step);
    p_end = series_at(arc->series[ARC_SIDE], ARC_ORDER, arc->step);
  }
  /* Beyond the throat is either another mouth, where the ray goes on as a new leg, or an empty sky. */
  const lanes_mask inside = lanes_mask_all(!wormhole) | (m->ray.side >= 0) | (m->ray.v > 0);
  const lanes_mask outward = is_outward(m, m->ray.v) & ~m->ray.doomed;
  const lanes_mask clear = (m->blind & lanes_mask_all(m->endless)) | ~inside | ((m->ray.w < reach) & outward);
  plan p;
  p.throat = ~clear & (p_end < 0) & (v_end < 0);
  const lanes_mask leaves = ~clear & ~p.throat & (w_end < reach) & is_outward(m, v_end) & ~m->ray.doomed;
  const lanes_mask turning = leaves & (m->ray.w < reach), exits = leaves & ~turning;
  lanes_mask passes = clear;
  if (lanes_any(turning)) passes |= end_at_turning(m, arc, v_end, turning);
  p.walking = ~passes;
  /* an arc that reaches infinity itself needs no jump */
  p.away = lanes_mask_all(m->endless) & inside & ~m->ray.doomed & ~arc->escapes & (passes | exits);
  p.limit = lanes_select(passes & p.away, lanes_all(0), arc->step);
  if (lanes_any(exits)) {
    const lanes crossing = arc_crossing(arc, arc->series[ARC_W], reach, w_end, exits);
    p.limit = lanes_select(exits, crossing, p.limit);
  }
  if (wormhole && lanes_any(p.throat)) {
    const lanes crossing = arc_crossing(arc, arc->series[ARC_SIDE], lanes_all(0), p_end, p.throat);
    p.limit = lanes_select(p.throat, crossing, p.limit);
  }
  return p;
}

/* Lanes that leave the lens on this arc, before infinity or the horizon. `direction`: local, in spacetime axes. */
static void report_stop(march *m, const outcome *out, int lane, const lanes direction[3])
{
  traveler *t = &m->travelers[m->target[lane]];
  bent_hit *hit = &m->hits[m->target[lane]];
  t->leaving = 0;
  hit->length = m->length[lane];
  t->position = lane_vec3(m->here, lane);
  t->left = (int)(m->lens - m->g->lenses);
  if (out->away >> lane & 1) {
    t->direction = march_direction(m, direction, lane);
    t->leg = LEG_AWAY;
    return;
  }
  hit->borders++;
  if (out->edge >> lane & 1) {
    t->direction = march_direction(m, direction, lane);
    t->leg = LEG_FLAT;
    return;
  }
  traveler_pass_throat(t, m->g, m->lens, lane_vec3(direction, lane));
}

/* Lanes that reach infinity, the horizon, or nothing at all. */
static void report_end(march *m, int lane, int resolved, const lanes asymptote[3])
{
  traveler *t = &m->travelers[m->target[lane]];
  bent_hit *hit = &m->hits[m->target[lane]];
  t->leg = LEG_OVER;
  vec3 direction = v3(NAN, NAN, NAN);
  hit->length = m->length[lane];
  if (!resolved) hit->fate = BENT_UNRESOLVED;
  else if (m->ray.doomed[lane]) hit->fate = BENT_CAPTURED;
  else {
    const int far = m->ray.side[lane] < 0;
    direction = lane_vec3(asymptote, lane);
    if (far) direction.y = -direction.y, hit->sky = (int)(m->lens - m->g->lenses);
    hit->fate = far ? BENT_ESCAPED_FAR : BENT_ESCAPED;
    hit->length = INFINITY;
    direction = v3_normalize(mat4_vector(&m->lens->world_from_spacetime, direction));
  }
  v3_to(hit->direction, direction);
}

/* Lanes whose arc must be the last. */
typedef struct endings {
  unsigned stopped, ended, resolved;
} endings;

static void report(march *m, const outcome *out, endings ends, const lanes direction[3])
{
  const lanes error = arc_error(&m->space, &m->ray, m->steps);
  lanes asymptote[3];
  if (ends.ended) arc_asymptote(&m->space, &m->ray, asymptote);
  for (unsigned left = (ends.stopped | ends.ended) & m->busy; left; left &= left - 1) {
    const int lane = __builtin_ctz(left);
    bent_hit *hit = &m->hits[m->target[lane]];
    hit->error += error[lane];
    hit->swept += m->ray.swept[lane];
    if (ends.stopped >> lane & 1) report_stop(m, out, lane, direction);
    else {
      const int accurate = error[lane] <= fmax(m->rays[m->target[lane]].angular_tolerance, BENT_TRACE_ERROR_MAX);
      report_end(m, lane, ends.resolved >> lane & 1 && accurate, asymptote);
    }
  }
  m->busy &= ~(ends.stopped | ends.ended);
}

/* Brings `here` of lanes that go away to where they stop: chords may have ended before. */
LANES_INLINE void leave(march *m, const arc *arc, const outcome *out)
{
  lanes at[3];
  march_position(m, &m->ray, arc, out->offset, at);
  for (int k = 0; k < 3; k++) m->here[k] = lanes_select(lanes_mask_from_bits(out->away), at[k], m->here[k]);
}

/* One arc for every lane. */
static void march_arc(march *m)
{
  arc arc;
  arc_expand_to(&m->space, &m->ray, m->arc_tolerance, ARC_ORDER, &arc);
  arc_land(&m->space, &m->ray, &arc);
  const lanes_mask stuck = ~(arc.step >= 0) | (m->steps >= ARC_STEPS_MAX) | (m->ray.depth < 1e-15);
  arc.step = lanes_select(stuck, lanes_all(0), arc.step);
  plan p = plan_arc(m, &arc);
  const lanes_mask busy = lanes_mask_from_bits(m->busy);
  outcome out = {.offset = arc.step};
  if (lanes_any(m->leaving & busy & p.walking)) set_departure(m, &arc, p.limit);
  const lanes_mask walking = p.walking & busy & ~stuck & (p.limit > 0);
  chords_walk(m, &arc, p.limit, walking, &out);
  m->busy &= ~out.hit;
  out.throat = lanes_bits(p.throat) & m->busy & ~out.edge & (m->lens->exit >= 0 ? ~0u : 0);
  out.away = lanes_bits(p.away & ~stuck) & m->busy & ~out.edge;
  out.offset = lanes_select(lanes_mask_from_bits(out.edge | out.throat), out.offset, arc.step);
  out.offset = lanes_select(lanes_mask_from_bits(out.away), p.limit, out.offset);
  endings ends = {.stopped = out.edge | out.throat | out.away};
  if (out.away) leave(m, &arc, &out);
  lanes direction[3];
  if (ends.stopped) arc_direction(&m->space, &m->ray, &arc, out.offset, direction);
  arc_advance(&m->space, &arc, out.offset, &m->ray);
  m->steps += 1;
  ends.ended = lanes_bits(arc.escapes | arc.falls | stuck) & m->busy & ~ends.stopped;
  ends.resolved = lanes_bits(((arc.escapes & ~m->ray.doomed) | (arc.falls & m->ray.doomed)) & ~stuck);
  if (ends.stopped | ends.ended) report(m, &out, ends, direction);
  if (ends.stopped | ends.ended | out.hit) refill(m);
}

void BENT_KERNEL(bent_travel_curved)(const geometry *g, int lens_index, size_t n, const uint32_t *index,
                                     const bent_ray *rays, traveler *travelers, bent_hit *hits)
{
  march m = march_make(g, lens_index);
  m.index = index, m.count = n, m.rays = rays, m.travelers = travelers, m.hits = hits;
  if (!n) return;
  launch_more(&m);
  m.ray = m.ready; /* idle lanes hold valid numbers */
  m.arc_tolerance = m.tolerance = lanes_all(1);
  m.delta = lanes_all(1);
  refill(&m);
  while (m.busy) march_arc(&m);
  land(&m);
}
