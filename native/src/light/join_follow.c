/* See join_follow.h. All vectors but the joint's are in the spacetime's axes. */
#include "light/join_follow.h"

#include "bentlight/trace.h"

static const double MISS = 1e-8, TRACE_TOLERANCE = 1e-11;
static const double STEP = 1e-5;      /* of the differences, radians */
static const double STRIDE_MAX = 0.1; /* of an iteration, radians */
enum { ITERATIONS = 40, RAYS = 5 };

/* A ray and its neighbors: where it ends, and how that changes with the launch direction along both axes beside it. */
typedef struct probe {
  vec3 launch, axes[2], end, change[2];
  double swept;
} probe;

static int trace_probe(const bent_spacetime *spacetime, const double at[3], vec3 launch, probe *out)
{
  double origins[RAYS][3], directions[RAYS][3], ends[RAYS][3], swept[RAYS];
  uint8_t fate[RAYS];
  out->launch = launch;
  v3_basis(launch, &out->axes[0], &out->axes[1]);
  for (int i = 0; i < RAYS; i++) {
    for (int k = 0; k < 3; k++) origins[i][k] = at[k];
    v3_to(directions[i], i ? v3_mad(out->axes[(i - 1) / 2], i % 2 ? STEP : -STEP, launch) : launch);
  }
  const bent_trace_result result = {.fate = fate, .direction = ends, .swept = swept};
  bent_error ignored;
  if (bent_trace_rays(spacetime, RAYS, (const double(*)[3])origins, (const double(*)[3])directions, TRACE_TOLERANCE,
                      BENT_ROUTE_AUTO, &result, NULL, &ignored))
    return 0;
  for (int i = 0; i < RAYS; i++)
    if (fate[i] != BENT_ESCAPED) return 0;
  out->end = v3_from(ends[0]);
  out->swept = swept[0];
  for (int k = 0; k < 2; k++)
    out->change[k] = v3_scale(v3_sub(v3_from(ends[1 + 2 * k]), v3_from(ends[2 + 2 * k])), 0.5 / STEP);
  return 1;
}

/* The step of the launch direction that would bring the ray's end to `to`, were it linear. */
static vec3 newton_step(const probe *p, vec3 to)
{
  const vec3 off = v3_sub(to, p->end), normal = v3_cross(p->change[0], p->change[1]);
  const double size = max2(v3_dot(normal, normal), 1e-30);
  const double a = v3_dot(v3_cross(off, p->change[1]), normal) / size, b = v3_dot(v3_cross(p->change[0], off), normal) / size;
  const vec3 step = v3_mad(p->axes[0], a, v3_scale(p->axes[1], b));
  const double length = v3_length(step);
  return length > STRIDE_MAX ? v3_scale(step, STRIDE_MAX / length) : step;
}

static double miss(const probe *p, vec3 to) { return v3_length(v3_sub(to, p->end)); }

int join_follow(const geometry *g, vec3 from, vec3 to, joint *j)
{
  const lens *l = &g->lenses[j->first_lens];
  double at[3];
  v3_to(at, mat4_point(&l->spacetime_from_world, from));
  const vec3 target = v3_normalize(mat4_transposed_vector(&l->world_from_spacetime, to));
  probe now, next;
  if (!trace_probe(&l->spacetime, at, v3_normalize(mat4_transposed_vector(&l->world_from_spacetime, j->launch)), &now))
    return 0;
  double part = 1; /* of the whole step: less where the way is not straight */
  for (int i = 0; i < ITERATIONS && miss(&now, target) > MISS; i++) {
    const vec3 launch = v3_normalize(v3_mad(newton_step(&now, target), part, now.launch));
    const int better = trace_probe(&l->spacetime, at, launch, &next) && miss(&next, target) < miss(&now, target);
    if (better) now = next;
    part = better ? min2(2 * part, 1) : part / 2;
  }
  if (!(miss(&now, target) <= MISS)) return 0;
  j->launch = v3_normalize(mat4_vector(&l->world_from_spacetime, now.launch));
  j->spread = v3_length(v3_cross(now.change[0], now.change[1]));
  j->swept = now.swept;
  return 1;
}
