/* Truncated power series over lanes: Cauchy products and evaluation.
 *
 * The order of a series is a constant where these are inlined, so every loop unrolls. Sums run in two halves to shorten
 * the chain of dependent additions.
 */
#ifndef BENT_SPACETIME_SERIES_H
#define BENT_SPACETIME_SERIES_H
#include "base/lanes.h"

/* Coefficient k of the product a b. */
LANES_INLINE lanes series_product(const lanes *a, const lanes *b, int k)
{
  lanes even = a[0] * b[k], odd = {0};
#pragma GCC unroll 32
  for (int j = 1; j <= k; j++)
    if (j & 1) odd += a[j] * b[k - j];
    else even += a[j] * b[k - j];
  return even + odd;
}

/* Coefficient k of the product a b without the term a[0] b[k]. */
LANES_INLINE lanes series_product_tail(const lanes *a, const lanes *b, int k)
{
  lanes even = {0}, odd = {0};
#pragma GCC unroll 32
  for (int j = 1; j <= k; j++)
    if (j & 1) odd += a[j] * b[k - j];
    else even += a[j] * b[k - j];
  return even + odd;
}

/* Coefficient k of a squared. */
LANES_INLINE lanes series_square(const lanes *a, int k)
{
  lanes even = {0}, odd = {0};
#pragma GCC unroll 32
  for (int j = 0; j < (k + 1) / 2; j++)
    if (j & 1) odd += a[j] * a[k - j];
    else even += a[j] * a[k - j];
  const lanes sum = even + odd;
  return k & 1 ? sum + sum : sum + sum + a[k / 2] * a[k / 2];
}

/* The series at x. */
LANES_INLINE lanes series_at(const lanes *a, int order, lanes x)
{
  lanes value = a[order];
#pragma GCC unroll 32
  for (int k = order - 1; k >= 0; k--) value = value * x + a[k];
  return value;
}

/* How much the series differs at x from its beginning, and its derivative there. */
LANES_INLINE void series_change_with_slope(const lanes *a, int order, lanes x, lanes *change, lanes *slope)
{
  lanes p = a[order], d = {0};
#pragma GCC unroll 32
  for (int k = order - 1; k > 0; k--) d = d * x + p, p = p * x + a[k];
  *change = p * x, *slope = d * x + p;
}

/* The series and its derivative at x. */
LANES_INLINE void series_with_slope(const lanes *a, int order, lanes x, lanes *value, lanes *slope)
{
  series_change_with_slope(a, order, x, value, slope);
  *value += a[0];
}
#endif
