/* Sine and cosine of angles that are drawn: libm's would cost as much as all the rest of drawing a direction. */
#ifndef BENT_BASE_TURN_H
#define BENT_BASE_TURN_H

/* Of an angle in turns, 0 <= turns < 2^28; error below 3e-16. Taylor series on an eighth of a turn to both sides of the
 * nearest quarter. */
static inline void turn_sincos(double turns, double *sine, double *cosine)
{
  const int quarter = (int)(4 * turns + 0.5);
  const double x = (4 * turns - quarter) * 1.57079632679489661923, y = x * x;
  const double s = x * (1 + y * (-1.0 / 6 + y * (1.0 / 120 + y * (-1.0 / 5040 + y * (1.0 / 362880 +
                   y * (-1.0 / 39916800 + y * (1.0 / 6227020800 - y / 1307674368000)))))));
  const double c = 1 + y * (-1.0 / 2 + y * (1.0 / 24 + y * (-1.0 / 720 + y * (1.0 / 40320 + y * (-1.0 / 3628800 +
                   y * (1.0 / 479001600 + y * (-1.0 / 87178291200 + y / 20922789888000)))))));
  const double across = quarter & 1 ? c : s, along = quarter & 1 ? s : c;
  *sine = quarter & 2 ? -across : across;
  *cosine = (quarter + 1) & 2 ? -along : along;
}
#endif
