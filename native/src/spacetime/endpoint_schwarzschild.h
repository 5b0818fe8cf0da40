/* Schwarzschild, endpoint route: the swept angle by one or two Carlson R_F. Kernel code.
 *
 * With u = M/r and beta = b/M the orbit obeys (du/d(phi))^2 = P(u) = 1/beta^2 - u^2 + 2 u^3. In d = u - 1/3 that is
 * p0 + d^2 + 2 d^3 with p0 = 1/beta^2 - 1/27: the photon sphere is d = 0 and p0 keeps its relative accuracy at the critical
 * impact parameter, beta = sqrt(27). Rays with p0 < 0 meet a barrier between the roots u_t < 1/3 < u_3.
 */
#ifndef BENT_SPACETIME_ENDPOINT_SCHWARZSCHILD_H
#define BENT_SPACETIME_ENDPOINT_SCHWARZSCHILD_H
#include "spacetime/endpoint_lanes.h"
#include "spacetime/schwarzschild_place.h"

/* x in [0, 1/2] with x^2 (3 - 2 x) = y, 0 <= y <= 1/2, to full relative accuracy: a root of P in units of 1/3. */
LANES_INLINE lanes inverse_smoothstep(lanes y)
{
  const lanes t = lanes_sqrt(y * (1.0 / 3));
  lanes x = t * (1 + t * (1.0 / 3 + t * (5.0 / 18 + t * (8.0 / 27)))); /* Lagrange series: 1 % at worst */
  for (int i = 0; i < 3; i++) x -= (x * x * (3 - 2 * x) - y) / lanes_max(6 * x * (1 - x), lanes_all(DBL_MIN));
  return x;
}

/* The roots u_1 < 0 < u_t < u_3 of P of a ray with a barrier; d = u - 1/3; gap = u_3 - u_t. */
typedef struct barrier {
  lanes u_1, u_t, u_3, d_t, d_3, gap;
} barrier;

/* y = -27 p0 in (0, 1], inverse_b2 = 1 / beta^2. The roots are deflated in d where the two next to the barrier stay apart,
 * and in u where the two next to infinity do. */
LANES_INLINE barrier barrier_of(lanes y, lanes inverse_b2)
{
  const lanes_mask near_critical = y < 0.5;
  const lanes x = inverse_smoothstep(lanes_select(near_critical, y, 27 * inverse_b2));
  barrier b;
  b.d_t = lanes_select(near_critical, -x, x - 1) * (1.0 / 3);
  b.u_t = lanes_select(near_critical, 1 - x, x) * (1.0 / 3);
  const lanes sum = -0.5 - b.d_t, product = y * (1.0 / 54) / b.d_t;
  b.d_3 = product / (0.5 * (sum - lanes_sqrt(sum * sum - 4 * product)));
  b.u_3 = b.d_3 + 1.0 / 3, b.u_1 = -0.5 * inverse_b2 / (b.u_t * b.u_3), b.gap = b.d_3 - b.d_t;
  return b;
}

/* Angle swept from u_o to infinity by a ray with a barrier that starts below it, going out or first in to the turning
 * point. slope2 = P(u_o), y = -27 p0 in (0, 1], inverse_b2 = 1 / beta^2. */
LANES_INLINE lanes sweep_with_barrier(lanes y, lanes inverse_b2, lanes d_o, lanes u_o, lanes slope2, lanes_mask inward)
{
  const barrier b = barrier_of(y, inverse_b2);
  const lanes rise = b.u_t - b.u_1;
  const lanes first = lanes_sqrt(b.u_t) * lanes_rf(b.u_3 * rise, -b.u_1 * b.gap, b.gap * rise);
  /* u_t - u_o from P(u_o), which is known to relative accuracy also close to the turning point. */
  const lanes before = 0.5 * slope2 / ((b.d_3 - d_o) * (u_o - b.u_1));
  const lanes second = lanes_sqrt(before) * lanes_rf((b.d_3 - d_o) * rise, (u_o - b.u_1) * b.gap, b.gap * rise);
  return M_SQRT2 * (first + lanes_select(inward, second, -second));
}

/* Angle swept on the way out from u_o to infinity when P has no root there: p0 > 0. P = (u + g) times a quadratic without
 * real roots; Carlson 1991 (Math. Comp. 56), case of one real and two complex roots. */
LANES_INLINE lanes sweep_without_barrier(lanes inverse_b2, lanes b2, lanes u_o, lanes slope2)
{
  /* g = 1/h with h^3 = (2 + h) beta^2: Newton from just above, where the cubic is convex. */
  lanes h = 1.07 * lanes_rough_root(2 * b2, 1.0 / 3) + 0.45 * lanes_sqrt(b2);
  for (int i = 0; i < 5; i++) {
    const lanes h2 = h * h;
    h = 2 * (h * h2 + b2) / (3 * h2 - b2);
  }
  /* P = (u + g) (f + q u + 2 u^2) */
  const lanes g = 1 / h, f = inverse_b2 * h, q = -f * h;
  const lanes rise = lanes_sqrt(f) + lanes_sqrt(slope2 / (g + u_o));
  const lanes root = (lanes_sqrt(g) + lanes_sqrt(g + u_o)) / u_o;
  const lanes m2 = (rise * rise - 2 * u_o * u_o) * root * root, middle = m2 + 4 * g - q;
  const lanes spread = 2 * M_SQRT2 * lanes_sqrt(f - q * g + 2 * g * g);
  return 4 * lanes_rf(m2, lanes_max(middle - spread, lanes_all(DBL_MIN)), middle + spread);
}

LANES_INLINE endpoint endpoint_schwarzschild(double mass, int is_isotropic, const aim *a)
{
  const schwarzschild_place at = schwarzschild_place_at(mass, is_isotropic, a->radius);
  const lanes u = mass * at.w, d = mass * at.above, lapse = at.lapse, sine = lanes_max(a->sine, lanes_all(1e-60));
  const lanes scale = u * lapse / sine, inverse_b2 = scale * scale, b2 = 1 / inverse_b2, beta = 1 / scale;
  const lanes slope2 = inverse_b2 * a->cosine * a->cosine;
  /* y = -27 p0; beside the photon sphere the position tells it better than beta does. */
  const double critical = 5.19615242270663188058;
  const lanes_mask beside = lanes_abs(d) < 0.05;
  const lanes y = lanes_select(beside, 27 * (d * d * (1 + 2 * d) - slope2), (beta - critical) * (beta + critical) * inverse_b2);
  const lanes_mask barrier = y > 0, inward = a->cosine < 0;
  const lanes_mask escapes = (barrier & (d < 0)) | (~barrier & ~inward);

  endpoint end;
  end.swept = lanes_all(NAN);
  if (lanes_any(barrier & escapes)) {
    const lanes safe = lanes_max(lanes_min(y, lanes_all(1)), lanes_all(1e-40));
    end.swept = sweep_with_barrier(safe, inverse_b2, d, u, slope2, inward);
  }
  if (lanes_any(~barrier & escapes))
    end.swept = lanes_select(barrier, end.swept, sweep_without_barrier(inverse_b2, b2, u, slope2));
  end.swept = lanes_select(escapes, end.swept, lanes_all(NAN));

  /* How far y is known, then what that does to the swept angle: at most d(phi)/d(ln beta) = phi / (beta^2 min P). */
  const lanes doubt = DBL_EPSILON * (4 + 1 / sine); /* relative, of beta */
  const lanes off = lanes_abs(beta - critical), past_far = 2 * doubt * beta / off;
  const lanes uncertain = DBL_EPSILON * (54 * lanes_abs(d) + 2 * lanes_abs(a->cosine));
  const lanes past = lanes_select(beside, uncertain / lanes_abs(y), past_far);
  const lanes lowest = lanes_select(d < 0, slope2, lanes_min(slope2, lanes_abs(y) * (1.0 / 27)));
  const lanes on = doubt * end.swept * inverse_b2 / lowest;
  end.error = 4 * DBL_EPSILON * (1 + end.swept) + lanes_select(inward, past, lanes_min(past, on));
  const lanes_mask certain = past < 0.125;
  end.fate = (certain | (~inward & (d < -0.05))) & ((escapes & BENT_ESCAPED) | (~escapes & BENT_CAPTURED));
  endpoint_turn(&end, a);
  return end;
}
#endif
