/* Kerr rays in 113-bit arithmetic: the truth that estimates of rounding errors are held against.
 *
 * Carter's separated equations in Mino time (as in the core's kerr.h: w = 1/r, a unit vector n in axes that the hole drags
 * along, the dragging angle), launched from the tetrad of Bardeen, Press & Teukolsky 1972, by plain Taylor series with a
 * step that leaves 1e-27 an arc. No lanes, no barriers, no shortcuts; units M = 1. Golden data, which were computed from the
 * unseparated equations, are its own test.
 */
#include <math.h>
#include <stddef.h>

#if defined(__x86_64__)
#include <quadmath.h>
typedef __float128 quad;
#define SQRT sqrtq
#define POW powq
#define SIN sinq
#define COS cosq
#else
typedef long double quad; /* 113 bits on aarch64 */
#define SQRT sqrtl
#define POW powl
#define SIN sinl
#define COS cosl
#endif

enum { ORDER = 26, STEPS_MAX = 4000 };

typedef struct ray {
  quad spin, energy, momentum, carter; /* spin as the backward ray sees it */
  quad w, v;                           /* 1/r and its rate */
  quad n[3], m[3];                     /* n and its rate */
  quad drag, swept;
} ray;

/* The Taylor coefficients of a ray's state. */
typedef struct series {
  quad w[ORDER + 1], n[3][ORDER + 1], drag[ORDER + 1], swept[ORDER + 1];
} series;

static quad larger(quad a, quad b) { return a > b ? a : b; }
static quad size(quad a) { return a < 0 ? -a : a; }

static quad product(const quad *a, const quad *b, int k)
{
  quad sum = 0;
  for (int j = 0; j <= k; j++) sum += a[j] * b[k - j];
  return sum;
}

static quad value(const quad *a, quad x)
{
  quad sum = 0;
  for (int k = ORDER; k >= 0; k--) sum = sum * x + a[k];
  return sum;
}

static quad slope(const quad *a, quad x)
{
  quad sum = 0;
  for (int k = ORDER; k >= 1; k--) sum = sum * x + k * a[k];
  return sum;
}

static ray launch(double spin, const double origin[3], const double direction[3])
{
  const quad s = -(quad)spin, s2 = s * s, x = origin[0], y = origin[1], z = origin[2];
  const quad across2 = x * x + y * y, half = (across2 + z * z - s2) / 2, across = SQRT(across2);
  const quad r = SQRT(half + SQRT(half * half + s2 * z * z)), h = SQRT(r * r + s2);
  const quad cp = across > 0 ? x / across : 1, sp = across > 0 ? y / across : 0, ct = z / r, st = across / h;
  const quad sigma = r * r + s2 * ct * ct, delta = r * r - 2 * r + s2, area = h * h * h * h - st * st * s2 * delta;
  quad d[3] = {direction[0], direction[1], direction[2]};
  const quad length = SQRT(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]), along = (d[0] * cp + d[1] * sp) / length;
  const quad east = (d[1] * cp - d[0] * sp) / length, up = d[2] / length;
  const quad swing = east * SQRT(area / sigma), polar = h * ct * along - r * st * up; /* L / sin theta and p_theta */
  ray ray = {.spin = s, .momentum = swing * st, .w = 1 / r};
  ray.energy = SQRT(sigma * delta / area) + 2 * s * r / area * ray.momentum;
  ray.carter = polar * polar + ct * ct * (swing * swing - s2 * ray.energy * ray.energy);
  ray.v = -SQRT(delta) * (r * st * along + h * ct * up) / (r * r);
  ray.n[0] = st * cp, ray.n[1] = st * sp, ray.n[2] = ct;
  ray.m[0] = polar * ct * cp - swing * sp, ray.m[1] = polar * ct * sp + swing * cp, ray.m[2] = -polar * st;
  return ray;
}

static void expand(const ray *ray, series *t)
{
  const quad s = ray->spin, s2 = s * s, E = ray->energy, L = ray->momentum, sE2 = s2 * E * E;
  const quad curl = ray->carter + L * L, K = (L - s * E) * (L - s * E) + ray->carter;
  quad w2[ORDER], w2_delta[ORDER], rate[ORDER], turn[ORDER], speed2[ORDER], speed[ORDER];
  t->w[0] = ray->w, t->w[1] = ray->v, t->drag[0] = ray->drag, t->swept[0] = ray->swept;
  for (int i = 0; i < 3; i++) t->n[i][0] = ray->n[i], t->n[i][1] = ray->m[i];
  for (int k = 0; k < ORDER; k++) {
    w2[k] = product(t->w, t->w, k);
    w2_delta[k] = s2 * w2[k] - 2 * t->w[k] + (k == 0);
    quad known = 0, square = 0;
    for (int j = 1; j <= k; j++) known += w2_delta[j] * rate[k - j];
    rate[k] = (2 * s * E * t->w[k] - s2 * L * w2[k] - known) / w2_delta[0];
    t->drag[k + 1] = rate[k] / (k + 1);
    const quad z2 = product(t->n[2], t->n[2], k);
    turn[k] = 2 * sE2 * z2 + (k ? 0 : curl), speed2[k] = sE2 * z2 + (k ? 0 : curl);
    for (int j = 1; j < k; j++) square += speed[j] * speed[k - j];
    speed[k] = k ? (speed2[k] - square) / (2 * speed[0]) : SQRT(speed2[0]);
    t->swept[k + 1] = speed[k] / (k + 1);
    if (k + 2 > ORDER) break;
    const int q = (k + 1) * (k + 2);
    t->w[k + 2] = ((sE2 - curl) * t->w[k] + 3 * K * w2[k] - 2 * s2 * ray->carter * product(t->w, w2, k)) / q;
    for (int i = 0; i < 3; i++)
      t->n[i][k + 2] = ((i == 2 ? sE2 * t->n[2][k] : 0) - product(turn, t->n[i], k)) / q;
  }
}

/* The step that leaves 1e-27, and does not pass infinity twice or go round. */
static quad step_of(const ray *ray, const series *t, quad horizon)
{
  quad inverse = 0;
  for (int k = ORDER - 2; k <= ORDER; k++) {
    quad most = larger(larger(size(t->w[k]), size(t->drag[k])), size(t->swept[k]));
    for (int i = 0; i < 3; i++) most = larger(most, size(t->n[i][k]));
    inverse = larger(inverse, POW(most, (quad)1 / k));
  }
  const quad step = POW((quad)1e-27, (quad)1 / ORDER) / inverse;
  const quad quickest = larger((t->swept[1] + size(ray->energy)), size(ray->v) / (ray->w + horizon));
  return step * quickest > 1 ? 1 / quickest : step;
}

/* The offset in (0, step] at which w is 0: Newton's method between bounds. */
static quad infinity_at(const quad *w, quad step)
{
  quad low = 0, high = step, x = step * w[0] / (w[0] - value(w, step));
  for (int i = 0; i < 100; i++) {
    const quad now = value(w, x);
    if (now > 0) low = x;
    else high = x;
    x -= now / slope(w, x);
    if (!(x >= low && x <= high)) x = (low + high) / 2;
  }
  return x;
}

/* Asymptotic directions (n, 3) and swept angles (n,) of rays that escape; NaN of others. */
void kerr_reference(double spin, size_t n, const double (*origins)[3], const double (*directions)[3],
                    double (*asymptotes)[3], double *swept)
{
  const quad horizon = 1 / (1 + SQRT((1 - (quad)spin) * (1 + (quad)spin)));
  for (size_t at = 0; at < n; at++) {
    ray ray = launch(spin, origins[at], directions[at]);
    int out = 0;
    for (int steps = 0; steps < STEPS_MAX && !out; steps++) {
      series t;
      expand(&ray, &t);
      quad step = step_of(&ray, &t, horizon);
      const quad end = value(t.w, step);
      if (!(end < horizon)) break;
      out = end <= 0;
      if (out) step = infinity_at(t.w, step);
      ray.w = value(t.w, step), ray.v = slope(t.w, step);
      ray.drag = value(t.drag, step), ray.swept = value(t.swept, step);
      for (int i = 0; i < 3; i++) ray.n[i] = value(t.n[i], step), ray.m[i] = slope(t.n[i], step);
    }
    const quad c = COS(ray.drag), s = SIN(ray.drag);
    asymptotes[at][0] = out ? (double)(c * ray.n[0] - s * ray.n[1]) : NAN;
    asymptotes[at][1] = out ? (double)(s * ray.n[0] + c * ray.n[1]) : NAN;
    asymptotes[at][2] = out ? (double)ray.n[2] : NAN;
    swept[at] = out ? (double)ray.swept : NAN;
  }
}
