/* Piecewise polynomials of tables: fitting them, what they are off by, and fetching their coefficients. Kernel code. */
#ifndef BENT_TABLE_FIT_H
#define BENT_TABLE_FIT_H
#include <math.h>

#include "base/lanes.h"
#include "table/table_data.h"

/* Node k of `count` Chebyshev nodes on [-1, 1]; those beyond repeat them. */
LANES_INLINE double chebyshev_node(int k, int count) { return cos(M_PI * (k + 0.5) / count); }

/* values at the Chebyshev nodes, `stride` apart -> monomial coefficients in place. count <= TABLE_WIDTH */
LANES_INLINE void fit(double *values, int stride, int count)
{
  double chebyshev[TABLE_WIDTH], power[TABLE_WIDTH][TABLE_WIDTH] = {{0}}; /* power[j]: T_j in monomials */
  for (int j = 0; j < count; j++) {
    double sum = 0;
    for (int k = 0; k < count; k++) sum += values[k * stride] * cos(M_PI * j * (k + 0.5) / count);
    chebyshev[j] = sum * (j ? 2.0 : 1.0) / count;
  }
  power[0][0] = power[1][1] = 1;
  for (int j = 2; j < count; j++)
    for (int i = 0; i < count; i++) power[j][i] = (i ? 2 * power[j - 1][i - 1] : 0) - power[j - 2][i];
  for (int i = 0; i < count; i++) {
    double sum = 0;
    for (int j = 0; j < count; j++) sum += chebyshev[j] * power[j][i];
    values[i * stride] = sum;
  }
}

/* Adds the differences of n numbers to an error. */
LANES_INLINE void note_errors(const double *a, const double *b, size_t n, table_row_error *error)
{
  for (size_t i = 0; i < n; i++) {
    const double e = fabs(a[i] - b[i]);
    if (!(e <= error->max)) error->max = e; /* NaN shows */
    error->square_sum += e * e;
  }
  error->count += n;
}

/* Lane i of the result is entry k of row index[i]. */
LANES_INLINE lanes gather(const double *rows, size_t width, const int64_t *index, size_t k)
{
  lanes value = {0};
  for (int i = 0; i < LANES; i++) value[i] = rows[(size_t)index[i] * width + k];
  return value;
}
#endif
