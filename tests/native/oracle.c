/* The truth about curved rays and triangles, by means that share nothing with the core: every ray is a polyline of many
 * thousand chords from a Runge-Kutta integration of Hamilton's equations in Cartesian coordinates, every chord is tried
 * against every triangle (blocks of chords against bounding boxes first), all in double precision.
 *
 * Schwarzschild and Ellis: their spatial metric is conformally flat, so light is that of a medium of refractive index
 * n(R): H = |p|^2 / 2n^2 (Gordon 1923; the isotropic chart). Kerr: H = g^ab p_a p_b / 2 in Kerr-Schild coordinates,
 * regular on the axis and at the horizon (Kerr & Schild 1965), drawn in the oblate chart afterwards. A ray traced backwards
 * in time round a hole of spin a is a forward one round a hole of spin -a.
 */
#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

enum { ISOTROPIC, AREAL, ELLIS, KERR };
enum { ESCAPED = 1, CAPTURED = 2, ESCAPED_FAR = 3, HIT = 4 };
enum { PIECES = 16, BLOCK = 64 };

typedef struct space {
  int kind;
  double mass, spin, throat;
} space;

/* Position and momentum in the coordinates of the integration. */
typedef struct state {
  double x[3], p[3], energy;
} state;

static double dot(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/* fmin and fmax, which are calls, where no argument is NaN. */
static double least(double a, double b) { return b < a ? b : a; }
static double most(double a, double b) { return b > a ? b : a; }

/* The square of the refractive index and its derivative by R^2, over R^2. */
static void index_of(const space *s, double R, double *n2, double *slope)
{
  if (s->kind == ELLIS) {
    const double q = s->throat * s->throat / (4 * R * R), n = 1 + q;
    *n2 = n * n, *slope = 2 * n * (-2 * q / R);
  } else {
    const double q = s->mass / (2 * R), n = (1 + q) * (1 + q) * (1 + q) / (1 - q);
    const double dlog = -q / R * (3 / (1 + q) + 1 / (1 - q));
    *n2 = n * n, *slope = 2 * n * n * dlog;
  }
}

/* Kerr-Schild: g^ab = eta^ab - f l^a l^b; forward spin s->spin already reversed by the caller. */
static double kerr_radius(const space *s, const double x[3])
{
  const double a2 = s->spin * s->spin, half = 0.5 * (dot(x, x) - a2);
  return sqrt(half + sqrt(half * half + a2 * x[2] * x[2]));
}

static double kerr_form(const space *s, const double x[3], double l[3])
{
  const double a = s->spin, r = kerr_radius(s, x), d = r * r + a * a;
  l[0] = (r * x[0] + a * x[1]) / d, l[1] = (r * x[1] - a * x[0]) / d, l[2] = x[2] / r;
  return 2 * s->mass * r * r * r / (r * r * r * r + a * a * x[2] * x[2]);
}

/* The part of H that is not flat: l^a p_a = E + l . p for p_t = -E. */
static double kerr_potential(const space *s, const double x[3], const double p[3], double energy)
{
  double l[3];
  const double f = kerr_form(s, x, l), along = energy + dot(l, p);
  return -0.5 * f * along * along;
}

static void derivative(const space *s, const state *y, double dx[3], double dp[3])
{
  if (s->kind != KERR) {
    const double R = sqrt(dot(y->x, y->x));
    double n2, slope;
    index_of(s, R, &n2, &slope);
    for (int k = 0; k < 3; k++) dx[k] = y->p[k], dp[k] = 0.5 * slope * y->x[k] / R;
    return;
  }
  double l[3];
  const double f = kerr_form(s, y->x, l), along = y->energy + dot(l, y->p);
  for (int k = 0; k < 3; k++) dx[k] = y->p[k] - f * along * l[k];
  const double h = 1e-4 * kerr_radius(s, y->x); /* fourth-order difference: error 1e-15 */
  for (int k = 0; k < 3; k++) {
    double v[4], at[3];
    for (int j = 0; j < 4; j++) {
      memcpy(at, y->x, sizeof at);
      at[k] += h * (double[]){-2, -1, 1, 2}[j];
      v[j] = kerr_potential(s, at, y->p, y->energy);
    }
    dp[k] = -((v[0] - v[3]) / 12 + (v[2] - v[1]) * 2 / 3) / h;
  }
}

/* dx, dp: the derivative at y. */
static void runge_kutta(const space *s, state *y, const double dx[3], const double dp[3], double h)
{
  double kx[4][3], kp[4][3];
  state z = *y;
  const double part[4] = {0, 0.5, 0.5, 1};
  memcpy(kx[0], dx, sizeof kx[0]), memcpy(kp[0], dp, sizeof kp[0]);
  for (int i = 1; i < 4; i++) {
    for (int k = 0; k < 3; k++)
      z.x[k] = y->x[k] + part[i] * h * kx[i - 1][k], z.p[k] = y->p[k] + part[i] * h * kp[i - 1][k];
    derivative(s, &z, kx[i], kp[i]);
  }
  for (int k = 0; k < 3; k++) {
    y->x[k] += h / 6 * (kx[0][k] + 2 * kx[1][k] + 2 * kx[2][k] + kx[3][k]);
    y->p[k] += h / 6 * (kp[0][k] + 2 * kp[1][k] + 2 * kp[2][k] + kp[3][k]);
  }
}

/* Scene chart -> integration coordinates and back. */
static double isotropic_of_areal(const space *s, double r)
{
  return 0.5 * (r - s->mass + sqrt(fmax(r * (r - 2 * s->mass), 0)));
}

static double kerr_twist(const space *s, double r) /* phi_KS - phi_BL */
{
  const double a = s->spin, root = sqrt(s->mass * s->mass - a * a);
  if (a == 0) return 0;
  return a / (2 * root) * log(fabs((r - s->mass - root) / (r - s->mass + root)));
}

static void draw(const space *s, const double x[3], double out[3])
{
  memcpy(out, x, 3 * sizeof *x);
  if (s->kind == AREAL) {
    const double R = sqrt(dot(x, x)), q = 1 + s->mass / (2 * R);
    for (int k = 0; k < 3; k++) out[k] = x[k] * q * q;
  } else if (s->kind == KERR) {
    /* phi is that of (x + i y) / (r + i a), less the twist */
    const double r = kerr_radius(s, x), a = s->spin, R = sqrt(r * r + a * a), twist = kerr_twist(s, r);
    const double u = (x[0] * r + x[1] * a) / R, v = (x[1] * r - x[0] * a) / R, c = cos(twist), n = sin(twist);
    out[0] = u * c + v * n, out[1] = v * c - u * n;
  }
}

static void launch_kerr(const space *s, const double o[3], const double d[3], state *y)
{
  const double M = s->mass, a = s->spin, rho = sqrt(o[0] * o[0] + o[1] * o[1]);
  const double r = kerr_radius(s, o), ct = o[2] / r, st = rho / sqrt(r * r + a * a);
  const double cp = o[0] / rho, sp = o[1] / rho, sigma = r * r + a * a * ct * ct, delta = r * r - 2 * M * r + a * a;
  const double A = (r * r + a * a) * (r * r + a * a) - st * st * a * a * delta, R = sqrt(r * r + a * a);
  /* flat oblate basis */
  const double er[3] = {r * st * cp / sqrt(sigma), r * st * sp / sqrt(sigma), R * ct / sqrt(sigma)};
  const double et[3] = {R * ct * cp / sqrt(sigma), R * ct * sp / sqrt(sigma), -r * st / sqrt(sigma)};
  const double ep[3] = {-sp, cp, 0};
  const double L = dot(d, ep) * st * sqrt(A / sigma), E = sqrt(sigma * delta / A) + 2 * M * r * a / A * L;
  const double p_theta = sqrt(sigma) * dot(d, et);
  const double p_r = sqrt(sigma / delta) * dot(d, er) + (2 * M * r * E - a * L) / delta; /* Boyer-Lindquist -> KS */
  /* x + i y = (r + i a) sin(theta) e^(i tilde): invert the Jacobian by (r, theta, tilde) for p_x, p_y, p_z */
  const double tilde = atan2(o[1], o[0]) + kerr_twist(s, r), phi = tilde + atan2(a, r);
  const double x = R * st * cos(phi), y1 = R * st * sin(phi);
  const double J[3][3] = {{st * cos(tilde), st * sin(tilde), ct}, {x * ct / st, y1 * ct / st, -r * st}, {-y1, x, 0}};
  const double q[3] = {p_r, p_theta, L};
  double inverse[3][3], det = 0;
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      inverse[j][i] = J[(i + 1) % 3][(j + 1) % 3] * J[(i + 2) % 3][(j + 2) % 3] -
                      J[(i + 1) % 3][(j + 2) % 3] * J[(i + 2) % 3][(j + 1) % 3];
  for (int j = 0; j < 3; j++) det += J[0][j] * inverse[j][0];
  y->x[0] = x, y->x[1] = y1, y->x[2] = o[2], y->energy = E;
  for (int k = 0; k < 3; k++) y->p[k] = dot(inverse[k], q) / det;
}

static void launch(const space *s, const double o[3], const double d[3], state *y)
{
  if (s->kind == KERR) {
    launch_kerr(s, o, d, y);
    return;
  }
  double n2, slope, factor = 1;
  if (s->kind == AREAL) {
    const double r = sqrt(dot(o, o));
    factor = isotropic_of_areal(s, r) / r;
  }
  for (int k = 0; k < 3; k++) y->x[k] = factor * o[k];
  index_of(s, sqrt(dot(y->x, y->x)), &n2, &slope);
  for (int k = 0; k < 3; k++) y->p[k] = sqrt(n2) * d[k];
}

/* Distance from the horizon or throat and the fate there; 0 while on the way. Rays are drawn down to 1e-7 above the
 * horizon's radius r, which in the isotropic chart is 6.33e-4. */
static int arrived(const space *s, const double x[3], double outer, double *room)
{
  const double R = sqrt(dot(x, x));
  double core = s->kind == ELLIS ? s->throat / 2 : s->mass / 2, r = R;
  if (s->kind == KERR) r = kerr_radius(s, x), core = s->mass + sqrt(s->mass * s->mass - s->spin * s->spin);
  *room = r - core;
  if (R > outer) return ESCAPED;
  if (s->kind == ELLIS && R < core) return ESCAPED_FAR;
  return *room < (s->kind == KERR ? 1e-7 : 6.33e-4) * core && s->kind != ELLIS ? CAPTURED : 0;
}

typedef struct polyline {
  double points[BLOCK + 1][3];
  int count;
} polyline;

typedef int (*visitor)(void *user, const polyline *block);

/* Calls `visit` for blocks of chords until it returns nonzero or the ray ends; returns the fate, or HIT. A chord is
 * c = 6e-4 of the distance r from the hole, or less: far away, where light curves by 4 M / r^2 at most, it is off the ray by
 * no more than M c^2 / 2 = 2e-7 M. */
static int follow(const space *s, const double o[3], const double d[3], double outer, visitor visit, void *user)
{
  state y = {.energy = 0};
  polyline block;
  launch(s, o, d, &y);
  draw(s, y.x, block.points[0]);
  block.count = 0;
  double v0[3], v1[3], a0[3], a1[3];
  derivative(s, &y, v0, a0);
  for (long steps = 0; steps < 4000000; steps++) {
    double room;
    const int fate = arrived(s, y.x, outer, &room);
    if (fate) {
      if (block.count && visit(user, &block)) return HIT;
      return fate;
    }
    /* Kerr-Schild coordinates need no short steps at the horizon, but there the drawn azimuth turns like log(room). */
    const double near = s->kind == KERR ? least(most(room, 0.02 * s->mass), 4 * room) : sqrt(dot(y.x, y.x));
    const double length = 0.01 * (s->kind == KERR || s->kind == ELLIS ? near : least(near, 4 * room));
    const double h = most(length, 1e-11) / sqrt(dot(v0, v0));
    const state before = y;
    runge_kutta(s, &y, v0, a0, h);
    derivative(s, &y, v1, a1);
    for (int i = 1; i <= PIECES; i++) {
      const double t = (double)i / PIECES, u = 1 - t;
      double x[3];
      for (int k = 0; k < 3; k++)
        x[k] = u * u * (1 + 2 * t) * before.x[k] + t * u * u * h * v0[k] + t * t * (3 - 2 * t) * y.x[k] -
               t * t * u * h * v1[k];
      double *drawn = block.points[++block.count];
      draw(s, x, drawn);
      const double excess = sqrt(dot(x, x)) - s->throat / 2;
      const int beyond = s->kind == ELLIS && excess < 0;
      if (beyond) { /* back onto the throat */
        const double *last = block.points[block.count - 1], back = excess / (excess - (sqrt(dot(last, last)) - s->throat / 2));
        for (int k = 0; k < 3; k++) drawn[k] += back * (last[k] - drawn[k]);
      }
      if (block.count < BLOCK && !beyond) continue;
      if (visit(user, &block)) return HIT;
      if (beyond) return ESCAPED_FAR;
      memcpy(block.points[0], block.points[BLOCK], sizeof block.points[0]);
      block.count = 0;
    }
    memcpy(v0, v1, sizeof v0), memcpy(a0, a1, sizeof a0);
  }
  return 0;
}

typedef struct search {
  size_t count;
  const double (*triangles)[3][3];
  const double (*boxes)[2][3];
  int triangle;
  double position[3], length; /* up to the block's beginning; of the hit, once there is one */
} search;

static double distance(const double a[3], const double b[3])
{
  const double d[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
  return sqrt(dot(d, d));
}

/* The fraction of the chord at which it meets the triangle, or 2 (Moller & Trumbore 1997). */
static double meet(const double a[3], const double b[3], const double t[3][3])
{
  double e1[3], e2[3], d[3], q[3], w[3], r[3];
  for (int k = 0; k < 3; k++) e1[k] = t[1][k] - t[0][k], e2[k] = t[2][k] - t[0][k], d[k] = b[k] - a[k], w[k] = a[k] - t[0][k];
  for (int k = 0; k < 3; k++) {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    q[k] = d[i] * e2[j] - d[j] * e2[i], r[k] = w[i] * e1[j] - w[j] * e1[i];
  }
  const double det = dot(e1, q), u = dot(w, q) / det, v = dot(d, r) / det, s = dot(e2, r) / det;
  return det != 0 && u >= 0 && v >= 0 && u + v <= 1 && s >= 0 && s <= 1 ? s : 2;
}

static int visit_search(void *user, const polyline *block)
{
  search *f = user;
  double lower[3], upper[3], best = BLOCK + 1;
  for (int k = 0; k < 3; k++) {
    lower[k] = upper[k] = block->points[0][k];
    for (int i = 1; i <= block->count; i++)
      lower[k] = least(lower[k], block->points[i][k]), upper[k] = most(upper[k], block->points[i][k]);
  }
  for (size_t t = 0; t < f->count; t++) {
    const double(*box)[3] = f->boxes[t];
    if (box[0][0] > upper[0] || box[1][0] < lower[0] || box[0][1] > upper[1] || box[1][1] < lower[1] ||
        box[0][2] > upper[2] || box[1][2] < lower[2])
      continue;
    for (int i = 0; i < block->count && i < best; i++) {
      const double s = meet(block->points[i], block->points[i + 1], f->triangles[t]);
      if (s > 1 || i + s >= best) continue;
      best = i + s;
      f->triangle = (int)t;
      for (int k = 0; k < 3; k++)
        f->position[k] = block->points[i][k] + s * (block->points[i + 1][k] - block->points[i][k]);
    }
  }
  const int found = best <= BLOCK, end = found ? (int)best : block->count;
  for (int i = 0; i < end; i++) f->length += distance(block->points[i], block->points[i + 1]);
  if (found) f->length += distance(block->points[end], f->position);
  return found;
}

/* The first hits of n rays: fate, triangle (-1), position, and drawn length up to it. boxes: lower and upper corners of the triangles. */
void oracle_hits(int kind, double mass, double spin, double throat, double outer, size_t count,
                 const double (*triangles)[3][3], const double (*boxes)[2][3], size_t n, const double (*origins)[3],
                 const double (*directions)[3], int32_t *fate, int32_t *triangle, double (*position)[3], double *length)
{
  const space s = {kind, mass, -spin, throat};
  for (size_t i = 0; i < n; i++) {
    search f = {count, triangles, boxes, -1, {NAN, NAN, NAN}, 0};
    fate[i] = follow(&s, origins[i], directions[i], outer, visit_search, &f);
    triangle[i] = f.triangle;
    memcpy(position[i], f.position, sizeof f.position);
    length[i] = f.length;
  }
}

static double segment_distance(const double a[3], const double b[3], const double c[3], const double d[3])
{
  double u[3], v[3], w[3];
  for (int k = 0; k < 3; k++) u[k] = b[k] - a[k], v[k] = d[k] - c[k], w[k] = a[k] - c[k];
  const double uu = dot(u, u), uv = dot(u, v), vv = dot(v, v), uw = dot(u, w), vw = dot(v, w), det = uu * vv - uv * uv;
  double s = det > 1e-300 ? least(most((uv * vw - vv * uw) / det, 0), 1) : 0;
  double t = vv > 0 ? least(most((uv * s + vw) / vv, 0), 1) : 0;
  s = uu > 0 ? least(most((uv * t - uw) / uu, 0), 1) : 0;
  double gap = 0;
  for (int k = 0; k < 3; k++) {
    const double g = w[k] + s * u[k] - t * v[k];
    gap += g * g;
  }
  return sqrt(gap);
}

typedef struct nearest {
  const double (*segments)[2][3];
  size_t count;
  double distance;
} nearest;

static int visit_nearest(void *user, const polyline *block)
{
  nearest *f = user;
  for (int i = 0; i < block->count; i++)
    for (size_t e = 0; e < f->count; e++)
      f->distance = least(f->distance, segment_distance(block->points[i], block->points[i + 1], f->segments[e][0],
                                                        f->segments[e][1]));
  return 0;
}

/* The smallest distance of each ray from its own `count` segments (points are segments of length 0). */
void oracle_distances(int kind, double mass, double spin, double throat, double outer, size_t n,
                      const double (*origins)[3], const double (*directions)[3], size_t count,
                      const double (*segments)[2][3], double *distance)
{
  const space s = {kind, mass, -spin, throat};
  for (size_t i = 0; i < n; i++) {
    nearest f = {segments + i * count, count, INFINITY};
    follow(&s, origins[i], directions[i], outer, visit_nearest, &f);
    distance[i] = f.distance;
  }
}
