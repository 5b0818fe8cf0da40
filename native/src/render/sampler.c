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

/* Direction numbers of dimension d, bits reversed: `reversed[i]` belongs to bit i of the index. */
static void direction_numbers(int d, uint32_t reversed[32])
{
  /* Degree and inner coefficients of the primitive polynomial, and the initial odd m_i (Joe & Kuo 2008). */
  static const struct {
    int degree;
    uint32_t coefficients, m[3];
  } table[SAMPLER_DIMENSIONS] = {{0, 0, {0}}, {1, 0, {1}}, {2, 1, {1, 3}}, {3, 1, {1, 3, 1}}};
  const int degree = table[d].degree;
  uint32_t v[32];
  for (int i = 0; i < 32; i++) {
    if (degree == 0) { /* van der Corput */
      v[i] = 1u << (31 - i);
    } else if (i < degree) {
      v[i] = table[d].m[i] << (31 - i);
    } else {
      v[i] = v[i - degree] ^ v[i - degree] >> degree;
      for (int k = 1; k < degree; k++)
        if (table[d].coefficients >> (degree - 1 - k) & 1) v[i] ^= v[i - k];
    }
  }
  for (int i = 0; i < 32; i++) reversed[i] = reverse_bits(v[i]);
}

void sampler_init(sampler *s)
{
  memset(s, 0, sizeof *s);
  for (int d = 0; d < SAMPLER_DIMENSIONS; d++) {
    uint32_t direction[32];
    direction_numbers(d, direction);
    for (int position = 0; position < 8; position++)
      for (int value = 0; value < 16; value++)
        for (int bit = 0; bit < 4; bit++)
          if (value >> bit & 1) s->nibble[position][value][d] ^= direction[4 * position + bit];
  }
}

uint32_t sampler_pixel_key(uint32_t seed, uint32_t x, uint32_t y)
{
  return mix(y + mix(x + mix(seed + 0x9e3779b9u)));
}

void sampler_draw(const sampler *s, uint32_t pixel_key, uint32_t sample, uint32_t set, double u[SAMPLER_DIMENSIONS])
{
  const uint32_t key = mix(pixel_key + mix(set + 0x85ebca6bu));
  const uint32_t index = reverse_bits(scramble_reversed(reverse_bits(sample), mix(key)));
  uint32_t value[SAMPLER_DIMENSIONS] = {0};
  for (int position = 0; position < 8; position++)
    for (int d = 0; d < SAMPLER_DIMENSIONS; d++) value[d] ^= s->nibble[position][index >> (4 * position) & 15][d];
  for (uint32_t d = 0; d < SAMPLER_DIMENSIONS; d++)
    u[d] = reverse_bits(scramble_reversed(value[d], mix(key + (d + 1) * 0x9e3779b9u))) * 0x1p-32;
}
