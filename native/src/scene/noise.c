/* See noise.h. */
#include "scene/noise.h"

#include <math.h>
#include <string.h>

static uint32_t rotate(uint32_t x, int k) { return x << k | x >> (32 - k); }

/* Bob Jenkins' lookup3 (http://burtleburtle.net/bob/c/lookup3.c) of 1 to 4 words. */
static uint32_t noise_hash(const uint32_t *words, int n)
{
  uint32_t a, b, c;
  a = b = c = 0xdeadbeefu + ((uint32_t)n << 2) + 13;
  a += words[0];
  if (n > 1) b += words[1];
  if (n > 2) c += words[2];
  if (n > 3) {
    a -= c, a ^= rotate(c, 4), c += b;
    b -= a, b ^= rotate(a, 6), a += c;
    c -= b, c ^= rotate(b, 8), b += a;
    a -= c, a ^= rotate(c, 16), c += b;
    b -= a, b ^= rotate(a, 19), a += c;
    c -= b, c ^= rotate(b, 4), b += a;
    a += words[3];
  }
  c ^= b, c -= rotate(b, 14);
  a ^= c, a -= rotate(c, 11);
  b ^= a, b -= rotate(a, 25);
  c ^= b, c -= rotate(b, 16);
  a ^= c, a -= rotate(c, 4);
  b ^= a, b -= rotate(a, 14);
  c ^= b, c -= rotate(b, 24);
  return c;
}

float noise_hash_floats(const float *values, int n)
{
  uint32_t words[NOISE_DIMENSIONS_MAX];
  memcpy(words, values, (size_t)n * sizeof *words);
  return (float)noise_hash(words, n) * 0x1p-32f;
}

void noise_hash_color(noise_point p, float color[3])
{
  const float *x = p.x;
  color[0] = noise_hash_floats(x, p.n);
  if (p.n == 4) { /* no room for one number more: the coordinates change places instead */
    color[1] = noise_hash_floats((float[]){x[2], x[0], x[3], x[1]}, 4);
    color[2] = noise_hash_floats((float[]){x[3], x[2], x[1], x[0]}, 4);
    return;
  }
  for (int i = 1; i < 3; i++) {
    p.x[p.n] = (float)i;
    color[i] = noise_hash_floats(p.x, p.n + 1);
  }
}

static float signed_if(float x, uint32_t negative) { return negative ? -x : x; }

/* The slope at a corner of the lattice times the way from there. */
static float gradient(uint32_t hash, int n, const float *x)
{
  uint32_t h;
  float u, v, w;
  switch (n) {
    case 1:
      h = hash & 15;
      return signed_if((float)(1 + (h & 7)), h & 8) * x[0];
    case 2:
      h = hash & 7;
      u = h < 4 ? x[0] : x[1], v = 2 * (h < 4 ? x[1] : x[0]);
      return signed_if(u, h & 1) + signed_if(v, h & 2);
    case 3:
      h = hash & 15;
      u = h < 8 ? x[0] : x[1], v = h < 4 ? x[1] : h == 12 || h == 14 ? x[0] : x[2];
      return signed_if(u, h & 1) + signed_if(v, h & 2);
    default:
      h = hash & 31;
      u = h < 24 ? x[0] : x[1], v = h < 16 ? x[1] : x[2], w = h < 8 ? x[2] : x[3];
      return signed_if(u, h & 1) + signed_if(v, h & 2) + signed_if(w, h & 4);
  }
}

float noise_perlin(noise_point p)
{
  static const float scale[] = {0.25f, 0.6616f, 0.9820f, 0.8344f}; /* to about -1 to 1 */
  uint32_t cell[NOISE_DIMENSIONS_MAX];
  float fraction[NOISE_DIMENSIONS_MAX], value[1 << NOISE_DIMENSIONS_MAX];
  for (int i = 0; i < p.n; i++) {
    if (!isfinite(p.x[i])) return 0;
    /* Far away all floats are whole numbers, where the noise is 0: half a unit further it is not. */
    const float x = fmodf(p.x[i], 100000) + (fabsf(p.x[i]) >= 1e6f ? 0.5f : 0), whole = floorf(x);
    cell[i] = (uint32_t)(int32_t)whole;
    fraction[i] = x - whole;
  }
  for (int corner = 0; corner < 1 << p.n; corner++) {
    uint32_t words[NOISE_DIMENSIONS_MAX];
    float way[NOISE_DIMENSIONS_MAX];
    for (int i = 0; i < p.n; i++) {
      const uint32_t step = corner >> i & 1;
      words[i] = cell[i] + step;
      way[i] = fraction[i] - (float)step;
    }
    value[corner] = gradient(noise_hash(words, p.n), p.n, way);
  }
  for (int i = 0; i < p.n; i++) {
    const float t = fraction[i], fade = t * t * t * (t * (t * 6 - 15) + 10);
    for (int k = 0; k < 1 << (p.n - i - 1); k++) value[k] = (1 - fade) * value[2 * k] + fade * value[2 * k + 1];
  }
  return value[0] * scale[p.n - 1];
}

noise_point noise_point_add(noise_point p, noise_point offset)
{
  for (int i = 0; i < p.n; i++) p.x[i] += offset.x[i];
  return p;
}

noise_point noise_point_scale(noise_point p, float scale)
{
  for (int i = 0; i < p.n; i++) p.x[i] *= scale;
  return p;
}

noise_point noise_offset(int n, float seed)
{
  noise_point p = {.n = n};
  for (int i = 0; i < n; i++) p.x[i] = 100 + noise_hash_floats((float[]){seed, (float)i}, n == 1 ? 1 : 2) * 100;
  return p;
}

static float fbm(const fractal *f, noise_point p)
{
  float scale = 1, amplitude = 1, total = 0, sum = 0;
  const int octaves = (int)f->detail;
  const float rest = f->detail - (float)octaves;
  for (int i = 0; i <= octaves; i++) {
    sum += noise_perlin(noise_point_scale(p, scale)) * amplitude;
    total += amplitude;
    amplitude *= f->roughness;
    scale *= f->lacunarity;
  }
  const float one = f->normalize ? 0.5f * sum / total + 0.5f : sum;
  if (rest == 0) return one;
  sum += noise_perlin(noise_point_scale(p, scale)) * amplitude;
  const float other = f->normalize ? 0.5f * sum / (total + amplitude) + 0.5f : sum;
  return (1 - rest) * one + rest * other;
}

static float multifractal(const fractal *f, noise_point p)
{
  float value = 1, power = 1;
  const int octaves = (int)f->detail;
  const float rest = f->detail - (float)octaves;
  for (int i = 0; i <= octaves; i++) {
    value *= power * noise_perlin(p) + 1;
    power *= f->roughness;
    p = noise_point_scale(p, f->lacunarity);
  }
  return rest == 0 ? value : value * (rest * power * noise_perlin(p) + 1);
}

static float hetero_terrain(const fractal *f, noise_point p)
{
  float value = f->offset + noise_perlin(p), power = f->roughness;
  const int octaves = (int)f->detail;
  const float rest = f->detail - (float)octaves;
  p = noise_point_scale(p, f->lacunarity);
  for (int i = 1; i <= octaves; i++) {
    value += (noise_perlin(p) + f->offset) * power * value;
    power *= f->roughness;
    p = noise_point_scale(p, f->lacunarity);
  }
  return rest == 0 ? value : value + rest * ((noise_perlin(p) + f->offset) * power * value);
}

static float hybrid_multifractal(const fractal *f, noise_point p)
{
  float value = 0, power = 1, weight = 1;
  const int octaves = (int)f->detail;
  const float rest = f->detail - (float)octaves;
  for (int i = 0; weight > 0.001f && i <= octaves; i++) {
    weight = fminf(weight, 1);
    const float signal = (noise_perlin(p) + f->offset) * power;
    power *= f->roughness;
    value += weight * signal;
    weight *= f->gain * signal;
    p = noise_point_scale(p, f->lacunarity);
  }
  if (rest == 0 || !(weight > 0.001f)) return value;
  return value + rest * fminf(weight, 1) * ((noise_perlin(p) + f->offset) * power);
}

static float ridge(const fractal *f, noise_point p)
{
  const float height = f->offset - fabsf(noise_perlin(p));
  return height * height;
}
static float ridged_multifractal(const fractal *f, noise_point p)
{
  float power = f->roughness, signal = ridge(f, p), value = signal;
  for (int i = 1; i <= (int)f->detail; i++) {
    p = noise_point_scale(p, f->lacunarity);
    signal = ridge(f, p) * fminf(fmaxf(signal * f->gain, 0), 1);
    value += signal * power;
    power *= f->roughness;
  }
  return value;
}

float noise_fractal(const fractal *f, noise_point p)
{
  switch (f->type) {
    case FRACTAL_MULTIFRACTAL: return multifractal(f, p);
    case FRACTAL_RIDGED_MULTIFRACTAL: return ridged_multifractal(f, p);
    case FRACTAL_HYBRID_MULTIFRACTAL: return hybrid_multifractal(f, p);
    case FRACTAL_HETERO_TERRAIN: return hetero_terrain(f, p);
    default: return fbm(f, p);
  }
}
