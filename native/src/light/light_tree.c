/* See light_tree.h. Nodes lie in an array; a parent comes before its children, and its first child follows it. */
#include "light/light_tree.h"

#include <stdint.h>
#include <stdlib.h>

/* In curved space what seems to face away, or to stand behind the surface, weighs at least this part. */
static const double BENT_FLOOR = 0.1;
enum { BINS = 16, DEPTH_MAX = 64 };

typedef struct node {
  light_cluster cluster;
  vec3 center, half; /* of the box */
  double radius;     /* of its bounding sphere */
  int32_t parent; /* -1: the root */
  int32_t second; /* child; -1: a leaf */
  int32_t emitter;
} node;

struct light_tree {
  double floor;
  size_t count;
  int32_t *leaf; /* of each emitter */
  node *nodes;
};

static vec3 v3_lower(vec3 a, vec3 b) { return v3(min2(a.x, b.x), min2(a.y, b.y), min2(a.z, b.z)); }
static vec3 v3_upper(vec3 a, vec3 b) { return v3(max2(a.x, b.x), max2(a.y, b.y), max2(a.z, b.z)); }

/* The smallest cone around two cones. */
static void join_cones(light_cluster *out, const light_cluster *a, const light_cluster *b)
{
  const double half_a = atan2(a->sin_normals, a->cos_normals), half_b = atan2(b->sin_normals, b->cos_normals);
  const light_cluster *wide = half_a >= half_b ? a : b, *narrow = wide == a ? b : a;
  const double large = max2(half_a, half_b), small = min2(half_a, half_b);
  const vec3 cross = v3_cross(wide->axis, narrow->axis);
  const double between = atan2(v3_length(cross), v3_dot(wide->axis, narrow->axis));
  out->axis = wide->axis;
  double half = large;
  if (between + small > large) {
    half = min2((large + between + small) / 2, acos(-1));
    const double turn = half - large, sine = v3_length(cross);
    if (sine > 1e-9) {
      const vec3 sideways = v3_cross(v3_scale(cross, 1 / sine), wide->axis);
      out->axis = v3_normalize(v3_mad(sideways, sin(turn), v3_scale(wide->axis, cos(turn))));
    } else if (between > 1) {
      half = acos(-1); /* opposite axes */
    }
  }
  out->cos_normals = cos(half), out->sin_normals = max2(sin(half), 0);
}

static light_cluster join(const light_cluster *a, const light_cluster *b)
{
  const double part = b->power / (a->power + b->power);
  light_cluster out = {.low = v3_lower(a->low, b->low), .high = v3_upper(a->high, b->high),
                       .middle = v3_mad(v3_sub(b->middle, a->middle), part, a->middle),
                       .size2 = a->size2 + part * (b->size2 - a->size2),
                       .power = a->power + b->power, .around = a->around || b->around};
  if (!out.around) join_cones(&out, a, b);
  return out;
}

static vec3 center_of(const light_cluster *c) { return v3_scale(v3_add(c->low, c->high), 0.5); }
static double axis_of(vec3 v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

/* Cost of a cluster in the surface area orientation heuristic: power, extent and spread of directions. */
static double cost_of(const light_cluster *c)
{
  const vec3 size = v3_sub(c->high, c->low);
  const double spread = c->around ? 4 : 2 - c->cos_normals; /* of the order of the cone's solid angle */
  return c->power * (v3_dot(size, size) + 1e-300) * spread;
}

typedef struct split {
  int axis;
  double at, cost;
} split;

/* The cheapest of BINS - 1 places along one axis. */
static void try_axis(const light_cluster *emitters, const int32_t *order, size_t count, int axis, double low, double high,
                     split *best)
{
  light_cluster bins[BINS], right[BINS];
  int used[BINS] = {0}, used_right[BINS];
  const double scale = BINS / (high - low);
  for (size_t i = 0; i < count; i++) {
    const light_cluster *e = &emitters[order[i]];
    int bin = (int)((axis_of(center_of(e), axis) - low) * scale);
    bin = bin < 0 ? 0 : bin >= BINS ? BINS - 1 : bin;
    bins[bin] = used[bin] ? join(&bins[bin], e) : *e;
    used[bin] = 1;
  }
  for (int i = BINS - 1; i > 0; i--) {
    used_right[i] = i == BINS - 1 ? used[i] : used[i] || used_right[i + 1];
    if (i == BINS - 1 || !used_right[i + 1]) right[i] = bins[i];
    else right[i] = used[i] ? join(&bins[i], &right[i + 1]) : right[i + 1];
  }
  light_cluster left = bins[0];
  for (int i = 1; i < BINS; i++) { /* bin 0 and the last are never empty: they hold the extremes */
    const double cost = used_right[i] ? cost_of(&left) + cost_of(&right[i]) : INFINITY;
    if (cost < best->cost) *best = (split){axis, low + i / scale, cost};
    if (used[i]) left = join(&left, &bins[i]);
  }
}

/* Puts the emitters of one side first; returns how many they are. In half where no place tells them apart. */
static size_t divide(const light_cluster *emitters, int32_t *order, size_t count, int depth)
{
  vec3 low = center_of(&emitters[order[0]]), high = low;
  for (size_t i = 1; i < count; i++) {
    const vec3 c = center_of(&emitters[order[i]]);
    low = v3_lower(low, c), high = v3_upper(high, c);
  }
  split best = {-1, 0, INFINITY};
  for (int axis = 0; axis < 3 && depth < DEPTH_MAX / 2; axis++)
    if (axis_of(high, axis) > axis_of(low, axis))
      try_axis(emitters, order, count, axis, axis_of(low, axis), axis_of(high, axis), &best);
  if (best.axis < 0) return count / 2;
  size_t left = 0;
  for (size_t i = 0; i < count; i++) {
    if (axis_of(center_of(&emitters[order[i]]), best.axis) >= best.at) continue;
    const int32_t kept = order[left];
    order[left++] = order[i], order[i] = kept;
  }
  return left && left < count ? left : count / 2;
}

/* Builds the subtree of order[0 .. count) at *next, which it moves on. Depth is bounded: beyond half of DEPTH_MAX the
 * emitters are halved by number. */
static void build(light_tree *t, const light_cluster *emitters, int32_t *order, size_t count, int parent, int depth,
                  int32_t *next)
{
  const int32_t self = (*next)++;
  node *n = &t->nodes[self];
  *n = (node){.parent = parent, .second = -1, .emitter = -1};
  if (count == 1) {
    n->emitter = order[0];
    n->cluster = emitters[order[0]];
    t->leaf[order[0]] = self;
  } else {
    const size_t left = divide(emitters, order, count, depth);
    build(t, emitters, order, left, self, depth + 1, next);
    n->second = *next;
    build(t, emitters, order + left, count - left, self, depth + 1, next);
    n->cluster = join(&t->nodes[self + 1].cluster, &t->nodes[n->second].cluster);
  }
  n->center = center_of(&n->cluster);
  n->half = v3_scale(v3_sub(n->cluster.high, n->cluster.low), 0.5);
  n->radius = v3_length(n->half);
}

bent_status light_tree_new(const light_cluster *emitters, size_t count, int bent, light_tree **out, bent_error *error)
{
  light_tree *t = calloc(1, sizeof *t);
  int32_t *order = malloc(count * sizeof *order);
  if (t) {
    t->nodes = malloc((2 * count - 1) * sizeof *t->nodes);
    t->leaf = malloc(count * sizeof *t->leaf);
  }
  if (!t || !order || !t->nodes || !t->leaf) {
    free(order);
    light_tree_free(t);
    return bent_fail(error, BENT_ERROR_MEMORY, "lights: out of memory");
  }
  t->floor = bent ? BENT_FLOOR : 0;
  t->count = count;
  for (size_t i = 0; i < count; i++) order[i] = (int32_t)i;
  int32_t next = 0;
  build(t, emitters, order, count, -1, 0, &next);
  free(order);
  *out = t;
  return BENT_OK;
}

void light_tree_free(light_tree *tree)
{
  if (!tree) return;
  free(tree->nodes);
  free(tree->leaf);
  free(tree);
}

/* cos(max(a - b, 0)) of two angles in [0, pi], given by their cosines and the sine of b. */
static double cos_less(double cos_a, double cos_b, double sin_b)
{
  return cos_a >= cos_b ? 1 : cos_a * cos_b + sqrt(max2(1 - cos_a * cos_a, 0)) * sin_b;
}

/* Whether any of a node's box is above a plane through `point`, of that normal. */
static int reaches_above(const node *n, vec3 point, vec3 normal)
{
  const double up = v3_dot(v3_sub(n->center, point), normal);
  return up + fabs(normal.x) * n->half.x + fabs(normal.y) * n->half.y + fabs(normal.z) * n->half.z > 0;
}

/* The part of a node's light, about and rather too much, that its emitters send towards a point, and that a surface there
 * takes; 0 if they or it face away from each other. */
static double facing(const node *n, vec3 point, vec3 normal, double floor)
{
  const light_cluster *c = &n->cluster;
  const int flat = !c->around && c->cos_normals >= 1, has_normal = v3_dot(normal, normal) > 0; /* a flat lamp */
  const vec3 to = v3_sub(point, n->center);
  const double distance2 = v3_dot(to, to);
  if (distance2 <= n->radius * n->radius) {
    const int behind = flat && !reaches_above(n, point, v3_scale(c->axis, -1));
    const int below = has_normal && !reaches_above(n, point, normal);
    return behind && below ? floor * floor : behind || below ? floor : 1;
  }
  const double inverse = 1 / sqrt(distance2), sin_box = n->radius * inverse;
  const double cos_box = sqrt(max2(1 - sin_box * sin_box, 0));
  double sent = 1, lit = 1;
  if (!c->around) {
    const double cosine = v3_dot(to, c->axis) * inverse;
    const double in_cone = flat ? cosine : cos_less(cosine, c->cos_normals, c->sin_normals);
    sent = max2(cos_less(in_cone, cos_box, sin_box), floor);
    if (!(sent > 0)) return 0;
  }
  if (has_normal) lit = max2(cos_less(-v3_dot(to, normal) * inverse, cos_box, sin_box), floor);
  return sent * lit;
}

double light_tree_weight(const light_tree *tree, vec3 point, vec3 normal)
{
  const node *root = &tree->nodes[0];
  const vec3 to = v3_sub(point, root->center);
  const double distance2 = max2(v3_dot(to, to), root->radius * root->radius);
  return root->cluster.power / max2(distance2, 1e-300) * facing(root, point, normal, tree->floor);
}

/* What a node weighs beside its sibling. An evenly shining disk of radius r lights a place at distance h on its axis as
 * 1 / (h^2 + r^2): so lamps near a point do not outweigh others beyond measure. From among many small ones the nearest is not
 * known. */
static double weight_of(const node *n, vec3 point, vec3 normal, double floor)
{
  const vec3 to = v3_sub(point, n->cluster.middle);
  const double distance2 = max2(v3_dot(to, to) + n->cluster.size2, n->radius * n->radius);
  return n->cluster.power / max2(distance2, 1e-300) * facing(n, point, normal, floor);
}

/* Probability of the first of two children; NaN if neither can reach the point. */
static double first_share(const light_tree *t, int32_t parent, vec3 point, vec3 normal)
{
  const double a = weight_of(&t->nodes[parent + 1], point, normal, t->floor);
  const double b = weight_of(&t->nodes[t->nodes[parent].second], point, normal, t->floor);
  return a / (a + b);
}

int light_tree_draw(const light_tree *t, vec3 point, vec3 normal, double *u, double *probability)
{
  int32_t at = 0;
  *probability = 1;
  while (t->nodes[at].second >= 0) {
    const double share = first_share(t, at, point, normal);
    if (!(share >= 0)) return -1;
    const int first = *u < share;
    *u = min2(first ? *u / share : (*u - share) / (1 - share), 1 - 1e-9);
    *probability *= first ? share : 1 - share;
    at = first ? at + 1 : t->nodes[at].second;
  }
  return t->nodes[at].emitter;
}

double light_tree_probability(const light_tree *t, int emitter, vec3 point, vec3 normal)
{
  double probability = 1;
  for (int32_t at = t->leaf[emitter]; t->nodes[at].parent >= 0; at = t->nodes[at].parent) {
    const int32_t parent = t->nodes[at].parent;
    const double share = first_share(t, parent, point, normal);
    if (!(share >= 0)) return 0;
    probability *= at == parent + 1 ? share : 1 - share;
  }
  return probability;
}
