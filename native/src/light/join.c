/* See join.h. */
#include "light/join.h"

#include "bentlight/connect.h"

/* Wanted miss of a connection, in radii of its far end: what shading needs. */
static const double TOLERANCE = 1e-6;
/* A traced ray that is farther from a connection, in swept angle or in direction, is another one: radians. */
static const double ANGLE_APART = 0.1;
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
    if (isinf(l->radius) && !(l->spacetime.kind == BENT_KERR && l->spacetime.spin != 0)) found = l;
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

static void join_straight(const geometry *g, vec3 from, vec3 to, int sky, joints *out)
{
  const vec3 way = sky ? to : v3_sub(to, from);
  const double length = v3_length(way);
  *out = (joints){.straight = 1};
  if (!(length > 0)) return;
  const vec3 direction = v3_scale(way, 1 / length);
  if (!is_clear(g, from, direction, sky ? INFINITY : length)) return;
  out->list[out->count++] = (joint){direction, direction, sky ? 1 : length * length, 0};
}

/* A place where rays go by: outside the horizon; in a wormhole without an exit, this side of the throat. */
static int is_place(const lens *l, const double at[3])
{
  const double core = bent_spacetime_core_radius(&l->spacetime);
  if (l->spacetime.kind == BENT_ELLIS && !(v3_length(v3_from(at)) > core)) return 0;
  return bent_spacetime_contains(&l->spacetime, at);
}

/* Connections of at most BLOCK pairs that are good places; pair k goes to out[target[k]]. */
static void join_images(const lens *l, size_t n, const double (*from)[3], const double (*to)[3], const size_t *target,
                        int sky, int far, joints *out)
{
  enum { ENTRIES = BLOCK * JOINTS_MAX };
  uint8_t status[ENTRIES];
  double launch[ENTRIES][3], arrival[ENTRIES][3], spread[ENTRIES], swept[ENTRIES];
  const bent_connections results = {.status = status, .launch = launch, .arrival = arrival, .spread = spread,
                                    .swept = swept};
  bent_error ignored; /* all arguments have been checked */
  const bent_status failed =
      sky ? bent_connect_sky(&l->spacetime, n, from, to, far, JOINTS_MAX, JOINT_SHARE_MIN, TOLERANCE, &results, NULL, NULL,
                             &ignored)
          : bent_connect(&l->spacetime, n, from, to, JOINTS_MAX, JOINT_SHARE_MIN, TOLERANCE, &results, NULL, NULL,
                         &ignored);
  if (failed) return;
  for (size_t i = 0; i < n * JOINTS_MAX; i++) {
    if (status[i] != BENT_CONNECTION_MET && status[i] != BENT_CONNECTION_RING) continue;
    joints *j = &out[target[i / JOINTS_MAX]];
    j->list[j->count++] = (joint){v3_normalize(mat4_vector(&l->world_from_spacetime, v3_from(launch[i]))),
                                  v3_normalize(mat4_vector(&l->world_from_spacetime, v3_from(arrival[i]))),
                                  sky ? spread[i] : spread[i] * l->scale * l->scale, swept[i]};
  }
}

static void join_all(const geometry *g, size_t n, const vec3 *from, const vec3 *to, int sky, int far, joints *out)
{
  int bent;
  const lens *l = lone_lens(g, &bent);
  if (!l) {
    for (size_t i = 0; i < n; i++) join_straight(g, from[i], to[i], sky, &out[i]);
    return;
  }
  for (size_t first = 0; first < n; first += BLOCK) {
    double a[BLOCK][3], b[BLOCK][3];
    size_t target[BLOCK], count = 0;
    for (size_t i = first; i < n && i < first + BLOCK; i++) {
      out[i].count = out[i].straight = 0;
      v3_to(a[count], mat4_point(&l->spacetime_from_world, from[i]));
      v3_to(b[count], sky ? mat4_transposed_vector(&l->world_from_spacetime, to[i])
                          : mat4_point(&l->spacetime_from_world, to[i]));
      if (far) b[count][1] = -b[count][1]; /* the far side's sky is drawn mirrored (jump.c) */
      if (is_place(l, a[count]) && (sky || is_place(l, b[count]))) target[count++] = i;
    }
    if (count) join_images(l, count, (const double(*)[3])a, (const double(*)[3])b, target, sky, far, out);
  }
}

void join_points(const geometry *g, size_t n, const vec3 *from, const vec3 *to, joints *out)
{
  join_all(g, n, from, to, 0, 0, out);
}

void join_sky(const geometry *g, size_t n, const vec3 *from, const vec3 *to, int far, joints *out)
{
  join_all(g, n, from, to, 1, far, out);
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
