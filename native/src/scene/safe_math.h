/* Arithmetic that is defined everywhere, by Blender's conventions: what has no value is 0. */
#ifndef BENT_SCENE_SAFE_MATH_H
#define BENT_SCENE_SAFE_MATH_H
#include <math.h>

static inline double safe_divide(double a, double b) { return b != 0 ? a / b : 0; }
static inline double safe_power(double a, double b) { return a < 0 && b != trunc(b) ? 0 : pow(a, b); }
static inline double safe_log(double a, double b) { return a <= 0 || b <= 0 ? 0 : safe_divide(log(a), log(b)); }
static inline double smooth_min(double a, double b, double c)
{
  if (c == 0) return fmin(a, b);
  const double h = fmax(c - fabs(a - b), 0) / c;
  return fmin(a, b) - h * h * h * c / 6;
}
static inline double wrap_range(double x, double high, double low)
{
  const double range = high - low;
  return range != 0 ? x - range * floor((x - low) / range) : low;
}
static inline double ping_pong(double a, double b)
{
  if (b == 0) return 0;
  const double t = (a - b) / (2 * b);
  return fabs((t - floor(t)) * 2 * b - b);
}

#endif
