/* See join.h. */
#include "light/join.h"

#include "bentlight/connect.h"

/* Wanted miss of a connection, in radii of its far end: what shading needs. */
static const double TOLERANCE = 1e-6;
/* A traced ray that is farther from a connection, in swept angle or in direction, is another one: radians. */
static const double ANGLE_APART = 0.1;
/* The least chance with which images after the first are listed. */
static const double CHANCE_LEAST = 0.02;
enum { BLOCK = 64 };

/* The one lens that is all of space and has connections; NULL if there is none. *bent: whether there is any lens. */
static const lens *lone_lens(const geometry *g, int *bent)
{
  const lens *found = NULL;
  *bent = 0;
  for (size_t i = 0; i < g->lens_count; i++) {
    const lens *l = &g->lenses[i];
    if (l->flat) continue;
    *bent = 1;
    if (isinf(l->radius)) found = l;
  }
  return found;
}

int join_has_far_sky(const geometry *g)
{
  int bent;
  const lens *l = lone_lens(g, &bent);
  return l && l->spacetime.kind == BENT_ELLIS && l->exit < 0;
}

/* Whether a straight line from `from`, of `length` along the unit direction, stays outside all spheres. */
static int is_clear(const geometry *g, vec3 from, vec3 direction, double length)
{
  for (size_t i = 0; i < g->lens_count; i++) {
    const lens *l = &g->lenses[i];
    if (l->flat) continue;
    const vec3 to = v3_sub(l->center, from);
    const double along = min2(max2(v3_dot(to, direction), 0), length);
    if (v3_length(v3_mad(direction, -along, to)) <= l->radius * (1 + 1e-9)) return 0;
  }
  return 1;
}

static void join_straight(const geometry *g, vec3 from, vec3 to, double u, int sky, joints *out)
{
  const vec3 way = sky ? to : v3_sub(to, from);
  const double length = v3_length(way);
  *out = (joints){.straight = 1, .rest = u};
  if (!(length > 0)) return;
  const vec3 direction = v3_scale(way, 1 / length);
  if (!is_clear(g, from, direction, sky ? INFINITY : length)) return;
  const double spread = sky ? 1 : length * length;
  out->list[out->count++] = (joint){direction, direction, v3_scale(direction, 1 / spread), spread, 0, 1};
}

/* A place where rays go by: outside the horizon; in a wormhole without an exit, this side of the throat. */
static int is_place(const lens *l, const double at[3])
{
  const double core = bent_spacetime_core_radius(&l->spacetime);
  if (l->spacetime.kind == BENT_ELLIS && !(v3_length(v3_from(at)) > core)) return 0;
  return bent_spacetime_contains(&l->spacetime, at);
}

/* Images are listed by levels: just the first, two, or all, the later ones with less chance. */
enum { LEVELS = 3 };
static const size_t LEVEL_IMAGES[LEVELS] = {1, 2, JOINTS_MAX};
/* Images after the second have about e^-2 pi = 1/535 of the light of the two before. */
static const double LEVEL_2_SHARE = 0.05;

/* The chance with which the second image is listed: about its share of the light, by the lens equation (share 1 / u^4 at u
 * Einstein radii), which far from the line through the center has some times too much rather than too little. */
static double chance_of_second(const lens *l, const double from[3], const double to[3], int sky)
{
  const vec3 a = v3_from(from), way = sky ? v3_normalize(v3_from(to)) : v3_sub(v3_from(to), a);
  const double length2 = v3_dot(way, way), along = max2(-v3_dot(a, way) / length2, 0);
  const double part = sky ? along : min2(along, 1);
  const vec3 closest = v3_mad(way, part, a);
  const double miss = v3_length(closest), near = v3_length(a), beyond = sky ? INFINITY : v3_length(v3_from(to));
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

static int spins(const lens *l) { return l->spacetime.kind == BENT_KERR && l->spacetime.spin != 0; }

/* joint.cone in the spacetime's axes. Surfaces stay at their places of the chart, past which the ZAMO of a spinning hole moves:
 * a ray that arrives along the unit vector n for it goes along n + v there, and covers 1 + n.v times the area. */
static vec3 cone_at(const lens *l, const double to[3], vec3 arrival, double spread)
{
  if (!spins(l)) return v3_scale(arrival, 1 / spread);
  const double out = hypot(to[0], to[1]), speed = -bent_zamo_speed(&l->spacetime, to); /* against time */
  const vec3 v = out > 0 ? v3(-speed * to[1] / out, speed * to[0] / out, 0) : v3(0, 0, 0);
  return v3_scale(v3_add(arrival, v), 1 / (spread * (1 + v3_dot(arrival, v))));
}

/* Connections of at most BLOCK pairs that are good places; pair k goes to out[target[k]]. */
static void join_images(const lens *l, size_t n, const double (*from)[3], const double (*to)[3], const size_t *target,
                        int level, int sky, int far, joints *out)
{
  const size_t images = spins(l) && LEVEL_IMAGES[level] > 2 ? 2 : LEVEL_IMAGES[level]; /* more are slow to find */
  enum { ENTRIES = BLOCK * JOINTS_MAX };
  uint8_t status[ENTRIES];
  double launch[ENTRIES][3], arrival[ENTRIES][3], spread[ENTRIES], swept[ENTRIES];
  const bent_connections results = {.status = status, .launch = launch, .arrival = arrival, .spread = spread,
                                    .swept = swept};
  bent_error ignored; /* all arguments have been checked */
  const bent_status failed =
      sky ? bent_connect_sky(&l->spacetime, n, from, to, far, images, JOINT_SHARE_MIN, TOLERANCE, &results, NULL, NULL,
                             &ignored)
          : bent_connect(&l->spacetime, n, from, to, images, JOINT_SHARE_MIN, TOLERANCE, &results, NULL, NULL, &ignored);
  if (failed) return;
  for (size_t i = 0; i < n * images; i++) {
    if (status[i] != BENT_CONNECTION_MET && status[i] != BENT_CONNECTION_RING) continue;
    const size_t k = i / images;
    const int order = (int)(i % images);
    const double second = order ? chance_of_second(l, from[k], to[k], sky) : 1;
    joints *j = &out[target[k]];
    const vec3 arrives = v3_from(arrival[i]), cone = sky ? arrives : cone_at(l, to[k], arrives, spread[i]);
    const double area = sky ? 1 : l->scale * l->scale, turned = 1 / l->scale; /* the matrix turns and scales */
    j->list[j->count++] = (joint){v3_scale(mat4_vector(&l->world_from_spacetime, v3_from(launch[i])), turned),
                                  v3_scale(mat4_vector(&l->world_from_spacetime, arrives), turned),
                                  v3_scale(mat4_vector(&l->world_from_spacetime, cone), turned / area),
                                  spread[i] * area, swept[i], chance_of_level(second, order < 2 ? order : 2)};
  }
}

/* Those of a block of pairs in a lone lens whose images are listed up to a level. */
static void join_level(const lens *l, size_t n, const vec3 *from, const vec3 *to, const double *u, int sky, int far,
                       int level, joints *out)
{
  double a[BLOCK][3], b[BLOCK][3];
  size_t target[BLOCK], count = 0;
  for (size_t i = 0; i < n; i++) {
    v3_to(a[count], mat4_point(&l->spacetime_from_world, from[i]));
    v3_to(b[count], sky ? mat4_transposed_vector(&l->world_from_spacetime, to[i])
                        : mat4_point(&l->spacetime_from_world, to[i]));
    if (far) b[count][1] = -b[count][1]; /* the far side's sky is drawn mirrored (jump.c) */
    if (!is_place(l, a[count]) || !(sky || is_place(l, b[count]))) continue;
    const double second = chance_of_second(l, a[count], b[count], sky);
    const double high = chance_of_level(second, level), low = chance_of_level(second, level + 1);
    if (!(u[i] >= low && u[i] < high)) continue;
    out[i].rest = (u[i] - low) / (high - low);
    target[count++] = i;
  }
  if (count) join_images(l, count, (const double(*)[3])a, (const double(*)[3])b, target, level, sky, far, out);
}

static void join_all(const geometry *g, size_t n, const vec3 *from, const vec3 *to, const double *u, int sky, int far,
                     joints *out)
{
  int bent;
  const lens *l = lone_lens(g, &bent);
  for (size_t i = 0; i < n && !l; i++) join_straight(g, from[i], to[i], u[i], sky, &out[i]);
  for (size_t first = 0; first < n && l; first += BLOCK) {
    const size_t count = n - first < BLOCK ? n - first : BLOCK;
    for (size_t i = first; i < first + count; i++) out[i].count = out[i].straight = 0;
    for (int level = 0; level < LEVELS; level++)
      join_level(l, count, from + first, to + first, u + first, sky, far, level, out + first);
  }
}

void join_points(const geometry *g, size_t n, const vec3 *from, const vec3 *to, const double *u, joints *out)
{
  join_all(g, n, from, to, u, 0, 0, out);
}

void join_sky(const geometry *g, size_t n, const vec3 *from, const vec3 *to, const double *u, int far, joints *out)
{
  join_all(g, n, from, to, u, 1, far, out);
}

int join_is_first(const geometry *g, vec3 from, vec3 to, int sky, double swept)
{
  int bent;
  const lens *l = lone_lens(g, &bent);
  if (!l) return 1;
  const vec3 a = v3_sub(from, l->center), b = sky ? to : v3_sub(to, l->center);
  const double angle = atan2(v3_length(v3_cross(a, b)), v3_dot(a, b));
  if (spins(l)) { /* near the hole dragging confuses angles */
    const double far = 3 * bent_spacetime_core_radius(&l->spacetime) * l->scale;
    if (angle > M_PI / 2 || v3_length(a) < far || !(sky || v3_length(b) > far)) return 0;
  }
  return fabs(swept - angle) < ANGLE_APART && angle < M_PI - 2 * ANGLE_APART;
}

const joint *joints_find(const joints *joints, vec3 direction, double swept)
{
  const joint *nearest = NULL;
  double distance = ANGLE_APART;
  for (int i = 0; i < joints->count; i++) {
    const joint *j = &joints->list[i];
    const double off = v3_length(v3_sub(direction, j->launch));
    if (fabs(swept - j->swept) > (joints->straight ? 0 : ANGLE_APART) || off > distance) continue;
    nearest = j, distance = off;
  }
  return nearest;
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
