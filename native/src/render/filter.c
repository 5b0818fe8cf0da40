/* See filter.h. */
#include "render/filter.h"

#include <math.h>

/* The one-dimensional filter at t in [0, 1], the fraction of the half width; not normalized. */
static double density(bent_filter_kind kind, double t)
{
  const double v = M_PI * (1 + t); /* Blackman-Harris: four-term window (Harris 1978) */
  switch (kind) {
    case BENT_FILTER_BLACKMAN_HARRIS:
      return 0.35875 - 0.48829 * cos(v) + 0.14128 * cos(2 * v) - 0.01168 * cos(3 * v);
    case BENT_FILTER_GAUSSIAN: return exp(-18 * t * t); /* the edge is at six standard deviations */
    default: return 1;
  }
}

void filter_init(pixel_filter *filter, bent_filter_kind kind, double width)
{
  filter->half_width = (kind == BENT_FILTER_BOX ? 1 : width) / 2;
  double sum = filter->cumulative[0] = 0;
  for (int i = 0; i < FILTER_CELLS; i++)
    filter->cumulative[i + 1] = sum += density(kind, (i + 0.5) / FILTER_CELLS);
  for (int i = 1; i <= FILTER_CELLS; i++) filter->cumulative[i] /= sum;
  for (int i = 0, cell = 0; i < FILTER_CELLS; i++) {
    while (filter->cumulative[cell + 1] <= (double)i / FILTER_CELLS) cell++;
    filter->first[i] = cell;
  }
}

double filter_offset(const pixel_filter *filter, double u)
{
  const double *c = filter->cumulative, side = u < 0.5 ? -1 : 1, wanted = fabs(2 * u - 1);
  if (!(wanted < 1)) return side * filter->half_width;
  int cell = filter->first[(int)(wanted * FILTER_CELLS)];
  while (c[cell + 1] <= wanted) cell++;
  return side * filter->half_width * (cell + (wanted - c[cell]) / (c[cell + 1] - c[cell])) / FILTER_CELLS;
}

double filter_density(const pixel_filter *filter, double offset)
{
  const double at = fabs(offset) / filter->half_width * FILTER_CELLS;
  if (!(at < FILTER_CELLS)) return 0;
  const double *c = &filter->cumulative[(int)at];
  return (c[1] - c[0]) * FILTER_CELLS / (2 * filter->half_width);
}

double filter_cumulative(const pixel_filter *filter, double offset)
{
  const double at = fabs(offset) / filter->half_width * FILTER_CELLS;
  if (!(at < FILTER_CELLS)) return offset > 0;
  const double *c = &filter->cumulative[(int)at], part = c[0] + (c[1] - c[0]) * (at - (int)at);
  return offset > 0 ? (1 + part) / 2 : (1 - part) / 2;
}
