/* See gabor.h. */
#include "scene/gabor.h"

#include <math.h>

#include "scene/noise.h"

enum { WAVES = 8 }; /* of a cell */
static const float PI = 3.14159265358979323846f;

typedef struct phasor {
  float re, im;
} phasor;

static float dot(int n, const float *a, const float *b)
{
  float sum = 0;
  for (int i = 0; i < n; i++) sum += a[i] * b[i];
  return sum;
}

/* The direction of wave `number` of a cell. */
static void orient(const gabor *g, const float *cell, int number, float out[3])
{
  const float seed = (float)(3 * number);
  if (g->dimensions == 2) {
    const float turn = (noise_hash_floats((float[]){cell[0], cell[1], seed}, 3) - 0.5f) * PI;
    const float angle = g->angle + turn * g->isotropy;
    out[0] = cosf(angle), out[1] = sinf(angle), out[2] = 0;
    return;
  }
  const float *o = g->orientation;
  for (int i = 0; i < 3; i++) out[i] = o[i];
  if (g->isotropy == 0) return;
  const float across = sqrtf(o[0] * o[0] + o[1] * o[1]);
  const float cosine = across > 0 ? o[0] / across : 1;
  float inclination = acosf(fminf(fmaxf(o[2], -1), 1));
  float azimuth = (o[1] < 0 ? -1.0f : 1.0f) * acosf(fminf(fmaxf(cosine, -1), 1));
  inclination += noise_hash_floats((float[]){cell[0], cell[1], cell[2], seed}, 4) * PI * g->isotropy;
  azimuth += noise_hash_floats((float[]){cell[2], cell[0], seed, cell[1]}, 4) * PI * g->isotropy;
  out[0] = sinf(inclination) * cosf(azimuth), out[1] = sinf(inclination) * sinf(azimuth), out[2] = cosf(inclination);
}

/* Where wave `number` is in its cell. */
static void center_of(int n, const float *cell, int number, float out[3])
{
  const float seed = (float)(3 * number + 1), x = cell[0], y = cell[1], z = cell[2];
  if (n == 2) {
    out[0] = noise_hash_floats((float[]){x, y, seed}, 3);
    out[1] = noise_hash_floats((float[]){seed, x, y}, 3);
    return;
  }
  noise_hash_color((noise_point){4, {x, y, z, seed}}, out);
}

static float sign_of(int n, const float *cell, int number)
{
  const float seed = (float)(3 * number + 2);
  const float chance = n == 2 ? noise_hash_floats((float[]){cell[0], cell[1], seed}, 3)
                              : noise_hash_floats((float[]){cell[0], cell[1], cell[2], seed}, 4);
  return chance < 0.5f ? -1 : 1;
}

/* All waves of a cell at a place in it, or beside it. */
static phasor waves_of(const gabor *g, const float *cell, const float *place)
{
  phasor sum = {0, 0};
  for (int k = 0; k < WAVES; k++) {
    float from[3] = {0}, along[3];
    center_of(g->dimensions, cell, k, from);
    for (int i = 0; i < g->dimensions; i++) from[i] = place[i] - from[i];
    const float distance2 = dot(g->dimensions, from, from);
    if (distance2 >= 1) continue;
    orient(g, cell, k, along);
    for (int i = 0; i < g->dimensions; i++) along[i] *= g->frequency;
    const float hill = expf(-PI * distance2) * (0.5f + 0.5f * cosf(PI * distance2)) * sign_of(g->dimensions, cell, k);
    const float angle = 2 * PI * dot(g->dimensions, from, along);
    sum.re += hill * cosf(angle), sum.im += hill * sinf(angle);
  }
  return sum;
}

void gabor_noise(const gabor *g, const float place[3], float out[3])
{
  const int n = g->dimensions;
  float cell[3] = {0}, rest[3] = {0};
  for (int i = 0; i < n; i++) cell[i] = floorf(place[i]), rest[i] = place[i] - cell[i];
  phasor sum = {0, 0};
  for (int z = n == 3 ? -1 : 0; z <= (n == 3); z++)
    for (int y = -1; y <= 1; y++)
      for (int x = -1; x <= 1; x++) {
        const float there[3] = {cell[0] + (float)x, cell[1] + (float)y, cell[2] + (float)z};
        const float from[3] = {rest[0] - (float)x, rest[1] - (float)y, rest[2] - (float)z};
        const phasor waves = waves_of(g, there, from);
        sum.re += waves.re, sum.im += waves.im;
      }
  /* Six deviations of the sum: the integral of a wave squared times the mean square of its sign. */
  const float square = n == 2 ? 0.25f : 0.17677669529663687f, scale = 1 / (6 * sqrtf(WAVES * 0.5f * square));
  out[0] = sum.im * scale * 0.5f + 0.5f;
  out[1] = (atan2f(sum.im, sum.re) + PI) / (2 * PI);
  out[2] = sqrtf(sum.re * sum.re + sum.im * sum.im) * scale;
}
