/* Textures made of numbers alone. */
#include <math.h>

#include "scene/fresnel.h"
#include "scene/gabor.h"
#include "scene/noise.h"
#include "scene/program.h"
#include "scene/safe_math.h"
#include "scene/voronoi.h"

/* A vector and w as a point of `dimension` + 1 dimensions; in one dimension it is w. */
static noise_point point_of(int dimension, const vec3 *v, const vec3 *w)
{
  if (dimension == 0) return (noise_point){1, {(float)w->x}};
  return (noise_point){dimension + 1, {(float)v->x, (float)v->y, (float)v->z, (float)w->x}};
}
static vec3 color_of(const float c[3]) { return v3(c[0], c[1], c[2]); }
static float within(double x, float low, float high) { return fminf(fmaxf((float)x, low), high); }

/* Vector, w, scale, detail, roughness, lacunarity, offset, gain, distortion. */
OPERATION(noise)
{
  noise_point p = noise_point_scale(point_of(immediates[0], in[0], in[1]), (float)in[2]->x);
  const fractal f = {.type = immediates[1], .normalize = immediates[2], .detail = within(in[3]->x, 0, 15),
                     .roughness = fmaxf((float)in[4]->x, 0), .lacunarity = (float)in[5]->x, .offset = (float)in[6]->x,
                     .gain = (float)in[7]->x};
  const float distortion = (float)in[8]->x;
  if (distortion != 0) {
    noise_point moved = p;
    for (int i = 0; i < p.n; i++)
      moved.x[i] += noise_perlin(noise_point_add(p, noise_offset(p.n, (float)i))) * distortion;
    p = moved;
  }
  const double value = noise_fractal(&f, p);
  out[0] = out[1] = v3_splat(value);
  if (!immediates[3]) return; /* the color is not wanted */
  const float seed = (float)(p.n == 1 ? 1 : p.n);
  out[1] = v3(value, noise_fractal(&f, noise_point_add(p, noise_offset(p.n, seed))),
              noise_fractal(&f, noise_point_add(p, noise_offset(p.n, seed + 1))));
}

OPERATION(white_noise)
{
  float color[3];
  noise_hash_color(point_of(immediates[0], in[0], in[1]), color);
  out[0] = v3_splat(color[0]);
  out[1] = color_of(color);
}

/* Vector, scale, frequency, anisotropy, angle, orientation. */
OPERATION(gabor)
{
  const vec3 o = v3_normalize(*in[5]);
  const gabor g = {.dimensions = immediates[0] + 2, .frequency = fmaxf((float)in[2]->x, 0.001f),
                   .isotropy = 1 - within(in[3]->x, 0, 1), .angle = (float)in[4]->x,
                   .orientation = {(float)o.x, (float)o.y, (float)o.z}};
  const float scale = (float)in[1]->x;
  float found[3];
  gabor_noise(&g, (float[]){(float)in[0]->x * scale, (float)in[0]->y * scale, (float)in[0]->z * scale}, found);
  for (int i = 0; i < 3; i++) out[i] = v3_splat(found[i]);
}

/* Vector, w, scale, detail, roughness, lacunarity, smoothness, exponent, randomness. */
OPERATION(voronoi)
{
  const voronoi v = {.feature = immediates[1], .metric = immediates[2], .normalize = immediates[3],
                     .float_hash = immediates[4], .detail = within(in[3]->x, 0, 15), .roughness = within(in[4]->x, 0, 1),
                     .lacunarity = (float)in[5]->x, .smoothness = within(in[6]->x / 2, 0, 0.5f),
                     .exponent = (float)in[7]->x, .randomness = within(in[8]->x, 0, 1)};
  const float scale = (float)in[2]->x;
  const voronoi_result r = voronoi_at(&v, noise_point_scale(point_of(immediates[0], in[0], in[1]), scale));
  const double unit = safe_divide(1, scale);
  const float *x = r.position.x;
  out[0] = v3_splat(r.distance);
  out[1] = color_of(r.color);
  out[2] = r.position.n == 1 ? v3(0, 0, 0) : v3_scale(v3(x[0], x[1], r.position.n > 2 ? x[2] : 0), unit);
  out[3] = v3_splat((r.position.n == 1 ? x[0] : r.position.n == 4 ? x[3] : 0) * unit);
}

OPERATION(gradient)
{
  const vec3 p = *in[0];
  const double r = fmax(0.999999 - v3_length(p), 0), t = saturate(p.x);
  double value = 0;
  switch ((gradient_type)immediates[0]) {
    case GRADIENT_LINEAR: value = p.x; break;
    case GRADIENT_QUADRATIC: value = squared(fmax(p.x, 0)); break;
    case GRADIENT_EASING: value = t * t * (3 - 2 * t); break;
    case GRADIENT_DIAGONAL: value = (p.x + p.y) / 2; break;
    case GRADIENT_RADIAL: value = atan2(p.y, p.x) / (2 * M_PI) + 0.5; break;
    case GRADIENT_QUADRATIC_SPHERE: value = r * r; break;
    case GRADIENT_SPHERICAL: value = r; break;
  }
  *out = v3_splat(saturate(value));
}

/* Vector, scale, distortion; immediate: how often the sines are fed back. */
OPERATION(magic)
{
  const vec3 p = v3_scale(*in[0], in[1]->x);
  const int depth = immediates[0];
  double d = in[2]->x;
  double x = sin((p.x + p.y + p.z) * 5), y = cos((-p.x + p.y - p.z) * 5), z = -cos((-p.x - p.y + p.z) * 5);
  if (depth > 0) {
    x *= d, y *= d, z *= d;
    y = -cos(x - y + z) * d;
  }
  if (depth > 1) x = cos(x - y - z) * d;
  if (depth > 2) z = sin(-x - y - z) * d;
  if (depth > 3) x = -cos(-x + y - z) * d;
  if (depth > 4) y = -sin(-x + y + z) * d;
  if (depth > 5) y = -cos(-x + y + z) * d;
  if (depth > 6) x = cos(x + y + z) * d;
  if (depth > 7) z = sin(x + y - z) * d;
  if (depth > 8) x = -cos(-x - y + z) * d;
  if (depth > 9) y = -sin(x - y + z) * d;
  if (d != 0) d *= 2, x /= d, y /= d, z /= d;
  out[0] = v3(0.5 - x, 0.5 - y, 0.5 - z);
  out[1] = v3_splat(v3_average(out[0]));
}

/* Vector, scale, distortion, detail, detail scale, detail roughness, phase. */
OPERATION(wave)
{
  const vec3 v = v3_scale(v3_add(v3_scale(*in[0], in[1]->x), v3_splat(1e-6)), 0.999999); /* as for the checker */
  const wave_direction direction = immediates[1];
  double n;
  if (immediates[0] == WAVE_BANDS) {
    n = direction == WAVE_X ? v.x * 20 : direction == WAVE_Y ? v.y * 20 : direction == WAVE_Z ? v.z * 20
                                                                       : (v.x + v.y + v.z) * 10;
  } else {
    const vec3 axes = v3(direction != WAVE_X, direction != WAVE_Y, direction != WAVE_Z);
    n = v3_length(v3_mul(v, axes)) * 20;
  }
  n += in[6]->x;
  if (in[2]->x != 0) {
    const fractal f = {.type = FRACTAL_FBM, .normalize = 1, .lacunarity = 2, .detail = within(in[3]->x, 0, 15),
                       .roughness = (float)in[5]->x};
    n += in[2]->x * (2 * noise_fractal(&f, noise_point_scale(point_of(2, &v, &v), (float)in[4]->x)) - 1.0);
  }
  const double turns = n / (2 * M_PI);
  const double value = immediates[2] == WAVE_SIN ? 0.5 + 0.5 * sin(n - M_PI / 2)
                       : immediates[2] == WAVE_SAW ? turns - floor(turns) : fabs(turns - floor(turns + 0.5)) * 2;
  *out = v3_splat(value);
}

/* A whole number as the bits of an integer; far ones count as the farthest. */
static uint32_t word_of(float x) { return isfinite(x) ? (uint32_t)(int64_t)fminf(fmaxf(x, -0x1p31f), 0x1p31f) : 0; }

/* A number in [0, 1] for each brick, by the integer noise of libnoise. */
static double brick_noise(uint32_t n)
{
  n = (n + 1013) & 0x7fffffff;
  n ^= n >> 13;
  return 0.5 * (((n * (n * n * 60493u + 19990303u) + 1376312589u) & 0x7fffffff) / 1073741824.0);
}

/* Vector, color 1, color 2, mortar, scale, mortar size, mortar smooth, bias, brick width, row height, offset, its
 * frequency, squash, its frequency. */
OPERATION(brick)
{
  const noise_point p = noise_point_scale(point_of(1, in[0], in[0]), (float)in[4]->x);
  const float mortar_size = (float)in[5]->x, smooth = (float)in[6]->x, height = (float)in[9]->x;
  const int every = (int)within(in[11]->x, 0, 99), squash_every = (int)within(in[13]->x, 0, 99);
  float width = (float)in[8]->x, offset = 0;
  const float row = height != 0 ? floorf(p.x[1] / height) : 0;
  if (every && squash_every) {
    if (fmodf(row, (float)squash_every) == 0) width *= (float)in[12]->x;
    if (fmodf(row, (float)every) == 0) offset = width * (float)in[10]->x;
  }
  const float brick = width != 0 ? floorf((p.x[0] + offset) / width) : 0;
  const float x = p.x[0] + offset - width * brick, y = p.x[1] - height * row;
  const double tint = saturate(brick_noise((word_of(row) << 16) + (word_of(brick) & 0xffff)) + in[7]->x);
  const float edge = fminf(fminf(x, y), fminf(width - x, height - y));
  double mortar = edge < mortar_size;
  if (mortar && smooth != 0) {
    const float t = (1 - edge / mortar_size) / smooth;
    if (t < 1) mortar = t * t * (3 - 2 * t);
  }
  out[0] = v3_mix(v3_mix(*in[1], *in[2], tint), *in[3], mortar);
  out[1] = v3_splat(mortar);
}
