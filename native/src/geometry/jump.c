/* The last leg of rays that have left all geometry behind: fate and asymptotic direction by the deflection table or the
 * separated integrals, at a fraction of the cost of Taylor arcs. */
#include "geometry/jump.h"

/* Rays of one lens on their last leg, in spacetime axes. */
typedef struct batch {
  size_t count;
  uint32_t target[TRAVELERS_MAX];
  double origins[TRAVELERS_MAX][3], directions[TRAVELERS_MAX][3];
  uint8_t fate[TRAVELERS_MAX];
  double asymptote[TRAVELERS_MAX][3], error[TRAVELERS_MAX], swept[TRAVELERS_MAX];
} batch;

static bent_trace_result results_of(batch *b)
{
  return (bent_trace_result){.fate = b->fate, .direction = b->asymptote, .error = b->error, .swept = b->swept};
}

bent_status jump_commit(lens *l, bent_error *error)
{
  if (l->table || l->flat || !isinf(l->radius) || l->spacetime.kind == BENT_KERR) return BENT_OK;
  bent_status status = bent_table_new(&l->spacetime, &l->table, error);
  if (!status) status = bent_table_build(l->table, 0, bent_table_rows(l->table), NULL, error);
  bent_table_error measured;
  if (!status) status = bent_table_measured(l->table, &measured, error);
  if (!status) l->table_error = measured.total_max + measured.sweep_max;
  return status;
}

static void batch_add(batch *b, const lens *l, uint32_t target, const traveler *t)
{
  const size_t k = b->count++;
  b->target[k] = target;
  v3_to(b->origins[k], mat4_point(&l->spacetime_from_world, t->position));
  v3_to(b->directions[k], v3_normalize(mat4_transposed_vector(&l->world_from_spacetime, t->direction)));
}

static void finish(const batch *b, size_t k, const lens *l, int lens_index, bent_hit *hit)
{
  hit->fate = b->fate[k];
  hit->error += b->error[k];
  if (hit->fate == BENT_ESCAPED || hit->fate == BENT_ESCAPED_FAR) {
    vec3 direction = v3_from(b->asymptote[k]);
    if (hit->fate == BENT_ESCAPED_FAR) direction.y = -direction.y, hit->sky = lens_index;
    hit->length = INFINITY;
    hit->swept += b->swept[k];
    v3_to(hit->direction, v3_normalize(mat4_vector(&l->world_from_spacetime, direction)));
  } else {
    v3_to(hit->direction, v3(NAN, NAN, NAN));
  }
}

/* By the table; returns how many of the batch it could not answer within their tolerance, moved to the front. */
static size_t jump_by_table(batch *b, const lens *l, int lens_index, const bent_ray *rays, bent_hit *hits)
{
  const bent_trace_result results = results_of(b);
  bent_table_trace(l->table, b->count, (const double(*)[3])b->origins, (const double(*)[3])b->directions, &results);
  size_t left = 0;
  for (size_t k = 0; k < b->count; k++) {
    const double tolerance = rays[b->target[k]].angular_tolerance;
    if (l->table_error <= tolerance && b->fate[k] != BENT_UNRESOLVED) {
      finish(b, k, l, lens_index, &hits[b->target[k]]);
      continue;
    }
    b->target[left] = b->target[k];
    for (int i = 0; i < 3; i++) b->origins[left][i] = b->origins[k][i], b->directions[left][i] = b->directions[k][i];
    left++;
  }
  return left;
}

/* By tracing, at each ray's own tolerance: runs of equal ones together, which changes no ray's answer. */
static void jump_by_tracing(batch *b, const lens *l, int lens_index, const bent_ray *rays, bent_hit *hits)
{
  for (size_t first = 0, end; first < b->count; first = end) {
    const double tolerance = rays[b->target[first]].angular_tolerance;
    for (end = first + 1; end < b->count && rays[b->target[end]].angular_tolerance == tolerance;) end++;
    const bent_trace_result results = {.fate = b->fate + first, .direction = b->asymptote + first,
                                       .error = b->error + first, .swept = b->swept + first};
    bent_error ignored;
    const bent_status status =
        bent_trace_rays(&l->spacetime, end - first, (const double(*)[3])(b->origins + first),
                        (const double(*)[3])(b->directions + first), tolerance, BENT_ROUTE_AUTO, &results, NULL, &ignored);
    for (size_t k = first; k < end; k++) {
      /* refused: rounding has put the ray where none may start */
      if (status) b->fate[k] = BENT_UNRESOLVED, b->error[k] = M_PI;
      finish(b, k, l, lens_index, &hits[b->target[k]]);
    }
  }
}

void jump(const geometry *g, size_t n, const uint32_t *index, const bent_ray *rays, traveler *travelers, bent_hit *hits)
{
  for (int i = 0; i < (int)g->lens_count; i++) {
    batch b;
    b.count = 0;
    for (size_t k = 0; k < n; k++)
      if (travelers[index[k]].left == i) batch_add(&b, &g->lenses[i], index[k], &travelers[index[k]]);
    if (b.count && g->lenses[i].table) b.count = jump_by_table(&b, &g->lenses[i], i, rays, hits);
    jump_by_tracing(&b, &g->lenses[i], i, rays, hits);
  }
  for (size_t k = 0; k < n; k++) travelers[index[k]].leg = LEG_OVER;
}
