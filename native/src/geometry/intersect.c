/* The nearest hit along each ray: checks the rays and takes them, leg by leg, to their end. */
#include "bentlight/intersect.h"

#include <math.h>

#include "geometry/cross.h"
#include "geometry/flat.h"
#include "geometry/jump.h"
#include "geometry/travel.h"
#include "scene/scene.h"

enum {
  BATCH = TRAVELERS_MAX, /* rays between two looks at the progress cell, side by side in one batch */
  LEGS_MAX = 64, /* a ray that goes to and fro between lenses for longer is unresolved */
};

static int is_inside_horizon(const lens *l, vec3 position)
{
  double at[3];
  if (!l) return 0;
  v3_to(at, mat4_point(&l->spacetime_from_world, position));
  return !bent_spacetime_contains(&l->spacetime, at);
}

/* `l`: the lens that the ray starts in, or NULL; `inside`: its horizon. */
static bent_status check_ray(const geometry *g, size_t index, const bent_ray *ray, const lens *l, int inside,
                             bent_error *error)
{
  const vec3 o = v3_from(ray->origin), d = v3_from(ray->direction);
  if (!v3_is_finite(o) || !v3_is_finite(d) || v3_dot(d, d) == 0)
    return bent_fail(error, BENT_ERROR_ARGUMENT, "ray %zu: origin and direction must be finite and the direction not zero",
                     index);
  if (!(ray->tolerance > 0) || !(ray->angular_tolerance > 0))
    return bent_fail(error, BENT_ERROR_ARGUMENT, "ray %zu: tolerances must be positive", index);
  if (!(ray->length_min >= 0) || !(ray->length_max >= ray->length_min))
    return bent_fail(error, BENT_ERROR_ARGUMENT, "ray %zu: needs 0 <= length_min <= length_max", index);
  if (ray->source_instance >= 0 &&
      ((size_t)ray->source_instance >= g->instance_count || ray->source_triangle < 0 ||
       (size_t)ray->source_triangle >= g->meshes[g->instances[ray->source_instance].mesh].triangle_count))
    return bent_fail(error, BENT_ERROR_ARGUMENT, "ray %zu: there is no triangle %d of instance %d", index,
                     ray->source_triangle, ray->source_instance);
  if (ray->source_instance < 0 && inside)
    return bent_fail(error, BENT_ERROR_ARGUMENT, "ray %zu: starts inside the horizon of spacetime object %d", index,
                     (int)(l - g->lenses));
  return BENT_OK;
}

static void set_out(const geometry *g, const bent_ray *ray, const lens *l, int inside, traveler *t, bent_hit *hit)
{
  *hit = (bent_hit){.fate = BENT_UNRESOLVED, .instance = -1, .triangle = -1, .position = {NAN, NAN, NAN},
                    .first_lens = l ? (int)(l - g->lenses) : -1, .sky = -1};
  t->position = v3_from(ray->origin);
  t->direction = v3_normalize(v3_from(ray->direction));
  t->leg = l ? (int)(l - g->lenses) : LEG_FLAT;
  t->at = AT_ANY;
  t->left = -1;
  if (l && !l->flat && isinf(l->radius) && !ray->visibility) t->leg = LEG_AWAY, t->left = (int)(l - g->lenses);
  t->leaving = ray->source_instance >= 0;
  t->legs = 0;
  if (t->leaving && inside) {
    hit->fate = BENT_CAPTURED;
    v3_to(hit->direction, v3(NAN, NAN, NAN));
    t->leg = LEG_OVER;
  }
}

/* The lens whose sphere a straight line enters first, and at what length; -1 and INFINITY if none. The line comes out of
 * the lens `left`, which it cannot meet again. */
static int next_lens(const geometry *g, vec3 origin, vec3 direction, int left, double *length)
{
  int next = -1;
  *length = INFINITY;
  for (int i = 0; i < (int)g->lens_count; i++) {
    const lens *l = &g->lenses[i];
    if (l->flat || i == left) continue;
    const vec3 to = v3_sub(l->center, origin);
    const double along = v3_dot(to, direction);
    const vec3 closest = v3_mad(direction, -along, to);
    const double half2 = l->radius * l->radius - v3_dot(closest, closest);
    if (!(along > 0) || !(half2 > 0)) continue;
    const double entry = fmax(along - sqrt(half2), 0);
    if (entry < *length) *length = entry, next = i;
  }
  return next;
}

/* What a ray in flat space meets: a surface, then the lens `next` at length `entry`. */
typedef struct view {
  int seen, next;
  double entry;
  found found;
} view;

static view look(const geometry *g, const bent_ray *ray, const traveler *t, double length)
{
  view v;
  v.next = next_lens(g, t->position, t->direction, t->left, &v.entry);
  const double near = max2(ray->length_min - length, 0), far = min2(ray->length_max - length, v.entry);
  v.seen = ray->visibility && far >= near && flat_ask(g, ray, t->position, t->direction, near, far, t->leaving, &v.found);
  return v;
}

static void go(const geometry *g, const view *v, traveler *t, bent_hit *hit)
{
  t->leaving = 0;
  v3_to(hit->direction, t->direction);
  if (v->seen) {
    hit->fate = BENT_HIT;
    hit->length += flat_land(g, &v->found, t->position, t->direction, hit);
    t->leg = LEG_OVER;
  } else if (v->next < 0) {
    hit->fate = BENT_ESCAPED;
    hit->length = INFINITY;
    t->leg = LEG_OVER;
  } else {
    hit->length += v->entry;
    t->position = v3_mad(t->direction, v->entry, t->position);
    t->leg = v->next;
    hit->borders++;
    if (hit->first_lens < 0) hit->first_lens = v->next;
    t->at = AT_SPHERE;
  }
}

/* The flat legs of a batch, in the order that geometry_query asks for. */
static void travel_flat(const geometry *g, size_t n, const uint32_t *index, const bent_ray *rays, traveler *travelers,
                        bent_hit *hits)
{
  view views[BATCH];
  for (size_t k = 0; k < n; k++)
    views[k] = look(g, &rays[index[k]], &travelers[index[k]], hits[index[k]].length);
  for (size_t k = 0; k < n; k++)
    if (views[k].seen) found_fetch_indices(g, &views[k].found);
  for (size_t k = 0; k < n; k++)
    if (views[k].seen) found_fetch_vertices(g, &views[k].found);
  for (size_t k = 0; k < n; k++) go(g, &views[k], &travelers[index[k]], &hits[index[k]]);
}

/* One leg of every ray of the batch that is still on its way; returns how many then are. */
static size_t travel(const geometry *g, size_t n, const bent_ray *rays, traveler *travelers, bent_hit *hits)
{
  uint32_t index[BATCH];
  for (size_t i = 0; i < n; i++)
    if (travelers[i].leg != LEG_OVER && travelers[i].legs++ == LEGS_MAX)
      hits[i].fate = BENT_UNRESOLVED, travelers[i].leg = LEG_OVER;
  for (int leg = LEG_FLAT; leg < (int)g->lens_count; leg++) {
    size_t count = 0;
    for (size_t i = 0; i < n; i++)
      if (travelers[i].leg == leg) index[count++] = (uint32_t)i;
    if (!count) continue;
    if (leg == LEG_FLAT) {
      travel_flat(g, count, index, rays, travelers, hits);
      continue;
    }
    count = cross(g, leg, count, index, rays, travelers, hits);
    BENT_CALL(bent_travel_curved)(g, leg, count, index, rays, travelers, hits);
  }
  size_t away = 0, left = 0;
  for (size_t i = 0; i < n; i++)
    if (travelers[i].leg == LEG_AWAY) index[away++] = (uint32_t)i;
  if (away) jump(g, away, index, rays, travelers, hits);
  for (size_t i = 0; i < n; i++) left += travelers[i].leg != LEG_OVER;
  return left;
}

bent_status bent_scene_intersect(const bent_scene *scene, size_t n, const bent_ray *rays, bent_hit *hits,
                                 bent_progress *progress, bent_error *error)
{
  if (!scene->committed)
    return bent_fail(error, BENT_ERROR_STATE, "intersect: the scene has edits that are not committed");
  const geometry *g = scene->geometry;
  traveler travelers[BATCH];
  for (size_t begin = 0; begin < n; begin += BATCH) {
    const size_t count = n - begin < BATCH ? n - begin : BATCH;
    if (progress && atomic_load_explicit(&progress->cancel, memory_order_relaxed))
      return bent_fail(error, BENT_CANCELLED, "intersect: cancelled");
    for (size_t i = 0; i < count; i++) {
      const bent_ray *ray = &rays[begin + i];
      const lens *l = geometry_lens_at(g, v3_from(ray->origin));
      const int inside = is_inside_horizon(l, v3_from(ray->origin));
      const bent_status status = check_ray(g, begin + i, ray, l, inside, error);
      if (status) return status;
      set_out(g, ray, l, inside, &travelers[i], &hits[begin + i]);
    }
    while (travel(g, count, rays + begin, travelers, hits + begin)) {
    }
    if (progress) atomic_fetch_add_explicit(&progress->done, count, memory_order_relaxed);
  }
  return BENT_OK;
}
