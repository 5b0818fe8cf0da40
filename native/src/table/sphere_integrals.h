/* Swept angle and drawn length of rays inside a lens sphere, directly: what the columns of a bent_sphere hold. Kernel code.
 *
 * With the right angle t for a variable the orbit's integrals are sums over smooth functions, for which Gauss-Legendre
 * rules are good to rounding, near the critical ray too, where the interval of t grows like the logarithm.
 *
 * Schwarzschild, u = M/r, beta = b/M, P = 1/beta^2 - u^2 + 2 u^3: d(phi) = du / sqrt(P). The drawn length is
 * dL/d(phi) = (1 + h(u)) / (beta u^2), h = O(u^2). Of that the first part is all but a pole at u = 0:
 *   1/(beta u^2) d(phi) = d(beta sqrt(P) / u) + beta u d(phi), up to the sign of du,
 * and beta sqrt(P) / u = r cosine. What remains to sum has no pole:
 *   isotropic: dL = R r / (b sqrt(1 - 2u)) d(phi): h / (beta u^2) = 1 / (2 beta s (1 - u + s)), s = sqrt(1 - 2u);
 *   areal: dL^2 = dr^2 + r^2 d(phi)^2: h / (beta u^2) = 2 beta u / (1 + sqrt(1 + 2 beta^2 u^3)).
 * With a barrier u = u_t - gap sinh^2 t; without one, where P = 2 (u - u_1) ((u - p)^2 + q^2), u = p + q sinh t, and
 * near the horizon s instead.
 *
 * Ellis, rho = 1, r^2 = 1 + l^2: d(phi) = b/r dt, dL = R dt, R = (l + r) / 2, with l = sqrt(b^2 - 1) cosh t for rays that turn
 * back and l = sqrt(1 - b^2) sinh t for those to the throat.
 */
#ifndef BENT_TABLE_SPHERE_INTEGRALS_H
#define BENT_TABLE_SPHERE_INTEGRALS_H
#include "base/lane_math.h"
#include "spacetime/arc.h"
#include "spacetime/endpoint_schwarzschild.h"
#include "spacetime/gauss_legendre.h"
#include "table/sphere_data.h"

/* Rules of gauss_legendre.h: 48 nodes, and 16 where the variable is s. */
enum { SPHERE_RULE = 6, HORIZON_RULE = 2 };
/* Beyond this u the variable is s. */
#define HORIZON_U 0.42

/* A ray inside a sphere, in units of M or rho. */
typedef struct inside {
  lanes swept, length;
} inside;

LANES_INLINE lanes lanes_asinh(lanes x)
{
  const lanes size = lanes_abs(x);
  return lanes_copysign(lanes_log1p(size + size * size / (1 + lanes_sqrt(1 + size * size))), x);
}

LANES_INLINE lanes lanes_sinh(lanes x)
{
  const lanes e = lanes_exp(x);
  return 0.5 * (e - 1 / e);
}

/* The orbit of a ray around a hole, and which length its chart draws. */
typedef struct orbit {
  int is_isotropic;
  lanes beta;
  lanes u_1, u_t, gap; /* with a barrier */
  lanes p, q;          /* without */
} orbit;

/* What is left of the drawn length without its pole, per angle swept times beta. */
LANES_INLINE lanes length_left(const orbit *o, lanes u)
{
  const lanes beta2u = o->beta * o->beta * u;
  if (!o->is_isotropic) return beta2u + 2 * beta2u / (1 + lanes_sqrt(1 + 2 * beta2u * u * u));
  const lanes s = lanes_sqrt(1 - 2 * u);
  return beta2u + 0.5 / (s * (1 - u + s));
}

/* Rates of (swept, length without its pole) / beta in the variable of each kind of panel. */
LANES_INLINE inside rate_back(const orbit *o, lanes t)
{
  const lanes sinh_t = lanes_sinh(t), u = o->u_t - o->gap * sinh_t * sinh_t;
  const lanes turn = M_SQRT2 / (o->beta * lanes_sqrt(u - o->u_1));
  return (inside){turn, turn * length_left(o, u)};
}

LANES_INLINE inside rate_down(const orbit *o, lanes t)
{
  const lanes u = o->p + o->q * lanes_sinh(t);
  const lanes turn = M_SQRT1_2 / (o->beta * lanes_sqrt(u - o->u_1));
  return (inside){turn, turn * length_left(o, u)};
}

LANES_INLINE inside rate_horizon(const orbit *o, lanes s)
{
  const lanes u = 0.5 * (1 - s * s), off = u - o->p;
  const lanes turn = M_SQRT1_2 / (o->beta * lanes_sqrt((u - o->u_1) * (off * off + o->q * o->q)));
  const lanes beta2u = o->beta * o->beta * u;
  const lanes left = o->is_isotropic ? s * beta2u + 0.5 / (1 - u + s)
                                     : s * (beta2u + 2 * beta2u / (1 + lanes_sqrt(1 + 2 * beta2u * u * u)));
  return (inside){turn * s, turn * left};
}

/* Rates in t of a ray past the throat, b > 1 (`back`), or to it. */
typedef struct passage {
  int back;
  lanes b, root; /* root = sqrt|b^2 - 1| */
} passage;

LANES_INLINE inside rate_ellis(const passage *o, lanes t)
{
  const lanes e = lanes_exp(t), l = 0.5 * o->root * (o->back ? e + 1 / e : e - 1 / e), r = lanes_sqrt(1 + l * l);
  return (inside){o->b / r, 0.5 * (l + r)};
}

/* Adds the sum of a rule of `rate` over [low, high] to *sum. */
#define ADD_PANEL(sum, rule, rate, ray, low, high)                                              \
  do {                                                                                          \
    const lanes half_ = 0.5 * ((high) - (low)), middle_ = 0.5 * ((high) + (low));               \
    for (int i_ = 0; i_ < gauss_nodes[rule] / 2; i_++) {                                        \
      const double *pair_ = gauss_pairs[gauss_first[rule] + i_];                                \
      const inside before_ = rate(ray, middle_ - half_ * pair_[0]);                             \
      const inside after_ = rate(ray, middle_ + half_ * pair_[0]);                              \
      (sum)->swept += half_ * (pair_[1] * (before_.swept + after_.swept));                      \
      (sum)->length += half_ * (pair_[1] * (before_.length + after_.length));                   \
    }                                                                                           \
  } while (0)

/* In and out again, delta > 0; cosine: at the sphere. */
LANES_INLINE inside schwarzschild_back(const bent_sphere *sphere, lanes delta, lanes cosine)
{
  const lanes b = 1 + delta, inverse_b2 = 1 / (27 * b * b);
  const barrier bar = barrier_of(delta * (2 + delta) / (b * b), inverse_b2);
  const orbit o = {.is_isotropic = sphere->spacetime.chart == BENT_CHART_ISOTROPIC, .beta = 1 / lanes_sqrt(inverse_b2),
                   .u_1 = bar.u_1, .u_t = bar.u_t, .gap = bar.gap};
  const double u = 1 / sphere->size;
  const lanes before = 0.5 * inverse_b2 * cosine * cosine / ((bar.u_3 - u) * (u - bar.u_1)); /* u_t - u, from P(u) */
  inside sum = {{0}, {0}};
  ADD_PANEL(&sum, SPHERE_RULE, rate_back, &o, lanes_all(0), lanes_asinh(lanes_sqrt(before / bar.gap)));
  return (inside){2 * o.beta * sum.swept, 2 * (sphere->size * cosine + sum.length)};
}

/* Down to the horizon, -1 < delta < 0. */
LANES_INLINE inside schwarzschild_down(const bent_sphere *sphere, lanes delta, lanes cosine)
{
  const lanes b = 1 + delta, inverse_b2 = 1 / (27 * b * b), p0 = -delta * (2 + delta) * inverse_b2;
  /* The real root is u_1 = e - 1/6 with 2 e (e - 1/2)^2 = -p0: Newton from below, where the cubic is concave. */
  lanes e = lanes_max(-2 * p0, -1.1 * lanes_rough_root(0.5 * p0, 1.0 / 3));
  for (int i = 0; i < 12; i++) {
    const lanes below = e - 0.5;
    e -= (2 * e * below * below + p0) / (2 * below * (below + 2 * e));
  }
  const orbit o = {.is_isotropic = sphere->spacetime.chart == BENT_CHART_ISOTROPIC, .beta = 1 / lanes_sqrt(inverse_b2),
                   .u_1 = e - 1.0 / 6, .p = 1.0 / 3 - 0.5 * e, .q = lanes_sqrt(p0 / (1 - 2 * e) - 0.25 * e * e)};
  const double u = 1 / sphere->size, end = 0.5 * ARC_HORIZON;
  const lanes first = lanes_asinh((u - o.p) / o.q), last = lanes_asinh((HORIZON_U - o.p) / o.q);
  const lanes middle = lanes_min(lanes_all(0), last);
  inside sum = {{0}, {0}};
  ADD_PANEL(&sum, SPHERE_RULE, rate_down, &o, first, middle);
  ADD_PANEL(&sum, SPHERE_RULE, rate_down, &o, middle, last);
  ADD_PANEL(&sum, HORIZON_RULE, rate_horizon, &o, lanes_all(sqrt(1 - 2 * end)), lanes_all(sqrt(1 - 2 * HORIZON_U)));
  const lanes at_end = lanes_sqrt(1 + 27 * b * b * (end * end * (2 * end - 1))) / end; /* beta sqrt(P) / u */
  return (inside){o.beta * sum.swept, sphere->size * cosine - at_end + sum.length};
}

LANES_INLINE inside ellis_inside(const bent_sphere *sphere, int back, lanes delta, lanes cosine)
{
  const passage o = {.back = back, .b = 1 + delta, .root = lanes_sqrt(lanes_abs(delta) * (2 + delta))};
  /* The integrand is least smooth about l = 1: a panel on either side. */
  const double l = sqrt((sphere->size - 1) * (sphere->size + 1));
  const lanes up = back ? sphere->size * cosine : lanes_all(l); /* sqrt(l^2 - l_t^2) */
  const lanes last = lanes_asinh(up / o.root);
  const lanes one = back ? lanes_sqrt(lanes_max((1 - o.root) * (1 + o.root), lanes_all(0))) : lanes_all(1);
  const lanes middle = lanes_min(lanes_asinh(one / o.root), last);
  inside sum = {{0}, {0}};
  ADD_PANEL(&sum, SPHERE_RULE, rate_ellis, &o, lanes_all(0), middle);
  ADD_PANEL(&sum, SPHERE_RULE, rate_ellis, &o, middle, last);
  return back ? (inside){2 * sum.swept, 2 * sum.length} : sum;
}

/* Of rays in a column. size: delta / delta_max of SPHERE_BACK, -delta of SPHERE_DOWN, in (0, 1). */
LANES_INLINE inside inside_direct(const bent_sphere *sphere, int column, lanes size, lanes *cosine)
{
  const int back = column == SPHERE_BACK, is_ellis = sphere->spacetime.kind == BENT_ELLIS;
  const lanes delta = back ? sphere->delta_max * size : -size;
  const lanes under = sphere->critical * (back ? sphere->delta_max * (1 - size) : sphere->delta_max + size); /* 1 - sine */
  *cosine = lanes_sqrt(under * (2 - under));
  if (is_ellis) return ellis_inside(sphere, back, delta, *cosine);
  return back ? schwarzschild_back(sphere, delta, *cosine) : schwarzschild_down(sphere, delta, *cosine);
}
#endif
