/* Local frames: where a ray may start, the ZAMO's lapse, and covectors in its tetrad. */
#include <math.h>
#include <string.h>

#include "base/vec3.h"
#include "bentlight/spacetime.h"

/* Boyer-Lindquist place of a point of the oblate chart (areal: spin 0), and the metric there.
 * Sigma, Delta, A as in Bardeen, Press & Teukolsky 1972. */
typedef struct place {
  double r, cos_theta, sin_theta, cos_phi, sin_phi;
  double sigma, delta, area;
} place;

static place place_at(double mass, double spin, vec3 x)
{
  const double horizontal = sqrt(x.x * x.x + x.y * x.y), a2 = spin * spin;
  const double half = 0.5 * (x.x * x.x + x.y * x.y + x.z * x.z - a2);
  const double outer = mass + sqrt((mass - spin) * (mass + spin)), inner = outer > 0 ? a2 / outer : 0;
  place at;
  at.r = sqrt(half + sqrt(half * half + a2 * x.z * x.z));
  at.cos_theta = at.r > 0 ? x.z / at.r : 1;
  at.sin_theta = at.r > 0 ? horizontal / sqrt(at.r * at.r + a2) : 0;
  at.cos_phi = horizontal > 0 ? x.x / horizontal : 1;
  at.sin_phi = horizontal > 0 ? x.y / horizontal : 0;
  at.sigma = at.r * at.r + a2 * at.cos_theta * at.cos_theta;
  at.delta = (at.r - outer) * (at.r - inner);
  const double s = at.r * at.r + a2;
  at.area = s * s - at.delta * a2 * at.sin_theta * at.sin_theta;
  return at;
}

int bent_spacetime_contains(const bent_spacetime *s, const double position[3])
{
  const vec3 x = v3_from(position);
  const double distance2 = v3_dot(x, x);
  if (!(distance2 <= 1e300)) return 0;
  if (bent_spacetime_is_flat(s)) return 1;
  if (!(distance2 > 1e-300)) return 0;
  if (s->kind == BENT_ELLIS) return 1;
  const double core = bent_spacetime_core_radius(s);
  if (s->kind == BENT_SCHWARZSCHILD) return distance2 > core * core;
  /* the horizon is the spheroid r = r_plus, whose semi-axes are sqrt(r_plus^2 + a^2) and r_plus */
  const double polar2 = (core - s->spin) * (core + s->spin);
  return (x.x * x.x + x.y * x.y) / (core * core) + x.z * x.z / polar2 > 1;
}

double bent_lapse(const bent_spacetime *s, const double position[3])
{
  const vec3 x = v3_from(position);
  if (!bent_spacetime_contains(s, position)) return 0;
  if (s->kind == BENT_ELLIS || bent_spacetime_is_flat(s)) return 1;
  if (s->chart == BENT_CHART_ISOTROPIC) {
    const double radius = v3_length(x);
    return (radius - s->mass / 2) / (radius + s->mass / 2);
  }
  const place at = place_at(s->mass, s->spin, x);
  return sqrt(at.sigma * at.delta / at.area);
}

static void add_axis(double matrix[3][3], vec3 axis, double factor)
{
  const double e[3] = {axis.x, axis.y, axis.z};
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) matrix[i][j] += factor * e[i] * e[j];
}

/* Each flat basis vector is stretched by (flat scale factor) / (curved one). */
void bent_local_from_covector(const bent_spacetime *s, const double position[3], double matrix[3][3])
{
  memset(matrix, 0, sizeof(double[3][3]));
  if (bent_spacetime_is_flat(s) || s->chart == BENT_CHART_ISOTROPIC || !bent_spacetime_contains(s, position)) {
    for (int i = 0; i < 3; i++) matrix[i][i] = 1;
    return;
  }
  const place at = place_at(s->mass, s->spin, v3_from(position));
  const double equatorial2 = at.r * at.r + s->spin * s->spin, equatorial = sqrt(equatorial2);
  const vec3 er = v3_scale(v3(at.r * at.sin_theta * at.cos_phi, at.r * at.sin_theta * at.sin_phi,
                              equatorial * at.cos_theta), 1 / sqrt(at.sigma));
  const vec3 et = v3_scale(v3(equatorial * at.cos_theta * at.cos_phi, equatorial * at.cos_theta * at.sin_phi,
                              -at.r * at.sin_theta), 1 / sqrt(at.sigma));
  add_axis(matrix, er, sqrt(at.delta / equatorial2));
  add_axis(matrix, et, 1);
  add_axis(matrix, v3(-at.sin_phi, at.cos_phi, 0), sqrt(equatorial2 * at.sigma / at.area));
}
