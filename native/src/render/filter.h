/* Pixel reconstruction filters, importance sampled: a pixel is the plain mean of its own samples, whose positions are
 * drawn from the filter. Widths and shapes as Blender's Cycles has them. */
#ifndef BENT_RENDER_FILTER_H
#define BENT_RENDER_FILTER_H
#include "bentlight/render.h"

enum { FILTER_CELLS = 1024 };

/* Cumulative distribution of |offset|, at the edges of equal cells of the right half. */
typedef struct pixel_filter {
  double half_width; /* pixels */
  double cumulative[FILTER_CELLS + 1];
  int first[FILTER_CELLS]; /* the cell where the cumulative distribution reaches i / FILTER_CELLS */
} pixel_filter;

/* width: the full support in pixels. A box is always one pixel wide. */
void filter_init(pixel_filter *filter, bent_filter_kind kind, double width);
/* Offset from the pixel's center, in pixels, for u in [0, 1). */
double filter_offset(const pixel_filter *filter, double u);
/* The density of such offsets, per pixel. */
double filter_density(const pixel_filter *filter, double offset);
/* The part of them that lies below. */
double filter_cumulative(const pixel_filter *filter, double offset);
#endif
