/* Crossing the clear spheres of lenses by table. */
#include "geometry/cross.h"

#include "geometry/clear.h"

/* Rays that enter a lens, or come out of its throat, in spacetime axes. */
typedef struct batch {
  size_t count;
  uint32_t target[TRAVELERS_MAX];
  double points[TRAVELERS_MAX][3], directions[TRAVELERS_MAX][3];
  uint8_t fate[TRAVELERS_MAX];
  double exit[TRAVELERS_MAX][3], direction[TRAVELERS_MAX][3];
  double swept[TRAVELERS_MAX], length[TRAVELERS_MAX], error[TRAVELERS_MAX];
} batch;

/* Chart radius of the sphere of a lens. */
static double chart_radius(const lens *l) { return l->radius / l->scale; }

static int is_tabulated(const lens *l) { return !l->flat && bent_sphere_is_tabulated(&l->spacetime, chart_radius(l)); }

static int are_equal(const lens *a, const lens *b)
{
  const bent_spacetime *s = &a->spacetime, *t = &b->spacetime;
  return chart_radius(a) == chart_radius(b) && s->kind == t->kind && s->chart == t->chart && s->mass == t->mass &&
         s->throat_radius == t->throat_radius;
}

/* The table of lens `index`: one that an equal lens has, or its own. */
static bent_status get_sphere(geometry *g, size_t index, bent_error *error)
{
  lens *l = &g->lenses[index];
  for (size_t i = 0; i < g->lens_count && !l->sphere; i++)
    if (g->lenses[i].sphere && are_equal(l, &g->lenses[i])) l->sphere = g->lenses[i].sphere;
  return l->sphere ? BENT_OK : bent_sphere_new(&l->spacetime, chart_radius(l), &l->sphere, error);
}

bent_status cross_commit(geometry *g, bent_error *error)
{
  for (size_t i = 0; i < g->lens_count; i++) {
    lens *l = &g->lenses[i];
    if (l->clearness == CLEARNESS_UNKNOWN) l->clearness = is_tabulated(l) && is_clear(g, l) ? CLEAR : OCCUPIED;
    const bent_status status = l->clearness == CLEAR ? get_sphere(g, i, error) : BENT_OK;
    if (status) return status;
  }
  return BENT_OK;
}

/* Whether answer k keeps the tolerances of its ray: the angular one, and that of positions at the sphere and beyond, the
 * same as arcs that are marched are held to. */
static int is_good(const batch *b, size_t k, const lens *l, const bent_ray *ray)
{
  const double length_error = bent_sphere_measured(l->sphere).length_max * l->scale;
  return b->fate[k] != BENT_UNRESOLVED && b->error[k] <= ray->angular_tolerance &&
         4 * l->radius * b->error[k] <= ray->tolerance && length_error <= ray->tolerance;
}

/* Takes a traveler to where answer k leaves it. */
static void arrive(const geometry *g, int lens_index, const batch *b, size_t k, traveler *t, bent_hit *hit)
{
  const lens *l = &g->lenses[lens_index];
  const vec3 direction = v3_from(b->direction[k]);
  hit->length += b->length[k] * l->scale;
  hit->swept += b->swept[k];
  hit->error += b->error[k];
  t->left = lens_index;
  if (b->fate[k] == BENT_CAPTURED) {
    hit->fate = BENT_CAPTURED;
    v3_to(hit->direction, v3(NAN, NAN, NAN));
    t->leg = LEG_OVER;
    return;
  }
  t->position = mat4_point(&l->world_from_spacetime, v3_from(b->exit[k]));
  if (b->fate[k] == BENT_ESCAPED || l->exit >= 0) hit->borders++;
  if (b->fate[k] == BENT_ESCAPED_FAR && l->exit >= 0) {
    traveler_pass_throat(t, g, l, direction);
    return;
  }
  t->direction = v3_normalize(mat4_vector(&l->world_from_spacetime, direction));
  t->leg = b->fate[k] == BENT_ESCAPED ? LEG_FLAT : LEG_AWAY; /* beyond a throat without an exit is an empty sky */
}

/* cross() for the travelers that are `at` one place. */
static size_t cross_from(int at, const geometry *g, int lens_index, size_t n, uint32_t *index, const bent_ray *rays,
                         traveler *travelers, bent_hit *hits)
{
  const lens *l = &g->lenses[lens_index];
  size_t left = 0;
  batch b;
  b.count = 0;
  for (size_t i = 0; i < n; i++) {
    const uint32_t target = index[i];
    const traveler *t = &travelers[target];
    if (t->at != at) {
      index[left++] = target;
      continue;
    }
    const size_t k = b.count++;
    b.target[k] = target;
    v3_to(b.points[k], mat4_point(&l->spacetime_from_world, t->position));
    v3_to(b.directions[k], mat4_transposed_vector(&l->world_from_spacetime, t->direction));
  }
  const bent_crossing out = {.fate = b.fate, .exit = b.exit, .direction = b.direction, .swept = b.swept,
                             .length = b.length, .error = b.error};
  (at == AT_SPHERE ? bent_sphere_cross : bent_sphere_emerge)(l->sphere, b.count, (const double(*)[3])b.points,
                                                             (const double(*)[3])b.directions, &out);
  for (size_t k = 0; k < b.count; k++) {
    const uint32_t target = b.target[k];
    if (is_good(&b, k, l, &rays[target])) arrive(g, lens_index, &b, k, &travelers[target], &hits[target]);
    else index[left++] = target;
  }
  return left;
}

size_t cross(const geometry *g, int lens_index, size_t n, uint32_t *index, const bent_ray *rays, traveler *travelers,
             bent_hit *hits)
{
  const lens *l = &g->lenses[lens_index];
  if (l->clearness != CLEAR) return n;
  n = cross_from(AT_SPHERE, g, lens_index, n, index, rays, travelers, hits);
  if (l->spacetime.kind != BENT_ELLIS) return n;
  return cross_from(AT_THROAT, g, lens_index, n, index, rays, travelers, hits);
}
