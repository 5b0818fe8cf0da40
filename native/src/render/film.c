/* See film.h. */
#include "render/film.h"

#include <math.h>
#include <string.h>

void film_clear(film *film, float *const channels[CHANNEL_COUNT])
{
  memset(film, 0, sizeof *film);
  for (int c = 0; c < CHANNEL_COUNT; c++)
    if (channels[c] || c == CHANNEL_COMBINED) film->gathered[film->count++] = (uint8_t)c;
}

/* Updates the scatter of whole groups' sums at the end of a group (Welford 1962): no digits are lost where it is small. */
static void end_group(double sums[CHANNEL_COUNT][CHANNEL_COMPONENTS_MAX], uint32_t groups)
{
  for (int k = 0; k < 3; k++) {
    double *group = &sums[CHANNEL_NOISE_PARTIAL][k];
    const double before = sums[CHANNEL_COMBINED][k] - *group, n = groups;
    const double deviation = n > 1 ? *group - before / (n - 1) : 0;
    sums[CHANNEL_NOISE_SCATTER][k] += deviation * deviation * (n - 1) / n;
    *group = 0;
  }
}

void film_add(film *film, uint32_t pixel, const sample_record *record)
{
  size_t count;
  const bent_channel *table = bent_render_channels(&count);
  const uint32_t taken = film->taken[pixel]++;
  for (int i = 0; i < film->count; i++) {
    const int c = film->gathered[i];
    for (int k = 0; k < table[c].components; k++) {
      double *sum = &film->sums[pixel][c][k];
      const double value = record->value[c][k];
      switch (table[c].reduction) {
        case BENT_MEAN: *sum += value; break;
        case BENT_MAX: *sum = fmax(*sum, value); break;
        case BENT_FIRST: *sum = taken ? *sum : value; break;
        case BENT_COUNT: *sum = taken + 1; break;
        case BENT_STATE: break;
      }
    }
  }
  for (int k = 0; k < 3; k++) film->sums[pixel][CHANNEL_NOISE_PARTIAL][k] += record->value[CHANNEL_COMBINED][k];
  if ((taken + 1) % FILM_GROUP == 0) end_group(film->sums[pixel], (taken + 1) / FILM_GROUP);
}

/* Cycles compares the mean of all samples with that of every second one, whose mean distance, summed over colors, is
 * sqrt(2/pi) standard errors each. A measure from many groups is steadier: it does not fall to 0 by chance. */
double film_noise(const film *film, uint32_t pixel)
{
  const double(*sums)[CHANNEL_COMPONENTS_MAX] = film->sums[pixel];
  const double n = film->taken[pixel] / FILM_GROUP;
  if (n < 2) return INFINITY;
  double errors = 0, color = 0;
  for (int k = 0; k < 3; k++) {
    errors += sqrt(sums[CHANNEL_NOISE_SCATTER][k] / (n * (n - 1)));
    color += (sums[CHANNEL_COMBINED][k] - sums[CHANNEL_NOISE_PARTIAL][k]) / n;
  }
  return sqrt(2 / M_PI) * (errors / FILM_GROUP) / (1e-4 + sqrt(fmax(color / FILM_GROUP, 0)));
}

void film_read(film *film, float *const channels[CHANNEL_COUNT], size_t first, uint32_t pixels)
{
  size_t count;
  const bent_channel *table = bent_render_channels(&count);
  for (uint32_t i = 0; i < pixels; i++) {
    const float taken = channels[CHANNEL_SAMPLE_COUNT][first + i];
    film->taken[i] = taken > 0 && taken < 0x1p31f ? (uint32_t)taken : 0; /* 0 for NaN too */
  }
  for (size_t c = 0; c < count; c++) {
    if (!channels[c]) continue;
    for (uint32_t i = 0; i < pixels; i++) {
      const double scale = table[c].reduction == BENT_MEAN ? film->taken[i] : 1;
      const float *in = channels[c] + (first + i) * (size_t)table[c].components;
      for (int k = 0; k < table[c].components; k++)
        film->sums[i][c][k] = table[c].reduction == BENT_COUNT ? film->taken[i] : in[k] * scale;
    }
  }
}

void film_write(const film *film, float *const channels[CHANNEL_COUNT], size_t first, uint32_t pixels)
{
  size_t count;
  const bent_channel *table = bent_render_channels(&count);
  for (size_t c = 0; c < count; c++) {
    if (!channels[c]) continue;
    for (uint32_t i = 0; i < pixels; i++) {
      const double scale = table[c].reduction == BENT_MEAN && film->taken[i] ? 1.0 / film->taken[i] : 1;
      float *out = channels[c] + (first + i) * (size_t)table[c].components;
      for (int k = 0; k < table[c].components; k++) out[k] = (float)(film->sums[i][c][k] * scale);
    }
  }
}
