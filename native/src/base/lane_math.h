/* Elementary functions and Carlson's R_F over SIMD lanes, where one libm call a lane would cost more than the rest.
 *
 * Each states its domain and its largest error there, in units in the last place (ulp), measured against long double; the
 * tests measure it again. Nothing traps; outside the domain the result is unspecified. Minimax coefficients of log:
 * FreeBSD msun e_log.c (Sun Microsystems 1993); exp: Taylor series after reduction by ln 2.
 */
#ifndef BENT_BASE_LANE_MATH_H
#define BENT_BASE_LANE_MATH_H
#include "base/lanes.h"

/* Nearest integer, |x| < 2^51. */
LANES_INLINE lanes lanes_round(lanes x) { return (x + 0x1.8p52) - 0x1.8p52; }

/* log x, 1e-300 <= x <= 1e300: 0.9 ulp. */
LANES_INLINE lanes lanes_log(lanes x)
{
  const lanes_mask exponent = ((lanes_mask)x - 0x3fe6a09e667f3bcdLL) >> 52; /* mantissa in [sqrt(1/2), sqrt(2)) */
  const lanes mantissa = (lanes)((lanes_mask)x - (exponent << 52)), k = __builtin_convertvector(exponent, lanes);
  const lanes f = mantissa - 1, s = f / (2 + f), z = s * s, half = 0.5 * f * f;
  lanes r = z * 1.479819860511658591e-01 + 1.531383769920937332e-01;
  r = r * z + 1.818357216161805012e-01, r = r * z + 2.222219843214978396e-01, r = r * z + 2.857142874366239149e-01;
  r = r * z + 3.999999999940941908e-01, r = r * z + 6.666666666666735130e-01, r = r * z;
  return k * 6.93147180369123816490e-01 - ((half - (s * (half + r) + k * 1.90821492927058770002e-10)) - f);
}

/* log(1 + x), 0 <= x <= 1e300: 1.2 ulp, near 0 too. */
LANES_INLINE lanes lanes_log1p(lanes x)
{
  const lanes w = 1 + x;
  return lanes_log(w) + lanes_select(x > 1e16, lanes_all(0), (x - (w - 1)) / w); /* second term: what rounding w lost */
}

/* e^x, |x| <= 700: 1.2 ulp. */
LANES_INLINE lanes lanes_exp(lanes x)
{
  static const double inverse_factorial[] = {1.0,          1.0,           1.0 / 2,        1.0 / 6,          1.0 / 24,
                                             1.0 / 120,    1.0 / 720,     1.0 / 5040,     1.0 / 40320,      1.0 / 362880,
                                             1.0 / 3628800, 1.0 / 39916800, 1.0 / 479001600, 1.0 / 6227020800};
  const lanes k = lanes_round(x * 0x1.71547652b82fep+0);
  const lanes r = (x - k * 6.93147180369123816490e-01) - k * 1.90821492927058770002e-10;
  lanes p = lanes_all(inverse_factorial[13]);
  for (int i = 12; i >= 0; i--) p = p * r + inverse_factorial[i];
  return (lanes)((lanes_mask)p + (__builtin_convertvector(k, lanes_mask) << 52));
}

/* Carlson's R_F(x, y, z) for x, y, z >= 0, at most one of them 0, each 0 or within 1e-100 .. 1e100: 6 ulp. Duplication
 * until the series of order 7 is exact (Carlson 1995, Numer. Algorithms 10, 13). A lane that has converged is frozen, so
 * that its value does not depend on its neighbors. */
LANES_INLINE lanes lanes_rf(lanes x, lanes y, lanes z)
{
  lanes a = (x + y + z) * (1.0 / 3);
  for (int i = 0; i < 200; i++) {
    const lanes spread = lanes_max(lanes_max(lanes_abs(a - x), lanes_abs(a - y)), lanes_abs(a - z));
    const lanes_mask open = spread > 0.0117 * a;
    if (!lanes_any(open)) break;
    const lanes sx = lanes_sqrt(x), sy = lanes_sqrt(y), sz = lanes_sqrt(z), lambda = sx * (sy + sz) + sy * sz;
    x = lanes_select(open, 0.25 * (x + lambda), x);
    y = lanes_select(open, 0.25 * (y + lambda), y);
    z = lanes_select(open, 0.25 * (z + lambda), z);
    a = (x + y + z) * (1.0 / 3);
  }
  const lanes inverse = 1 / a, dx = (a - x) * inverse, dy = (a - y) * inverse, dz = -(dx + dy);
  const lanes e2 = dx * dy - dz * dz, e3 = dx * dy * dz;
  const lanes series = 1 + e2 * (-1.0 / 10 + e2 * (1.0 / 24 - e2 * (5.0 / 208)) - e3 * (3.0 / 44)) +
                       e3 * (1.0 / 14 + e3 * (3.0 / 104) + e2 * e2 * (1.0 / 16));
  return series * lanes_sqrt(inverse);
}
#endif
