/* Ambient occlusion: how much of the hemisphere above a surface is open, by rays of limited length. They bend as all light
 * does. Random numbers are a hash of the place and of how it is looked at. */
#include <math.h>
#include <string.h>

#include "geometry/query.h"
#include "scene/program.h"
#include "scene/scene.h"

enum { SAMPLES_MAX = 128 };
static const double ANGULAR_TOLERANCE = 1e-3;

static uint64_t hash(uint64_t x)
{
  x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9u; /* Steele, Lea, Flood 2014: splitmix64 */
  x = (x ^ x >> 27) * 0x94d049bb133111ebu;
  return x ^ x >> 31;
}

static uint64_t seed_of(const shade_point *p)
{
  const double values[6] = {p->position.x, p->position.y, p->position.z, p->wo.x, p->wo.y, p->wo.z};
  uint64_t words[6], seed = 0;
  memcpy(words, values, sizeof words);
  for (int i = 0; i < 6; i++) seed = hash(seed + 0x9e3779b97f4a7c15u + words[i]);
  return seed;
}

/* Directions around the normal by their cosine: points of the unit disk, one in each of n sectors. */
static vec3 direction(vec3 normal, uint64_t seed, int i, int n)
{
  const uint64_t bits = hash(seed + (uint64_t)i * 0x9e3779b97f4a7c15u);
  const double u = (bits >> 32) * 0x1p-32, phi = 2 * M_PI * (i + (bits & UINT32_MAX) * 0x1p-32) / n;
  vec3 x, y;
  v3_basis(normal, &x, &y);
  return v3_add(v3_scale(normal, sqrt(1 - u)), v3_scale(v3_add(v3_scale(x, cos(phi)), v3_scale(y, sin(phi))), sqrt(u)));
}

/* How many of the rays meet something: of the same instance, or of all that throws shadows. */
static int count_met(const shade_point *p, int n, const bent_ray *rays, int own)
{
  int met = 0;
  if (own) {
    const geometry *g = p->scene->geometry;
    for (int i = 0; i < n; i++) {
      const vec3 to = v3_from(rays[i].direction);
      const query q = {.start = p->position, .span = to, .far = rays[i].length_max, .visibility = UINT32_MAX,
                       .leaving = &rays[i], .departure = to, .inside = &g->instances[p->instance]};
      found f;
      met += geometry_query(g, &q, &f);
    }
    return met;
  }
  bent_hit hits[SAMPLES_MAX];
  bent_error error;
  if (bent_scene_intersect(p->scene, (size_t)n, rays, hits, NULL, &error)) return 0;
  for (int i = 0; i < n; i++) met += hits[i].fate == BENT_HIT;
  return met;
}

/* Normal, distance -> the open part; number of rays, inside, only this object. */
OPERATION(occlusion)
{
  const shade_point *p = context->point;
  const int n = immediates[0] < SAMPLES_MAX ? immediates[0] : SAMPLES_MAX;
  const double distance = in[1]->x, length = v3_length(*in[0]);
  *out = v3_splat(1);
  if (!p->scene || n < 1 || !(distance > 0) || !(length > 0 && length < INFINITY)) return;
  const vec3 normal = v3_scale(*in[0], (immediates[1] ? -1 : 1) / length);
  const uint64_t seed = seed_of(p);
  bent_ray rays[SAMPLES_MAX];
  for (int i = 0; i < n; i++) {
    rays[i] = (bent_ray){.tolerance = ANGULAR_TOLERANCE * min2(distance, 1), .angular_tolerance = ANGULAR_TOLERANCE,
                         .length_max = distance, .source_instance = p->instance, .source_triangle = p->triangle,
                         .visibility = BENT_SHADOW};
    v3_to(rays[i].origin, p->position);
    v3_to(rays[i].direction, direction(normal, seed, i, n));
  }
  *out = v3_splat(1 - (double)count_met(p, n, rays, immediates[2]) / n);
}
