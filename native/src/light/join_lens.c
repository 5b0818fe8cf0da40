/* See join_lens.h. Each pair becomes a problem in the plane of its ends and the center (spacetime/passage.h), and each
 * solution a joint, if its straight pieces meet no other lens. */
#include "light/join_lens.h"

#include "spacetime/passage.h"

enum { BLOCK = JOIN_BLOCK, IMAGES = JOIN_IMAGES };
/* The chance of second images through a throat, which are faint or not. */
static const double SECOND_THROUGH = 0.25;
/* Spheres closer to the photon sphere than this are left to scattering: rays inside turn back there. */
static const double RIM_MIN = 3.1; /* areal radius, M */
/* Ends whose directions from the center differ by less, or are that nearly opposite, are in line. */
static const double IN_LINE = 1e-15;

/* One end of a pair, in the axes of the spacetime on its side; through a throat in those that go on from the other. */
typedef struct place {
  double radius; /* chart units of the lens that they pass; INFINITY in the sky */
  vec3 outward;
} place;

/* Pairs of one kind, to be solved side by side. */
typedef struct group {
  passage_kind kind;
  int reversed; /* solved from b to a */
  int index;    /* the lens */
  int side_b;   /* the lens on b's side; -1: a far sky */
  size_t count;
  size_t pair[BLOCK], images[BLOCK];
  double second[BLOCK]; /* chance, as in join_images_wanted */
  double way_chance[BLOCK];
  place a[BLOCK], b[BLOCK];
} group;

/* Even in [0, 1): SplitMix64 (Steele, Lea & Flood 2014). */
static double roll(uint64_t *dice)
{
  uint64_t z = *dice += 0x9e3779b97f4a7c15u;
  z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
  z = (z ^ z >> 27) * 0x94d049bb133111ebu;
  return (double)((z ^ z >> 31) >> 11) * 0x1p-53;
}

/* What a joint counts: the light that it stands for, but for its ends. */
static double brightness(const joint *j) { return 1 / (j->spread * j->way_chance); }

/* Of the two faintest of a full list and `extra` one goes; *extra becomes the other, the rest stays in the list. */
static void make_room(joints *joints, joint *extra)
{
  joint all[JOINTS_MAX + 1];
  for (int i = 0; i <= JOINTS_MAX; i++) all[i] = i < JOINTS_MAX ? joints->list[i] : *extra;
  for (int last = JOINTS_MAX; last > JOINTS_MAX - 2; last--) /* the two faintest to the end */
    for (int i = 0; i < last; i++)
      if (brightness(&all[i]) < brightness(&all[last])) {
        const joint fainter = all[i];
        all[i] = all[last], all[last] = fainter;
      }
  const double a = brightness(&all[JOINTS_MAX - 1]), chance = a / (a + brightness(&all[JOINTS_MAX]));
  const int kept = roll(&joints->dice) < chance;
  for (int i = 0; i < JOINTS_MAX - 1; i++) joints->list[i] = all[i];
  joints->count = JOINTS_MAX - 1;
  *extra = all[kept ? JOINTS_MAX - 1 : JOINTS_MAX];
  extra->way_chance *= kept ? chance : 1 - chance;
}

void joints_add(joints *joints, const joint *j)
{
  joint added = *j;
  if (!(added.weigh_spread > 0)) added.weigh_spread = j->spread, added.weigh_cone = j->cone;
  if (joints->count == JOINTS_MAX) make_room(joints, &added);
  joints->list[joints->count++] = added;
}

int join_is_clear(const geometry *g, vec3 from, vec3 direction, double length, int except)
{
  for (int i = 0; i < (int)g->lens_count; i++) {
    const lens *l = &g->lenses[i];
    if (l->flat || i == except) continue;
    const vec3 to = v3_sub(l->center, from);
    const double along = min2(max2(v3_dot(to, direction), 0), length);
    if (v3_length(v3_mad(direction, -along, to)) <= l->radius * (1 + 1e-9)) return 0;
  }
  return 1;
}

int join_is_place(const lens *l, const double at[3])
{
  const double core = bent_spacetime_core_radius(&l->spacetime);
  if (l->spacetime.kind == BENT_ELLIS && !(v3_length(v3_from(at)) > core)) return 0;
  return bent_spacetime_contains(&l->spacetime, at);
}

/* World units of a chart unit of lens `l` on the side of lens `side`: the mouths' throats are the same in both. */
static double unit_of(const lens *l, const lens *side)
{
  if (side == l) return l->scale;
  return side->scale * (side->spacetime.throat_radius / l->spacetime.throat_radius);
}

static double rim_of(const lens *l, const lens *side) { return side->radius / unit_of(l, side); }

int join_is_wide(const lens *l)
{
  const bent_spacetime *s = &l->spacetime;
  if (l->flat || isinf(l->radius) || (s->kind == BENT_KERR && s->spin != 0)) return 0;
  if (s->kind == BENT_ELLIS) return 1;
  const double r = rim_of(l, l), half = s->chart == BENT_CHART_ISOTROPIC ? 0.5 * s->mass / r : 0;
  return r * (1 + half) * (1 + half) >= RIM_MIN * s->mass;
}

/* ---- Ends ---- */

/* mirrored: the side beyond the throat is drawn so (geometry/travel.h). */
static place place_of(const lens *l, const lens *side, vec3 at, int sky, int mirrored)
{
  vec3 x = sky ? mat4_transposed_vector(&side->world_from_spacetime, at) : mat4_point(&side->spacetime_from_world, at);
  if (mirrored) x.y = -x.y;
  return (place){sky ? INFINITY : v3_length(v3_sub(at, side->center)) / unit_of(l, side), v3_normalize(x)};
}

static int is_usable(const lens *l, vec3 at)
{
  double x[3];
  v3_to(x, mat4_point(&l->spacetime_from_world, at));
  return join_is_place(l, x);
}

/* The plane of two ends: the angle between them and the directions in which the short way turns. */
typedef struct plane {
  double angle;
  vec3 toward_a, toward_b;
} plane;

static plane plane_of(vec3 a, vec3 b)
{
  vec3 axis = v3_cross(a, b), unused;
  const double sine = v3_length(axis), cosine = v3_dot(a, b);
  plane p = {.angle = atan2(sine, cosine)};
  if (sine <= IN_LINE) { /* they share every plane */
    v3_basis(a, &axis, &unused);
    p.angle = cosine > 0 ? 0 : M_PI;
  }
  p.toward_a = v3_normalize(v3_cross(axis, a));
  axis = v3_normalize(v3_cross(a, p.toward_a)); /* again: the first one of nearly parallel vectors is askew */
  p.toward_b = v3_normalize(v3_cross(axis, b));
  return p;
}

/* ---- Joints ---- */

/* A direction of a passage in the world. */
static vec3 direction_of(const lens *l, vec3 outward, vec3 toward, double turn, passage_direction d, int mirrored)
{
  vec3 x = v3_mad(toward, turn * d.sine, v3_scale(outward, d.cosine));
  if (mirrored) x.y = -x.y;
  return v3_normalize(mat4_vector(&l->world_from_spacetime, x));
}

/* Whether the straight piece from a place outside a lens to its sphere meets no other. */
static int is_piece_clear(const geometry *g, vec3 from, vec3 direction, int index)
{
  const lens *l = &g->lenses[index];
  const vec3 to = v3_sub(l->center, from);
  const double along = v3_dot(to, direction), half2 = l->radius * l->radius - v3_dot(to, to) + along * along;
  return join_is_clear(g, from, direction, along - sqrt(max2(half2, 0)), index);
}

/* The same for the piece from the sphere to the sky: `toward` as in plane, `sine` of the angle at which the ray leaves. */
static int is_sky_clear(const geometry *g, const lens *l, vec3 outward, vec3 toward, double turn, double sine,
                        int mirrored, vec3 direction)
{
  const double cosine = sqrt(max2(1 - sine * sine, 0));
  const vec3 n = direction_of(l, outward, toward, turn, (passage_direction){cosine, -sine}, mirrored);
  return join_is_clear(g, v3_mad(n, l->radius, l->center), direction, INFINITY, (int)(l - g->lenses));
}

/* Image k of pair i as a joint; returns 0 if other lenses are in its way. */
static int joint_of(const geometry *g, const group *q, size_t i, const plane *p, int k, const passage *found, vec3 from,
                    vec3 to, int sky, joint *out)
{
  const int through = q->kind == PASSAGE_THROUGH, far = q->side_b < 0;
  const lens *a = &g->lenses[q->index], *b = far ? a : &g->lenses[q->side_b];
  const double turn = k % 2 ? -1 : 1;
  vec3 launch = direction_of(a, q->a[i].outward, p->toward_a, turn, found->launch, 0);
  vec3 arrival = direction_of(b, q->b[i].outward, p->toward_b, turn, found->arrival, through);
  if (q->reversed) {
    const vec3 back = v3_scale(launch, -1);
    launch = v3_scale(arrival, -1), arrival = back;
  }
  const int a_outside = q->a[i].radius >= rim_of(a, a), b_outside = !far && q->b[i].radius >= rim_of(a, b);
  const int first_outside = q->reversed ? b_outside : a_outside, last_outside = q->reversed ? a_outside : b_outside;
  if (first_outside && !is_piece_clear(g, from, launch, q->reversed ? q->side_b : q->index)) return 0;
  if (last_outside && !sky && !is_piece_clear(g, to, v3_scale(arrival, -1), q->reversed ? q->index : q->side_b)) return 0;
  if (last_outside && sky &&
      !is_sky_clear(g, b, q->b[i].outward, p->toward_b, turn, found->rim_sine, through, arrival))
    return 0;
  const double unit = sky ? 1 : unit_of(a, b);
  const double spread = (q->reversed ? found->spread_back : found->spread) * unit * unit;
  *out = (joint){.launch = launch, .arrival = arrival, .cone = v3_scale(arrival, 1 / spread), .swept = found->inside, .first_lens = q->index,
                 .spread = spread,
                 .through = through,
                 .borders = (uint32_t)(a_outside + b_outside + (through && !far)),
                 .chance = join_chance(q->second[i], k), .way_chance = q->way_chance[i]};
  return 1;
}

static void solve(const geometry *g, const group *q, const vec3 *from, const vec3 *to, int sky, joints *out)
{
  if (!q->count) return;
  double radius_a[BLOCK], radius_b[BLOCK], angle[BLOCK];
  plane planes[BLOCK];
  passage found[BLOCK * IMAGES];
  for (size_t i = 0; i < q->count; i++) {
    planes[i] = plane_of(q->a[i].outward, q->b[i].outward);
    radius_a[i] = q->a[i].radius, radius_b[i] = q->b[i].radius, angle[i] = planes[i].angle;
  }
  const lens *a = &g->lenses[q->index];
  const passage_request request = {.spacetime = &a->spacetime, .kind = q->kind, .rim_a = rim_of(a, a),
                                   .rim_b = q->side_b < 0 ? INFINITY : rim_of(a, &g->lenses[q->side_b]), .images = IMAGES,
                                   .min_share = JOINT_SHARE_MIN};
  BENT_CALL(bent_passages)(&request, q->count, q->images, radius_a, radius_b, angle, found);
  for (size_t i = 0; i < q->count; i++)
    for (int k = 0; k < IMAGES; k++) {
      const passage *f = &found[i * IMAGES + (size_t)k];
      const size_t pair = q->pair[i];
      joint j;
      /* ends in line are joined by a ring, which has no light: spread 0 */
      if (f->found && f->spread > 0 && joint_of(g, q, i, &planes[i], k, f, from[pair], to[pair], sky, &j))
        joints_add(&out[pair], &j);
    }
}

/* ---- Groups ---- */

enum { ACROSS, OUT, IN, THROUGH, GROUPS };

/* Whether the straight line between two places outside the sphere, or towards the sky, stays there. Then no ray across the
 * sphere is the first image: bent towards the center, it ends on the center's side of its own straight continuation. */
static int passes_by(const lens *l, vec3 at, vec3 to, int sky)
{
  const vec3 way = sky ? to : v3_sub(to, at);
  const double along = max2(-v3_dot(at, way) / v3_dot(way, way), 0);
  return v3_length(v3_mad(way, sky ? along : min2(along, 1), at)) > rim_of(l, l) * (1 + 1e-6);
}

static void group_add(group *q, const geometry *g, size_t pair, place a, place b, double *u, const double *chances)
{
  const size_t i = q->count;
  if (!join_tries(chances, joint_way_by(q->index, q->kind == PASSAGE_THROUGH), u, &q->way_chance[i])) return;
  q->pair[i] = pair;
  q->a[i] = q->reversed ? b : a, q->b[i] = q->reversed ? a : b;
  const int sky = isinf(b.radius), through = q->kind == PASSAGE_THROUGH;
  const vec3 at = v3_scale(a.outward, a.radius), to = sky ? b.outward : v3_scale(b.outward, b.radius);
  q->second[i] = through ? SECOND_THROUGH : join_second_chance(&g->lenses[q->index], at, to, sky);
  q->images[i] = join_images_wanted(q->second[i], u);
  if (q->kind == PASSAGE_ACROSS && q->images[i] == 1 && passes_by(&g->lenses[q->index], at, to, sky)) return;
  q->count++;
}

/* Index of the lens that owns a point, -1 if none. */
static int owner(const geometry *g, vec3 at)
{
  const lens *l = geometry_lens_at(g, at);
  return l ? (int)(l - g->lenses) : -1;
}

static void sort_pair(const geometry *g, int index, size_t pair, vec3 from, vec3 to, double *u, const double *chances,
                      int sky, int far, group *groups)
{
  const lens *l = &g->lenses[index];
  const int in_a = owner(g, from), in_b = sky ? -1 : owner(g, to);
  if ((in_a >= 0 && in_a != index) || (in_a == index && !is_usable(l, from))) return;
  const place a = place_of(l, l, from, 0, 0);
  if (!far && (in_b < 0 || in_b == index)) {
    const int kind = in_a < 0 ? (in_b < 0 ? ACROSS : IN) : in_b < 0 ? OUT : GROUPS;
    if (kind < GROUPS && (in_b < 0 || is_usable(l, to))) group_add(&groups[kind], g, pair, a, place_of(l, l, to, sky, 0), u, chances);
  }
  if (l->spacetime.kind != BENT_ELLIS || far != (l->exit < 0)) return;
  const lens *b = far ? l : &g->lenses[l->exit];
  if (in_b < 0 || (in_b == l->exit && is_usable(b, to)))
    group_add(&groups[THROUGH], g, pair, a, place_of(l, b, to, sky, 1), u, chances);
}

void join_by_lens(const geometry *g, int index, size_t n, const vec3 *from, const vec3 *to, double *u,
                  const double *const *chances, int sky, int far, joints *out)
{
  const lens *l = &g->lenses[index];
  if (!join_is_wide(l)) return;
  static const passage_kind KINDS[GROUPS] = {PASSAGE_ACROSS, PASSAGE_OUT, PASSAGE_OUT, PASSAGE_THROUGH};
  group groups[GROUPS];
  for (int k = 0; k < GROUPS; k++) {
    groups[k].kind = KINDS[k], groups[k].reversed = k == IN, groups[k].count = 0;
    groups[k].index = index, groups[k].side_b = k == THROUGH ? l->exit : index;
  }
  for (size_t i = 0; i < n; i++)
    sort_pair(g, index, i, from[i], to[i], u ? &u[i] : NULL, chances ? chances[i] : NULL, sky, far, groups);
  for (int k = 0; k < GROUPS; k++) solve(g, &groups[k], from, to, sky, out);
}
