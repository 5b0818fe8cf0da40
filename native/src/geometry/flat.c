/* Straight rays: one query, its answer recomputed in double precision. */
#include "geometry/flat.h"

int flat_ask(const geometry *g, const bent_ray *ray, vec3 origin, vec3 direction, double near, double far, int leaving,
             found *out)
{
  const query q = {.start = origin, .span = direction, .near = near, .far = far, .visibility = ray->visibility,
                   .leaving = leaving ? ray : NULL, .departure = direction};
  return geometry_query(g, &q, out);
}

double flat_land(const geometry *g, const found *f, vec3 origin, vec3 direction, bent_hit *hit)
{
  const triangle t = triangle_of(g, f->instance, f->triangle);
  double b[2], length = v3_dot(t.normal, v3_sub(t.v0, origin)) / v3_dot(t.normal, direction);
  triangle_barycentric(&t, v3_mad(direction, length, origin), b);
  /* Seen almost edge-on, the plane is met too far away to be of use; then Embree's own point of the triangle stands. */
  const int useful = barycentric_outside(b) < 0.01;
  if (!useful) b[0] = f->b[0], b[1] = f->b[1];
  triangle_clamp(&t, b);
  const vec3 position = triangle_point(&t, b);
  if (!useful) length = v3_dot(v3_sub(position, origin), direction);
  hit->instance = f->instance, hit->triangle = f->triangle;
  hit->barycentric[0] = b[0], hit->barycentric[1] = b[1];
  v3_to(hit->position, position);
  return max2(length, 0);
}
