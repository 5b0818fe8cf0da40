/* Connections around a spinning hole: for every image of a block of pairs a first guess, then the aim. Pairs that fail are
 * guessed again by other rules. Searches that need the same work, of about the same length, do it side by side in the
 * lanes. */
#include <string.h>

#include "spacetime/connect.h"
#include "spacetime/connect_guess.h"

/* A ray that winds otherwise than guessed, by this many radians, is another image. */
#define SWEPT_APART 1.5
/* Rays of a pair whose launch directions differ by less are the same, at images that are no caustic. */
#define SAME 1e-6
/* Sines of polar angles of places on the axis. */
#define ON_AXIS (4 * EPSILON)

/* One image of a pair. */
typedef struct found_image {
  bent_connection_status status;
  double launch[3], arrival[3], spread, frequency_ratio, swept, error;
} found_image;

/* A block of pairs. */
typedef struct block {
  const connect_request *request;
  double mass;
  arc_space space; /* of the hole of mass 1 */
  const double (*a)[3], (*b)[3];
  found_image images[BENT_CONNECT_IMAGES_MAX][CONNECT_BLOCK]; /* by order and pair; lengths over M */
  aim_record searches[CONNECT_BLOCK];                         /* by pair */
  int attempt[CONNECT_BLOCK];
} block;

/* What a search may wait for: a guess by each rule, a trial. */
enum { WORK_GUESS = 0, WORK_TRIAL = GUESS_ATTEMPTS, WORK_KINDS };

/* Searches that wait for the same work, by the number of steps that it will take, about. The shortest go first, and come
 * back with longer work: so all are about as far, and there are always some of about the same length to share the lanes. */
enum { LENGTHS = 64 };
typedef struct queue {
  size_t count;
  int shortest; /* none that waits is shorter */
  int32_t first[LENGTHS], next[CONNECT_BLOCK]; /* pairs: by length, and after each pair; -1: no more */
} queue;

static void clear(queue *q)
{
  q->count = 0, q->shortest = LENGTHS;
  for (int i = 0; i < LENGTHS; i++) q->first[i] = -1;
}

static void enter(queue *q, uint32_t pair, double steps)
{
  const int length = (int)fmin(fmax(steps, 0), LENGTHS - 1);
  q->next[pair] = q->first[length], q->first[length] = (int32_t)pair;
  if (length < q->shortest) q->shortest = length;
  q->count++;
}

/* Takes up to LANES of the shortest; returns how many. */
static size_t leave(queue *q, uint32_t pairs[LANES])
{
  size_t n = 0;
  for (; n < LANES && q->count > 0; n++, q->count--) {
    while (q->first[q->shortest] < 0) q->shortest++;
    pairs[n] = (uint32_t)q->first[q->shortest];
    q->first[q->shortest] = q->next[pairs[n]];
  }
  return n;
}

/* The work to do next: what fills the lanes, guesses first; otherwise such as may lead to more for the others. -1: none is
 * left. */
static int next_work(const queue queues[WORK_KINDS])
{
  for (int kind = 0; kind < WORK_KINDS; kind++)
    if (queues[kind].count >= LANES) return kind;
  if (queues[WORK_TRIAL].count) return WORK_TRIAL;
  for (int kind = 0; kind < WORK_KINDS; kind++)
    if (queues[kind].count) return kind;
  return -1;
}

LANES_INLINE flow_place place_of(const block *block, const double (*points)[3], const uint32_t *index, size_t first,
                                 size_t n, int sky)
{
  lanes x[3];
  flow_place place;
  lanes_load_rows(points, index, first, n, x);
  if (sky) {
    const lanes length = lanes_sqrt(lanes_dot(x, x));
    for (int k = 0; k < 3; k++) place.n[k] = x[k] / length;
    place.w = lanes_all(0), place.above = lanes_all(1);
    return place;
  }
  kerr_place at;
  for (int k = 0; k < 3; k++) x[k] /= block->mass;
  place.w = kerr_place_at(&block->space, x, &at);
  place.above = 1 / place.w - block->space.outer;
  place.n[0] = at.sin_theta * at.cos_phi, place.n[1] = at.sin_theta * at.sin_phi, place.n[2] = at.cos_theta;
  const lanes length = lanes_sqrt(lanes_dot(place.n, place.n));
  for (int k = 0; k < 3; k++) place.n[k] /= length;
  return place;
}

/* Local unit direction in scene axes. */
LANES_INLINE void scene_direction(const flow_hole *hole, const flow_place *at, const lanes local[3], lanes out[3])
{
  const flow_metric g = flow_metric_at(hole, at);
  const lanes stretch = lanes_sqrt(1 + hole->spin * hole->spin * at->w * at->w), inverse = 1 / lanes_sqrt(g.sigma);
  const lanes sine = g.sine * inverse, cosine = g.cosine * inverse, x = g.east[1], y = -g.east[0];
  const lanes er[3] = {sine * x, sine * y, stretch * cosine};
  const lanes et[3] = {stretch * cosine * x, stretch * cosine * y, -sine};
  const lanes ep[3] = {-y, x, lanes_all(0)};
  for (int k = 0; k < 3; k++) out[k] = local[0] * er[k] + local[1] * et[k] + local[2] * ep[k];
  const lanes length = lanes_sqrt(lanes_dot(out, out));
  for (int k = 0; k < 3; k++) out[k] /= length;
}

/* What the aimed rays of lanes that are done are; lane i is pair pairs[i]. */
static void report(block *block, const aim_task *t, const aim_shot *shot, const aim_result *result, const uint32_t *pairs,
                   int order)
{
  const flow_hole hole = flow_hole_of(t->spin);
  const flow_ray *ray = &shot->ray;
  const int sky = block->request->sky;
  const lanes E = ray->energy.value, width = sky ? lanes_all(1) : t->b.w * t->b.w;
  lanes launch[3], components[3], arrival[3], local = E;
  scene_direction(&hole, &t->a, result->aimed.d, launch);
  for (int k = 0; k < 3; k++) arrival[k] = t->b.n[k];
  if (!sky) {
    local = aim_arrival(&hole, &t->b, ray, components);
    scene_direction(&hole, &t->b, components, arrival);
  }
  /* Area across the ray: the determinant of the end's displacements by the launch angles and along the ray, in local
   * measures of b, over the length of the latter. Lapse, local energy and the ZAMO's own motion combine to E w^2. */
  const lanes(*j)[3] = shot->jacobian;
  const lanes determinant = j[0][0] * (j[1][1] * j[2][2] - j[1][2] * j[2][1]) +
                            j[0][1] * (j[1][2] * j[2][0] - j[1][0] * j[2][2]) +
                            j[0][2] * (j[1][0] * j[2][1] - j[1][1] * j[2][0]);
  const lanes sine_a = lanes_sqrt(t->a.n[0] * t->a.n[0] + t->a.n[1] * t->a.n[1]);
  const lanes sine_b = lanes_sqrt(t->b.n[0] * t->b.n[0] + t->b.n[1] * t->b.n[1]);
  const lanes_mask ring = (sine_a <= ON_AXIS) & (sine_b <= ON_AXIS) & (ray->swept > 1);
  const lanes spread = lanes_select(ring, lanes_all(0), lanes_abs(determinant / (E * width)));
  const lanes_mask right = lanes_abs(ray->swept - t->swept) < SWEPT_APART;
  const lanes_mask sound = result->found & right & lanes_is_finite(spread + 1 / local) & lanes_is_finite(launch[0] + arrival[0]);
  const lanes_mask done = result->found | result->lost;
  for (int i = 0; i < LANES; i++) {
    if (!done[i]) continue;
    const int good = result->error[i] <= block->request->tolerance;
    const bent_connection_status met = good ? ring[i] ? BENT_CONNECTION_RING : BENT_CONNECTION_MET : BENT_CONNECTION_COARSE;
    found_image *image = &block->images[order][pairs[i]];
    *image = (found_image){.status = sound[i] ? met : BENT_CONNECTION_FAILED, .spread = spread[i],
                           .frequency_ratio = 1 / local[i], .swept = sound[i] ? ray->swept[i] : t->swept[i],
                           .error = result->error[i]};
    for (int k = 0; k < 3; k++) image->launch[k] = launch[k][i], image->arrival[k] = arrival[k][i];
  }
}

/* Guesses for n <= LANES pairs, by their next rule. */
static void guess(block *block, const uint32_t *pairs, size_t n, int order, int attempt, queue queues[WORK_KINDS])
{
  aim_task t;
  memset(&t, 0, sizeof t);
  t.a = place_of(block, block->a, pairs, 0, n, 0);
  t.b = place_of(block, block->b, pairs, 0, n, block->request->sky);
  t.sky = (lanes)lanes_mask_all(block->request->sky);
  t.spin = lanes_all(block->space.spin);
  guess_first(order, &GUESS_RULES[attempt], &t);
  for (size_t i = 0; i < n; i++) {
    aim_save(&t, (int)i, &block->searches[pairs[i]]);
    block->attempt[pairs[i]] = attempt + 1;
    enter(&queues[WORK_TRIAL], pairs[i], t.swept[i]);
  }
}

/* Whether an image is one of the pair's earlier ones once more. */
static int is_known(const block *block, size_t pair, int order)
{
  const found_image *image = &block->images[order][pair];
  if (image->status == BENT_CONNECTION_RING) return 0;
  for (int k = 0; k < order; k++) {
    const found_image *other = &block->images[k][pair];
    double apart = 0;
    for (int i = 0; i < 3; i++) apart = fmax(apart, fabs(image->launch[i] - other->launch[i]));
    if (other->status != BENT_CONNECTION_FAILED && apart < SAME && fabs(image->swept - other->swept) < 1) return 1;
  }
  return 0;
}

/* A search has ended: by the next rule, if there is one, an image that was not found is looked for again. */
static void conclude(block *block, uint32_t pair, int order, queue queues[WORK_KINDS])
{
  found_image *image = &block->images[order][pair];
  if (is_known(block, pair, order)) image->status = BENT_CONNECTION_FAILED;
  const int attempts = order < 2 ? GUESS_ATTEMPTS : GUESS_ATTEMPTS_FAINT;
  if (image->status == BENT_CONNECTION_FAILED && block->attempt[pair] < attempts)
    enter(&queues[WORK_GUESS + block->attempt[pair]], pair, 0);
}

/* A trial of n <= LANES pairs. */
static void aim(block *block, const uint32_t *pairs, size_t n, int order, queue queues[WORK_KINDS])
{
  aim_task t;
  aim_shot shot;
  for (size_t i = 0; i < LANES; i++) /* idle lanes hold valid numbers */
    aim_load(&t, (int)i, &block->searches[pairs[i < n ? i : 0]]);
  const lanes_mask busy = lanes_mask_from_bits((1u << n) - 1);
  const aim_result result = aim_try(&t, block->request->tolerance, busy, &shot);
  const lanes_mask done = result.found | result.lost;
  if (lanes_any(done)) report(block, &t, &shot, &result, pairs, order);
  for (size_t i = 0; i < n; i++) {
    if (done[i]) {
      conclude(block, pairs[i], order, queues);
      continue;
    }
    aim_save(&t, (int)i, &block->searches[pairs[i]]);
    enter(&queues[WORK_TRIAL], pairs[i], result.steps[i]);
  }
}

/* Image `order` of the pairs wanted[0 .. n-1], by as many attempts as it takes. */
static void find_images(block *block, const uint32_t *wanted, size_t n, int order)
{
  queue queues[WORK_KINDS];
  for (int kind = 0; kind < WORK_KINDS; kind++) clear(&queues[kind]);
  for (size_t k = 0; k < n; k++) enter(&queues[WORK_GUESS], wanted[k], 0);
  for (int kind; (kind = next_work(queues)) >= 0;) {
    uint32_t pairs[LANES];
    const size_t count = leave(&queues[kind], pairs);
    if (kind < WORK_TRIAL) guess(block, pairs, count, order, kind - WORK_GUESS, queues);
    else aim(block, pairs, count, order, queues);
  }
}

static void store(const block *block, const found_image *image, size_t at, const bent_connections *out,
                  bent_connection_count *count)
{
  const int none = image->status == BENT_CONNECTION_NONE, known = !none && image->status != BENT_CONNECTION_FAILED;
  const double area = block->request->sky ? 1 : block->mass * block->mass;
  size_t *const counters[] = {&count->none, &count->met, &count->ring, &count->coarse, &count->failed};
  ++*counters[image->status];
  if (out->status) out->status[at] = (uint8_t)image->status;
  if (out->spread) out->spread[at] = known ? image->spread * area : NAN;
  if (out->frequency_ratio) out->frequency_ratio[at] = known ? image->frequency_ratio : NAN;
  if (out->swept) out->swept[at] = none ? NAN : image->swept;
  if (out->error) out->error[at] = known ? image->error : NAN;
  for (int k = 0; k < 3; k++) {
    if (out->launch) out->launch[at][k] = known ? image->launch[k] : NAN;
    if (out->arrival) out->arrival[at][k] = known ? image->arrival[k] : NAN;
  }
}

void BENT_KERNEL(bent_connect_kerr)(const bent_spacetime *spacetime, size_t n, const double (*a)[3], const double (*b)[3],
                                    const connect_request *request, const bent_connections *out,
                                    bent_connection_count *count)
{
  const bent_spacetime unit = {.kind = BENT_KERR, .chart = BENT_CHART_OBLATE, .mass = 1,
                               .spin = spacetime->spin / spacetime->mass};
  block block; /* too large to be cleared each time */
  block.request = request, block.mass = spacetime->mass, block.space = arc_space_make(&unit);
  block.a = a, block.b = b;
  for (size_t order = 0; order < request->max_images; order++)
    for (size_t i = 0; i < n; i++) block.images[order][i].status = BENT_CONNECTION_NONE;
  uint32_t wanted[CONNECT_BLOCK];
  double sum[CONNECT_BLOCK] = {0};
  size_t open = n;
  for (size_t i = 0; i < n; i++) wanted[i] = (uint32_t)i;
  for (int order = 0; order < (int)request->max_images; order++) {
    find_images(&block, wanted, open, order);
    size_t kept = 0;
    for (size_t k = 0; k < open; k++) {
      found_image *image = &block.images[order][wanted[k]];
      const double share = image->status == BENT_CONNECTION_FAILED ? 0 : 1 / fmax(image->spread, 1e-300);
      if (image->status != BENT_CONNECTION_FAILED && share < request->min_share * sum[wanted[k]]) {
        image->status = BENT_CONNECTION_NONE;
        continue;
      }
      sum[wanted[k]] += share;
      wanted[kept++] = wanted[k];
    }
    open = kept;
    for (size_t i = 0; i < n; i++)
      store(&block, &block.images[order][i], i * request->max_images + (size_t)order, out, count);
  }
}
