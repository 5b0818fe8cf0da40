/* Straight rays: one query, its answer recomputed in double precision. */
#include "geometry/flat.h"

#include "geometry/query.h"

double flat_nearest(const geometry *g, const bent_ray *ray, vec3 origin, vec3 direction, double near, double far,
                    int leaving, bent_hit *hit)
{
  const query q = {.start = origin, .span = direction, .near = near, .far = far, .visibility = ray->visibility,
                   .leaving = leaving && ray->source_instance >= 0 ? ray : NULL, .departure = direction};
  found f;
  if (!geometry_query(g, &q, &f)) return INFINITY;
  double b[2], length = v3_dot(f.plane.normal, v3_sub(f.plane.v0, origin)) / v3_dot(f.plane.normal, direction);
  triangle_barycentric(&f.plane, v3_mad(direction, length, origin), b);
  /* Seen almost edge-on, the plane is met too far away to be of use; then Embree's own point of the triangle stands. */
  const int useful = barycentric_outside(b) < 0.01;
  if (!useful) b[0] = f.b[0], b[1] = f.b[1];
  barycentric_clamp(b);
  const vec3 position = triangle_point(&f.plane, b);
  if (!useful) length = v3_dot(v3_sub(position, origin), direction);
  hit->instance = f.instance, hit->triangle = f.triangle;
  hit->barycentric[0] = b[0], hit->barycentric[1] = b[1];
  v3_to(hit->position, position);
  return length > near ? length : near;
}
