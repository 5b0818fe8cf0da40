/* The Ellis wormhole for arc.h: ds^2 = -dt^2 + dl^2 + (rho^2 + l^2) dOmega^2 (Ellis 1973), isotropic chart.
 *
 * With chi = arctan(l / rho), p = sin chi = l/r, rho w = cos chi = rho/r, in Mino time and with E = 1:
 *     p' = rho w v,    w' = -p v / rho,    v = chi',    v' = b^2 rho p w,    v^2 = rho^2 - b^2 (rho w)^2,
 * and n turns at the constant rate b. Isotropic chart: R = (l + r) / 2, throat at rho / 2; R < rho / 2 is the far side.
 */
#ifndef BENT_SPACETIME_ELLIS_H
#define BENT_SPACETIME_ELLIS_H
#ifndef BENT_SPACETIME_ARC_H
#error "include spacetime/arc.h"
#endif

LANES_INLINE void ellis_launch(const arc_space *space, const lanes origin[3], const lanes direction[3], arc_ray *ray)
{
  const double rho = space->throat_radius;
  const lanes radius = lanes_sqrt(lanes_dot(origin, origin)), mirror = 0.25 * rho * rho / radius;
  ray->w = 1 / (radius + mirror);
  ray->side = (radius - 0.5 * rho) * (radius + 0.5 * rho) / radius * ray->w;
  arc_launch_planar(origin, direction, radius, ray);
  ray->energy = lanes_all(1);
  ray->v = rho * lanes_dot(direction, ray->n);
  ray->weight = lanes_sqrt(ray->curl + rho * rho) * (1 / rho);
  ray->doubt = arc_launch_doubt(ray, rho);
  ray->peak = lanes_all(space->horizon);
  const lanes b = ray->momentum, barrier = (rho - b) * (rho + b) * (1 / (rho * rho));
  const lanes near = lanes_min(lanes_abs(ray->side) + lanes_abs(ray->v) * (1 / rho), lanes_all(1)); /* as in arc_judge */
  ray->doomed = (lanes_mask){0};
  ray->depth = lanes_min(lanes_select(ray->side * ray->v < 0, lanes_abs(barrier) / near, near), lanes_all(1));
}

LANES_INLINE void ellis_expand(const arc_space *space, const arc_ray *ray, lanes tolerance, int order, arc *arc)
{
  const double rho = space->throat_radius;
  lanes *w = arc->series[ARC_W], *p = arc->series[ARC_SIDE], *v = arc->series[ARC_RATE];
  const lanes push = rho * ray->curl;
  w[0] = ray->w, p[0] = ray->side, v[0] = ray->v;
#pragma GCC unroll 32
  for (int k = 0; k < order; k++) {
    w[k + 1] = series_product(p, v, k) * (-1 / (rho * (k + 1)));
    p[k + 1] = series_product(w, v, k) * (rho / (k + 1));
    v[k + 1] = series_product(p, w, k) * (push * (1.0 / (k + 1)));
  }
  lanes size[4];
  for (int i = 0; i < 4; i++)
    size[i] = ray->weight *
              (rho * lanes_abs(w[order - i]) + lanes_abs(p[order - i]) + lanes_abs(v[order - i]) * (1 / rho));
  const lanes longest = ARC_TURN_MAX / lanes_max(ray->momentum, lanes_all(rho));
  arc->step = lanes_min(arc_step_length(size, order, tolerance), longest);
}

LANES_INLINE void ellis_advance(const arc *arc, lanes offset, arc_ray *ray)
{
  ray->w = series_at(arc->series[ARC_W], arc->order, offset);
  ray->side = series_at(arc->series[ARC_SIDE], arc->order, offset);
  ray->v = series_at(arc->series[ARC_RATE], arc->order, offset);
  ray->swept += ray->momentum * offset;
}

/* diag(1, -1, 1) joins the mouths' axes: the outward direction turns round at the throat, and without a mirror everything
 * beyond would be left-handed. */
LANES_INLINE void ellis_mirror(lanes_mask far, lanes a[3]) { a[1] = lanes_select(far, -a[1], a[1]); }

LANES_INLINE void ellis_position(const arc_ray *ray, const arc *arc, lanes offset, lanes numerator[3], lanes_mask *far)
{
  const lanes p = series_at(arc->series[ARC_SIDE], arc->order, offset);
  lanes n[3], m[3];
  arc_planar_basis(ray, offset, n, m);
  *far = p < 0;
  const lanes scale = 0.5 * (1 + lanes_abs(p));
  for (int k = 0; k < 3; k++) numerator[k] = scale * n[k];
}

LANES_INLINE void ellis_direction(const arc_space *space, const arc_ray *ray, const arc *arc, lanes offset,
                                  lanes direction[3])
{
  const lanes w = series_at(arc->series[ARC_W], arc->order, offset);
  const lanes p = series_at(arc->series[ARC_SIDE], arc->order, offset);
  const lanes v = series_at(arc->series[ARC_RATE], arc->order, offset);
  lanes n[3], m[3];
  arc_planar_basis(ray, offset, n, m);
  const lanes_mask far = p < 0;
  const lanes outward = lanes_select(far, -v, v), along = space->throat_radius * w * ray->momentum;
  for (int k = 0; k < 3; k++) direction[k] = outward * n[k] + along * m[k];
}

LANES_INLINE lanes ellis_drift(const arc_space *space, const arc_ray *ray)
{
  const double rho = space->throat_radius;
  const lanes c = rho * ray->w;
  return lanes_abs(ray->v * ray->v + ray->curl * c * c - rho * rho) * (1 / (rho * rho)) +
         lanes_abs(ray->side * ray->side + c * c - 1);
}
#endif
