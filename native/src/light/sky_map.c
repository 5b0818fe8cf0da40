/* See sky_map.h. Cells are even in z and in longitude, which makes them equal in solid angle. */
#include "light/sky_map.h"

#include <stdlib.h>

#define PI 3.14159265358979323846

enum { ROWS = 256, COLUMNS = 512, SUBSAMPLES = 2 };

struct sky_map {
  double mean;
  double row_sum[ROWS + 1];               /* of all rows before this one; the last: 1 */
  double column_sum[ROWS][COLUMNS + 1];   /* within a row */
};

static vec3 direction_at(double row, double column)
{
  const double z = 2 * row / ROWS - 1, r = sqrt(max2(1 - z * z, 0)), longitude = 2 * PI * column / COLUMNS - PI;
  return v3(r * cos(longitude), r * sin(longitude), z);
}

/* Mean brightness of a cell. Also counts how many samples differ from `first`. */
static double cell(const shading *shading, int row, int column, vec3 first, int *different)
{
  double sum = 0;
  for (int i = 0; i < SUBSAMPLES; i++)
    for (int j = 0; j < SUBSAMPLES; j++) {
      const vec3 sky = shading_sky(shading, direction_at(row + (i + 0.5) / SUBSAMPLES, column + (j + 0.5) / SUBSAMPLES),
                                   NULL, &RAY_SCATTERED);
      const double value = v3_average(sky);
      if (isfinite(value) && value > 0) sum += value;
      *different += sky.x != first.x || sky.y != first.y || sky.z != first.z;
    }
  return sum / (SUBSAMPLES * SUBSAMPLES);
}

/* Makes sum[i + 1] = value_0 + ... + value_i into shares of the whole; returns the whole. Even shares if that is 0. */
static double normalize(double *sum, int count)
{
  const double whole = sum[count];
  for (int i = 1; i < count; i++) sum[i] = whole > 0 ? sum[i] / whole : (double)i / count;
  sum[count] = 1;
  return whole;
}

bent_status sky_map_new(const shading *shading, sky_map **out, bent_error *error)
{
  *out = NULL;
  const vec3 first = shading_sky(shading, v3(0, 0, 1), NULL, &RAY_SCATTERED);
  sky_map *map = calloc(1, sizeof *map);
  double(*value)[COLUMNS] = malloc(sizeof *value * ROWS);
  if (!map || !value) {
    free(map), free(value);
    return bent_fail(error, BENT_ERROR_MEMORY, "sky: out of memory");
  }
  int different = 0;
  for (int i = 0; i < ROWS; i++)
    for (int j = 0; j < COLUMNS; j++) map->mean += value[i][j] = cell(shading, i, j, first, &different);
  map->mean /= ROWS * COLUMNS;
  for (int i = 0; i < ROWS; i++) {
    /* what shines between the samples of a dark cell must not be drawn too seldom */
    for (int j = 0; j < COLUMNS; j++)
      map->column_sum[i][j + 1] = map->column_sum[i][j] + 0.95 * value[i][j] + 0.05 * map->mean;
    map->row_sum[i + 1] = map->row_sum[i] + normalize(map->column_sum[i], COLUMNS);
  }
  normalize(map->row_sum, ROWS);
  free(value);
  if (different && map->mean > 0) *out = map;
  else free(map);
  return BENT_OK;
}

void sky_map_free(sky_map *map) { free(map); }
double sky_map_mean(const sky_map *map) { return map->mean; }

/* The cell whose range of shares contains *u, which is made uniform again. */
static int find(const double *sum, int count, double *u)
{
  int low = 0, high = count;
  while (high - low > 1) {
    const int middle = (low + high) / 2;
    if (*u >= sum[middle]) low = middle;
    else high = middle;
  }
  const double share = sum[low + 1] - sum[low];
  *u = share > 0 ? min2(max2((*u - sum[low]) / share, 0), 1) : 0.5;
  return low;
}

static double pdf_of(const sky_map *map, int row, int column)
{
  const double share = (map->row_sum[row + 1] - map->row_sum[row]) *
                       (map->column_sum[row][column + 1] - map->column_sum[row][column]);
  return share * ROWS * COLUMNS / (4 * PI);
}

double sky_map_draw(const sky_map *map, double u, double v, vec3 *direction)
{
  const int row = find(map->row_sum, ROWS, &u), column = find(map->column_sum[row], COLUMNS, &v);
  *direction = direction_at(row + u, column + v);
  return pdf_of(map, row, column);
}

double sky_map_pdf(const sky_map *map, vec3 direction)
{
  const int row = (int)((direction.z + 1) / 2 * ROWS), column = (int)((atan2(direction.y, direction.x) / PI + 1) / 2 * COLUMNS);
  return pdf_of(map, row < 0 ? 0 : row < ROWS ? row : ROWS - 1, column < 0 ? 0 : column < COLUMNS ? column : COLUMNS - 1);
}
