/* Making, building and asking deflection tables; the arithmetic is in table.kernel.c. */
#include "bentlight/table.h"

#include <math.h>
#include <string.h>

#include "base/aligned.h"
#include "table/table_data.h"

bent_status bent_table_new(const bent_spacetime *spacetime, bent_table **out, bent_error *error)
{
  const int is_ellis = spacetime->kind == BENT_ELLIS;
  if (!is_ellis && !(spacetime->kind == BENT_SCHWARZSCHILD && spacetime->mass > 0))
    return bent_fail(error, BENT_ERROR_ARGUMENT,
                     "spacetime: tables exist for Schwarzschild (mass > 0) and Ellis; Kerr has maps at a fixed radius");
  bent_table *table = aligned_new(sizeof *table);
  if (!table) return bent_fail(error, BENT_ERROR_MEMORY, "out of memory for a deflection table");
  memset(table, 0, sizeof *table);
  table->spacetime = *spacetime;
  table->sides = is_ellis ? 2 : 1;
  table->x_min = is_ellis ? BENT_TABLE_ELLIS_MIN : 0;
  table->x_max = is_ellis ? 1 : BENT_TABLE_SCHWARZSCHILD_MAX;
  *out = table;
  return BENT_OK;
}

void bent_table_free(bent_table *table) { aligned_release(table); }

size_t bent_table_rows(const bent_table *table) { return table->sides * TABLE_OCTAVES + TABLE_X_CELLS; }

bent_status bent_table_build(bent_table *table, size_t first, size_t last, bent_progress *progress, bent_error *error)
{
  const size_t octaves = table->sides * TABLE_OCTAVES;
  if (first > last || last > bent_table_rows(table))
    return bent_fail(error, BENT_ERROR_ARGUMENT, "rows: expected 0 <= first <= last <= %zu, got %zu and %zu",
                     bent_table_rows(table), first, last);
  for (size_t row = first; row < last; row++) {
    if (progress && atomic_load_explicit(&progress->cancel, memory_order_relaxed))
      return bent_fail(error, BENT_CANCELLED, "building a table was cancelled at row %zu", row);
    table_row_error *row_error = &table->errors[row];
    if (row < octaves)
      BENT_CALL(table_fill_total)(table, row / TABLE_OCTAVES, row % TABLE_OCTAVES, row_error);
    else
      BENT_CALL(table_fill_outward)(table, row - octaves, row_error);
    table->is_built[row] = 1;
    if (progress) atomic_fetch_add_explicit(&progress->done, 1, memory_order_relaxed);
  }
  return BENT_OK;
}

static void collect(const table_row_error *errors, size_t count, double *max, double *rms)
{
  double square_sum = 0;
  size_t compared = 0;
  *max = 0;
  for (size_t i = 0; i < count; i++) {
    *max = fmax(*max, errors[i].max);
    square_sum += errors[i].square_sum, compared += errors[i].count;
  }
  *rms = compared ? sqrt(square_sum / (double)compared) : 0;
}

bent_status bent_table_measured(const bent_table *table, bent_table_error *out, bent_error *error)
{
  const size_t octaves = table->sides * TABLE_OCTAVES, rows = bent_table_rows(table);
  for (size_t row = 0; row < rows; row++)
    if (!table->is_built[row])
      return bent_fail(error, BENT_ERROR_STATE, "the table is not built yet: row %zu of %zu is missing", row, rows);
  collect(table->errors, octaves, &out->total_max, &out->total_rms);
  collect(table->errors + octaves, TABLE_X_CELLS, &out->sweep_max, &out->sweep_rms);
  return BENT_OK;
}

void bent_table_total(const bent_table *table, size_t n, const double *delta, double *angle)
{
  BENT_CALL(table_total)(table, n, delta, angle);
}

void bent_table_sweep(const bent_table *table, size_t n, const double *radius, const double *cosine, const double *sine,
                      uint8_t *fate, double *swept)
{
  BENT_CALL(table_sweep)(table, n, radius, cosine, sine, fate, swept);
}

void bent_table_trace(const bent_table *table, size_t n, const double (*origins)[3], const double (*directions)[3],
                      const bent_trace_result *out)
{
  BENT_CALL(table_trace)(table, n, origins, directions, out);
}
