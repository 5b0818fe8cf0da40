/* See join.h. */
#include "light/join.h"

#include <string.h>

#include "bentlight/connect.h"
#include "light/join_lens.h"

/* Wanted miss of a connection, in radii of its far end: what shading needs; and around a spinning hole, still less than what
 * shadow rays are traced to. */
static const double TOLERANCE = 1e-6, TOLERANCE_SPIN = 1e-5;
/* A traced ray that is farther from a connection, in swept angle or in direction, is another one: radians. */
static const double ANGLE_APART = 0.1;
/* Straight lines that pass a spinning hole at so many radii of its horizon or more are good estimates of rays. */
static const double PLAIN = 5;
/* The least chance with which images after the first are listed. */
static const double CHANCE_LEAST = 0.02;
enum { BLOCK = JOIN_BLOCK, IMAGES = JOIN_IMAGES };

/* The one lens that is all of space; NULL if there is none. */
static const lens *lone_lens(const geometry *g)
{
  for (size_t i = 0; i < g->lens_count; i++) {
    const lens *l = &g->lenses[i];
    if (!l->flat && isinf(l->radius)) return l;
  }
  return NULL;
}

int join_has_far_sky(const geometry *g)
{
  for (size_t i = 0; i < g->lens_count; i++)
    if (!g->lenses[i].flat && g->lenses[i].spacetime.kind == BENT_ELLIS && g->lenses[i].exit < 0) return 1;
  return 0;
}

static void join_straight(const geometry *g, vec3 from, vec3 to, int sky, double way_chance, joints *out)
{
  const vec3 way = sky ? to : v3_sub(to, from);
  const double length = v3_length(way);
  if (!(length > 0)) return;
  const vec3 direction = v3_scale(way, 1 / length);
  if (!join_is_clear(g, from, direction, sky ? INFINITY : length, -1)) return;
  const double spread = sky ? 1 : length * length;
  joints_add(out, &(joint){.launch = direction, .arrival = direction, .cone = v3_scale(direction, 1 / spread),
                           .spread = spread, .first_lens = -1, .chance = 1, .way_chance = way_chance});
}

/* ---- Chances ---- */

/* Images are listed by levels: just the first, two, or all, the later ones with less chance. */
enum { LEVELS = 3, LEVEL_ALL = LEVELS - 1 };
static const size_t LEVEL_IMAGES[LEVELS] = {1, 2, IMAGES};
/* Images after the second have about e^-2 pi = 1/535 of the light of the two before. */
static const double LEVEL_2_SHARE = 0.05;

/* The chance with which the second image is listed: about its share of the light, by the lens equation (share 1 / u^4 at u
 * Einstein radii), which far from the line through the center has some times too much rather than too little. Ends in the
 * chart. */
double join_second_chance(const lens *l, vec3 a, vec3 b, int sky)
{
  const vec3 way = sky ? v3_normalize(b) : v3_sub(b, a);
  const double length2 = v3_dot(way, way), along = max2(-v3_dot(a, way) / length2, 0);
  const double part = sky ? along : min2(along, 1);
  const vec3 closest = v3_mad(way, part, a);
  const double miss = v3_length(closest), near = v3_length(a), beyond = sky ? INFINITY : v3_length(b);
  const double reduced = near / (1 + near / beyond);
  const int throat = l->spacetime.kind == BENT_ELLIS;
  const double rho = l->spacetime.throat_radius;
  const double ring = throat ? cbrt(M_PI / 4 * rho * rho * reduced) : sqrt(4 * l->spacetime.mass * reduced);
  const double radii = miss / ring;
  return min2(max2(0.5 / (radii * radii * radii * radii), CHANCE_LEAST), 1);
}

/* With which a level or a later one is taken. */
static double chance_of_level(double second, int level)
{
  return level == 0 ? 1 : level == 1 ? second : level == 2 ? LEVEL_2_SHARE * second : 0;
}

double join_chance(double second, int order) { return chance_of_level(second, order < 2 ? order : 2); }

/* The level that the even number *u decides; *u is an even number again, for further decisions. */
static int take_level(double *u, double second)
{
  for (int level = LEVEL_ALL; level > 0; level--) {
    const double high = chance_of_level(second, level), low = chance_of_level(second, level + 1);
    if (*u < high) {
      *u = (*u - low) / (high - low);
      return level;
    }
  }
  *u = (*u - second) / (1 - second);
  return 0;
}

size_t join_images_wanted(double second, double *u) { return LEVEL_IMAGES[u ? take_level(u, second) : LEVEL_ALL]; }

/* ---- Both ends inside one lens ---- */

/* Pairs of a lens, in its chart. */
typedef struct inner {
  size_t count;
  size_t pair[BLOCK], images[BLOCK];
  double from[BLOCK][3], to[BLOCK][3], second[BLOCK], way_chance[BLOCK];
} inner;

static int spins(const lens *l) { return l->spacetime.kind == BENT_KERR && l->spacetime.spin != 0; }

int join_is_slow(const geometry *g)
{
  const lens *l = lone_lens(g);
  return l && spins(l);
}

/* joint.cone in the spacetime's axes. Surfaces stay at their places of the chart, past which the ZAMO of a spinning hole moves:
 * a ray that arrives along the unit vector n for it goes along n + v there, and covers 1 + n.v times the area. */
static vec3 cone_at(const lens *l, const double to[3], vec3 arrival, double spread)
{
  if (!spins(l)) return v3_scale(arrival, 1 / spread);
  const double out = v2_length(to[0], to[1]), speed = -bent_zamo_speed(&l->spacetime, to); /* against time */
  const vec3 v = out > 0 ? v3(-speed * to[1] / out, speed * to[0] / out, 0) : v3(0, 0, 0);
  return v3_scale(v3_add(arrival, v), 1 / (spread * (1 + v3_dot(arrival, v))));
}

/* The shortest distance from the center to the straight line between two places beside it, or from one to the sky. */
static double closest_approach(vec3 a, vec3 b, int sky)
{
  const vec3 way = sky ? v3_normalize(b) : v3_sub(b, a);
  const double along = max2(-v3_dot(a, way) / v3_dot(way, way), 0);
  return v3_length(v3_mad(way, sky ? along : min2(along, 1), a));
}

/* Whether the way is so far from a spinning hole that only the first image sweeps about the angle between its ends. */
static int is_plain(const lens *l, vec3 a, vec3 b, int sky)
{
  return closest_approach(a, b, sky) > PLAIN * bent_spacetime_core_radius(&l->spacetime) * l->scale;
}

/* Whether a traced ray, which swept `swept`, can only be the first image; never if it arrived in a far sky. */
static int is_first(const lens *l, vec3 from, vec3 to, int sky, int far, double swept)
{
  const vec3 a = v3_sub(from, l->center), b = sky ? to : v3_sub(to, l->center);
  const double angle = atan2(v3_length(v3_cross(a, b)), v3_dot(a, b));
  if (spins(l) && !is_plain(l, a, b, sky)) return 0; /* near the hole dragging confuses angles */
  return !far && fabs(swept - angle) < ANGLE_APART && angle < M_PI - 2 * ANGLE_APART;
}

/* Sets the estimate by which a joint around a spinning hole weighs if it is the first image. */
static void weigh_by_line(const lens *l, vec3 from, vec3 to, int sky, int far, joint *j)
{
  if (!spins(l) || !is_first(l, from, to, sky, far, j->swept)) return;
  const vec3 way = sky ? to : v3_sub(to, from);
  const double length2 = v3_dot(way, way);
  j->weigh_spread = sky ? 1 : length2;
  j->weigh_cone = v3_scale(way, 1 / (sqrt(length2) * j->weigh_spread));
}

/* Those that want just so many images. */
static void join_images(const geometry *g, const lens *l, const inner *in, size_t images, const vec3 *ends_from,
                        const vec3 *ends_to, int sky, int far, joints *out)
{
  enum { ENTRIES = BLOCK * IMAGES };
  uint8_t status[ENTRIES];
  double from[BLOCK][3], to[BLOCK][3], launch[ENTRIES][3], arrival[ENTRIES][3], spread[ENTRIES], swept[ENTRIES];
  size_t which[BLOCK], n = 0;
  for (size_t i = 0; i < in->count; i++) {
    if (in->images[i] != images) continue;
    for (int k = 0; k < 3; k++) from[n][k] = in->from[i][k], to[n][k] = in->to[i][k];
    which[n++] = i;
  }
  if (!n) return;
  const bent_connections results = {.status = status, .launch = launch, .arrival = arrival, .spread = spread,
                                    .swept = swept};
  const double(*a)[3] = (const double(*)[3])from, (*b)[3] = (const double(*)[3])to;
  bent_error ignored; /* all arguments have been checked */
  const double tolerance = spins(l) ? TOLERANCE_SPIN : TOLERANCE;
  const bent_status failed = sky ? bent_connect_sky(&l->spacetime, n, a, b, far, images, JOINT_SHARE_MIN, tolerance,
                                                    &results, NULL, NULL, &ignored)
                                 : bent_connect(&l->spacetime, n, a, b, images, JOINT_SHARE_MIN, tolerance, &results,
                                                NULL, NULL, &ignored);
  if (failed) return;
  for (size_t i = 0; i < n * images; i++) {
    const size_t k = which[i / images];
    out[in->pair[k]].wanted += status[i] != BENT_CONNECTION_NONE;
    out[in->pair[k]].lost += status[i] == BENT_CONNECTION_COARSE || status[i] == BENT_CONNECTION_FAILED;
    if (status[i] != BENT_CONNECTION_MET) continue; /* nor a ring: it has no light, its spread is 0 */
    const vec3 arrives = v3_from(arrival[i]), cone = sky ? arrives : cone_at(l, in->to[k], arrives, spread[i]);
    const double area = sky ? 1 : l->scale * l->scale, turned = 1 / l->scale; /* the matrix turns and scales */
    joint j = {.launch = v3_scale(mat4_vector(&l->world_from_spacetime, v3_from(launch[i])), turned),
               .arrival = v3_scale(mat4_vector(&l->world_from_spacetime, arrives), turned),
               .cone = v3_scale(mat4_vector(&l->world_from_spacetime, cone), turned / area),
               .spread = spread[i] * area, .swept = swept[i], .first_lens = (int)(l - g->lenses), .through = far,
               .chance = join_chance(in->second[k], (int)(i % images)), .way_chance = in->way_chance[k]};
    if (i % images == 0) weigh_by_line(l, ends_from[in->pair[k]], ends_to[in->pair[k]], sky, far, &j);
    joints_add(&out[in->pair[k]], &j);
  }
}

/* Arguments as in join_by. All pairs are inside a lens that is all of space. */
static void join_inside(const geometry *g, const lens *l, size_t n, const vec3 *from, const vec3 *to, double *u,
                        const double *const *chances, const joint_trace *traces, int sky, int far, joints *out)
{
  inner in;
  in.count = 0;
  for (size_t i = 0; i < n; i++) {
    if (!isinf(l->radius) && (sky || geometry_lens_at(g, from[i]) != l || geometry_lens_at(g, to[i]) != l)) continue;
    vec3 a = mat4_point(&l->spacetime_from_world, from[i]);
    vec3 b = sky ? mat4_transposed_vector(&l->world_from_spacetime, to[i]) : mat4_point(&l->spacetime_from_world, to[i]);
    if (far) b.y = -b.y; /* the far side's sky is drawn mirrored (jump.c) */
    const size_t k = in.count;
    v3_to(in.from[k], a), v3_to(in.to[k], b);
    if (!join_is_place(l, in.from[k]) || !(sky || join_is_place(l, in.to[k]))) continue;
    if (!join_tries(chances ? chances[i] : NULL, joint_way_by((int)(l - g->lenses), far), u ? &u[i] : NULL, &in.way_chance[k]))
      continue;
    const int first = traces && is_first(l, from[i], to[i], sky, far, traces[i].swept);
    if (first && spins(l)) { /* its weight is known */
      joint j = {.launch = traces[i].launch, .swept = traces[i].swept, .first_lens = traces[i].first_lens,
                 .borders = traces[i].borders, .chance = 1, .way_chance = in.way_chance[k]};
      weigh_by_line(l, from[i], to[i], sky, far, &j);
      j.spread = j.weigh_spread, j.cone = j.weigh_cone;
      joints_add(&out[i], &j);
      continue;
    }
    in.pair[k] = i, in.second[k] = join_second_chance(l, a, b, sky);
    in.images[k] = first ? 1 : join_images_wanted(in.second[k], u ? &u[i] : NULL);
    if (spins(l) && in.images[k] > 2) in.images[k] = 2; /* more are slow to find */
    in.count++;
  }
  for (int level = 0; level < LEVELS; level++) join_images(g, l, &in, LEVEL_IMAGES[level], from, to, sky, far, out);
}

/* ---- All ways ---- */

/* Joints of n <= BLOCK pairs by way of lens number `index`; -1: straight ones. Which images are listed is decided by the
 * numbers u, which are then fit for further decisions; all if u is NULL, or those that `traces` may be. */
static void join_by(const geometry *g, int index, size_t n, const vec3 *from, const vec3 *to, double *u,
                    const double *const *chances, const joint_trace *traces, int sky, int far, joints *out)
{
  if (index < 0) {
    double chance = 1;
    for (size_t i = 0; i < n && !far; i++)
      if (!chances || join_tries(chances[i], 0, &u[i], &chance)) join_straight(g, from[i], to[i], sky, chance, &out[i]);
    return;
  }
  const lens *l = &g->lenses[index];
  if (isinf(l->radius) ? l == lone_lens(g) : join_is_wide(l))
    join_inside(g, l, n, from, to, u, chances, traces, sky, far, out);
  join_by_lens(g, index, n, from, to, u, chances, sky, far, out);
}

static uint64_t bits_of(double x)
{
  uint64_t bits;
  memcpy(&bits, &x, sizeof bits);
  return bits;
}

void join_by_chance(const geometry *g, size_t n, const vec3 *from, const vec3 *to, const double *u,
                    const double *const *chances, int sky, int far, joints *out)
{
  for (size_t first = 0; first < n; first += BLOCK) {
    const size_t count = n - first < BLOCK ? n - first : BLOCK;
    double rest[BLOCK];
    for (size_t i = 0; i < count; i++) rest[i] = u[first + i], out[first + i] = joints_none(bits_of(u[first + i]));
    for (int k = -1; k < (int)g->lens_count; k++)
      join_by(g, k, count, from + first, to + first, rest, chances ? chances + first : NULL, NULL, sky, far,
              out + first);
    for (size_t i = 0; i < count; i++) out[first + i].rest = rest[i];
  }
}

void join_points(const geometry *g, size_t n, const vec3 *from, const vec3 *to, const double *u, joints *out)
{
  join_by_chance(g, n, from, to, u, NULL, 0, 0, out);
}

void join_sky(const geometry *g, size_t n, const vec3 *from, const vec3 *to, const double *u, int far, joints *out)
{
  join_by_chance(g, n, from, to, u, NULL, 1, far, out);
}

static const joint *find(const joints *joints, const joint_trace *trace)
{
  const joint *nearest = NULL;
  double distance = ANGLE_APART;
  for (int i = 0; i < joints->count; i++) {
    const joint *j = &joints->list[i];
    if (j->first_lens != trace->first_lens || j->borders != trace->borders) continue;
    const double off = v3_length(v3_sub(trace->launch, j->launch));
    if (fabs(trace->swept - j->swept) > ANGLE_APART || off > distance) continue;
    nearest = j, distance = off;
  }
  return nearest;
}

void join_traced(const geometry *g, size_t n, const vec3 *from, const vec3 *to, int sky, int far, const joint_trace *traces,
                 joint *out)
{
  for (size_t i = 0; i < n; i++) out[i] = (joint){.spread = 0};
  for (int k = -1; k < (int)g->lens_count; k++) {
    for (size_t next = 0; next < n;) {
      vec3 a[BLOCK], b[BLOCK];
      joint_trace traced[BLOCK];
      size_t pair[BLOCK], count = 0;
      for (; next < n && count < BLOCK; next++)
        if (traces[next].first_lens == k)
          a[count] = from[next], b[count] = to[next], traced[count] = traces[next], pair[count++] = next;
      joints found[BLOCK];
      for (size_t i = 0; i < count; i++) found[i] = joints_none(0);
      if (count) join_by(g, k, count, a, b, NULL, NULL, traced, sky, far, found);
      for (size_t i = 0; i < count; i++) {
        const joint *j = find(&found[i], &traced[i]);
        if (j) out[pair[i]] = *j;
      }
    }
  }
}

vec3 join_local_area(const geometry *g, vec3 position, vec3 area)
{
  const lens *l = geometry_lens_at(g, position);
  if (!l) return area;
  double at[3], m[3][3];
  v3_to(at, mat4_point(&l->spacetime_from_world, position));
  bent_local_from_covector(&l->spacetime, at, m);
  const double scale = bent_length_scale(&l->spacetime, at);
  const vec3 a = mat4_transposed_vector(&l->world_from_spacetime, area), row0 = v3_from(m[0]), row1 = v3_from(m[1]),
             row2 = v3_from(m[2]);
  const double determinant = v3_dot(row0, v3_cross(row1, row2));
  const vec3 local = v3(v3_dot(row0, a), v3_dot(row1, a), v3_dot(row2, a));
  return v3_scale(mat4_vector(&l->world_from_spacetime, local), scale * scale / (determinant * l->scale * l->scale));
}
