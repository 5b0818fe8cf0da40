/* Embree called directly for many straight rays: the yardstick of bench_intersect.py. */
#include <math.h>
#include <stddef.h>
#include <stdint.h>

/* RTCRayHit of Embree 4. */
typedef struct ray_hit {
  _Alignas(16) float origin[3];
  float near, direction[3], time, far;
  uint32_t mask, id, flags;
  float normal[3], u, v;
  uint32_t triangle, geometry, instance, reserved[4];
} ray_hit;

/* Distances of the first hits along n rays, INFINITY for none. */
void embree_direct(void (*intersect1)(void *, ray_hit *, void *), void *scene, size_t n, const double (*origins)[3],
                   const double (*directions)[3], float *distance)
{
  for (size_t i = 0; i < n; i++) {
    const double *o = origins[i], *d = directions[i];
    ray_hit ray = {.origin = {(float)o[0], (float)o[1], (float)o[2]},
                   .direction = {(float)d[0], (float)d[1], (float)d[2]},
                   .far = INFINITY,
                   .mask = UINT32_MAX,
                   .geometry = UINT32_MAX,
                   .instance = UINT32_MAX};
    intersect1(scene, &ray, NULL);
    distance[i] = ray.far;
  }
}
