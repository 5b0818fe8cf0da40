/* Connections around a spinning hole: for every image of a pair a first guess, then the aim. Images that fail are guessed
 * again by other rules. Searches that need the same work do it side by side in the lanes. Where a trial is over, another one
 * takes its lane; where all images of a pair are known, another pair takes its place. */
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

/* Pairs under way at a time: enough to fill the lanes with searches that need the same, few enough to stay in the cache. */
enum { POOL = 128 };

/* A pair under way: the image that is looked for, and those before. */
typedef struct search {
  uint32_t pair;
  int order, attempt;
  double sum; /* of 1 / spread of the images before */
  found_image images[BENT_CONNECT_IMAGES_MAX]; /* lengths over M */
} search;

/* What a search may wait for: a guess at an image by a rule, a lane to fly in, to be judged. */
enum { WORK_LANE = BENT_CONNECT_IMAGES_MAX * GUESS_ATTEMPTS, WORK_JUDGE, WORK_KINDS };
/* Further work: trials fly on; nothing is left. */
enum { WORK_FLY = WORK_KINDS, WORK_NONE };

/* Searches that wait, first come, first served. */
typedef struct queues {
  int guesses, count[WORK_KINDS];
  uint32_t first[WORK_KINDS], last[WORK_KINDS], next[POOL]; /* searches: of each kind, and after each */
} queues;

/* Trials on their way. */
typedef struct air {
  aim_flight flight;
  uint32_t searches[LANES];
  int busy, taken[LANES];
} air;

typedef struct pool {
  const connect_request *request;
  double mass;
  arc_space space; /* of the hole of mass 1 */
  const double (*a)[3], (*b)[3];
  const bent_connections *out;
  bent_connection_count *count;
  search searches[POOL];
  aim_record aims[POOL]; /* of the searches */
  queues waiting;
  air air;
} pool;

static void enter(queues *q, uint32_t search, int kind)
{
  if (q->count[kind]++ > 0) q->next[q->last[kind]] = search;
  else q->first[kind] = search;
  q->last[kind] = search;
  q->guesses += kind < WORK_LANE;
}

static void enter_guess(pool *pool, uint32_t search)
{
  enter(&pool->waiting, search, pool->searches[search].order * GUESS_ATTEMPTS + pool->searches[search].attempt);
}

static uint32_t leave(queues *q, int kind)
{
  const uint32_t search = q->first[kind];
  q->first[kind] = q->next[search];
  q->count[kind]--, q->guesses -= kind < WORK_LANE;
  return search;
}

/* A guess that at least `least` searches wait for; WORK_LANE if there is none. */
static int find_guess(const queues *q, int least)
{
  int kind = q->guesses < least ? WORK_LANE : 0;
  while (kind < WORK_LANE && q->count[kind] < least) kind++;
  return kind;
}

/* The work to do next, where no trial waits for a free lane: what fills the lanes; otherwise what takes least and may lead
 * to more. */
static int next_work(const pool *pool)
{
  const queues *q = &pool->waiting;
  if (pool->air.busy == LANES) return WORK_FLY;
  if (q->count[WORK_JUDGE] >= LANES) return WORK_JUDGE;
  const int guess = find_guess(q, LANES);
  if (guess < WORK_LANE) return guess;
  if (q->count[WORK_JUDGE]) return WORK_JUDGE;
  if (pool->air.busy) return WORK_FLY;
  return q->guesses ? find_guess(q, 1) : WORK_NONE;
}

LANES_INLINE flow_place place_of(const pool *pool, const double (*points)[3], const uint32_t *pairs, size_t n, int sky)
{
  lanes x[3];
  flow_place place;
  lanes_load_rows(points, pairs, 0, n, x);
  if (sky) {
    const lanes length = lanes_sqrt(lanes_dot(x, x));
    for (int k = 0; k < 3; k++) place.n[k] = x[k] / length;
    place.w = lanes_all(0), place.above = lanes_all(1);
    return place;
  }
  kerr_place at;
  for (int k = 0; k < 3; k++) x[k] /= pool->mass;
  place.w = kerr_place_at(&pool->space, x, &at);
  place.above = 1 / place.w - pool->space.outer;
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

/* What the aimed rays of lanes that are done are; lane i belongs to searches[i]. */
static void report(pool *pool, const aim_task *t, const aim_shot *shot, const aim_result *result, const uint32_t *searches)
{
  const flow_hole hole = flow_hole_of(t->spin);
  const flow_ray *ray = &shot->ray;
  const int sky = pool->request->sky;
  const lanes E = ray->energy.value, width = sky ? lanes_all(1) : t->b.w * t->b.w;
  lanes launch[3], components[3], arrival[3], local = E;
  scene_direction(&hole, &t->a, t->trial.d, launch);
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
    const int good = result->error[i] <= pool->request->tolerance;
    const bent_connection_status met = good ? ring[i] ? BENT_CONNECTION_RING : BENT_CONNECTION_MET : BENT_CONNECTION_COARSE;
    search *search = &pool->searches[searches[i]];
    found_image *image = &search->images[search->order];
    *image = (found_image){.status = sound[i] ? met : BENT_CONNECTION_FAILED, .spread = spread[i],
                           .frequency_ratio = 1 / local[i], .swept = sound[i] ? ray->swept[i] : t->swept[i],
                           .error = result->error[i]};
    for (int k = 0; k < 3; k++) image->launch[k] = launch[k][i], image->arrival[k] = arrival[k][i];
  }
}

/* A search, lane `lane` of t, whose next trial is launched. */
static void wait_for_lane(pool *pool, const aim_task *t, const aim_flight *flight, int lane, uint32_t search)
{
  aim_save(t, AIM_WORDS, lane, pool->aims[search].task);
  aim_save(flight, AIM_FLIGHT_WORDS, lane, pool->aims[search].flight);
  enter(&pool->waiting, search, WORK_LANE);
}

/* Guesses for n <= LANES searches for images of the same order, by the same rule. */
static void guess(pool *pool, const uint32_t *searches, size_t n)
{
  const search *any = &pool->searches[searches[0]];
  uint32_t pairs[LANES];
  for (size_t i = 0; i < n; i++) pairs[i] = pool->searches[searches[i]].pair;
  aim_task t;
  memset(&t, 0, sizeof t);
  t.a = place_of(pool, pool->a, pairs, n, 0);
  t.b = place_of(pool, pool->b, pairs, n, pool->request->sky);
  t.sky = (lanes)lanes_mask_all(pool->request->sky);
  t.spin = lanes_all(pool->space.spin);
  guess_first(any->order, &GUESS_RULES[any->attempt], &t);
  aim_flight flight;
  aim_launch(&t, &flight);
  for (size_t i = 0; i < n; i++) wait_for_lane(pool, &t, &flight, (int)i, searches[i]);
}

/* Whether the last image is an earlier one once more. */
static int is_known(const search *search)
{
  const found_image *image = &search->images[search->order];
  if (image->status == BENT_CONNECTION_RING) return 0;
  for (const found_image *other = search->images; other < image; other++) {
    double apart = 0;
    for (int i = 0; i < 3; i++) apart = fmax(apart, fabs(image->launch[i] - other->launch[i]));
    if (other->status != BENT_CONNECTION_FAILED && apart < SAME && fabs(image->swept - other->swept) < 1) return 1;
  }
  return 0;
}

static void store(const pool *pool, const found_image *image, size_t at)
{
  const bent_connections *out = pool->out;
  bent_connection_count *count = pool->count;
  const int none = image->status == BENT_CONNECTION_NONE, known = !none && image->status != BENT_CONNECTION_FAILED;
  const double area = pool->request->sky ? 1 : pool->mass * pool->mass;
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

static void store_all(const pool *pool, const search *search)
{
  const size_t images = pool->request->max_images;
  for (size_t k = 0; k < images; k++) store(pool, &search->images[k], search->pair * images + k);
}

/* Takes up a pair, by search `at` of the pool. */
static void start(pool *pool, uint32_t at, uint32_t pair)
{
  search *search = &pool->searches[at];
  search->pair = pair, search->order = search->attempt = 0, search->sum = 0;
  for (size_t k = 0; k < pool->request->max_images; k++) search->images[k].status = BENT_CONNECTION_NONE;
  enter_guess(pool, at);
}

/* An aim has ended. An image that was not found is looked for again, by the next rule, if there is one; then the next
 * image, unless the last was too faint. Returns whether there is none. */
static int conclude(pool *pool, uint32_t at)
{
  search *search = &pool->searches[at];
  found_image *image = &search->images[search->order];
  if (is_known(search)) image->status = BENT_CONNECTION_FAILED;
  const int failed = image->status == BENT_CONNECTION_FAILED;
  const int attempts = search->order < 2 ? GUESS_ATTEMPTS : GUESS_ATTEMPTS_FAINT;
  const double share = failed ? 0 : 1 / fmax(image->spread, 1e-300);
  const int again = failed && ++search->attempt < attempts;
  const int faint = !failed && share < pool->request->min_share * search->sum;
  if (faint) image->status = BENT_CONNECTION_NONE;
  if (!again) search->sum += share, search->attempt = 0, search->order++;
  if (faint || search->order == (int)pool->request->max_images) return 1;
  enter_guess(pool, at);
  return 0;
}

/* Judges the trials of n <= LANES searches; those whose pairs are done come to the front. Returns how many. */
static size_t judge(pool *pool, uint32_t searches[LANES], size_t n)
{
  aim_task t;
  aim_flight flight;
  aim_shot shot;
  const double *tasks[LANES], *flights[LANES];
  for (size_t i = 0; i < LANES; i++) { /* idle lanes hold valid numbers */
    const aim_record *from = &pool->aims[searches[i < n ? i : 0]];
    tasks[i] = from->task, flights[i] = from->flight;
  }
  aim_load_all(&t, AIM_WORDS, tasks), aim_load_all(&flight, AIM_FLIGHT_WORDS, flights);
  const lanes_mask busy = lanes_mask_from_bits((1u << n) - 1);
  const aim_result result = aim_judge(&t, &flight, pool->request->tolerance, busy, &shot);
  const lanes_mask ended = result.found | result.lost;
  if (lanes_any(ended)) report(pool, &t, &shot, &result, searches);
  aim_launch(&t, &flight);
  size_t done = 0;
  for (size_t i = 0; i < n; i++) {
    const uint32_t search = searches[i];
    if (!ended[i]) wait_for_lane(pool, &t, &flight, (int)i, search);
    else if (conclude(pool, search)) searches[done++] = search;
  }
  return done;
}

/* Trials that wait take the free lanes. */
static void board(pool *pool)
{
  air *air = &pool->air;
  for (int i = 0; i < LANES && pool->waiting.count[WORK_LANE]; i++) {
    if (air->taken[i]) continue;
    const uint32_t search = leave(&pool->waiting, WORK_LANE);
    aim_load(&air->flight, AIM_FLIGHT_WORDS, i, pool->aims[search].flight);
    air->searches[i] = search, air->taken[i] = 1, air->busy++;
  }
}

/* A step of all trials on their way. */
static void fly(pool *pool)
{
  air *air = &pool->air;
  aim_fly(&air->flight, FLOW_TURNS);
  for (int i = 0; i < LANES; i++) {
    if (!air->taken[i] || air->flight.open[i]) continue;
    aim_save(&air->flight, AIM_FLIGHT_WORDS, i, pool->aims[air->searches[i]].flight);
    enter(&pool->waiting, air->searches[i], WORK_JUDGE);
    air->taken[i] = 0, air->busy--;
  }
}

void BENT_KERNEL(bent_connect_kerr)(const bent_spacetime *spacetime, size_t n, const double (*a)[3], const double (*b)[3],
                                    const connect_request *request, const bent_connections *out,
                                    bent_connection_count *count)
{
  const bent_spacetime unit = {.kind = BENT_KERR, .chart = BENT_CHART_OBLATE, .mass = 1,
                               .spin = spacetime->spin / spacetime->mass};
  pool pool; /* too large to be cleared each time */
  pool.request = request, pool.mass = spacetime->mass, pool.space = arc_space_make(&unit);
  pool.a = a, pool.b = b, pool.out = out, pool.count = count;
  memset(&pool.waiting, 0, sizeof pool.waiting), memset(&pool.air, 0, sizeof pool.air);
  uint32_t pairs = 0; /* that have been taken up */
  for (; pairs < n && pairs < POOL; pairs++) start(&pool, pairs, pairs);
  for (int kind;;) {
    board(&pool);
    if ((kind = next_work(&pool)) == WORK_NONE) return;
    if (kind == WORK_FLY) {
      fly(&pool);
      continue;
    }
    uint32_t searches[LANES];
    size_t present = 0;
    while (present < LANES && pool.waiting.count[kind]) searches[present++] = leave(&pool.waiting, kind);
    if (kind < WORK_LANE) {
      guess(&pool, searches, present);
      continue;
    }
    const size_t done = judge(&pool, searches, present);
    for (size_t i = 0; i < done; i++) {
      store_all(&pool, &pool.searches[searches[i]]);
      if (pairs < n) start(&pool, searches[i], pairs++);
    }
  }
}
