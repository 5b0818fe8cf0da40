/* The inside of a bent_sphere: its columns and the kernels that fill and read them. */
#ifndef BENT_TABLE_SPHERE_DATA_H
#define BENT_TABLE_SPHERE_DATA_H
#include "base/isa.h"
#include "bentlight/sphere.h"
#include "table/table_data.h"

enum {
  SPHERE_OCTAVES = 32,      /* of delta / delta_max and of -delta, up to 1 */
  SPHERE_MANTISSA_BITS = 3, /* each in 8 segments */
  SPHERE_SEGMENTS = 1 << SPHERE_MANTISSA_BITS,
};
/* The columns: of rays that turn back, and of those that go down to the horizon or the throat. */
enum { SPHERE_BACK, SPHERE_DOWN, SPHERE_COLUMNS };
/* What is in them. */
enum { SPHERE_SWEPT, SPHERE_LENGTH, SPHERE_VALUES };

struct bent_sphere {
  _Alignas(64) double columns[SPHERE_COLUMNS][SPHERE_OCTAVES * SPHERE_SEGMENTS][SPHERE_VALUES][TABLE_WIDTH];
  bent_spacetime spacetime;
  double radius;
  double unit;      /* M or rho, chart units: columns are in this unit of length */
  double size;      /* areal radius r over the unit */
  double critical;  /* sine of the critical ray at the sphere: b / b_c = sine / critical */
  double delta_max; /* of the ray that grazes the sphere */
  table_row_error errors[SPHERE_VALUES];
  bent_sphere_error measured;
};

BENT_DECLARE_KERNEL(void, sphere_fill, (bent_sphere * sphere))
BENT_DECLARE_KERNEL(void, sphere_cross,
                    (const bent_sphere *sphere, size_t n, const double (*points)[3], const double (*directions)[3],
                     const bent_crossing *out))
BENT_DECLARE_KERNEL(void, sphere_emerge,
                    (const bent_sphere *sphere, size_t n, const double (*points)[3], const double (*directions)[3],
                     const bent_crossing *out))
#endif
