/* See disk_seen.h. */
#include "scene/disk_seen.h"

#include "scene/disk.h"

disk_view disk_look(const shade_point *p, double mass, double spin, int is_isotropic)
{
  const double a = fabs(spin), sense = spin < 0 ? -1 : 1;
  const vec3 at = p->object_from_world ? mat4_point(p->object_from_world, p->position) : p->position;
  const vec3 out_of = p->object_from_world ? v3_normalize(mat4_vector(p->object_from_world, p->wo)) : p->wo;
  const double drawn = v2_length(at.x, at.y), azimuth = atan2(at.y, at.x);
  const double r = is_isotropic ? disk_radius_isotropic(drawn / mass) : disk_radius_oblate(drawn / mass, a);
  const double k_r = (at.x * out_of.x + at.y * out_of.y) / drawn;
  const double k_phi = sense * (at.x * out_of.y - at.y * out_of.x) / drawn;
  double doppler = disk_doppler(r, a, k_r, k_phi);
  double gravitational = p->ray.frequency > 0 ? p->ray.frequency : disk_gravitational(r, a, k_phi);
  if (!(doppler > 0 && doppler < INFINITY)) doppler = 0; /* at the horizon and within */
  if (!(gravitational > 0 && gravitational < INFINITY)) gravitational = 0;
  return (disk_view){isfinite(r) ? r : 0, azimuth < 0 ? azimuth + 2 * M_PI : azimuth, doppler, gravitational};
}
