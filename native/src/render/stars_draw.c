/* See bentlight/stars.h: stars' images into pixels, as points or, out of focus, as figures of the lens. Nothing is drawn by
 * chance: a figure's cells are quadrilaterals of even light, cut into lines along which the pixel filter is integrated. */
#include <stdlib.h>

#include "base/vec3.h"
#include "bentlight/stars.h"
#include "render/filter.h"

enum { SPAN_MAX = 32 };                         /* pixels along one axis that the widest filter reaches */
enum { LINES_PER_PIXEL = 4, LINES_MAX = 1 << 14 }; /* of a quadrilateral */
static const double THINNEST = 1e-3;            /* pixels that a line is long at least */

typedef struct brush {
  const bent_star_canvas *canvas;
  pixel_filter filter;
  double (*sums)[3];
} brush;

/* Shares of neighboring pixels along one axis, from pixel `first` on. */
typedef struct span {
  int64_t first;
  int count;
  double share[SPAN_MAX];
} span;

/* Of a point at `at` pixels. A filter narrower than a pixel may miss all centers: the point's own pixel gets all. */
static span span_at(const pixel_filter *filter, double at)
{
  span s = {.first = (int64_t)ceil(at - filter->half_width - 0.5)};
  const int64_t last = (int64_t)floor(at + filter->half_width - 0.5);
  double sum = 0;
  for (int64_t i = s.first; i <= last && s.count < SPAN_MAX; i++)
    sum += s.share[s.count++] = filter_density(filter, (double)i + 0.5 - at);
  if (!(sum > 0)) return (span){.first = (int64_t)floor(at), .count = 1, .share = {1}};
  for (int i = 0; i < s.count; i++) s.share[i] /= sum;
  return s;
}

/* Adds light to column x of the pixels, shared among lines as the span says. */
static void add_column(const brush *b, int64_t x, const span *across_y, const double light[3], double part)
{
  const uint32_t *tile = b->canvas->tile;
  const int64_t column = x - tile[0];
  if (column < 0 || column >= tile[2]) return;
  for (int j = 0; j < across_y->count; j++) {
    const int64_t row = across_y->first + j - tile[1];
    if (row < 0 || row >= tile[3]) continue;
    double *pixel = b->sums[(size_t)row * tile[2] + (size_t)column];
    for (int k = 0; k < 3; k++) pixel[k] += part * across_y->share[j] * light[k];
  }
}

static void draw_point(const brush *b, double x, double y, const double light[3])
{
  const span across_x = span_at(&b->filter, x), across_y = span_at(&b->filter, y);
  for (int i = 0; i < across_x.count; i++) add_column(b, across_x.first + i, &across_y, light, across_x.share[i]);
}

/* A line at height y of even light. */
static void draw_line(const brush *b, double from, double to, double y, const double light[3])
{
  const pixel_filter *f = &b->filter;
  const double thicken = max2(THINNEST - (to - from), 0) / 2, x0 = from - thicken, x1 = to + thicken;
  const int64_t first = (int64_t)ceil(x0 - f->half_width - 0.5), last = (int64_t)floor(x1 + f->half_width - 0.5);
  const span across_y = span_at(f, y);
  double sum = 0;
#define SHARE(i) (filter_cumulative(f, (double)(i) + 0.5 - x0) - filter_cumulative(f, (double)(i) + 0.5 - x1))
  for (int64_t i = first; i <= last; i++) sum += SHARE(i);
  if (!(sum > 0)) add_column(b, (int64_t)floor((x0 + x1) / 2), &across_y, light, 1);
  else for (int64_t i = first; i <= last; i++) add_column(b, i, &across_y, light, SHARE(i) / sum);
#undef SHARE
}

/* Where the line at height y enters and leaves a convex quadrilateral; of one that rounding lets it miss, where that ends. */
static void chord(const double corners[4][2], double y, double out[2])
{
  out[0] = INFINITY, out[1] = -INFINITY;
  for (int i = 0; i < 4; i++) {
    const double *a = corners[i], *b = corners[(i + 1) % 4];
    if ((a[1] > y) == (b[1] > y)) continue;
    const double x = a[0] + (b[0] - a[0]) * (y - a[1]) / (b[1] - a[1]);
    out[0] = min2(out[0], x), out[1] = max2(out[1], x);
  }
  for (int i = 0, missed = out[0] > out[1]; i < 4 && missed; i++)
    out[0] = min2(out[0], corners[i][0]), out[1] = max2(out[1], corners[i][0]);
}

static void draw_quadrilateral(const brush *b, const double corners[4][2], const double light[3])
{
  const uint32_t *tile = b->canvas->tile;
  const double reach = b->filter.half_width + 1;
  double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
  for (int i = 0; i < 4; i++)
    for (int k = 0; k < 2; k++) low[k] = min2(low[k], corners[i][k]), high[k] = max2(high[k], corners[i][k]);
  for (int k = 0; k < 2; k++)
    if (!(high[k] > tile[k] - reach && low[k] < (double)tile[k] + tile[2 + k] + reach)) return;
  const int lines = (int)max2(1, min2(ceil((high[1] - low[1]) * LINES_PER_PIXEL), LINES_MAX));
  const double step = (high[1] - low[1]) / lines;
  double ends[2], area = 0;
  if (!(step > 0)) { /* a line itself */
    draw_line(b, low[0], high[0], low[1], light);
    return;
  }
  for (int i = 0; i < lines; i++) {
    chord(corners, low[1] + (i + 0.5) * step, ends);
    area += max2(ends[1] - ends[0], THINNEST);
  }
  for (int i = 0; i < lines; i++) {
    const double y = low[1] + (i + 0.5) * step;
    chord(corners, y, ends);
    const double part = max2(ends[1] - ends[0], THINNEST) / area;
    draw_line(b, ends[0], ends[1], y, (const double[3]){part * light[0], part * light[1], part * light[2]});
  }
}

/* The corners of a cell of the lens; returns its area. */
static double cell_corners(const uint32_t cells[2], const double (*corners)[2], size_t cell, double out[4][2])
{
  static const uint32_t AROUND[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  for (int c = 0; c < 4; c++) {
    const double *corner = corners[(cell / cells[1] + AROUND[c][0]) * (cells[1] + 1) + cell % cells[1] + AROUND[c][1]];
    out[c][0] = corner[0], out[c][1] = corner[1];
  }
  return fabs((out[2][0] - out[0][0]) * (out[3][1] - out[1][1]) - (out[3][0] - out[1][0]) * (out[2][1] - out[0][1])) / 2;
}

/* An image through all cells of the lens. shift: pixels by which it is moved per scene unit along either axis of the lens. */
static void draw_blurred(const brush *b, const double at[2], const double light[3], const double shift[2][2],
                         const uint32_t cells[2], const double (*corners)[2], const uint8_t (*seen)[3])
{
  const size_t count = (size_t)cells[0] * cells[1];
  double sum[3] = {0, 0, 0}, lens[4][2];
  for (size_t i = 0; i < count; i++) {
    const double area = cell_corners(cells, corners, i, lens);
    for (int k = 0; k < 3; k++) sum[k] += area * seen[i][k];
  }
  for (size_t i = 0; i < count; i++) {
    const double area = cell_corners(cells, corners, i, lens);
    double quadrilateral[4][2], part[3];
    for (int k = 0; k < 3; k++) part[k] = sum[k] > 0 ? light[k] * area * seen[i][k] / sum[k] : 0;
    if (!(max2(part[0], max2(part[1], part[2])) > 0)) continue;
    for (int c = 0; c < 4; c++)
      for (int k = 0; k < 2; k++) quadrilateral[c][k] = at[k] + shift[k][0] * lens[c][0] + shift[k][1] * lens[c][1];
    draw_quadrilateral(b, quadrilateral, part);
  }
}

static bent_status begin(brush *b, const bent_star_canvas *canvas, bent_error *error)
{
  if (!(canvas->filter_width >= 0.01 && canvas->filter_width <= 30))
    return bent_fail(error, BENT_ERROR_ARGUMENT, "stars: filter_width must lie in [0.01, 30] pixels, got %g",
                     canvas->filter_width);
  b->canvas = canvas;
  b->sums = calloc((size_t)canvas->tile[2] * canvas->tile[3] + 1, sizeof *b->sums);
  if (!b->sums) return bent_fail(error, BENT_ERROR_MEMORY, "stars: out of memory");
  filter_init(&b->filter, canvas->filter, canvas->filter_width);
  return BENT_OK;
}

static void finish(brush *b)
{
  const size_t size = (size_t)b->canvas->tile[2] * b->canvas->tile[3];
  for (size_t i = 0; i < size; i++)
    for (int k = 0; k < 3; k++) b->canvas->pixels[i][k] += (float)b->sums[i][k];
  free(b->sums);
}

/* Light over the whole picture, of one pixel. */
static void gather(const bent_star_canvas *c, const double light[3], double out[3])
{
  for (int k = 0; k < 3; k++) out[k] = light[k] * ((double)c->width * c->height);
}

bent_status bent_stars_draw(const bent_star_canvas *canvas, size_t n, const double (*places)[2], const double (*light)[3],
                            bent_error *error)
{
  brush b;
  const bent_status status = begin(&b, canvas, error);
  if (status) return status;
  const double reach = b.filter.half_width + 1;
  const uint32_t *tile = canvas->tile;
  for (size_t i = 0; i < n; i++) {
    const double x = places[i][0] * canvas->width, y = places[i][1] * canvas->height;
    if (!(x > tile[0] - reach && x < (double)tile[0] + tile[2] + reach && y > tile[1] - reach &&
          y < (double)tile[1] + tile[3] + reach))
      continue;
    double gathered[3];
    gather(canvas, light[i], gathered);
    draw_point(&b, x, y, gathered);
  }
  finish(&b);
  return BENT_OK;
}

bent_status bent_stars_draw_blurred(const bent_star_canvas *canvas, size_t n, const double (*places)[2],
                                    const double (*light)[3], const double (*parallax)[2][2], const uint32_t cells[2],
                                    const double (*corners)[2], const uint8_t (*seen)[3], bent_error *error)
{
  brush b;
  const bent_status status = begin(&b, canvas, error);
  if (status) return status;
  const double size[2] = {canvas->width, canvas->height};
  for (size_t i = 0; i < n; i++) {
    double at[2], shift[2][2], gathered[3];
    for (int k = 0; k < 2; k++) {
      at[k] = places[i][k] * size[k];
      for (int axis = 0; axis < 2; axis++) shift[k][axis] = parallax[i][k][axis] * size[k];
    }
    gather(canvas, light[i], gathered);
    draw_blurred(&b, at, gathered, shift, cells, corners, seen + i * cells[0] * cells[1]);
  }
  finish(&b);
  return BENT_OK;
}
