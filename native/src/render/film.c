/* See film.h.
 *
 * A pixel's sums for means do not depend, to the last bit, on the order in which samples come, nor on how they are grouped:
 * each value is rounded to a multiple of 2^-44, and what of it is a multiple of 2^-12 is summed apart from the rest. Such
 * sums are exact in double precision, and so associative, while those of the values' magnitudes stay below 2^41 and there
 * are fewer than 2^21 samples; beyond that they are rounded as all sums are. */
#include "render/film.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Where a pixel's numbers are that every film has: of its samples, the first one's, its color; and what noise is told from. */
enum { TAKEN = 0, SINCE = 1, COLOR = 2, PARTIAL = COLOR + 2 * 4, SCATTER = PARTIAL + 3 };

static void sum_add(double sum[2], double value)
{
  const double coarse = rint(value * 0x1p12) * 0x1p-12;
  sum[0] += coarse;
  sum[1] += rint((value - coarse) * 0x1p44) * 0x1p-44;
}

static double sum_value(const double sum[2]) { return sum[0] + sum[1]; }

/* ---- Mattes: for each rank a name, and its coverage as such a sum ---- */

enum { RANK = 3 };

/* The sum of a name's coverage; NULL for one that finds no room. */
static double *matte_sum(double *ranks, uint32_t count, double name)
{
  for (uint32_t i = 0; i < count; i++) {
    double *rank = ranks + RANK * i;
    if (sum_value(&rank[1]) > 0 && rank[0] != name) continue;
    rank[0] = name;
    return &rank[1];
  }
  return NULL;
}

static void matte_sum_add(double *ranks, uint32_t count, double name, double coverage)
{
  double *sum = matte_sum(ranks, count, name);
  if (sum) sum_add(sum, coverage);
}

static void matte_merge(double *ranks, const double *others, uint32_t count)
{
  for (const double *other = others; other < others + RANK * count && sum_value(&other[1]) > 0; other += RANK) {
    double *sum = matte_sum(ranks, count, other[0]);
    if (sum) sum[0] += other[1], sum[1] += other[2];
  }
}

/* As pairs of name and coverage, the largest first; of equal ones by name, so that the order in which they came does not
 * matter. There are few. */
static void matte_develop(const double *ranks, uint32_t count, double scale, float *pairs)
{
  for (uint32_t i = 0; i < count; i++) {
    const float name = (float)ranks[RANK * i], coverage = (float)(sum_value(&ranks[RANK * i + 1]) * scale);
    uint32_t at = i;
    for (; at > 0; at--) {
      const float *before = &pairs[2 * at - 2];
      if (before[1] > coverage || (before[1] == coverage && before[0] >= name)) break;
      pairs[2 * at] = before[0], pairs[2 * at + 1] = before[1];
    }
    pairs[2 * at] = name, pairs[2 * at + 1] = coverage;
  }
}

/* ---- Layout ---- */

/* How many numbers of a pixel an entry takes. */
static uint32_t entry_length(const film_entry *e)
{
  return e->reduction == BENT_MEAN ? 2 * e->components : e->reduction == BENT_MATTE ? RANK * (e->components / 2) : e->components;
}

static void add_entry(film_layout *layout, channel channel, const bent_render_settings *settings)
{
  size_t count;
  film_entry *e = &layout->entries[layout->count++];
  *e = (film_entry){channel, bent_render_channels(&count)[channel].reduction, layout->width, channel_width(channel, settings)};
  layout->width += entry_length(e);
}

film_layout film_layout_of(const uint8_t wanted[CHANNEL_COUNT], const bent_render_settings *settings)
{
  film_layout layout = {.width = COLOR};
  layout.tells_noise = settings->noise_threshold > 0 || wanted[CHANNEL_NOISE_PARTIAL] || wanted[CHANNEL_NOISE_SCATTER];
  add_entry(&layout, CHANNEL_COMBINED, settings);
  if (layout.tells_noise) {
    add_entry(&layout, CHANNEL_NOISE_PARTIAL, settings);
    add_entry(&layout, CHANNEL_NOISE_SCATTER, settings);
  }
  for (int c = CHANNEL_COMBINED + 1; c < CHANNEL_COUNT; c++)
    if (wanted[c] && c != CHANNEL_NOISE_PARTIAL && c != CHANNEL_NOISE_SCATTER) add_entry(&layout, (channel)c, settings);
  return layout;
}

film *film_new(const film_layout *layout, const channel_layout *records)
{
  film *f = calloc(1, sizeof *f);
  if (!f) return NULL;
  f->layout = *layout;
  f->records = records;
  f->own = malloc((size_t)FILM_PIXELS * layout->width * sizeof *f->own);
  if (f->own) return f;
  free(f);
  return NULL;
}

void film_free(film *film)
{
  if (film) free(film->own);
  free(film);
}

void film_begin(film *film, double *state, uint32_t pixels, uint32_t first_sample)
{
  film->sums = state ? state : film->own;
  memset(film->taken, 0, sizeof film->taken);
  memset(film->sums, 0, (size_t)pixels * film->layout.width * sizeof *film->sums);
  for (uint32_t i = 0; i < pixels; i++) film->sums[i * (size_t)film->layout.width + SINCE] = first_sample;
}

/* A number of samples as arrays have it; 0 for what is none, NaN too. */
static uint32_t count_of(double taken) { return taken > 0 && taken < 0x1p31 ? (uint32_t)taken : 0; }

void film_resume(film *film, double *state, uint32_t pixels)
{
  film->sums = state;
  for (uint32_t i = 0; i < pixels; i++) film->taken[i] = count_of(state[i * (size_t)film->layout.width + TAKEN]);
}

uint32_t film_first_sample(const double *state) { return count_of(state[SINCE]); }

/* ---- Samples ---- */

/* Updates the scatter of whole groups' sums at the end of a group (Welford 1962): no digits are lost where it is small. */
static void end_group(double *sums, uint32_t groups)
{
  for (int k = 0; k < 3; k++) {
    double *group = &sums[PARTIAL + k];
    const double before = sum_value(&sums[COLOR + 2 * k]) - *group, n = groups;
    const double deviation = n > 1 ? *group - before / (n - 1) : 0;
    sums[SCATTER + k] += deviation * deviation * (n - 1) / n;
    *group = 0;
  }
}

void film_add(film *film, uint32_t pixel, const sample_record *record, uint32_t part, uint32_t parts)
{
  double *sums = film->sums + pixel * (size_t)film->layout.width;
  const uint32_t taken = film->taken[pixel];
  const double share = 1.0 / parts;
  for (int i = 0; i < film->layout.count; i++) {
    const film_entry *e = &film->layout.entries[i];
    double *at = sums + e->offset;
    const float *values = record_values(record, film->records, e->channel);
    for (uint32_t k = 0; k < e->components; k++) {
      const double value = values[k];
      switch (e->reduction) {
        case BENT_MEAN: sum_add(&at[2 * k], value * share); break;
        case BENT_MAX: at[k] = fmax(at[k], value); break;
        case BENT_FIRST: at[k] = taken || part ? at[k] : value; break;
        case BENT_COUNT: at[k] += 1; break;
        case BENT_MATTE:
          if (k % 2 && value > 0) matte_sum_add(at, e->components / 2, values[k - 1], value * share);
          break;
        case BENT_STATE: break;
      }
    }
  }
  const int is_whole = part + 1 == parts;
  film->taken[pixel] += is_whole;
  if (!film->layout.tells_noise) return;
  for (int k = 0; k < 3; k++) sums[PARTIAL + k] += record->value[CHANNEL_COMBINED][k] * share;
  if (is_whole && (taken + 1) % FILM_GROUP == 0) end_group(sums, (taken + 1) / FILM_GROUP);
}

/* Cycles compares the mean of all samples with that of every second one, whose mean distance, summed over colors, is
 * sqrt(2/pi) standard errors each. A measure from many groups is steadier: it does not fall to 0 by chance. */
double film_noise(const film *film, uint32_t pixel)
{
  const double *sums = film->sums + pixel * (size_t)film->layout.width;
  const double n = film->taken[pixel] / FILM_GROUP;
  if (n < 2) return INFINITY;
  double errors = 0, color = 0;
  for (int k = 0; k < 3; k++) {
    errors += sqrt(sums[SCATTER + k] / (n * (n - 1)));
    color += (sum_value(&sums[COLOR + 2 * k]) - sums[PARTIAL + k]) / n;
  }
  return sqrt(2 / M_PI) * (errors / FILM_GROUP) / (1e-4 + sqrt(fmax(color / FILM_GROUP, 0)));
}

/* ---- Channels ---- */

void film_read(film *film, float *const channels[CHANNEL_COUNT], size_t first, uint32_t pixels, const uint8_t *parts)
{
  for (uint32_t i = 0; i < pixels; i++) film->taken[i] = count_of(channels[CHANNEL_SAMPLE_COUNT][first + i]) / parts[i];
  for (int n = 0; n < film->layout.count; n++) {
    const film_entry *e = &film->layout.entries[n];
    for (uint32_t i = 0; channels[e->channel] && i < pixels; i++) {
      const float *in = channels[e->channel] + (first + i) * e->components;
      double *at = film->sums + i * (size_t)film->layout.width + e->offset;
      for (uint32_t k = 0; k < e->components; k++) {
        switch (e->reduction) {
          case BENT_MEAN: sum_add(&at[2 * k], (double)in[k] * film->taken[i]); break;
          case BENT_COUNT: at[k] = (double)film->taken[i] * parts[i]; break;
          case BENT_MATTE:
            if (k % 2) matte_sum_add(at, e->components / 2, in[k - 1], (double)in[k] * film->taken[i]);
            break;
          default: at[k] = in[k]; break;
        }
      }
    }
  }
}

/* Writes what one pixel's sums stand for into the arrays' pixel number `index`. */
static void develop(const film_layout *layout, const double *sums, float *const channels[CHANNEL_COUNT], size_t index)
{
  const double scale = sums[TAKEN] > 0 ? 1 / sums[TAKEN] : 1;
  for (int n = 0; n < layout->count; n++) {
    const film_entry *e = &layout->entries[n];
    const double *at = sums + e->offset;
    if (!channels[e->channel]) continue;
    float *out = channels[e->channel] + index * e->components;
    if (e->reduction == BENT_MATTE) matte_develop(at, e->components / 2, scale, out);
    else for (uint32_t k = 0; k < e->components; k++)
      out[k] = (float)(e->reduction == BENT_MEAN ? sum_value(&at[2 * k]) * scale : at[k]);
  }
}

void film_write(film *film, float *const channels[CHANNEL_COUNT], size_t first, uint32_t pixels)
{
  for (uint32_t i = 0; i < pixels; i++) {
    double *sums = film->sums + i * (size_t)film->layout.width;
    sums[TAKEN] = film->taken[i];
    develop(&film->layout, sums, channels, first + i);
  }
}

/* ---- States ---- */

/* Adds to a pixel's sums those of other samples. */
static void merge(const film_layout *layout, double *sums, const double *other)
{
  if (!(other[TAKEN] > 0)) return;
  if (!(sums[TAKEN] > 0)) {
    memcpy(sums, other, layout->width * sizeof *sums);
    return;
  }
  const int is_earlier = other[SINCE] < sums[SINCE];
  sums[TAKEN] += other[TAKEN];
  sums[SINCE] = fmin(sums[SINCE], other[SINCE]);
  for (int i = 0; i < layout->count; i++) {
    const film_entry *e = &layout->entries[i];
    const uint32_t end = e->offset + entry_length(e);
    if (e->reduction == BENT_MATTE) matte_merge(sums + e->offset, other + e->offset, e->components / 2);
    for (uint32_t k = e->offset; k < end; k++) {
      switch (e->reduction) {
        case BENT_MEAN: case BENT_COUNT: sums[k] += other[k]; break;
        case BENT_MAX: sums[k] = fmax(sums[k], other[k]); break;
        case BENT_FIRST: sums[k] = is_earlier ? other[k] : sums[k]; break;
        case BENT_MATTE: break;
        case BENT_STATE: sums[k] = 0; break; /* of no use to anyone */
      }
    }
  }
}

size_t bent_render_state_width(const bent_render_settings *settings, const uint8_t wanted[BENT_CHANNELS_MAX])
{
  return film_layout_of(wanted, settings).width;
}

void bent_render_state_merge(const bent_render_settings *settings, const uint8_t wanted[BENT_CHANNELS_MAX], size_t pixels,
                             double *state, const double *other)
{
  const film_layout layout = film_layout_of(wanted, settings);
  for (size_t i = 0; i < pixels; i++) merge(&layout, state + i * layout.width, other + i * layout.width);
}

void bent_render_state_develop(const bent_render_settings *settings, size_t pixels, const double *state,
                               float *const channels[BENT_CHANNELS_MAX])
{
  uint8_t wanted[BENT_CHANNELS_MAX] = {0};
  for (int c = 0; c < CHANNEL_COUNT; c++) wanted[c] = channels[c] != NULL;
  const film_layout layout = film_layout_of(wanted, settings);
  for (size_t i = 0; i < pixels; i++) develop(&layout, state + i * layout.width, channels, i);
}
