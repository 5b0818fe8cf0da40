/* See voronoi.h. */
#include "scene/voronoi.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* A cell of the lattice, and steps from one to another. */
typedef struct cell {
  int32_t i[NOISE_DIMENSIONS_MAX];
} cell;

/* The neighbor number `index` of all within `reach` steps along each of n axes. */
static cell neighbor(int n, int reach, int index)
{
  cell c = {{0}};
  for (int d = 0; d < n; d++, index /= 2 * reach + 1) c.i[d] = index % (2 * reach + 1) - reach;
  return c;
}
static int neighbor_count(int n, int reach)
{
  int count = 1;
  for (int d = 0; d < n; d++) count *= 2 * reach + 1;
  return count;
}

/* Jarzynski and Olano, "Hash Functions for GPU Rendering" (JCGT 2020), pcg2d to pcg4d, with the arithmetic shift of signed
 * numbers, as numbers in [0, 1]. */
static void hash_pcg(int n, const uint32_t *words, float *out)
{
  const uint32_t factor = 1664525;
  uint32_t v[NOISE_DIMENSIONS_MAX] = {0};
  for (int d = 0; d < n; d++) v[d] = words[d] * factor + 1013904223u;
  for (int round = 0; round < 2; round++) {
    if (n == 2) {
      v[0] += v[1] * factor, v[1] += v[0] * factor;
    } else if (n == 3) {
      v[0] += v[1] * v[2], v[1] += v[2] * v[0], v[2] += v[0] * v[1];
    } else {
      v[0] += v[1] * v[3], v[1] += v[2] * v[0], v[2] += v[0] * v[1], v[3] += v[1] * v[2];
    }
    if (round == 0)
      for (int d = 0; d < n; d++) v[d] ^= v[d] >> 16 | (v[d] & 0x80000000u ? 0xffff0000u : 0);
  }
  for (int d = 0; d < n; d++) out[d] = (float)(v[d] & 0x7fffffff) * (1.0f / 2147483648.0f);
}

/* The four numbers of a cell by which Blender before 5.0 places its point: hashes of the bits of its coordinates. */
static void hash_float_place(noise_point p, float *out)
{
  noise_hash_color(p, out);
  if (p.n < 4) return;
  const float *x = p.x;
  out[1] = noise_hash_floats((float[]){x[3], x[0], x[1], x[2]}, 4);
  out[2] = noise_hash_floats((float[]){x[2], x[3], x[0], x[1]}, 4);
  out[3] = noise_hash_floats((float[]){x[1], x[2], x[3], x[0]}, 4);
}

/* What is random of a cell: the place of its point and its color; either may be NULL. */
static void hash_cell(const voronoi *v, int n, const cell *base, const cell *step, float *place, float *color)
{
  uint32_t words[NOISE_DIMENSIONS_MAX] = {0};
  noise_point p = {.n = n};
  for (int d = 0; d < n; d++) {
    words[d] = (uint32_t)base->i[d] + (uint32_t)step->i[d];
    p.x[d] = (float)(int32_t)words[d];
  }
  float numbers[NOISE_DIMENSIONS_MAX];
  if (place) {
    if (v->float_hash || n == 1) hash_float_place(p, numbers);
    else hash_pcg(n, words, numbers);
    memcpy(place, numbers, (size_t)n * sizeof *place);
  }
  if (color) {
    if (v->float_hash || n == 1) noise_hash_color(p, numbers);
    else hash_pcg(n == 2 ? 3 : n, words, numbers);
    memcpy(color, numbers, 3 * sizeof *color);
  }
}

/* The lattice around one point of evaluation. */
typedef struct neighborhood {
  const voronoi *v;
  int n;
  cell base;
  float local[NOISE_DIMENSIONS_MAX]; /* the point within its cell */
} neighborhood;

static neighborhood neighborhood_of(const voronoi *v, noise_point p)
{
  neighborhood h = {.v = v, .n = p.n};
  for (int d = 0; d < p.n; d++) {
    /* Beyond 2^30 there is nothing between whole numbers. */
    const float x = isfinite(p.x[d]) ? fminf(fmaxf(p.x[d], -0x1p30f), 0x1p30f) : 0, whole = floorf(x);
    h.base.i[d] = (int32_t)whole;
    h.local[d] = x - whole;
  }
  return h;
}

/* The point of a neighbor, from the corner of the middle cell. */
static void point_in(const neighborhood *h, const cell *step, float *point)
{
  hash_cell(h->v, h->n, &h->base, step, point, NULL);
  for (int d = 0; d < h->n; d++) point[d] = (float)step->i[d] + point[d] * h->v->randomness;
}

static float dot(int n, const float *a, const float *b)
{
  float sum = 0;
  for (int d = 0; d < n; d++) sum += a[d] * b[d];
  return sum;
}
static float euclidean(int n, const float *a, const float *b)
{
  float way[NOISE_DIMENSIONS_MAX];
  for (int d = 0; d < n; d++) way[d] = a[d] - b[d];
  return sqrtf(dot(n, way, way));
}
static float distance(const voronoi *v, int n, const float *a, const float *b)
{
  if (n == 1) return fabsf(b[0] - a[0]);
  if (v->metric == METRIC_EUCLIDEAN) return euclidean(n, a, b);
  float sum = 0, most = 0;
  for (int d = 0; d < n; d++) {
    const float way = fabsf(a[d] - b[d]);
    sum += v->metric == METRIC_MINKOWSKI ? powf(way, v->exponent) : way;
    most = fmaxf(most, way);
  }
  return v->metric == METRIC_CHEBYCHEV ? most : v->metric == METRIC_MANHATTAN ? sum : powf(sum, 1 / v->exponent);
}

static float smooth_step(float t)
{
  t = fminf(fmaxf(t, 0), 1);
  return t * t * (3 - 2 * t);
}

/* The nearest point, or the second nearest. */
static voronoi_result nearest(const neighborhood *h, int second)
{
  float best[2] = {FLT_MAX, FLT_MAX}, point[2][NOISE_DIMENSIONS_MAX] = {{0}};
  cell step[2] = {{{0}}};
  for (int i = 0; i < neighbor_count(h->n, 1); i++) {
    const cell c = neighbor(h->n, 1, i);
    float candidate[NOISE_DIMENSIONS_MAX];
    point_in(h, &c, candidate);
    const float length = distance(h->v, h->n, candidate, h->local);
    int place = length < best[0] ? 0 : length < best[1] ? 1 : 2;
    if (place == 0) {
      best[1] = best[0], step[1] = step[0];
      memcpy(point[1], point[0], sizeof *point);
    }
    if (place < 2) {
      best[place] = length, step[place] = c;
      memcpy(point[place], candidate, sizeof candidate);
    }
  }
  voronoi_result r = {.distance = best[second], .position.n = h->n};
  hash_cell(h->v, h->n, &h->base, &step[second], NULL, r.color);
  for (int d = 0; d < h->n; d++) r.position.x[d] = point[second][d] + (float)h->base.i[d];
  return r;
}

/* A smooth minimum over the neighbors, one after the other. */
static voronoi_result smooth_nearest(const neighborhood *h)
{
  const float smoothness = h->v->smoothness;
  voronoi_result r = {.position.n = h->n};
  for (int i = 0; i < neighbor_count(h->n, 2); i++) {
    const cell c = neighbor(h->n, 2, i);
    float point[NOISE_DIMENSIONS_MAX], color[3];
    point_in(h, &c, point);
    hash_cell(h->v, h->n, &h->base, &c, NULL, color);
    const float length = distance(h->v, h->n, point, h->local);
    const float t = i == 0 ? 1 : smooth_step(0.5f + 0.5f * (r.distance - length) / smoothness);
    const float dip = smoothness * t * (1 - t), small_dip = dip / (1 + 3 * smoothness);
    r.distance += t * (length - r.distance) - dip;
    for (int k = 0; k < 3; k++) r.color[k] += t * (color[k] - r.color[k]) - small_dip;
    for (int d = 0; d < h->n; d++) r.position.x[d] += t * (point[d] - r.position.x[d]) - small_dip;
  }
  for (int d = 0; d < h->n; d++) r.position.x[d] += (float)h->base.i[d];
  return r;
}

/* To the nearest plane halfway between the nearest point and another: Inigo Quilez, "Voronoi edges" (2013). */
static float edge_distance(const neighborhood *h)
{
  float closest[NOISE_DIMENSIONS_MAX] = {0}, least = FLT_MAX;
  const int count = neighbor_count(h->n, 1);
  if (h->n == 1) { /* between the middle cell and its two neighbors, whichever is nearer */
    float middle, other;
    point_in(h, &(cell){{0}}, &middle);
    for (int side = -1; side <= 1; side += 2) {
      point_in(h, &(cell){{side}}, &other);
      least = fminf(least, fabsf((middle + other) / 2 - h->local[0]));
    }
    return least;
  }
  for (int pass = 0; pass < 2; pass++) {
    float nearest_way = FLT_MAX;
    for (int i = 0; i < count; i++) {
      const cell c = neighbor(h->n, 1, i);
      float way[NOISE_DIMENSIONS_MAX], across[NOISE_DIMENSIONS_MAX], sum[NOISE_DIMENSIONS_MAX];
      point_in(h, &c, way);
      for (int d = 0; d < h->n; d++) {
        way[d] -= h->local[d];
        across[d] = way[d] - closest[d];
        sum[d] = (way[d] + closest[d]) / 2;
      }
      const float square = dot(h->n, way, way), width = dot(h->n, across, across);
      if (pass == 0 && square < nearest_way) {
        nearest_way = square;
        memcpy(closest, way, sizeof closest);
      } else if (pass == 1 && width > 0.0001f) {
        least = fminf(least, dot(h->n, sum, across) / sqrtf(width));
      }
    }
  }
  return least;
}

/* Half the way from the nearest point to the one nearest to that. */
static float sphere_radius(const neighborhood *h)
{
  float closest[NOISE_DIMENSIONS_MAX] = {0}, least = FLT_MAX;
  cell at = {{0}};
  for (int i = 0; i < neighbor_count(h->n, 1); i++) {
    const cell c = neighbor(h->n, 1, i);
    float point[NOISE_DIMENSIONS_MAX] = {0};
    point_in(h, &c, point);
    const float length = euclidean(h->n, point, h->local);
    if (length < least) {
      least = length, at = c;
      memcpy(closest, point, sizeof closest);
    }
  }
  least = FLT_MAX;
  for (int i = 0; i < neighbor_count(h->n, 1); i++) {
    cell c = neighbor(h->n, 1, i);
    if (i == neighbor_count(h->n, 1) / 2) continue; /* itself */
    for (int d = 0; d < h->n; d++) c.i[d] += at.i[d];
    float point[NOISE_DIMENSIONS_MAX];
    point_in(h, &c, point);
    least = fminf(least, euclidean(h->n, closest, point));
  }
  return least / 2;
}

static voronoi_result octave_at(const voronoi *v, noise_point p)
{
  const neighborhood h = neighborhood_of(v, p);
  switch (v->feature) {
    case VORONOI_F2: return nearest(&h, 1);
    case VORONOI_SMOOTH_F1: return v->smoothness != 0 ? smooth_nearest(&h) : nearest(&h, 0);
    case VORONOI_DISTANCE_TO_EDGE: return (voronoi_result){.distance = edge_distance(&h), .position.n = p.n};
    case VORONOI_N_SPHERE_RADIUS: return (voronoi_result){.distance = sphere_radius(&h), .position.n = p.n};
    default: return nearest(&h, 0);
  }
}

/* The largest distance that one octave can give. */
static float largest_distance(const voronoi *v, int n)
{
  const float side = 0.5f + 0.5f * v->randomness;
  if (v->feature == VORONOI_DISTANCE_TO_EDGE) return side;
  const float zero[NOISE_DIMENSIONS_MAX] = {0}, corner[NOISE_DIMENSIONS_MAX] = {side, side, side, side};
  return distance(v, n, zero, corner) * (v->feature == VORONOI_F2 ? 2 : 1);
}

static float lerp(float a, float b, float t) { return (1 - t) * a + t * b; }

/* Octaves of the distance to the edge: each takes its part of the way to the smaller distance. */
static float fractal_edge(const voronoi *v, noise_point p)
{
  const float largest = largest_distance(v, p.n);
  float amplitude = 1, total = largest, scale = 1, result = 8;
  for (int i = 0; (float)i <= ceilf(v->detail); i++) {
    const float octave = octave_at(v, noise_point_scale(p, scale)).distance / scale;
    const float weight = (float)i <= v->detail ? 1 : v->detail - floorf(v->detail);
    total = lerp(total, lerp(total, largest / scale, amplitude), weight);
    result = lerp(result, fminf(result, lerp(result, fminf(result, octave), amplitude)), weight);
    scale *= v->lacunarity;
    amplitude *= v->roughness;
  }
  return v->normalize ? result / total : result;
}

voronoi_result voronoi_at(const voronoi *v, noise_point p)
{
  const int single = v->detail == 0 || v->roughness == 0;
  voronoi_result sum = {.position.n = p.n};
  if (v->feature == VORONOI_N_SPHERE_RADIUS) return octave_at(v, p);
  if (v->feature == VORONOI_DISTANCE_TO_EDGE && !single) {
    sum.distance = fractal_edge(v, p);
    return sum;
  }
  float amplitude = 1, total = 0, scale = 1;
  for (int i = 0; (float)i <= (single ? 0 : ceilf(v->detail)); i++) {
    const voronoi_result octave = octave_at(v, noise_point_scale(p, scale));
    const float weight = single || (float)i <= v->detail ? 1 : v->detail - floorf(v->detail);
    total += weight * amplitude;
    sum.distance += weight * amplitude * octave.distance;
    for (int k = 0; k < 3; k++) sum.color[k] += weight * amplitude * octave.color[k];
    for (int d = 0; d < p.n; d++)
      sum.position.x[d] = lerp(sum.position.x[d], octave.position.x[d] / scale, weight * amplitude);
    scale *= v->lacunarity;
    amplitude *= v->roughness;
  }
  if (v->normalize) {
    const float largest = largest_distance(v, p.n);
    sum.distance /= total * largest;
    for (int k = 0; k < 3; k++) sum.color[k] /= total;
  }
  return sum;
}
