/* Owen-scrambled Sobol points: the random numbers of a path, as a pure function of (seed, pixel, sample, set).
 *
 * A path needs more dimensions than Sobol points are good in, so they are padded: each set of four dimensions is the
 * 4D Sobol sequence with its own index shuffle and its own nested uniform scrambles. The first 2^k samples of a pixel
 * are then a scrambled net in every set, and sets (and pixels) are independent of each other.
 * Sources: Joe & Kuo 2008 (direction numbers); Burley 2020, "Practical Hash-based Owen Scrambling", JCGT 9(4).
 */
#ifndef BENT_RENDER_SAMPLER_H
#define BENT_RENDER_SAMPLER_H
#include <stdint.h>

enum { SAMPLER_DIMENSIONS = 4 };

/* XOR of the direction numbers, bits reversed, for each value of each of the index's eight nibbles. */
typedef struct sampler {
  uint32_t nibble[8][16][SAMPLER_DIMENSIONS];
} sampler;

void sampler_init(sampler *sampler);
/* The key of a pixel's samples; x and y count from the image's bottom left. */
uint32_t sampler_pixel_key(uint32_t seed, uint32_t x, uint32_t y);
/* Four numbers in [0, 1), multiples of 2^-32. */
void sampler_draw(const sampler *sampler, uint32_t pixel_key, uint32_t sample, uint32_t set,
                  double u[SAMPLER_DIMENSIONS]);
#endif
