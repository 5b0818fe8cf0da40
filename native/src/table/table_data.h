/* The inside of a bent_table: its segments and the kernels that fill and read them. */
#ifndef BENT_TABLE_TABLE_DATA_H
#define BENT_TABLE_TABLE_DATA_H
#include "base/isa.h"
#include "bentlight/table.h"

enum {
  TABLE_WIDTH = 8,             /* room for coefficients; arguments evaluated side by side: a multiple of LANES */
  TABLE_TERMS = 8,             /* total: degree 7 */
  TABLE_EXPONENT_MIN = -44,    /* |delta| from 2^-44 ... */
  TABLE_EXPONENT_MAX = 20,     /* ... to 2^20 */
  TABLE_OCTAVES = TABLE_EXPONENT_MAX - TABLE_EXPONENT_MIN,
  TABLE_MANTISSA_BITS = 3,     /* each octave in 8 segments */
  TABLE_SEGMENTS = 1 << TABLE_MANTISSA_BITS,
  TABLE_X_CELLS = 32, TABLE_X_TERMS = 5, /* position: degree 4 */
  TABLE_Y_CELLS = 16, TABLE_Y_TERMS = 7, /* |cos psi| in [0, 1]: degree 6 */
  TABLE_ROWS_MAX = 2 * TABLE_OCTAVES + TABLE_X_CELLS
};

/* Error of one row: largest, sum of squares, and how many were compared. */
typedef struct table_row_error {
  double max, square_sum;
  size_t count;
} table_row_error;

struct bent_table {
  /* [0]: delta > 0; [1]: delta < 0 (Ellis) */
  _Alignas(64) double total[2][TABLE_OCTAVES * TABLE_SEGMENTS][TABLE_WIDTH];
  _Alignas(64) double outward[TABLE_X_CELLS][TABLE_Y_CELLS][TABLE_X_TERMS][TABLE_WIDTH];
  bent_spacetime spacetime;
  double x_min, x_max; /* position: M/r (Schwarzschild) or l/r (Ellis) */
  size_t sides;
  unsigned char is_built[TABLE_ROWS_MAX];
  table_row_error errors[TABLE_ROWS_MAX];
};

BENT_DECLARE_KERNEL(void, table_fill_total, (bent_table * table, size_t side, size_t octave, table_row_error *error))
BENT_DECLARE_KERNEL(void, table_fill_outward, (bent_table * table, size_t x_cell, table_row_error *error))
BENT_DECLARE_KERNEL(void, table_total, (const bent_table *table, size_t n, const double *delta, double *angle))
BENT_DECLARE_KERNEL(void, table_sweep,
                    (const bent_table *table, size_t n, const double *radius, const double *cosine, const double *sine,
                     uint8_t *fate, double *swept))
BENT_DECLARE_KERNEL(void, table_trace,
                    (const bent_table *table, size_t n, const double (*origins)[3], const double (*directions)[3],
                     const bent_trace_result *out))
#endif
