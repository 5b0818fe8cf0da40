/* See film.h. */
#include "render/film.h"

#include <math.h>
#include <string.h>

void film_clear(film *film) { memset(film, 0, sizeof *film); }

void film_add(film *film, uint32_t pixel, const sample_record *record)
{
  size_t count;
  const bent_channel *table = bent_render_channels(&count);
  const uint32_t taken = film->taken[pixel]++;
  for (size_t c = 0; c < count; c++) {
    for (int k = 0; k < table[c].components; k++) {
      double *sum = &film->sums[pixel][c][k];
      const double value = record->value[c][k];
      switch (table[c].reduction) {
        case BENT_MEAN: *sum += value; break;
        case BENT_MAX: *sum = fmax(*sum, value); break;
        case BENT_FIRST: *sum = taken ? *sum : value; break;
        case BENT_COUNT: *sum = taken + 1; break;
      }
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
