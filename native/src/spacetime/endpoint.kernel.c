/* The endpoint route, lane by lane: loads rays, asks the spacetime's solver, stores what the caller wants. */
#include "spacetime/endpoint.h"
#include "spacetime/endpoint_ellis.h"
#include "spacetime/endpoint_kerr_sum.h"
#include "spacetime/endpoint_schwarzschild.h"

/* A ray whose arithmetic left the domain (an origin that is not in this spacetime, say) is declined. */
LANES_INLINE void decline_broken(endpoint *end)
{
  const lanes_mask sound = lanes_is_finite(end->error) & lanes_is_finite(end->swept);
  end->fate &= sound | (end->fate == BENT_CAPTURED);
}

/* Kerr rays are planned, sorted by the sum that they need, and finished LANES at a time: all lanes then do the same work,
 * and which work is a matter of the ray alone. */
enum { KERR_BLOCK = 256 };

typedef struct kerr_block {
  _Alignas(64) double rows[KERR_TASK_LANES][KERR_BLOCK];
  uint16_t sorted[KERR_BLOCK], sum[KERR_BLOCK];
  uint16_t first[KERR_SUMS + 1]; /* where the rays of each sum start in `sorted` */
} kerr_block;

static void plan_block(const kerr_hole *hole, double tolerance, size_t n, const double (*origins)[3],
                       const double (*directions)[3], size_t offset, const bent_trace_result *out, kerr_block *block)
{
  uint16_t count[KERR_SUMS] = {0};
  for (size_t first = 0; first < n; first += LANES) {
    lanes position[3], direction[3];
    lanes_load_rows(origins, NULL, first, n, position);
    lanes_load_rows(directions, NULL, first, n, direction);
    const kerr_plan plan = kerr_plan_ray(hole, tolerance, position, direction);
    const lanes *task = (const lanes *)&plan.task;
    for (int k = 0; k < KERR_TASK_LANES; k++) *(lanes *)&block->rows[k][first] = task[k];
    const size_t present = n - first < LANES ? n - first : LANES;
    for (size_t i = 0; i < present; i++) {
      const int escapes = plan.fate[i] == BENT_ESCAPED;
      block->sum[first + i] = escapes ? (uint16_t)plan.sum[i] : KERR_SUMS;
      if (escapes) count[plan.sum[i]]++;
    }
    if (lanes_any(plan.fate != BENT_ESCAPED)) {
      const endpoint end = {.fate = plan.fate & (plan.fate != BENT_ESCAPED)};
      endpoint_store(&end, offset + first, present, out);
    }
  }
  block->first[0] = 0;
  for (int s = 0; s < KERR_SUMS; s++) block->first[s + 1] = (uint16_t)(block->first[s] + count[s]);
  uint16_t next[KERR_SUMS];
  for (int s = 0; s < KERR_SUMS; s++) next[s] = block->first[s];
  for (size_t i = 0; i < n; i++)
    if (block->sum[i] < KERR_SUMS) block->sorted[next[block->sum[i]]++] = (uint16_t)i;
}

static void finish_sum(const kerr_hole *hole, const kerr_block *block, int sum, size_t offset,
                       const bent_trace_result *out)
{
  for (size_t first = block->first[sum], last = block->first[sum + 1]; first < last; first += LANES) {
    const size_t present = last - first < LANES ? last - first : LANES;
    kerr_task task;
    for (int k = 0; k < KERR_TASK_LANES; k++) {
      lanes gathered = {0};
      for (size_t i = 0; i < LANES; i++) gathered[i] = block->rows[k][block->sorted[i < present ? first + i : first]];
      ((lanes *)&task)[k] = gathered;
    }
    endpoint end = kerr_finish(hole, &task, sum);
    decline_broken(&end);
    for (size_t i = 0; i < present; i++) endpoint_store_ray(&end, i, offset + block->sorted[first + i], out);
  }
}

static void trace_kerr(const bent_spacetime *spacetime, size_t n, const double (*origins)[3],
                       const double (*directions)[3], double tolerance, const bent_trace_result *out)
{
  const kerr_hole hole = kerr_hole_make(spacetime);
  kerr_block block;
  for (size_t first = 0; first < n; first += KERR_BLOCK) {
    plan_block(&hole, tolerance, n - first < KERR_BLOCK ? n - first : KERR_BLOCK, origins + first, directions + first,
               first, out, &block);
    for (int sum = 0; sum < KERR_SUMS; sum++) finish_sum(&hole, &block, sum, first, out);
  }
}

void BENT_KERNEL(bent_trace_endpoint)(const bent_spacetime *spacetime, size_t n, const double (*origins)[3],
                                      const double (*directions)[3], double tolerance, const bent_trace_result *out)
{
  if (spacetime->kind == BENT_KERR && spacetime->spin != 0) {
    trace_kerr(spacetime, n, origins, directions, tolerance, out);
    return;
  }
  const int is_isotropic = spacetime->chart == BENT_CHART_ISOTROPIC;
  for (size_t first = 0; first < n; first += LANES) {
    lanes position[3], direction[3];
    lanes_load_rows(origins, NULL, first, n, position);
    lanes_load_rows(directions, NULL, first, n, direction);
    const aim a = aim_from(position, direction);
    endpoint end = spacetime->kind == BENT_ELLIS ? endpoint_ellis(spacetime->throat_radius, &a)
                                                 : endpoint_schwarzschild(spacetime->mass, is_isotropic, &a);
    decline_broken(&end);
    endpoint_store(&end, first, n - first < LANES ? n - first : LANES, out);
  }
}
