/* Kerr, endpoint route, first half: launch, fate, and the plan of the radial integral. Kernel code.
 *
 * Units M = E = 1. In Mino time tau, with u = 1/r, lambda = L/E and eta = Q/E^2,
 *     u'^2 = U(u) = 1 + A u^2 + 2 K u^3 - B u^4,  A = s^2 - q, q = lambda^2 + eta, K = eta + (lambda - s)^2, B = s^2 eta
 * (Carter 1968), smooth to infinity. s = -a is the spin that the backward ray sees. U has one stationary point u_p that
 * matters; U(u_p) < 0 is the barrier that turns rays back, between the roots u_t < u_p < u_3. Solved here in x = 1 - u/u_p,
 * where U is a quartic that keeps the relative size of u_p - u_t at the critical ray:
 *     U = U(0) - (1 - U_p) G,  1 - G(x) = F(x) = x^2 (3 - (2 - 4 k) x - 3 k x^2) / (1 + k),  k = m / (3 - 4 m),  m = B u_p / K.
 * With the barrier, u = u_t - (u_3 - u_t) sinh^2 s removes both roots from the integrand; without it, u = u_p + e sinh s
 * with e^2 = U_p / (U''/2) spreads the near-double root. Either way tau and the frame dragging are sums over the same
 * Gauss-Legendre nodes, as many as the nearest singularity in the complex s plane asks for (Bernstein ellipse).
 */
#ifndef BENT_SPACETIME_ENDPOINT_KERR_H
#define BENT_SPACETIME_ENDPOINT_KERR_H
#include "spacetime/endpoint_lanes.h"
#include "spacetime/gauss_legendre.h"

typedef struct kerr_hole {
  double mass, spin;   /* spin s in units of the mass */
  double outer, inner; /* radii of the horizons in units of the mass */
} kerr_hole;

LANES_INLINE kerr_hole kerr_hole_make(const bent_spacetime *spacetime)
{
  /* A backward ray in a hole of spin a moves like a forward photon in one of spin -a. */
  const double mass = spacetime->mass, spin = -spacetime->spin / mass;
  const double outer = 1 + sqrt((mass - spacetime->spin) * (mass + spacetime->spin)) / mass;
  return (kerr_hole){mass, spin, outer, spin * spin / outer};
}

/* u^2 Delta = 1 - 2 u + s^2 u^2, in factors that keep their digits near the horizon. */
LANES_INLINE lanes kerr_u2_delta(const kerr_hole *hole, lanes u) { return (1 - hole->outer * u) * (1 - hole->inner * u); }

/* All that the second half needs of a ray, each member a lane vector so that a block of rays can be sorted as rows. */
typedef struct kerr_task {
  lanes lambda, eta, q;            /* constants of the motion, q = lambda^2 + eta */
  lanes cosine, sine;              /* of the polar angle at the start */
  lanes azimuth[2];                /* cos, sin of the azimuth at the start; (1, 0) on the axis */
  lanes p_theta, swing;            /* theta component of n' and L / sin(theta) at the start */
  lanes center, half;              /* interval of s */
  lanes origin, scale;             /* u_t and u_3 - u_t, or u_p and e */
  lanes c0, c1, c2;                /* U = (u_t - u)(u_3 - u)(c0 + c1 u + ..), or U = c0 + c1 d^2 + c2 d^3 - .. */
  lanes error;                     /* estimate, radians */
} kerr_task;

enum { KERR_TASK_LANES = sizeof(kerr_task) / sizeof(lanes) };

/* Which sum a ray needs: rule of gauss_legendre.h, with a barrier or without, short or long polar series. */
enum { KERR_WITHOUT_BARRIER = GAUSS_RULES, KERR_LONG_SERIES = 2 * GAUSS_RULES, KERR_SUMS = 4 * GAUSS_RULES };

typedef struct kerr_plan {
  kerr_task task;
  lanes_mask fate; /* BENT_UNRESOLVED: declined; BENT_ESCAPED: `sum` says how to find the direction */
  lanes_mask sum;
} kerr_plan;

/* Start of a ray: the radial state and the task's angular members. */
typedef struct kerr_start {
  lanes u, slope; /* u and du/dtau */
  lanes energy;   /* E before division by it, per local energy */
  lanes doubt;    /* relative error of the impact parameter */
} kerr_start;

LANES_INLINE lanes kerr_asinh(lanes x)
{
  const lanes size = lanes_abs(x), x2 = size * size;
  return lanes_copysign(lanes_log1p(size + x2 / (1 + lanes_sqrt(1 + x2))), x);
}

/* asinh(sqrt(y)), y >= 0 */
LANES_INLINE lanes kerr_asinh_root(lanes y) { return 0.5 * lanes_log1p(2 * (y + lanes_sqrt(y * (1 + y)))); }

/* Launch from an oblate-chart position along a local (ZAMO) direction: Bardeen, Press & Teukolsky 1972. */
LANES_INLINE kerr_start kerr_start_from(const kerr_hole *hole, const lanes position[3], const lanes direction[3],
                                        kerr_task *task)
{
  const double s = hole->spin, s2 = s * s;
  const lanes inverse_d = 1 / lanes_sqrt(lanes_dot(direction, direction));
  const lanes x = position[0] / hole->mass, y = position[1] / hole->mass, z = position[2] / hole->mass;
  const lanes across2 = x * x + y * y, part = 0.5 * (across2 + z * z - s2);
  const lanes r2 = part + lanes_sqrt(part * part + s2 * z * z), r = lanes_sqrt(r2), u = 1 / r;
  const lanes h2 = r2 + s2, inverse_h = 1 / lanes_sqrt(h2), across = lanes_sqrt(across2);
  const lanes_mask on_axis = across2 == 0;
  const lanes inverse_across = 1 / lanes_select(on_axis, lanes_all(1), across);
  task->azimuth[0] = lanes_select(on_axis, lanes_all(1), x * inverse_across);
  task->azimuth[1] = y * inverse_across;
  task->cosine = z * u, task->sine = across * inverse_h;
  const lanes c = task->cosine, sine = task->sine;
  const lanes delta = (r - hole->outer) * (r - hole->inner), sigma = r2 + s2 * c * c, area = h2 * h2 - sine * sine * s2 * delta;
  const lanes stretch = lanes_sqrt(area / sigma), root_delta = lanes_sqrt(delta), h = h2 * inverse_h;

  const lanes along = (direction[0] * task->azimuth[0] + direction[1] * task->azimuth[1]) * inverse_d;
  const lanes around = (direction[1] * task->azimuth[0] - direction[0] * task->azimuth[1]) * inverse_d;
  const lanes up = direction[2] * inverse_d;
  const lanes swing = around * stretch, angular = swing * sine;
  kerr_start start = {.u = u, .energy = root_delta / stretch + 2 * r * s * angular / area};
  const lanes inverse_e = 1 / start.energy;
  task->lambda = angular * inverse_e, task->swing = swing * inverse_e;
  task->p_theta = (h * c * along - r * sine * up) * inverse_e;
  start.slope = -u * u * root_delta * (r * sine * along + h * c * up) * inverse_e;
  /* Exactly equatorial motion has no nodal line; a tilt of 1e-60 gives it one. */
  lanes tilt2 = task->p_theta * task->p_theta + c * c * task->swing * task->swing;
  task->p_theta = lanes_select(tilt2 < 1e-120, lanes_all(1e-60), task->p_theta);
  tilt2 = lanes_max(tilt2, lanes_all(1e-120));
  task->eta = tilt2 - s2 * c * c, task->q = task->eta + task->lambda * task->lambda;
  start.doubt = DBL_EPSILON * (4 + r / lanes_sqrt(lanes_max(task->q, lanes_all(DBL_MIN))));
  return start;
}

/* U about its stationary point u_p: U = U_p + c2 d^2 + c3 d^3 - B d^4, d = u - u_p. */
typedef struct kerr_barrier {
  lanes A, K, B, u_p, U_p, c2, c3;
  lanes_mask exists; /* a stationary point between infinity and the horizon */
} kerr_barrier;

LANES_INLINE kerr_barrier kerr_find_peak(const kerr_hole *hole, const kerr_task *task, const kerr_start *start)
{
  const double s = hole->spin, s2 = s * s;
  const lanes across = task->lambda - s;
  kerr_barrier b = {.A = s2 - task->q, .K = task->eta + across * across, .B = s2 * task->eta};
  const lanes discriminant = 9 * b.K * b.K + 8 * b.A * b.B;
  const lanes u_p = -2 * b.A / (3 * b.K + lanes_sqrt(lanes_max(discriminant, lanes_all(0))));
  b.exists = (b.A < 0) & (discriminant >= 0) & (hole->outer * u_p < 1);
  b.u_p = lanes_select(b.exists, u_p, lanes_all(0));
  b.c2 = b.u_p * (3 * b.K - 4 * b.B * b.u_p), b.c3 = 2 * b.K - 4 * b.B * b.u_p;
  const lanes d = start->u - b.u_p, beside = d * d * (b.c2 + d * (b.c3 - b.B * d));
  /* Beside the peak the position tells U_p better than the impact parameter does. */
  b.U_p = lanes_select(b.exists & (lanes_abs(beside) < 0.05), start->slope * start->slope - beside,
                       1 - b.u_p * b.u_p * b.u_p * (b.K - b.B * b.u_p));
  return b;
}

/* The smaller root x of x^2 (3 + c x - 3 k x^2) = y: Newton from the series. A few steps do, except where two roots nearly
 * meet (spin near 1); a lane that has converged is frozen, so that its value does not depend on its neighbors. */
LANES_INLINE lanes kerr_root(lanes y, lanes c, lanes k3)
{
  const lanes t = lanes_sqrt(y * (1.0 / 3)), g = -c * (1.0 / 6);
  lanes x = t * (1 + t * (g + t * (2.5 * g * g + k3 * (1.0 / 6))));
  lanes_mask open = lanes_mask_all(1);
  for (int i = 0; i < 16 && lanes_any(open); i++) {
    const lanes value = x * x * (3 + x * (c - k3 * x)) - y, slope = x * (6 + x * (3 * c - 4 * k3 * x));
    const lanes step = value / lanes_max(slope, 1e-3 * t);
    x = lanes_select(open, x - step, x);
    open &= lanes_abs(step) > 1e-9 * x; /* the step that is left is its square */
  }
  return x;
}

/* Interval of s, roots and cofactor for rays with a barrier; returns rho of the Bernstein ellipse of the integrand. */
LANES_INLINE lanes kerr_plan_barrier(const kerr_barrier *b, const kerr_start *start, kerr_task *task)
{
  const lanes m = b->B * b->u_p / b->K, k = m / (3 - 4 * m), rise = 1 - b->U_p;
  const lanes y = -b->U_p / rise, cubic = 2 - 4 * k;
  const lanes_mask near_critical = y < 0.5;
  /* u_t from F(x) = y, or, far from critical, from G(v) = 1 / (1 - U_p) in v = u / u_p. The same quartic family. */
  const lanes v_k = m / (3 - 2 * m), v_scale = 3 / (3 - 2 * m);
  const lanes root = kerr_root(lanes_select(near_critical, y * (1 + k), (1 - m) * v_scale / rise),
                               lanes_select(near_critical, -cubic, -2 * v_scale),
                               lanes_select(near_critical, 3 * k, -3 * v_k));
  const lanes w = kerr_root(y * (1 + k), cubic, 3 * k);
  const lanes x = lanes_select(near_critical, root, 1 - root), v = lanes_select(near_critical, 1 - root, root);
  const lanes u_t = b->u_p * v, u_3 = b->u_p * (1 + w), gap = b->u_p * (x + w);
  task->origin = u_t, task->scale = gap;
  task->c0 = 1 / (u_t * u_3), task->c1 = (u_t + u_3) * task->c0 * task->c0;
  const lanes u_o = start->u, cofactor = task->c0 + u_o * (task->c1 - b->B * u_o);
  const lanes before = start->slope * start->slope / ((u_3 - u_o) * cofactor); /* u_t - u_o */
  const lanes s_0 = kerr_asinh_root(u_t / gap), s_o = kerr_asinh_root(lanes_max(before, lanes_all(0)) / gap);
  const lanes s_in = lanes_copysign(s_o, -start->slope);
  task->center = 0.5 * (s_0 + s_in), task->half = 0.5 * (s_0 - s_in);
  /* Singular where the cofactor vanishes, u_1 < 0, and at Im s = pi/2, where frame dragging has its poles. */
  const lanes u_1 = -2 * task->c0 / (task->c1 + lanes_sqrt(task->c1 * task->c1 + 4 * b->B * task->c0));
  const lanes s_1 = kerr_asinh_root((u_t - u_1) / gap), inverse = 1 / lanes_max(task->half, lanes_all(1e-30));
  const lanes real = lanes_max((s_1 - lanes_abs(task->center)) * inverse, lanes_all(1));
  const lanes imaginary = 0.5 * M_PI * inverse;
  const lanes rho = lanes_min(real + lanes_sqrt(real * real - 1), imaginary + lanes_sqrt(imaginary * imaginary + 1));
  /* At the horizon of a maximal hole u_3 may all but meet the next root, and is then not known well enough: no rule will do. */
  const lanes apart = 6 + w * (3 * cubic - 12 * k * w);
  return lanes_select(apart < 0.01, lanes_all(1), rho);
}

/* A lower bound of the distance from u to the complex roots of U: inside it the terms of the Taylor series at u add up to
 * less than the first. */
LANES_INLINE lanes kerr_root_distance(const kerr_barrier *b, lanes u)
{
  const lanes inverse = 1 / (1 + u * u * (b->A + u * (2 * b->K - b->B * u)));
  const lanes t1 = lanes_abs(u * (2 * b->A + u * (6 * b->K - 4 * b->B * u)) * inverse);
  const lanes t2 = lanes_abs((b->A + u * (6 * b->K - 6 * b->B * u)) * inverse);
  const lanes t3 = lanes_abs((2 * b->K - 4 * b->B * u) * inverse), t4 = lanes_abs(b->B * inverse);
  return 1 / (t1 + lanes_sqrt(t2) + 1.1 * lanes_rough_root(t3 + 1e-30, 1.0 / 3) + lanes_sqrt(lanes_sqrt(t4)));
}

/* The same without a barrier: rays on their way out. */
LANES_INLINE lanes kerr_plan_free(const kerr_hole *hole, const kerr_barrier *b, const kerr_start *start, kerr_task *task)
{
  /* narrow: the complex roots of U are near u_p -+ i e, because there the cubic term is smaller than the quadratic one. */
  const lanes_mask narrow = b->exists & (b->U_p < b->c2) & (b->c3 * b->c3 * b->U_p < b->c2 * b->c2 * b->c2);
  const lanes e = lanes_select(narrow, lanes_sqrt(lanes_max(b->U_p, lanes_all(1e-300)) / b->c2), lanes_all(1));
  const lanes u_p = lanes_select(narrow, b->u_p, lanes_all(0)), inverse_e = 1 / e;
  task->origin = u_p, task->scale = e;
  task->c0 = lanes_select(narrow, b->U_p, lanes_all(1));
  task->c1 = lanes_select(narrow, b->c2, b->A), task->c2 = lanes_select(narrow, b->c3, 2 * b->K);
  const lanes first = kerr_asinh(-u_p * inverse_e), last = kerr_asinh((start->u - u_p) * inverse_e);
  task->center = 0.5 * (first + last), task->half = 0.5 * (last - first);
  /* U = 0 at u_1 = -g < 0: three Newton steps from a lower bound of g. */
  const lanes fall = lanes_max(-b->A, lanes_all(0));
  lanes g = 1 / (lanes_sqrt(fall) + 1.1 * lanes_rough_root(2 * b->K + 1e-30, 1.0 / 3) + lanes_sqrt(lanes_sqrt(lanes_abs(b->B))));
  for (int i = 0; i < 3; i++)
    g += (1 - g * g * (fall + g * (2 * b->K + b->B * g))) / (g * (2 * fall + g * (6 * b->K + 4 * b->B * g)));
  const lanes inverse = 1 / lanes_max(task->half, lanes_all(1e-30));
  const lanes left = (task->center - kerr_asinh((-g - u_p) * inverse_e)) * inverse;
  const lanes right = (kerr_asinh((1 / hole->outer - u_p) * inverse_e) - task->center) * inverse;
  lanes nearest = lanes_min(left, right);
  const lanes imaginary = 0.5 * M_PI * inverse;
  /* Without a near-double root the complex roots of U may lie anywhere: no nearer than this. */
  const lanes clear = kerr_root_distance(b, 0.5 * start->u) / (0.5 * start->u);
  nearest = lanes_select(narrow, nearest, lanes_min(nearest, clear));
  const lanes real = lanes_max(nearest, lanes_all(1));
  return lanes_min(real + lanes_sqrt(real * real - 1), imaginary + lanes_sqrt(imaginary * imaginary + 1));
}

/* The first rule whose error, bound / rho^(2 N), is below `wanted`; GAUSS_RULES if none is. */
LANES_INLINE lanes_mask kerr_rule(lanes rho, lanes bound, lanes wanted)
{
  const lanes p1 = 1 / (rho * rho), p2 = p1 * p1, p4 = p2 * p2, p8 = p4 * p4, p16 = p8 * p8, p32 = p16 * p16;
  const lanes limit = wanted / bound;
  const lanes power[GAUSS_RULES] = {p8, p8 * p4, p16, p16 * p4, p16 * p8, p32, p32 * p16, p32 * p32};
  lanes_mask rule = {0};
  for (int i = 0; i < GAUSS_RULES; i++) rule -= power[i] > limit;
  return rule;
}

/* What rounding does to a ray that escapes. */
typedef struct kerr_rounding {
  lanes critical;  /* relative error of U at the barrier: beyond 0.1 the fate is uncertain */
  lanes faint;     /* of a ray that passes far from the hole, radians: u cancels in the sums */
  lanes turn;      /* rate at which n turns, about: sqrt(q) */
  lanes drag_rate; /* frame dragging where the ray comes closest to the horizon, d(J)/d(tau) */
  lanes total;     /* error of the direction, radians */
} kerr_rounding;

LANES_INLINE kerr_rounding kerr_expect_rounding(const kerr_hole *hole, const kerr_task *task, const kerr_start *start,
                                                const kerr_barrier *b)
{
  const lanes_mask below = start->u < b->u_p, inward = start->slope > 0;
  const lanes slope2 = start->slope * start->slope;
  const lanes lowest = lanes_select(b->exists & ~below, lanes_min(lanes_abs(b->U_p), slope2), slope2);
  const lanes past = lanes_select(b->exists, 2 * start->doubt * (1 - b->U_p) / lanes_abs(b->U_p), lanes_all(0));
  const lanes on = 2 * start->doubt / lowest; /* a ray going out need not pass the peak */
  kerr_rounding r = {.critical = lanes_select(inward, past, lanes_min(past, on))};
  r.turn = lanes_sqrt(lanes_max(task->q, lanes_all(1e-30)));
  r.faint = 2 * DBL_EPSILON * lanes_sqrt(r.turn);
  const lanes bends = lanes_max(b->c2 + lanes_abs(b->c3) * b->u_p, lanes_all(DBL_MIN));
  const lanes short_by = lanes_sqrt(lanes_max(-b->U_p, lanes_all(0)) / bends); /* of the peak, at the turning point */
  const lanes closest = lanes_select(inward, lanes_max(b->u_p - short_by, start->u), start->u);
  const lanes u2_delta = kerr_u2_delta(hole, closest);
  r.drag_rate = lanes_abs(hole->spin * closest * (2 - hole->spin * task->lambda * closest)) / u2_delta;
  /* The angles swept and dragged through grow by `critical` of their rates for every e-fold of winding. Factors by
   * measurement: the worst errors are 1.4 times the total. */
  const lanes winding = (r.turn + 0.5 * r.drag_rate) / lanes_sqrt(lanes_max(b->c2, lanes_all(1e-6)));
  r.total = DBL_EPSILON * (16 + 4 * r.turn * start->u + 2 * r.drag_rate / lanes_sqrt(u2_delta)) + r.faint +
            2 * r.critical * (1 + winding);
  return r;
}

/* Fate, the sum that finds the direction, and the error to expect of it. */
LANES_INLINE kerr_plan kerr_plan_ray(const kerr_hole *hole, double tolerance, const lanes position[3],
                                     const lanes direction[3])
{
  kerr_plan plan;
  kerr_task *task = &plan.task;
  task->c2 = lanes_all(0);
  const kerr_start start = kerr_start_from(hole, position, direction, task);
  const kerr_barrier b = kerr_find_peak(hole, task, &start);
  const kerr_rounding rounding = kerr_expect_rounding(hole, task, &start, &b);
  const lanes_mask barrier = b.exists & (b.U_p < 0), below = start.u < b.u_p, inward = start.slope > 0;
  const lanes_mask escapes = (barrier & below) | (~barrier & ~inward);

  lanes rho = lanes_all(1);
  if (lanes_any(barrier & escapes)) rho = kerr_plan_barrier(&b, &start, task);
  if (lanes_any(~barrier & escapes)) {
    kerr_task other = *task;
    const lanes other_rho = kerr_plan_free(hole, &b, &start, &other);
    rho = lanes_select(barrier, rho, other_rho);
    for (int i = 0; i < KERR_TASK_LANES; i++)
      ((lanes *)task)[i] = lanes_select(barrier, ((lanes *)task)[i], ((lanes *)&other)[i]);
  }
  /* Without a barrier the complex roots lie somewhat closer than at Im s = pi/2: a larger constant, by measurement. */
  const lanes rate = 1 + rounding.turn + rounding.drag_rate;
  const lanes bound = lanes_select(barrier, lanes_all(4), lanes_all(60)) * rate * task->half;
  const lanes_mask rule = kerr_rule(rho, bound, lanes_max(lanes_all(tolerance), rounding.total));
  task->error = rounding.total + lanes_min(lanes_all(tolerance), lanes_all(1)); /* the rule's own part, bounded by choice */
  const lanes pole = hole->spin * hole->spin / (task->q - hole->spin * hole->spin); /* about 1 / sinh^2 of Im chi */
  plan.sum = rule + (~barrier & KERR_WITHOUT_BARRIER) + ((pole > 0.1) & KERR_LONG_SERIES);

  const lanes_mask certain = rounding.critical < 0.1, sharp = rounding.total <= fmax(tolerance, BENT_TRACE_ERROR_MAX);
  const lanes_mask sound = (start.energy > 1e-3) & (rounding.faint < fmax(tolerance, 1e-13));
  const lanes_mask answerable = sharp & (rule < GAUSS_RULES) & (task->eta >= 0) & (pole >= 0) & (pole < 0.9);
  plan.fate = certain & sound & ((escapes & answerable & BENT_ESCAPED) | (~escapes & BENT_CAPTURED));
  return plan;
}
#endif
