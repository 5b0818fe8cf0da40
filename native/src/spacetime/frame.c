/* Local frames: where a ray may start, the ZAMO's lapse, and covectors in its tetrad. */
#include "spacetime/frame.h"

#include "base/vec3.h"

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
  if (!bent_spacetime_contains(s, position)) return 0;
  if (s->kind == BENT_ELLIS || bent_spacetime_is_flat(s)) return 1;
  if (s->chart == BENT_CHART_ISOTROPIC) {
    const double radius = v3_length(v3_from(position));
    return (radius - s->mass / 2) / (radius + s->mass / 2);
  }
  return BENT_CALL(bent_kerr_lapse)(s, position);
}

void bent_local_from_covector(const bent_spacetime *s, const double position[3], double matrix[3][3])
{
  if (!bent_spacetime_is_flat(s) && s->chart != BENT_CHART_ISOTROPIC && bent_spacetime_contains(s, position)) {
    BENT_CALL(bent_kerr_local_from_covector)(s, position, matrix);
    return;
  }
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) matrix[i][j] = i == j;
}

double bent_length_scale(const bent_spacetime *s, const double position[3])
{
  if (bent_spacetime_is_flat(s) || s->chart != BENT_CHART_ISOTROPIC) return 1;
  const double radius = v3_length(v3_from(position)), part = bent_spacetime_core_radius(s) / radius;
  return s->kind == BENT_ELLIS ? 1 + part * part : (1 + part) * (1 + part);
}

double bent_zamo_speed(const bent_spacetime *s, const double position[3])
{
  if (s->kind != BENT_KERR || s->spin == 0 || !bent_spacetime_contains(s, position)) return 0;
  const double a2 = s->spin * s->spin, out2 = position[0] * position[0] + position[1] * position[1];
  const double z2 = position[2] * position[2], half = 0.5 * (out2 + z2 - a2), r2 = half + sqrt(half * half + a2 * z2);
  const double r = sqrt(r2), sigma = r2 + a2 * z2 / r2, delta = r2 - 2 * s->mass * r + a2;
  return 2 * s->mass * s->spin * r * sqrt(out2 / (r2 + a2)) / (sigma * sqrt(delta));
}
