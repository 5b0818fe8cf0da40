/* The Kerr metric for arc.h: Boyer-Lindquist coordinates drawn on flat oblate spheroids, axis +z.
 *
 * In Mino time, with w = 1/r and n the unit vector (sin th cos ph, sin th sin ph, cos th) in axes that the hole drags along
 * (Carter 1968; Mino 2003):
 *     w'^2 = P(w) = E^2 + (s^2 E^2 - C) w^2 + 2M K w^3 - s^2 Q w^4,   C = Q + L^2,  K = (L - sE)^2 + Q
 *     n''  = -(C + 2 s^2 E^2 n_z^2) n + s^2 E^2 n_z z,                |n'|^2 = C + s^2 E^2 n_z^2
 *     drag' = s (2 M E w - s L w^2) / (1 - 2 M w + s^2 w^2)
 * Nothing is singular on the axis, at turning points or at infinity. s is the spin that the backward ray sees (arc.h).
 */
#ifndef BENT_SPACETIME_KERR_H
#define BENT_SPACETIME_KERR_H
#ifndef BENT_SPACETIME_ARC_H
#error "include spacetime/arc.h"
#endif

/* w^2 Delta, in factors that keep their digits near the horizon. */
LANES_INLINE lanes kerr_delta(const arc_space *space, lanes w)
{
  return (1 - space->outer * w) * (1 - space->inner * w);
}

/* Functions of the place that the local frame is made of, all scaled by powers of w to be finite at infinity. */
typedef struct kerr_place {
  lanes cos_phi, sin_phi, cos_theta, sin_theta; /* on the axis phi = 0 */
  lanes sigma, delta, area; /* w^2 Sigma, w^2 Delta, w^4 A */
  lanes stretch;            /* sqrt(1 + s^2 w^2) */
} kerr_place;

/* horizontal = sqrt(x^2 + y^2) of a point at this azimuth. */
LANES_INLINE void kerr_set_azimuth(lanes x, lanes y, lanes horizontal, kerr_place *at)
{
  const lanes_mask on_axis = horizontal == 0;
  const lanes inverse = 1 / lanes_select(on_axis, lanes_all(1), horizontal);
  at->cos_phi = lanes_select(on_axis, lanes_all(1), x * inverse);
  at->sin_phi = y * inverse;
}

/* Needs the angles; delta is given because it loses digits near the horizon when computed from w. */
LANES_INLINE void kerr_set_metric(const arc_space *space, lanes w, lanes delta, kerr_place *at)
{
  const lanes sw2 = space->spin * space->spin * w * w;
  at->delta = delta;
  at->sigma = 1 + sw2 * at->cos_theta * at->cos_theta;
  at->area = (1 + sw2) * (1 + sw2) - sw2 * delta * at->sin_theta * at->sin_theta;
  at->stretch = lanes_sqrt(1 + sw2);
}

/* The place of a point of the chart, and w = 1/r there. */
LANES_INLINE lanes kerr_place_at(const arc_space *space, const lanes x[3], kerr_place *at)
{
  const double s2 = space->spin * space->spin;
  const lanes horizontal2 = x[0] * x[0] + x[1] * x[1], horizontal = lanes_sqrt(horizontal2);
  const lanes half = 0.5 * (horizontal2 + x[2] * x[2] - s2);
  const lanes r = lanes_sqrt(half + lanes_sqrt(half * half + s2 * x[2] * x[2])), w = 1 / r;
  kerr_set_azimuth(x[0], x[1], horizontal, at);
  at->cos_theta = x[2] * w;
  at->sin_theta = horizontal / lanes_sqrt(r * r + s2);
  kerr_set_metric(space, w, (r - space->outer) * (r - space->inner) * w * w, at);
  return w;
}

/* The ratio of the ZAMO's clock to the one at infinity. */
LANES_INLINE lanes kerr_lapse(const kerr_place *at) { return lanes_sqrt(at->sigma * at->delta / at->area); }

/* The flat basis of the chart, which stands for the ZAMO tetrad. */
LANES_INLINE void kerr_chart_basis(const kerr_place *at, lanes er[3], lanes et[3], lanes ep[3])
{
  const lanes inverse = 1 / lanes_sqrt(at->sigma), sine = at->sin_theta * inverse, cosine = at->cos_theta * inverse;
  er[0] = sine * at->cos_phi, er[1] = sine * at->sin_phi, er[2] = at->stretch * cosine;
  et[0] = at->stretch * cosine * at->cos_phi, et[1] = at->stretch * cosine * at->sin_phi, et[2] = -sine;
  ep[0] = -at->sin_phi, ep[1] = at->cos_phi, ep[2] = lanes_all(0);
}

/* Relative error that rounding brings to the drag angle. Its rate is divided by 1 - r_plus w, least at the ray's `deepest`
 * point. And where P is small and flat at the start the ray lingers: an error of the terms A w^2, C w^3, -B w^4 of P counts
 * by their size over what P rises to meanwhile. */
LANES_INLINE lanes kerr_drag_doubt(const arc_space *space, const arc_ray *ray, lanes deepest, lanes A, lanes C, lanes B)
{
  const lanes w = ray->w, w2 = w * w, speed = lanes_abs(ray->v);
  const lanes size = ray->energy * ray->energy + w2 * (lanes_abs(A) + w * (C + w * lanes_abs(B)));
  const lanes first = w2 * lanes_abs(2 * A + w * (3 * C - 4 * w * B)), second = w2 * lanes_abs(A + 3 * w * (C - 2 * w * B));
  const lanes third = w2 * w * lanes_abs(C - 4 * w * B);
  const lanes rise = speed * speed + first + speed * lanes_sqrt(second) +
                     lanes_rough_root(third * speed * speed * speed * speed + 1e-300, 1.0 / 3);
  return EPSILON * (32 / (1 - space->outer * deepest) + 8 * size / lanes_max(rise, lanes_all(1e-300)));
}

/* The stationary point of P nearest to infinity, and the depth and fate that follow from P there. P falls up to that point
 * and is a square at the horizon, so without one outside the horizon nothing turns a ray round. */
LANES_INLINE void kerr_find_barrier(const arc_space *space, arc_ray *ray)
{
  const double M = space->mass, s = space->spin;
  const lanes E = ray->energy, L = ray->momentum, E2 = E * E, sE2 = s * s * E2;
  const lanes K = (L - s * E) * (L - s * E) + ray->carter, A = sE2 - ray->curl, B = s * s * ray->carter;
  const lanes discriminant = 9 * M * M * K * K + 8 * A * B;
  const lanes root = lanes_sqrt(lanes_max(discriminant, lanes_all(0)));
  const lanes stationary = -2 * A / (3 * M * K + root);
  const lanes_mask none = (A >= 0) | (discriminant < 0) | (stationary >= space->horizon);
  const lanes w = lanes_select(none, lanes_all(0), stationary);
  ray->peak = w;
  /* P(peak) from P at the ray's own place, so that it keeps its digits near the top of the barrier */
  const lanes x = ray->w - w, bend = lanes_select(none, A, w * (3 * M * K - 4 * B * w));
  const lanes barrier = ray->v * ray->v - x * x * (bend + x * (2 * M * K - B * (4 * w + x)));
  /* Near the top of the barrier a ray winds by its own motion and by dragging, and errors grow with the rate of both. Where
   * the top is close to the horizon of a nearly maximal hole dragging is by far the faster. A ray that turns round stays
   * `short_by` of the top. */
  const lanes bends = lanes_abs(bend) + lanes_abs(2 * M * K - 4 * B * w) * w;
  const lanes short_by = lanes_sqrt(lanes_max(-barrier, lanes_all(0)) / lanes_max(bends, lanes_all(1e-300)));
  const lanes_mask turns = (ray->v > 0) & (ray->w < w);
  const lanes closest = lanes_select(turns, lanes_max(w - short_by, ray->w), lanes_min(w, ray->w));
  const lanes drag = s * closest * (2 * M * E - s * L * closest) / kerr_delta(space, closest);
  const lanes turning = lanes_sqrt(lanes_max(ray->curl, lanes_all(0)) + sE2);
  const lanes gain = 1 + 0.5 * lanes_abs(drag) / lanes_max(turning, lanes_all(1e-300));
  arc_judge(ray, barrier, E2 + lanes_abs(A) * w * w, gain);
  ray->drag_doubt = kerr_drag_doubt(space, ray, lanes_max(closest, ray->w), A, 2 * M * K, B);
  ray->doomed |= E <= 0;
}

LANES_INLINE void kerr_launch(const arc_space *space, const lanes origin[3], const lanes direction[3], arc_ray *ray)
{
  const double M = space->mass, s = space->spin;
  kerr_place at;
  lanes er[3], et[3], ep[3];
  const lanes w = kerr_place_at(space, origin, &at), r = 1 / w;
  kerr_chart_basis(&at, er, et, ep);
  const lanes toward_phi = lanes_dot(direction, ep) * r * lanes_sqrt(at.area / at.sigma); /* L / sin theta */
  const lanes p_theta = lanes_dot(direction, et) * r * lanes_sqrt(at.sigma), L = toward_phi * at.sin_theta;
  const lanes E = kerr_lapse(&at) + (2 * M * s) * w * w * w / at.area * L, sE2 = s * s * E * E;
  ray->energy = E;
  ray->momentum = L;
  ray->carter = p_theta * p_theta + at.cos_theta * at.cos_theta * (toward_phi * toward_phi - sE2);
  ray->curl = ray->carter + L * L;
  ray->weight = lanes_sqrt(lanes_max(ray->curl, lanes_all(0)) + sE2 + M * M * E * E) / lanes_abs(E);
  ray->w = w;
  ray->v = -lanes_sqrt(at.sigma * at.delta) * lanes_dot(direction, er);
  ray->n[0] = at.sin_theta * at.cos_phi, ray->n[1] = at.sin_theta * at.sin_phi, ray->n[2] = at.cos_theta;
  ray->m[0] = p_theta * at.cos_theta * at.cos_phi - toward_phi * at.sin_phi;
  ray->m[1] = p_theta * at.cos_theta * at.sin_phi + toward_phi * at.cos_phi;
  ray->m[2] = -p_theta * at.sin_theta;
  ray->drag = ray->swept = lanes_all(0);
  ray->doubt = arc_launch_doubt(ray, 5 * M) + EPSILON / (1 - space->outer * w); /* the lapse loses digits too */
  kerr_find_barrier(space, ray);
}

LANES_INLINE void kerr_expand(const arc_space *space, const arc_ray *ray, lanes tolerance, int order, arc *arc)
{
  const double M = space->mass, s = space->spin, s2 = s * s;
  lanes *w = arc->series[ARC_W], *x = arc->series[ARC_NX], *y = arc->series[ARC_NY], *z = arc->series[ARC_NZ];
  lanes *drag = arc->series[ARC_DRAG];
  lanes w2[ARC_ORDER_MAX], pull[ARC_ORDER_MAX], turn[ARC_ORDER_MAX], rate[ARC_ORDER_MAX], delta[ARC_ORDER_MAX];
  const lanes E = ray->energy, L = ray->momentum, sE2 = s2 * E * E, K = (L - s * E) * (L - s * E) + ray->carter;
  const lanes c1 = sE2 - ray->curl, c2 = 3 * M * K, c3 = -2 * s2 * ray->carter;
  const lanes drag1 = 2 * M * s * E, drag2 = -s2 * L;
  const lanes inverse = 1 / kerr_delta(space, ray->w);
  w[0] = ray->w, x[0] = ray->n[0], y[0] = ray->n[1], z[0] = ray->n[2];
  w[1] = ray->v, x[1] = ray->m[0], y[1] = ray->m[1], z[1] = ray->m[2];
  drag[0] = ray->drag;
#pragma GCC unroll 32
  for (int k = 0; k < order; k++) {
    w2[k] = series_square(w, k);
    delta[k] = s2 * w2[k] - 2 * M * w[k];
    rate[k] = (drag1 * w[k] + drag2 * w2[k] - series_product_tail(delta, rate, k)) * inverse;
    drag[k + 1] = rate[k] * (1.0 / (k + 1));
    if (k + 2 > order) break;
    const double q = 1.0 / ((k + 1) * (k + 2));
    pull[k] = c2 * w[k] + c3 * w2[k];
    w[k + 2] = (c1 * w[k] + series_product(pull, w, k)) * q;
    turn[k] = 2 * sE2 * series_square(z, k);
    if (k == 0) turn[k] += ray->curl;
    x[k + 2] = series_product(turn, x, k) * -q;
    y[k + 2] = series_product(turn, y, k) * -q;
    z[k + 2] = (sE2 * z[k] - series_product(turn, z, k)) * q;
  }
  const lanes weight = lanes_min(ray->weight, 2 / lanes_max(ray->w, lanes_all(1e-300)));
  const lanes_mask ignore_drag = ray->doomed & -(int64_t)(space->ends_only != 0);
  lanes size[4];
  for (int i = 0; i < 4; i++) {
    const int o = order - i;
    size[i] = lanes_max(lanes_abs(x[o]), lanes_max(lanes_abs(y[o]), lanes_abs(z[o]))) + weight * lanes_abs(w[o]) +
              lanes_select(ignore_drag, lanes_all(0), lanes_abs(drag[o]));
  }
  const lanes speed = lanes_sqrt(lanes_dot(ray->m, ray->m)) + lanes_abs(s * E);
  const lanes longest = lanes_min(ARC_TURN_MAX / (speed + 1e-200),
                                  (ray->w + space->horizon) / (lanes_abs(ray->v) + 1e-200));
  arc->step = lanes_min(arc_step_length(size, order, tolerance), longest);
}

LANES_INLINE void kerr_advance(const arc_space *space, const arc *arc, lanes offset, arc_ray *ray)
{
  const lanes(*series)[ARC_ORDER_MAX + 1] = arc->series;
  const lanes sE2 = space->spin * space->spin * ray->energy * ray->energy;
  const lanes speed0 = lanes_sqrt(lanes_dot(ray->m, ray->m)), bend0 = ray->n[2] * ray->m[2];
  series_with_slope(series[ARC_W], arc->order, offset, &ray->w, &ray->v);
  for (int k = 0; k < 3; k++) series_with_slope(series[ARC_NX + k], arc->order, offset, &ray->n[k], &ray->m[k]);
  ray->drag = series_at(series[ARC_DRAG], arc->order, offset);
  /* Hermite's rule for the integral of |n'|, whose derivative is sE2 n_z n'_z / |n'| */
  const lanes speed1 = lanes_sqrt(lanes_dot(ray->m, ray->m)), bend1 = ray->n[2] * ray->m[2];
  const lanes slopes = sE2 * (bend0 / (speed0 + 1e-200) - bend1 / (speed1 + 1e-200));
  ray->swept += offset * (0.5 * (speed0 + speed1) + offset * slopes * (1.0 / 12));
}

LANES_INLINE void kerr_position(const arc_space *space, const arc_ray *ray, const arc *arc, lanes offset, lanes w,
                                lanes numerator[3])
{
  const lanes(*series)[ARC_ORDER_MAX + 1] = arc->series;
  (void)ray;
  const lanes x = series_at(series[ARC_NX], arc->order, offset), y = series_at(series[ARC_NY], arc->order, offset);
  const lanes stretch = lanes_sqrt(1 + space->spin * space->spin * w * w);
  lanes sine, cosine;
  lanes_sincos(series_at(series[ARC_DRAG], arc->order, offset), &sine, &cosine);
  numerator[0] = stretch * (cosine * x - sine * y);
  numerator[1] = stretch * (sine * x + cosine * y);
  numerator[2] = series_at(series[ARC_NZ], arc->order, offset);
}

LANES_INLINE void kerr_direction(const arc_space *space, const arc_ray *ray, const arc *arc, lanes offset,
                                 lanes direction[3])
{
  const lanes(*series)[ARC_ORDER_MAX + 1] = arc->series;
  lanes w, v, n[3], m[3], sine, cosine, er[3], et[3], ep[3];
  (void)ray;
  series_with_slope(series[ARC_W], arc->order, offset, &w, &v);
  for (int k = 0; k < 3; k++) series_with_slope(series[ARC_NX + k], arc->order, offset, &n[k], &m[k]);
  const lanes horizontal = lanes_sqrt(n[0] * n[0] + n[1] * n[1]);
  kerr_place at;
  kerr_set_azimuth(n[0], n[1], horizontal, &at);
  at.cos_theta = n[2], at.sin_theta = horizontal;
  kerr_set_metric(space, w, lanes_max(kerr_delta(space, w), lanes_all(1e-300)), &at);
  const lanes p_theta = (m[0] * at.cos_phi + m[1] * at.sin_phi) * n[2] - m[2] * horizontal;
  const lanes toward_phi = m[1] * at.cos_phi - m[0] * at.sin_phi;
  const lanes radial = -v / lanes_sqrt(at.delta * at.sigma), south = p_theta * w / lanes_sqrt(at.sigma);
  const lanes east = toward_phi * w * lanes_sqrt(at.sigma / at.area);
  lanes_sincos(series_at(series[ARC_DRAG], arc->order, offset), &sine, &cosine);
  const lanes turned = cosine * at.cos_phi - sine * at.sin_phi;
  at.sin_phi = sine * at.cos_phi + cosine * at.sin_phi, at.cos_phi = turned;
  kerr_chart_basis(&at, er, et, ep);
  for (int k = 0; k < 3; k++) direction[k] = radial * er[k] + south * et[k] + east * ep[k];
}

LANES_INLINE lanes kerr_drift(const arc_space *space, const arc_ray *ray)
{
  const double M = space->mass, s = space->spin, s2 = s * s;
  const lanes E = ray->energy, L = ray->momentum, Q = ray->carter, w = ray->w, sE2 = s2 * E * E;
  const lanes K = (L - s * E) * (L - s * E) + Q;
  const lanes P = E * E + w * w * (sE2 - ray->curl + w * (2 * M * K - s2 * Q * w));
  const lanes turning = lanes_max(ray->curl, lanes_all(0)) + sE2 + M * M * E * E;
  const lanes radial = lanes_abs(ray->v * ray->v - P) / (E * E + lanes_abs(ray->curl) * w * w);
  const lanes sphere = lanes_abs(lanes_dot(ray->n, ray->n) - 1);
  const lanes tangent = lanes_abs(lanes_dot(ray->n, ray->m));
  const lanes axial = lanes_abs(ray->n[0] * ray->m[1] - ray->n[1] * ray->m[0] - L);
  const lanes speed = lanes_abs(lanes_dot(ray->m, ray->m) - ray->curl - sE2 * ray->n[2] * ray->n[2]);
  return radial + sphere + (tangent + axial) / lanes_sqrt(turning) + speed / turning;
}
#endif
