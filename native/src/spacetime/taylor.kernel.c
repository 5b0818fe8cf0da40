/* Marches rays along Taylor arcs to infinity or the horizon, LANES at a time; a lane whose ray has ended takes the next. */
#include "spacetime/taylor.h"

#include "spacetime/arc.h"

/* Ended lanes wait until this many can be landed together, which costs as much as one. */
#define LAND_TOGETHER (LANES / 2)
/* Looser tolerances than this save nothing and would leave the fates to chance. */
#define TOLERANCE_MAX 0.01

typedef struct march {
  arc_space space;
  size_t count, loaded;       /* rays in all, rays launched so far */
  const uint32_t *index;
  const double (*origins)[3], (*directions)[3];
  const bent_trace_result *out;
  double tolerance;
  arc_ray ready;              /* launched rays that wait for a lane: those from ready_at on */
  int ready_at, ready_count;
  arc_ray ray;                /* the rays in the lanes */
  unsigned busy;
  size_t target[LANES];       /* place of each lane's results */
  lanes steps;
} march;

static void launch_more(march *m)
{
  lanes origin[3], direction[3];
  arc_load(m->origins, m->directions, m->index, m->loaded, m->count, origin, direction);
  arc_launch(&m->space, origin, direction, &m->ready);
  m->ready_at = 0;
  m->ready_count = m->count - m->loaded < LANES ? (int)(m->count - m->loaded) : LANES;
}

/* Gives every idle lane the next ray, while there are any. */
static void refill(march *m)
{
  for (int lane = 0; lane < LANES && m->loaded < m->count; lane++) {
    if (m->busy >> lane & 1) continue;
    if (m->ready_at == m->ready_count) launch_more(m);
    arc_ray_copy_lane(&m->ray, lane, &m->ready, m->ready_at++);
    m->target[lane] = m->index ? m->index[m->loaded] : m->loaded;
    m->steps[lane] = 0;
    m->busy |= 1u << lane;
    m->loaded++;
  }
}

static void report_lane(const march *m, int lane, bent_fate fate, double error, const lanes direction[3])
{
  const bent_trace_result *out = m->out;
  const size_t at = m->target[lane];
  const int known = fate == BENT_ESCAPED || fate == BENT_ESCAPED_FAR;
  if (out->fate) out->fate[at] = (uint8_t)fate;
  if (out->error) out->error[at] = error;
  if (out->steps) out->steps[at] = (uint32_t)m->steps[lane];
  if (out->swept) out->swept[at] = m->ray.swept[lane];
  if (out->direction)
    for (int k = 0; k < 3; k++) out->direction[at][k] = known ? direction[k][lane] : NAN;
}

/* Writes the results of the lanes in `ended` and frees them. `resolved`: lanes that arrived where they should. */
static void report(march *m, unsigned ended, unsigned resolved)
{
  lanes direction[3];
  arc_asymptote(&m->space, &m->ray, direction);
  lanes error = arc_error(&m->space, &m->ray, m->steps) + ARC_SHARE * m->tolerance;
  /* a ray that has not arrived may be going anywhere */
  error = lanes_select(lanes_mask_from_bits(resolved), error, lanes_max(error, lanes_all(M_PI)));
  const unsigned good = resolved & lanes_bits(error <= fmax(m->tolerance, BENT_TRACE_ERROR_MAX));
  const unsigned doomed = lanes_bits(m->ray.doomed), far = lanes_bits(m->ray.side < 0);
  for (int lane = 0; lane < LANES; lane++) {
    if (!(ended >> lane & 1)) continue;
    bent_fate fate = BENT_UNRESOLVED;
    if (good >> lane & 1)
      fate = doomed >> lane & 1 ? BENT_CAPTURED : far >> lane & 1 ? BENT_ESCAPED_FAR : BENT_ESCAPED;
    report_lane(m, lane, fate, error[lane], direction);
  }
  m->busy &= ~ended;
}

/* One arc for every lane. Lanes that end on it keep their place until enough have gathered, then they land and report. */
LANES_INLINE void march_arc(march *m, int order)
{
  arc arc;
  lanes end, slope;
  arc_expand_to(&m->space, &m->ray, lanes_all(ARC_SHARE * fmin(m->tolerance, TOLERANCE_MAX)), order, &arc);
  series_with_slope(arc.series[ARC_W], order, arc.step, &end, &slope);
  const lanes bottom = lanes_all(m->space.kind == BENT_ELLIS ? INFINITY : m->space.horizon);
  const lanes_mask doomed = m->ray.doomed;
  /* inside the barrier a falling ray can turn only behind the horizon */
  const lanes_mask turned = doomed & (m->ray.v > 0) & (slope <= 0) & (end > m->ray.peak);
  const lanes_mask escapes = end <= 0, falls = (end >= bottom) | turned;
  const lanes_mask stuck = ~((end <= 0) | (end > 0)) | (m->steps >= ARC_STEPS_MAX) | (m->ray.depth < 1e-15);
  const lanes_mask ends = escapes | falls | stuck;
  const unsigned over = lanes_bits(ends) & m->busy;
  lanes offset = lanes_select(ends, lanes_all(0), arc.step);
  if (!over || (__builtin_popcount(over) < LAND_TOGETHER && over != m->busy)) {
    arc_advance(&m->space, &arc, offset, &m->ray);
    m->steps += lanes_select(ends, lanes_all(0), lanes_all(1));
    return;
  }
  const lanes_mask lands = (escapes | (falls & (end >= bottom))) & ~stuck;
  const lanes level = lanes_select(escapes, lanes_all(0), bottom);
  const lanes landing = arc_crossing(&arc, arc.series[ARC_W], level, end, lands);
  offset = lanes_select(stuck, lanes_all(0), landing);
  arc_advance(&m->space, &arc, offset, &m->ray);
  m->steps += 1;
  const lanes_mask resolved = ((escapes & ~doomed) | (falls & doomed)) & ~stuck;
  report(m, over, lanes_bits(resolved));
  refill(m);
}

void BENT_KERNEL(bent_trace_taylor)(const bent_spacetime *spacetime, size_t n, const uint32_t *index,
                                    const double (*origins)[3], const double (*directions)[3], double tolerance,
                                    const bent_trace_result *out)
{
  march m = {.space = arc_space_make(spacetime), .count = n, .index = index, .origins = origins,
             .directions = directions, .out = out, .tolerance = tolerance};
  m.space.ends_only = 1;
  if (!n) return;
  launch_more(&m);
  m.ray = m.ready; /* idle lanes hold valid numbers */
  refill(&m);
  if (tolerance >= ARC_LOW_TOLERANCE)
    while (m.busy) march_arc(&m, ARC_ORDER_LOW);
  else
    while (m.busy) march_arc(&m, ARC_ORDER_MAX);
}

size_t BENT_KERNEL(bent_first_bad_ray)(const bent_spacetime *spacetime, size_t n, const double (*origins)[3],
                                       const double (*directions)[3])
{
  const double core = bent_spacetime_core_radius(spacetime), spin = spacetime->spin;
  const double horizon = sqrt((core - fabs(spin)) * (core + fabs(spin)));
  const int kerr = spacetime->kind == BENT_KERR, hole = kerr || spacetime->kind == BENT_SCHWARZSCHILD;
  const double across = hole && core > 0 ? 1 / (core * core) : 0;
  const double along = kerr && core > 0 ? 1 / (horizon * horizon) : across;
  const int curved = !bent_spacetime_is_flat(spacetime);
  for (size_t first = 0; first < n; first += LANES) {
    lanes x[3], d[3];
    lanes_load_rows(origins, NULL, first, n, x);
    lanes_load_rows(directions, NULL, first, n, d);
    const lanes length2 = lanes_dot(d, d), distance2 = lanes_dot(x, x);
    lanes_mask good = (length2 >= 1e-300) & (length2 <= 1e300) & (distance2 <= 1e300);
    if (curved) good &= distance2 > 1e-300;
    if (hole && curved) good &= (x[0] * x[0] + x[1] * x[1]) * across + x[2] * x[2] * along > 1;
    const unsigned bad = ~lanes_bits(good) & LANES_EVERY;
    if (bad) {
      const size_t at = first + (size_t)__builtin_ctz(bad);
      return at < n ? at : n - 1;
    }
  }
  return n;
}
