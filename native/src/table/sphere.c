/* Making and asking the tables of lens spheres; the arithmetic is in sphere.kernel.c. */
#include "bentlight/sphere.h"

#include <math.h>
#include <string.h>

#include "base/aligned.h"
#include "bentlight/table.h"
#include "table/map.h"
#include "table/sphere_data.h"

/* Larger spheres would have their critical rays between the last octave and 0. */
static const double SIZE_MAX_FACTOR = 1e6;

/* M/r or l/r at a chart radius outside the core. */
static double position_of(const bent_spacetime *s, double radius)
{
  if (s->kind == BENT_ELLIS) return map_x_ellis(0.5 * s->throat_radius / radius);
  return s->chart == BENT_CHART_ISOTROPIC ? map_x_schwarzschild(0.5 * s->mass / radius) : s->mass / radius;
}

int bent_sphere_is_tabulated(const bent_spacetime *s, double radius)
{
  if (!isfinite(radius) || !(radius > bent_spacetime_core_radius(s))) return 0;
  if (s->kind == BENT_ELLIS)
    return position_of(s, radius) >= BENT_TABLE_ELLIS_MIN && radius <= SIZE_MAX_FACTOR * s->throat_radius;
  return s->kind == BENT_SCHWARZSCHILD && s->mass > 0 && position_of(s, radius) <= BENT_TABLE_SCHWARZSCHILD_MAX &&
         radius <= SIZE_MAX_FACTOR * s->mass;
}

bent_status bent_sphere_new(const bent_spacetime *spacetime, double radius, bent_sphere **out, bent_error *error)
{
  if (!bent_sphere_is_tabulated(spacetime, radius))
    return bent_fail(error, BENT_ERROR_ARGUMENT, "lens sphere: there is no table for radius %g around this spacetime "
                     "(Schwarzschild from r = 4 M, Ellis from l = rho / 4, up to 1e6 times that)", radius);
  bent_sphere *sphere = aligned_new(sizeof *sphere);
  if (!sphere) return bent_fail(error, BENT_ERROR_MEMORY, "out of memory for the table of a lens sphere");
  memset(sphere, 0, sizeof *sphere);
  const double x = position_of(spacetime, radius);
  sphere->spacetime = *spacetime;
  sphere->radius = radius;
  if (spacetime->kind == BENT_ELLIS) {
    const double half = 0.5 * spacetime->throat_radius / radius;
    sphere->unit = spacetime->throat_radius;
    sphere->size = 0.5 * (1 + half * half) / half;
    sphere->critical = 1 / sphere->size;
  } else {
    sphere->unit = spacetime->mass;
    sphere->size = 1 / x;
    sphere->critical = 1 / (1 + map_delta_schwarzschild(x, 1));
  }
  sphere->delta_max = 1 / sphere->critical - 1;
  BENT_CALL(sphere_fill)(sphere);
  const table_row_error *e = sphere->errors;
  sphere->measured = (bent_sphere_error){
      .swept_max = e[SPHERE_SWEPT].max, .swept_rms = sqrt(e[SPHERE_SWEPT].square_sum / (double)e[SPHERE_SWEPT].count),
      .length_max = sphere->unit * e[SPHERE_LENGTH].max,
      .length_rms = sphere->unit * sqrt(e[SPHERE_LENGTH].square_sum / (double)e[SPHERE_LENGTH].count)};
  *out = sphere;
  return BENT_OK;
}

void bent_sphere_free(bent_sphere *sphere) { aligned_release(sphere); }

bent_sphere_error bent_sphere_measured(const bent_sphere *sphere) { return sphere->measured; }

void bent_sphere_cross(const bent_sphere *sphere, size_t n, const double (*points)[3], const double (*directions)[3],
                       const bent_crossing *out)
{
  BENT_CALL(sphere_cross)(sphere, n, points, directions, out);
}

void bent_sphere_emerge(const bent_sphere *sphere, size_t n, const double (*points)[3], const double (*directions)[3],
                        const bent_crossing *out)
{
  BENT_CALL(sphere_emerge)(sphere, n, points, directions, out);
}
