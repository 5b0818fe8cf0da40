/* See sampler.h. Sobol values are kept with their bits reversed (binary digit 1 in bit 0), because the scramble by
 * hashing lets each bit depend on the lower ones only. */
#include "render/sampler.h"

#include <string.h>

static uint32_t reverse_bits(uint32_t x)
{
  x = __builtin_bswap32(x);
  x = (x & 0x0f0f0f0fu) << 4 | (x >> 4 & 0x0f0f0f0fu);
  x = (x & 0x33333333u) << 2 | (x >> 2 & 0x33333333u);
  return (x & 0x55555555u) << 1 | (x >> 1 & 0x55555555u);
}

/* A 32-bit finalizer with low bias (constants: C. Wellons, "Prospecting for Hash Functions", 2018). */
static uint32_t mix(uint32_t x)
{
  x = (x ^ x >> 16) * 0x7feb352du;
  x = (x ^ x >> 15) * 0x846ca68bu;
  return x ^ x >> 16;
}

/* Flips each bit by a hash of the bits below it and the seed: a nested uniform scramble of the bit-reversed number
 * (Laine & Karras 2011; constants: N. Vegdahl, "Building a Better LK Hash", 2021). */
static uint32_t scramble_reversed(uint32_t x, uint32_t seed)
{
  x ^= x * 0x3d20adeau;
  x += seed;
  x *= (seed >> 16) | 1;
  x ^= x * 0x05526c56u;
  x ^= x * 0x53a22864u;
  return x;
}

/* Digits that are worked with: 32 and one more, so that they are whole groups of a polynomial's degree. And columns: two
 * more, for products with q. */
enum { DIGITS = 33, COLUMNS = DIGITS + 2 };

/* Columns of Sobol's matrix of dimension d: digit k of column i, the coefficients of X^i, is in bit k. */
static void sobol_columns(int d, uint64_t column[COLUMNS])
{
  /* Degree and inner coefficients of the primitive polynomial, and the initial odd m_i (Joe & Kuo 2008). Their third
   * dimension, X^2 + X + 1, is left out: it is q. */
  static const struct {
    int degree;
    uint32_t coefficients, m[3];
  } table[SAMPLER_DIMENSIONS] = {{0, 0, {0}}, {1, 0, {1}}, {3, 1, {1, 3, 1}}, {3, 2, {1, 1, 1}}};
  const int degree = table[d].degree;
  for (int i = 0; i < COLUMNS; i++) {
    column[i] = 0;
    if (degree == 0) { /* van der Corput */
      column[i] = 1ull << i;
    } else if (i < degree) {
      for (int k = 0; k <= i; k++) column[i] |= (uint64_t)(table[d].m[i] >> (i - k) & 1) << k;
    } else {
      column[i] = column[i - degree] ^ column[i - degree] << degree;
      for (int k = 1; k < degree; k++)
        if (table[d].coefficients >> (degree - 1 - k) & 1) column[i] ^= column[i - k];
    }
    column[i] &= (1ull << DIGITS) - 1;
  }
}

/* Columns of the pixels' matrix: X^2j / q^(j+1) and X^(2j+1) / q^(j+1), q = X^2 + X + 1, from those of X^i. */
static void pixel_columns(const uint64_t power[COLUMNS], uint64_t column[32])
{
  uint64_t row[DIGITS] = {0}, powers[DIGITS] = {0}; /* combinations of the q X^i whose first digit is k, and of which i */
  for (int i = 0; i < DIGITS; i++) {
    uint64_t value = power[i] ^ power[i + 1] ^ power[i + 2], of = 1ull << i;
    for (int k = 0; k < DIGITS; k++) {
      if (!(value >> k & 1)) continue;
      if (!row[k]) {
        row[k] = value, powers[k] = of;
        break;
      }
      value ^= row[k], of ^= powers[k];
    }
  }
  uint64_t rest = power[0]; /* X^2j / q^j */
  for (int j = 0; j < 32; j += 2) {
    uint64_t quotient = 0; /* the powers of X that make up rest / q */
    for (int k = 0; k < DIGITS; k++)
      if (rest >> k & 1) rest ^= row[k], quotient ^= powers[k];
    column[j] = column[j + 1] = rest = 0;
    for (int i = 0; i < DIGITS; i++)
      if (quotient >> i & 1) column[j] ^= power[i], column[j + 1] ^= power[i + 1], rest ^= power[i + 2];
  }
}

static void set_columns(sampler_matrix *m, int d, const uint64_t column[32])
{
  for (int position = 0; position < 8; position++)
    for (int value = 0; value < 16; value++)
      for (int bit = 0; bit < 4; bit++)
        if (value >> bit & 1) m->nibble[position][value][d] ^= (uint32_t)column[31 - (4 * position + bit)];
}

void sampler_init(sampler *s, bent_sampling_pattern pattern)
{
  memset(s, 0, sizeof *s);
  s->pattern = pattern;
  for (int d = 0; d < SAMPLER_DIMENSIONS; d++) {
    uint64_t samples[COLUMNS], pixels[32];
    sobol_columns(d, samples);
    set_columns(&s->samples, d, samples);
    if (pattern != BENT_PATTERN_BLUE_NOISE) continue;
    pixel_columns(samples, pixels);
    set_columns(&s->pixels, d, pixels);
  }
}

/* Puts a 0 before each of the lower 16 bits. */
static uint32_t spread_bits(uint32_t x)
{
  x = (x | x << 8) & 0x00ff00ffu;
  x = (x | x << 4) & 0x0f0f0f0fu;
  x = (x | x << 2) & 0x33333333u;
  return (x | x << 1) & 0x55555555u;
}

sampler_pixel sampler_pixel_at(const sampler *s, uint32_t seed, uint32_t x, uint32_t y)
{
  const uint32_t key = mix(seed + 0x9e3779b9u);
  if (s->pattern == BENT_PATTERN_BLUE_NOISE) return (sampler_pixel){key, reverse_bits(spread_bits(x) | spread_bits(y) << 1)};
  return (sampler_pixel){mix(y + mix(x + key)), 0};
}

/* Adds the columns of an index, bits reversed, after a shuffle that keeps aligned blocks of 2^k indices together. */
static void add_columns(const sampler_matrix *m, uint32_t index, uint32_t seed, uint32_t value[SAMPLER_DIMENSIONS])
{
  index = scramble_reversed(index, seed);
  for (int position = 0; position < 8; position++)
    for (int d = 0; d < SAMPLER_DIMENSIONS; d++) value[d] ^= m->nibble[position][index >> (4 * position) & 15][d];
}

void sampler_draw(const sampler *s, sampler_pixel pixel, uint32_t sample, uint32_t set, double u[SAMPLER_DIMENSIONS])
{
  const uint32_t key = mix(pixel.key + mix(set + 0x85ebca6bu));
  uint32_t value[SAMPLER_DIMENSIONS] = {0};
  add_columns(&s->samples, reverse_bits(sample), mix(key), value);
  if (s->pattern == BENT_PATTERN_BLUE_NOISE) add_columns(&s->pixels, pixel.order, mix(key + 0x68e31da4u), value);
  for (uint32_t d = 0; d < SAMPLER_DIMENSIONS; d++)
    u[d] = reverse_bits(scramble_reversed(value[d], mix(key + (d + 1) * 0x9e3779b9u))) * 0x1p-32;
}
