/* See casters.h. */
#include "light/casters.h"

#include <stdlib.h>

#include "geometry/geometry.h"
#include "light/surface.h"
#include "scene/shading.h"

/* Lobes as narrow as this throw caustics: GGX roughness alpha. */
static const double ALPHA_NARROW = 0.1;
/* Objects with less of narrow lobes do not count. */
static const double WEIGHT_MIN = 0.25;
static const double CHANCE = 0.5;
/* Places at which an object's material is looked at. */
enum { PROBES = 8 };

/* The part of the light at the middle of a triangle that narrow lobes scatter. */
static double narrow_share(const bent_scene *scene, int index, int triangle, closure *room)
{
  vec3 corner[3];
  for (int i = 0; i < 3; i++) corner[i] = geometry_vertex(scene->geometry, index, triangle, i);
  const vec3 middle = v3_scale(v3_add(corner[0], v3_add(corner[1], corner[2])), 1.0 / 3);
  const vec3 normal = v3_normalize(v3_cross(v3_sub(corner[1], corner[0]), v3_sub(corner[2], corner[0])));
  bent_hit hit = {.instance = index, .triangle = triangle, .barycentric = {1.0 / 3, 1.0 / 3}};
  v3_to(hit.position, middle);
  v3_to(hit.direction, v3_scale(normal, -1));
  surface surface;
  surface_at(scene, &hit, 1, &surface);
  surface.point.ray = RAY_SCATTERED;
  closure_set set = {.closures = room};
  shading_evaluate(scene->shading, surface.material, &surface.point, &set);
  double sum = 0;
  for (int i = 0; i < set.count; i++)
    if (closure_is_microfacet(&set.closures[i]) && set.closures[i].alpha * set.closures[i].alpha_y < ALPHA_NARROW * ALPHA_NARROW)
      sum += set.closures[i].share;
  return sum;
}

/* A sphere around an instance, not the smallest. */
static void enclose(const geometry *g, int index, size_t triangles, caster *out)
{
  vec3 low = geometry_vertex(g, index, 0, 0), high = low;
  for (int pass = 0; pass < 2; pass++) {
    for (size_t k = 0; k < 3 * triangles; k++) {
      const vec3 v = geometry_vertex(g, index, (int)(k / 3), (int)(k % 3));
      if (pass) out->radius = max2(out->radius, v3_length(v3_sub(v, out->center)));
      low = v3(min2(low.x, v.x), min2(low.y, v.y), min2(low.z, v.z));
      high = v3(max2(high.x, v.x), max2(high.y, v.y), max2(high.z, v.z));
    }
    out->center = v3_scale(v3_add(low, high), 0.5);
  }
}

/* Adds a caster, in place of the smallest if there are too many. */
static void add(casters *casters, const caster *c)
{
  int at = casters->count < CASTERS_MAX ? casters->count++ : 0;
  for (int i = 0; casters->count == CASTERS_MAX && i < CASTERS_MAX; i++)
    if (casters->list[i].radius < casters->list[at].radius) at = i;
  if (casters->list[at].radius < c->radius) casters->list[at] = *c;
}

casters casters_find(const bent_scene *scene)
{
  casters found = {.count = 0};
  const geometry *g = scene->geometry;
  closure *room = malloc((size_t)shading_lobe_max(scene->shading) * sizeof *room);
  for (int i = 0; room && i < (int)g->instance_count; i++) { /* without room there is no guidance, and no harm */
    const size_t triangles = g->meshes[g->instances[i].mesh].triangle_count;
    if (!triangles || g->instances[i].visibility & BENT_IMMATERIAL) continue;
    caster c = {.radius = 0};
    for (int k = 0; k < PROBES; k++)
      c.weight += narrow_share(scene, i, (int)((size_t)k * triangles / PROBES), room) / PROBES;
    if (c.weight < WEIGHT_MIN) continue;
    enclose(g, i, triangles, &c);
    if (c.radius > 0 && isfinite(c.radius)) add(&found, &c);
  }
  free(room);
  return found;
}

caster_mix casters_seen(const casters *casters, vec3 place, vec3 normal)
{
  caster_mix mix = {.count = 0};
  double sum = 0;
  for (int i = 0; i < casters->count; i++) {
    const caster *c = &casters->list[i];
    const vec3 to = v3_sub(c->center, place);
    const double distance = v3_length(to);
    if (!(distance > c->radius)) continue;
    const cap cap = cap_of_sine(v3_scale(to, 1 / distance), c->radius / distance);
    const double share = c->weight * cap_form_factor(&cap, normal);
    if (!(share > 0)) continue;
    mix.caps[mix.count] = cap;
    mix.shares[mix.count++] = share;
    sum += share;
  }
  for (int i = 0; i < mix.count; i++) mix.shares[i] /= sum;
  mix.chance = mix.count ? CHANCE : 0;
  return mix;
}

vec3 caster_draw(const caster_mix *mix, double pick, const double u[2])
{
  int chosen = 0;
  while (chosen + 1 < mix->count && pick >= mix->shares[chosen]) pick -= mix->shares[chosen++];
  return cap_draw(&mix->caps[chosen], u[0], u[1]);
}

double caster_pdf(const caster_mix *mix, vec3 direction)
{
  double pdf = 0;
  for (int i = 0; i < mix->count; i++)
    if (cap_covers(&mix->caps[i], direction)) pdf += mix->shares[i] / cap_solid_angle(&mix->caps[i]);
  return pdf;
}
