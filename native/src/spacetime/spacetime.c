/* Making and checking spacetimes. */
#include "bentlight/spacetime.h"

#include <math.h>

bent_spacetime bent_minkowski(void)
{
  return (bent_spacetime){.kind = BENT_MINKOWSKI, .chart = BENT_CHART_CARTESIAN};
}

bent_status bent_schwarzschild(double mass, bent_chart chart, bent_spacetime *out, bent_error *error)
{
  if (!isfinite(mass) || mass < 0)
    return bent_fail(error, BENT_ERROR_ARGUMENT, "mass: must be finite and not negative, got %g", mass);
  if (chart != BENT_CHART_ISOTROPIC && chart != BENT_CHART_AREAL)
    return bent_fail(error, BENT_ERROR_ARGUMENT, "chart: Schwarzschild has the isotropic and the areal chart");
  *out = (bent_spacetime){.kind = BENT_SCHWARZSCHILD, .chart = chart, .mass = mass};
  return BENT_OK;
}

bent_status bent_kerr(double mass, double spin, bent_spacetime *out, bent_error *error)
{
  if (!isfinite(mass) || mass < 0)
    return bent_fail(error, BENT_ERROR_ARGUMENT, "mass: must be finite and not negative, got %g", mass);
  if (!isfinite(spin) || (fabs(spin) >= mass && !(spin == 0 && mass == 0)))
    return bent_fail(error, BENT_ERROR_ARGUMENT, "spin: |spin| must be smaller than the mass %g, got %g", mass, spin);
  *out = (bent_spacetime){.kind = BENT_KERR, .chart = BENT_CHART_OBLATE, .mass = mass, .spin = spin};
  return BENT_OK;
}

bent_status bent_ellis(double throat_radius, bent_spacetime *out, bent_error *error)
{
  if (!isfinite(throat_radius) || throat_radius <= 0)
    return bent_fail(error, BENT_ERROR_ARGUMENT, "throat_radius: must be finite and positive, got %g", throat_radius);
  *out = (bent_spacetime){.kind = BENT_ELLIS, .chart = BENT_CHART_ISOTROPIC, .throat_radius = throat_radius};
  return BENT_OK;
}

int bent_spacetime_is_flat(const bent_spacetime *s)
{
  return s->kind == BENT_MINKOWSKI || (s->kind != BENT_ELLIS && s->mass == 0);
}

double bent_spacetime_core_radius(const bent_spacetime *s)
{
  switch (s->kind) {
    case BENT_SCHWARZSCHILD: return s->chart == BENT_CHART_AREAL ? 2 * s->mass : s->mass / 2;
    case BENT_KERR: {
      const double horizon = s->mass + sqrt(s->mass * s->mass - s->spin * s->spin);
      return sqrt(horizon * horizon + s->spin * s->spin);
    }
    case BENT_ELLIS: return s->throat_radius / 2;
    default: return 0;
  }
}
