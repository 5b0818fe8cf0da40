/* See sky_levels.h. A lookup between texels of width s has the standard deviation s / 2, averaged over places: its square is
 * 1/12 of s^2 for the texel itself and 1/6 for the interpolation. A box of the width sqrt(3 (b^2 - s^2)) besides makes it
 * b / 2. Filters are named by the width of such a texel. */
#include "scene/sky_levels.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { LEVELS_MAX = 16, LEAST_ROWS = 4 };
/* Of a lookup. Ellipses longer than this allows for their width are made wider. */
enum { PROBES_MAX = 32 };
static const double LONGEST = M_PI_2; /* radians */

typedef struct level {
  size_t width, height;
  float (*pixels)[4];
} level;

struct sky_levels {
  int count; /* of levels 1, 2, ... in list[0], list[1], ... */
  level list[LEVELS_MAX];
};

/* The width of the box that makes a filter of width `have` one of width `wanted`. */
static double box_between(double have, double wanted) { return sqrt(3 * fmax(wanted * wanted - have * have, 0)); }

/* ---- Making ---- */

/* Row y of the image, linear. */
static void read_row(const image *image, size_t y, float (*out)[4])
{
  if (image->pixels) {
    memcpy(out, image->pixels + y * image->width, image->width * sizeof *out);
    return;
  }
  for (size_t x = 0; x < image->width; x++) {
    const texel t = image_texel(image, x, y);
    for (int k = 0; k < 3; k++) out[x][k] = (float)t.color[k];
    out[x][3] = (float)t.alpha;
  }
}

/* Solid angle of the band between two heights of an image, each in [0, 1], over 2 pi. */
static double band(double below, double above) { return cos(M_PI * below) - cos(M_PI * above); }

/* Adds a fine row of `width` texels, by area, to a coarse one. */
static void add_row(const float (*fine)[4], size_t width, double weight, double (*coarse)[4], size_t coarse_width)
{
  const double ratio = (double)width / coarse_width;
  for (size_t x = 0; x < coarse_width; x++) {
    const double from = x * ratio, to = fmin((x + 1) * ratio, width);
    for (size_t i = (size_t)from; i < to; i++) {
      const double part = weight * (fmin(to, i + 1) - fmax(from, i)) / ratio;
      for (int k = 0; k < 4; k++) coarse[x][k] += part * fine[i][k];
    }
  }
}

/* Half the size, by the means over texels' solid angles. The finer one is a level, or the image itself. rows: room for a row of
 * each. */
static void halve(const image *image, const level *fine, const level *coarse, float (*row)[4], double (*sum)[4])
{
  const size_t height = fine ? fine->height : image->height, width = fine ? fine->width : image->width;
  for (size_t y = 0; y < coarse->height; y++) {
    const double below = (double)y / coarse->height, above = (double)(y + 1) / coarse->height, whole = band(below, above);
    memset(sum, 0, coarse->width * sizeof *sum);
    for (size_t i = (size_t)(below * height); i < height && i < above * height; i++) {
      const double part = band(fmax(below, (double)i / height), fmin(above, (double)(i + 1) / height)) / whole;
      if (!(part > 0)) continue;
      if (!fine) read_row(image, i, row);
      add_row(fine ? (const float(*)[4])fine->pixels + i * width : (const float(*)[4])row, width, part, sum, coarse->width);
    }
    for (size_t x = 0; x < coarse->width; x++)
      for (int k = 0; k < 4; k++) coarse->pixels[y * coarse->width + x][k] = (float)sum[x][k];
  }
}

/* The integral of a row, which goes on around the sphere, from its left edge to `place`; sums: those up to each texel. */
static double integral(const float (*row)[4], const double (*sums)[4], size_t width, double place, int k)
{
  const double turns = floor(place / width), within = place - turns * width;
  const size_t i = within < width - 1 ? (size_t)within : width - 1;
  return turns * sums[width][k] + sums[i][k] + (within - i) * row[i][k];
}

/* Copies a level with its rows made as wide as they are high. sums: room for a row and one more. */
static void widen(const level *from, const level *to, double (*sums)[4])
{
  const double rows_per_column = 2.0 * from->height / from->width;
  for (size_t y = 0; y < from->height; y++) {
    const float(*row)[4] = (const float(*)[4])from->pixels + y * from->width;
    float(*out)[4] = to->pixels + y * from->width;
    const double texels = 1 / (rows_per_column * sin(M_PI * (y + 0.5) / from->height));
    const double box = fmin(box_between(1, texels), from->width);
    if (!(box > 1)) { /* it stays within a texel */
      memcpy(out, row, from->width * sizeof *out);
      continue;
    }
    memset(sums, 0, sizeof *sums);
    for (size_t x = 0; x < from->width; x++)
      for (int k = 0; k < 4; k++) sums[x + 1][k] = sums[x][k] + row[x][k];
    for (size_t x = 0; x < from->width; x++)
      for (int k = 0; k < 4; k++)
        out[x][k] = (float)((integral(row, (const double(*)[4])sums, from->width, x + 0.5 + box / 2, k) -
                             integral(row, (const double(*)[4])sums, from->width, x + 0.5 - box / 2, k)) / box);
  }
}

static int level_make(level *l, size_t width, size_t height)
{
  *l = (level){width, height, malloc(width * height * sizeof *l->pixels)};
  return l->pixels != NULL;
}

bent_status sky_levels_new(const image *image, struct sky_levels **out, bent_error *error)
{
  struct sky_levels *s = calloc(1, sizeof *s);
  float(*row)[4] = malloc(image->width * sizeof *row);
  double(*sums)[4] = malloc((image->width + 1) * sizeof *sums);
  level fine = {image->width, image->height, NULL}, coarse = fine;
  int ok = s && row && sums;
  while (ok && s->count < LEVELS_MAX && fine.height > LEAST_ROWS) {
    const size_t width = (fine.width + 1) / 2, height = (fine.height + 1) / 2;
    ok = level_make(&coarse, width, height) && level_make(&s->list[s->count], width, height);
    if (!ok) break;
    halve(image, fine.pixels ? &fine : NULL, &coarse, row, sums);
    widen(&coarse, &s->list[s->count++], sums);
    free(fine.pixels);
    fine = coarse;
    coarse.pixels = NULL;
  }
  free(fine.pixels);
  free(coarse.pixels);
  free(row);
  free(sums);
  *out = s;
  if (ok) return BENT_OK;
  sky_levels_free(s);
  *out = NULL;
  return bent_fail(error, BENT_ERROR_MEMORY, "image: out of memory for the levels of %zu x %zu pixels", image->width,
                   image->height);
}

void sky_levels_free(struct sky_levels *levels)
{
  for (int i = 0; levels && i < LEVELS_MAX; i++) free(levels->list[i].pixels);
  free(levels);
}

/* ---- Looking up ---- */

void sky_place(vec3 direction, double *u, double *v)
{
  const vec3 d = v3_normalize(direction);
  *u = 0.5 - atan2(d.y, d.x) / (2 * M_PI);
  *v = atan2(d.z, v2_length(d.x, d.y)) / M_PI + 0.5;
}

/* Adds weight times a level, linearly between texels: around the sphere, and up to the poles. */
static void add_level(const level *l, double u, double v, double weight, double sum[4])
{
  const double x = u * l->width - 0.5, y = fmin(fmax(v * l->height - 0.5, 0), l->height - 1);
  const double column = floor(x);
  const size_t left = (size_t)(column < 0 ? column + l->width : column) % l->width, right = (left + 1) % l->width;
  const size_t low = (size_t)y, high = low + 1 < l->height ? low + 1 : low;
  const double across = x - column, up = y - low;
  const float *corner[4] = {l->pixels[low * l->width + left], l->pixels[low * l->width + right],
                            l->pixels[high * l->width + left], l->pixels[high * l->width + right]};
  const double part[4] = {(1 - across) * (1 - up), across * (1 - up), (1 - across) * up, across * up};
  for (int i = 0; i < 4; i++)
    for (int k = 0; k < 4; k++) sum[k] += weight * part[i] * corner[i][k];
}

/* What is mixed to a filter between those of two levels: level `fine`, of which 0 is the image, and the next one. */
typedef struct mixture {
  int fine;
  double coarse_part;
} mixture;

/* Of texels of that width, in those of the image: the variances add up to its own. */
static mixture mixture_of(const struct sky_levels *s, double width)
{
  const int fine = (int)log2(width);
  if (fine >= s->count) return (mixture){s->count, 0};
  return (mixture){fine, (pow(width / (1 << fine), 2) - 1) / 3};
}

/* Adds weight times a mixture of levels. */
static void add_probe(const image *image, vec3 direction, mixture m, double weight, interpolation interpolation,
                      double sum[4])
{
  const struct sky_levels *s = image->levels;
  double u, v;
  sky_place(direction, &u, &v);
  const double fine_weight = weight * (1 - m.coarse_part);
  if (m.fine > 0) {
    add_level(&s->list[m.fine - 1], u, v, fine_weight, sum);
  } else if (image->pixels && interpolation == INTERPOLATE_LINEAR) { /* the quicker way */
    add_level(&(level){image->width, image->height, image->pixels}, u, v, fine_weight, sum);
  } else {
    const texel t = image_lookup(image, u, v, interpolation, EXTEND_REPEAT, 0);
    for (int k = 0; k < 3; k++) sum[k] += fine_weight * t.color[k];
    sum[3] += fine_weight * t.alpha;
  }
  if (m.coarse_part > 0) add_level(&s->list[m.fine], u, v, weight * m.coarse_part, sum);
}

/* The axes of an ellipse that is given by two conjugate radii: its long one, and the length of the other. */
static vec3 long_axis(vec3 a, vec3 b, double *shorter)
{
  const double aa = v3_dot(a, a), bb = v3_dot(b, b), ab = v3_dot(a, b), turn = 0.5 * atan2(2 * ab, aa - bb);
  *shorter = v3_length(v3_mad(a, -sin(turn), v3_scale(b, cos(turn))));
  return v3_mad(a, cos(turn), v3_scale(b, sin(turn)));
}

/* The part of a vector that turns the unit vector d. */
static vec3 tangential(vec3 v, vec3 d) { return v3_mad(d, -v3_dot(v, d), v); }

texel sky_lookup(const image *image, vec3 direction, const vec3 across[2], interpolation interpolation)
{
  const vec3 d = v3_normalize(direction);
  const double texel_height = M_PI / image->height;
  double length = 0, width = 0, sum[4] = {0};
  vec3 axis = v3(0, 0, 0);
  if (image->levels && image->levels->count) {
    axis = long_axis(tangential(across[0], d), tangential(across[1], d), &width);
    length = 2 * v3_length(axis), width *= 2;
  }
  if (!(length > texel_height) || !v3_is_finite(axis)) {
    double u, v;
    sky_place(d, &u, &v);
    return image_lookup(image, u, v, interpolation, EXTEND_REPEAT, 0);
  }
  axis = v3_normalize(axis);
  length = fmin(length, LONGEST);
  width = fmax(fmax(width, texel_height), length * sqrt(3.0 / (PROBES_MAX * PROBES_MAX + 3)));
  width = fmin(width, length);
  const mixture mixture = mixture_of(image->levels, width / texel_height);
  const double box = box_between(width, length);
  const int probes = box > 0 ? (int)fmin(ceil(box / width), PROBES_MAX) : 1;
  for (int i = 0; i < probes; i++) {
    const double angle = ((i + 0.5) / probes - 0.5) * box;
    add_probe(image, v3_mad(axis, sin(angle), v3_scale(d, cos(angle))), mixture, 1.0 / probes, interpolation, sum);
  }
  return (texel){.color = {sum[0], sum[1], sum[2]}, .alpha = sum[3]};
}
