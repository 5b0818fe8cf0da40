/* SIMD lanes: LANES doubles that do the same work side by side. Only *.kernel.c files and their headers include this.
 *
 * The type is a GCC/Clang vector, so + - * / and comparisons are the language's own; a comparison gives a mask that is all
 * ones or all zeros in each lane. As wide as the register of each instruction set: 8 lanes for AVX-512, 4 for AVX2, 2 for
 * SSE and NEON (wider vectors were measured 1.3 to 3 times slower on AVX2 and SSE with GCC 12). A lane's result never depends on its neighbors. NaN and infinity keep their meaning.
 */
#ifndef BENT_BASE_LANES_H
#define BENT_BASE_LANES_H
#include <stddef.h>
#include <stdint.h>

#if defined(__AVX512F__) && defined(__AVX512DQ__)
#include <immintrin.h>
#define LANES 8
#elif defined(__AVX2__)
#include <immintrin.h>
#define LANES 4
#elif defined(__SSE2__)
#include <emmintrin.h>
#define LANES 2
#elif defined(__aarch64__)
#include <arm_neon.h>
#define LANES 2
#else
#error "lanes.h: unknown instruction set"
#endif

typedef double lanes __attribute__((vector_size(LANES * 8)));
typedef int64_t lanes_mask __attribute__((vector_size(LANES * 8)));

#define LANES_INLINE static inline __attribute__((always_inline, unused))

LANES_INLINE lanes lanes_all(double x) { return x - (lanes){0}; }
LANES_INLINE lanes_mask lanes_mask_all(int on) { return (lanes_mask){0} - (int64_t)(on != 0); }
/* mask ? a : b, lane by lane. */
LANES_INLINE lanes lanes_select(lanes_mask mask, lanes a, lanes b)
{
  return (lanes)((mask & (lanes_mask)a) | (~mask & (lanes_mask)b));
}
LANES_INLINE lanes lanes_abs(lanes a) { return (lanes)((lanes_mask)a & INT64_MAX); }
LANES_INLINE lanes lanes_copysign(lanes size, lanes sign)
{
  return (lanes)(((lanes_mask)size & INT64_MAX) | ((lanes_mask)sign & INT64_MIN));
}

/* min, max: where one operand is NaN the result is b. bits: one bit a lane, lane 0 lowest. */
#if LANES == 8
LANES_INLINE lanes lanes_min(lanes a, lanes b) { return (lanes)_mm512_min_pd((__m512d)a, (__m512d)b); }
LANES_INLINE lanes lanes_max(lanes a, lanes b) { return (lanes)_mm512_max_pd((__m512d)a, (__m512d)b); }
LANES_INLINE lanes lanes_sqrt(lanes a) { return (lanes)_mm512_sqrt_pd((__m512d)a); }
LANES_INLINE unsigned lanes_bits(lanes_mask a) { return _mm512_movepi64_mask((__m512i)a); }
#elif LANES == 4
LANES_INLINE lanes lanes_min(lanes a, lanes b) { return (lanes)_mm256_min_pd((__m256d)a, (__m256d)b); }
LANES_INLINE lanes lanes_max(lanes a, lanes b) { return (lanes)_mm256_max_pd((__m256d)a, (__m256d)b); }
LANES_INLINE lanes lanes_sqrt(lanes a) { return (lanes)_mm256_sqrt_pd((__m256d)a); }
LANES_INLINE unsigned lanes_bits(lanes_mask a) { return (unsigned)_mm256_movemask_pd((__m256d)a); }
#elif defined(__SSE2__)
LANES_INLINE lanes lanes_min(lanes a, lanes b) { return (lanes)_mm_min_pd((__m128d)a, (__m128d)b); }
LANES_INLINE lanes lanes_max(lanes a, lanes b) { return (lanes)_mm_max_pd((__m128d)a, (__m128d)b); }
LANES_INLINE lanes lanes_sqrt(lanes a) { return (lanes)_mm_sqrt_pd((__m128d)a); }
LANES_INLINE unsigned lanes_bits(lanes_mask a) { return (unsigned)_mm_movemask_pd((__m128d)a); }
#else
LANES_INLINE lanes lanes_min(lanes a, lanes b) { return lanes_select(a < b, a, b); }
LANES_INLINE lanes lanes_max(lanes a, lanes b) { return lanes_select(a > b, a, b); }
LANES_INLINE lanes lanes_sqrt(lanes a) { return (lanes)vsqrtq_f64((float64x2_t)a); }
LANES_INLINE unsigned lanes_bits(lanes_mask a) { return (a[0] ? 1u : 0) | (a[1] ? 2u : 0); }
#endif

enum { LANES_EVERY = (1 << LANES) - 1 };
LANES_INLINE int lanes_any(lanes_mask a) { return lanes_bits(a) != 0; }
LANES_INLINE int lanes_every(lanes_mask a) { return lanes_bits(a) == LANES_EVERY; }
/* The mask with the lanes of the low LANES bits of `bits`. */
LANES_INLINE lanes_mask lanes_mask_from_bits(unsigned bits)
{
  lanes_mask mask = {0};
  for (int i = 0; i < LANES; i++) mask[i] = -(int64_t)(bits >> i & 1);
  return mask;
}
/* True where a is neither NaN nor infinite. */
LANES_INLINE lanes_mask lanes_is_finite(lanes a) { return lanes_abs(a) <= 1.79769313486231570815e308; }

/* Rows first .. first+LANES-1 of an (n, 3) array as three lanes; beyond the end the last row is repeated. With `index`
 * the rows are index[first ..] instead. */
LANES_INLINE void lanes_load_rows(const double (*rows)[3], const uint32_t *index, size_t first, size_t n, lanes out[3])
{
  lanes x = {0}, y = {0}, z = {0};
  for (int i = 0; i < LANES; i++) {
    const size_t at = first + i < n ? first + i : n - 1;
    const double *row = rows[index ? index[at] : at];
    x[i] = row[0], y[i] = row[1], z[i] = row[2];
  }
  out[0] = x, out[1] = y, out[2] = z;
}

LANES_INLINE lanes lanes_dot(const lanes a[3], const lanes b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/* x^power for x > 0 and 0 < power < 1 to 6 %, which is all a step size needs: the exponent and mantissa of a double, read
 * as one fixed-point number, are nearly its base-2 logarithm. */
LANES_INLINE lanes lanes_rough_root(lanes x, double power)
{
  const double two52 = 0x1p52, one = 1023 * 0x1p40; /* the bits of 1.0, shifted down by 12 */
  const lanes logarithm = (lanes)(((lanes_mask)x >> 12) | (lanes_mask)lanes_all(two52)) - two52;
  const lanes scaled = logarithm * power + one * (1 - power);
  return (lanes)(((lanes_mask)(scaled + two52) & 0xfffffffffffffLL) << 12);
}

/* sin and cos for |x| < 1e5, error below 2e-16 absolute: reduction by pi/2 in three parts (Cody & Waite 1980), then
 * Taylor polynomials on [-pi/4, pi/4]. */
LANES_INLINE void lanes_sincos(lanes x, lanes *sine, lanes *cosine)
{
  const double magic = 0x1.8p52; /* adding it rounds to an integer in the low bits */
  const lanes shifted = x * 0.63661977236758134308 + magic, turns = shifted - magic;
  const lanes_mask quadrant = (lanes_mask)shifted;
  lanes r = x - turns * 0x1.921fb544p+0;
  r -= turns * 0x1.0b4611a6p-34;
  r -= turns * 0x1.3198a2e037073p-69;
  const lanes r2 = r * r;
  lanes s = r2 * (1 / 355687428096000.0) - 1 / 1307674368000.0;
  s = s * r2 + 1 / 6227020800.0, s = s * r2 - 1 / 39916800.0, s = s * r2 + 1 / 362880.0;
  s = s * r2 - 1 / 5040.0, s = s * r2 + 1 / 120.0, s = s * r2 - 1 / 6.0;
  s = s * r2 * r + r;
  lanes c = r2 * (1 / 20922789888000.0) - 1 / 87178291200.0;
  c = c * r2 + 1 / 479001600.0, c = c * r2 - 1 / 3628800.0, c = c * r2 + 1 / 40320.0;
  c = c * r2 - 1 / 720.0, c = c * r2 + 1 / 24.0;
  c = 1 - (0.5 * r2 - c * r2 * r2);
  const lanes_mask swap = -(quadrant & 1), negative_sine = (quadrant & 2) << 62, negative_cosine = ((quadrant + 1) & 2) << 62;
  *sine = (lanes)((lanes_mask)lanes_select(swap, c, s) ^ negative_sine);
  *cosine = (lanes)((lanes_mask)lanes_select(swap, s, c) ^ negative_cosine);
}
#endif
