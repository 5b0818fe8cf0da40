/* Owen-scrambled Sobol points: the random numbers of a path, as a pure function of (seed, pixel, sample, set).
 *
 * A path needs more dimensions than Sobol points are good in, so they are padded: each set of four dimensions is a
 * 4D Sobol sequence with its own index shuffle and its own nested uniform scrambles (dimensions.h says what each is for).
 * The first 2^k samples of a pixel are then a scrambled net in every set, and sets are independent of each other.
 *
 * Pixels of the classic pattern are independent of each other, too. In the blue-noise pattern all pixels share their
 * scrambles, and a pixel's points are shifted, digit by digit, by columns that belong to its place in a Z-order of
 * pixels, shuffled for each set: as Ahmed & Wonka 2020 ("Screen-space blue-noise diffusion of Monte Carlo sampling error
 * via hierarchical ordering of pixels") hand one long sequence out to pixels, but good at every number of samples. Seen
 * as polynomials over GF(2), column i of Sobol's matrices stands for X^i, and dimension d for the expansion at the
 * primitive polynomial r_d, its first digits being those modulo r_d, then modulo r_d^2, and so on. The Z-order's j-th
 * pair of bits stands for X^2j / q^(j+1) and X^(2j+1) / q^(j+1), q = X^2 + X + 1. The first 2^a samples of all pixels of
 * an aligned square of 2^b x 2^b then are g / q^b for all g of degree < a + 2b. As q is no r_d, they are as good a net
 * of 2^(a + 2b) points as polynomials of that degree, which are Sobol's points: in the first two dimensions, r = X and
 * X + 1, a net with t = 0. Nearby pixels' errors therefore cancel, whatever a.
 *
 * Sources: Joe & Kuo 2008 (direction numbers); Niederreiter 1988 (nets from polynomials); Burley 2020, "Practical
 * Hash-based Owen Scrambling", JCGT 9(4).
 */
#ifndef BENT_RENDER_SAMPLER_H
#define BENT_RENDER_SAMPLER_H
#include <stdint.h>

#include "bentlight/render.h"

enum { SAMPLER_DIMENSIONS = 4 };

/* XOR of a matrix' columns, bits reversed, for each value of each of the eight nibbles of an index with its bits reversed. */
typedef struct sampler_matrix {
  uint32_t nibble[8][16][SAMPLER_DIMENSIONS];
} sampler_matrix;

typedef struct sampler {
  bent_sampling_pattern pattern;
  sampler_matrix samples, pixels;
} sampler;

/* What the samples of a pixel have in common. */
typedef struct sampler_pixel {
  uint32_t key;
  uint32_t order; /* Z-order, bits reversed */
} sampler_pixel;

void sampler_init(sampler *sampler, bent_sampling_pattern pattern);
/* x and y count from the image's bottom left and are below 2^16. */
sampler_pixel sampler_pixel_at(const sampler *sampler, uint32_t seed, uint32_t x, uint32_t y);
/* Four numbers in [0, 1), multiples of 2^-32. */
void sampler_draw(const sampler *sampler, sampler_pixel pixel, uint32_t sample, uint32_t set,
                  double u[SAMPLER_DIMENSIONS]);
#endif
