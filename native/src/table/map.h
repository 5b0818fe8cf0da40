/* Table coordinates, written once for two compilers: C, and OSL's oslc, where REAL is float.
 *
 * A table stored as an image is read by a shader through these functions, and was filled through their inverses. Plain
 * functions of numbers: no pointers, no structs. Change anything here and BENT_MAP_VERSION with it: files of another
 * version are refused.
 */
#ifndef BENT_TABLE_MAP_H
#define BENT_TABLE_MAP_H

#define BENT_MAP_VERSION 1

#ifdef OSL_VERSION
#define REAL float
#define MAP_FUNCTION float
#else
#include <math.h>
#define REAL double
#define MAP_FUNCTION static inline double
#endif

/* The image coordinate in [0, 1] of size = |b/b_c - 1|, over the octaves from 2^low to 2^high. */
MAP_FUNCTION map_delta_coordinate(REAL size, REAL low, REAL high) { return (log2(size) - low) / (high - low); }
MAP_FUNCTION map_delta_from_coordinate(REAL coordinate, REAL low, REAL high)
{
  return exp2(low + coordinate * (high - low));
}

/* The total swept angle diverges like -log(size): what is stored is the smooth rest. */
MAP_FUNCTION map_total_stored(REAL total, REAL size) { return total + log(size / (1 + size)); }
MAP_FUNCTION map_total_from_stored(REAL stored, REAL size) { return stored - log(size / (1 + size)); }

/* Position x (M/r in Schwarzschild, l/r in Ellis) from the isotropic chart: ratio = M / (2 R), rho / (2 R). */
MAP_FUNCTION map_x_schwarzschild(REAL ratio) { return 2 * ratio / ((1 + ratio) * (1 + ratio)); }
MAP_FUNCTION map_ratio_schwarzschild(REAL x)
{
  /* the root with R outside the horizon, without cancellation far away */
  return x / (1 - x + sqrt(1 - 2 * x));
}
MAP_FUNCTION map_x_ellis(REAL ratio) { return (1 - ratio) * (1 + ratio) / (1 + ratio * ratio); }
MAP_FUNCTION map_ratio_ellis(REAL x) { return sqrt((1 - x) / (1 + x)); }

/* delta = b/b_c - 1 of a ray whose local angle to the radial direction has this sine, at position x. */
MAP_FUNCTION map_delta_schwarzschild(REAL x, REAL sine)
{
  return sine / (x * sqrt(1 - 2 * x)) * 0.19245008972987525484 - 1; /* 1 / sqrt(27) */
}
MAP_FUNCTION map_delta_ellis(REAL x, REAL sine) { return sine / sqrt((1 - x) * (1 + x)) - 1; }

/* Kerr at a fixed radius: the angle psi from the inward radial, beyond the shadow's edge at the same position angle, as an
 * image coordinate in [0, 1], logarithmic in the distance to the edge from the fraction `smallest` of its range to all. */
MAP_FUNCTION map_edge_coordinate(REAL psi, REAL edge, REAL smallest)
{
  return 1 - log((psi - edge) / (3.14159265358979323846 - edge)) / log(smallest);
}
MAP_FUNCTION map_psi_from_coordinate(REAL coordinate, REAL edge, REAL smallest)
{
  return edge + (3.14159265358979323846 - edge) * exp(log(smallest) * (1 - coordinate));
}

#undef REAL
#undef MAP_FUNCTION
#endif
