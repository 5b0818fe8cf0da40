/* Image lookup: interpolation and extension as Cycles defines them. */
#include "scene/texture.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "scene/sky_levels.h"

enum { SIDE_MAX = 65536 };

bent_status image_make(image *out, const bent_image *source, bent_error *error)
{
  const size_t width = source->width, height = source->height;
  if (width < 1 || height < 1 || width > SIDE_MAX || height > SIDE_MAX)
    return bent_fail(error, BENT_ERROR_ARGUMENT, "image: size %zu x %zu is not within 1 to %d", width, height, SIDE_MAX);
  if (!source->pixels == !source->bytes)
    return bent_fail(error, BENT_ERROR_ARGUMENT, "image: expected either float or byte pixels");
  const size_t size = width * height * (source->pixels ? sizeof *source->pixels : sizeof *source->bytes);
  void *copy = malloc(size);
  if (!copy) return bent_fail(error, BENT_ERROR_MEMORY, "image: out of memory for %zu x %zu pixels", width, height);
  memcpy(copy, source->pixels ? (const void *)source->pixels : (const void *)source->bytes, size);
  image_free(out);
  *out = (image){.width = width, .height = height, .srgb = source->srgb};
  if (source->pixels) out->pixels = copy;
  else out->bytes = copy;
  return BENT_OK;
}

void image_free(image *image)
{
  free(image->pixels);
  free(image->bytes);
  image->pixels = NULL;
  image->bytes = NULL;
  sky_levels_free(image->levels);
  image->levels = NULL;
}

/* The texel's index along one axis, or -1 where the image is clipped. */
static int64_t wrap(int64_t i, int64_t n, extension extension)
{
  switch (extension) {
    case EXTEND_REPEAT: i %= n; return i < 0 ? i + n : i;
    case EXTEND_EXTEND: return i < 0 ? 0 : i >= n ? n - 1 : i;
    case EXTEND_MIRROR: i = llabs(i + (i < 0)) % (2 * n); return i >= n ? 2 * n - 1 - i : i;
    default: return i < 0 || i >= n ? -1 : i;
  }
}

/* The texels that are blended along one axis. */
typedef struct footprint {
  int count;
  int64_t index[4];
  double weight[4];
} footprint;

static footprint footprint_at(double x, size_t size, interpolation interpolation, extension extension)
{
  const int64_t n = (int64_t)size;
  /* Far coordinates lose their fraction anyway; this keeps the integer part within an integer. */
  double position = fmin(fmax(x * n, -1e15), 1e15) - (interpolation == INTERPOLATE_CLOSEST ? 0 : 0.5);
  const double whole = floor(position), t = position - whole;
  const int64_t i = (int64_t)whole;
  footprint f = {.count = interpolation == INTERPOLATE_CLOSEST ? 1 : interpolation == INTERPOLATE_LINEAR ? 2 : 4};
  if (f.count == 1) {
    f.weight[0] = 1;
  } else if (f.count == 2) {
    f.weight[0] = 1 - t, f.weight[1] = t;
  } else { /* cubic B-spline */
    const double s = 1 - t;
    f.weight[0] = s * s * s / 6, f.weight[1] = 2.0 / 3 - t * t * (2 - t) / 2;
    f.weight[2] = 2.0 / 3 - s * s * (2 - s) / 2, f.weight[3] = t * t * t / 6;
  }
  for (int k = 0; k < f.count; k++) f.index[k] = wrap(i + k - (f.count == 4), n, extension);
  return f;
}

static double srgb_to_linear(double x) { return x <= 0.04045 ? (x > 0 ? x / 12.92 : 0) : pow((x + 0.055) / 1.055, 2.4); }

/* Color and alpha of four numbers as the image holds them. */
static texel decoded(const image *image, const double value[4], int straight_alpha)
{
  texel out = {.alpha = value[3]};
  const double scale = straight_alpha && value[3] != 0 ? 1 / value[3] : 1;
  for (int k = 0; k < 3; k++) out.color[k] = image->srgb ? srgb_to_linear(value[k] * scale) : value[k] * scale;
  return out;
}

texel image_texel(const image *image, size_t x, size_t y)
{
  const size_t at = y * image->width + x;
  double value[4];
  for (int k = 0; k < 4; k++) value[k] = image->pixels ? image->pixels[at][k] : image->bytes[at][k] * (1.0 / 255);
  return decoded(image, value, 0);
}

texel image_lookup(const image *image, double u, double v, interpolation interpolation, extension extension,
                   int straight_alpha)
{
  double sum[4] = {0};
  if (isfinite(u) && isfinite(v)) {
    const footprint columns = footprint_at(u, image->width, interpolation, extension);
    const footprint rows = footprint_at(v, image->height, interpolation, extension);
    for (int r = 0; r < rows.count; r++)
      for (int c = 0; c < columns.count; c++) {
        if (rows.index[r] < 0 || columns.index[c] < 0) continue;
        const size_t at = (size_t)rows.index[r] * image->width + (size_t)columns.index[c];
        const double weight = rows.weight[r] * columns.weight[c];
        for (int k = 0; k < 4; k++)
          sum[k] += weight * (image->pixels ? image->pixels[at][k] : image->bytes[at][k] * (1.0 / 255));
      }
  }
  return decoded(image, sum, straight_alpha);
}
