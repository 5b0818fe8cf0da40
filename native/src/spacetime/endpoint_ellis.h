/* Ellis wormhole, endpoint route: swept angle by one R_F and one arithmetic-geometric mean. Kernel code.
 *
 * In units of the throat radius, with l = tan(chi): d(phi)/d(chi) = b / sqrt(1 - b^2 cos^2 chi), an elliptic integral of the
 * first kind of modulus b (through the throat, b < 1) or 1/b (b > 1, back to where it came from). From a point with
 * p = l/r, for a ray at angle psi to +l, the way on outward sweeps F = sin(psi) R_F(p^2, cos^2 psi, 1) in both cases, and
 * the way through the throat or the turning point 2K - F (James, von Tunzelmann, Franklin & Thorne 2015, eqs. A; DLMF 19.25).
 */
#ifndef BENT_SPACETIME_ENDPOINT_ELLIS_H
#define BENT_SPACETIME_ENDPOINT_ELLIS_H
#include "spacetime/endpoint_lanes.h"

/* (pi/2) / AGM(x, y), x, y > 0 with ratio up to 1e14. */
LANES_INLINE lanes half_pi_over_agm(lanes x, lanes y)
{
  for (int i = 0; i < 8; i++) {
    const lanes mean = 0.5 * (x + y);
    y = lanes_sqrt(x * y), x = mean;
  }
  return M_PI / (x + y);
}

LANES_INLINE endpoint endpoint_ellis(double throat_radius, const aim *a)
{
  const lanes half = 0.5 * throat_radius / a->radius;  /* isotropic chart: (rho/2) / R */
  const lanes inverse = 1 / (1 + half * half), p = (1 - half) * (1 + half) * inverse, c = 2 * half * inverse;
  const lanes b = a->sine / c, v = a->cosine;
  /* (1 - b^2) c^2 = c^2 - sine^2 = v^2 - p^2: the factored form whose terms are small is the exact one. */
  const lanes gap = lanes_select(c < 0.7, (c - a->sine) * (c + a->sine), (v - p) * (v + p)) / (c * c);
  const lanes_mask through = gap > 0, outward = v * p > 0;
  const lanes f = a->sine * lanes_rf(p * p, v * v, lanes_all(1));
  const lanes distance = lanes_max(lanes_abs(gap), lanes_all(1e-27));
  const lanes k2 = 2 * b * half_pi_over_agm(lanes_max(lanes_all(1), b), lanes_sqrt(distance));

  endpoint end;
  end.swept = lanes_select(outward, f, k2 - f);
  /* sine is known to about DBL_EPSILON through the cross product, cosine and p likewise; so b^2 - 1 is known to: */
  const lanes doubt = DBL_EPSILON * (4 + 1 / lanes_max(a->sine, lanes_all(DBL_MIN)));
  const lanes uncertain = lanes_select(c < 0.7, 2 * doubt * b * b, 4 * DBL_EPSILON * (lanes_abs(v) + lanes_abs(p)));
  const lanes past = lanes_min(uncertain / distance + doubt * end.swept, lanes_all(10));
  const lanes on = doubt * f / lanes_max(v * v, p * p);
  end.error = 4 * DBL_EPSILON * (1 + end.swept) + lanes_select(outward, lanes_min(on, past), past);
  const lanes_mask far = lanes_select(through, v, p) < 0, certain = lanes_abs(gap) > 4 * uncertain;
  /* Going outward the throat does not matter. */
  const lanes_mask leaving = outward & (lanes_min(lanes_abs(v), lanes_abs(p)) > 8 * DBL_EPSILON);
  end.fate = (certain | leaving) & ((far & BENT_ESCAPED_FAR) | (~far & BENT_ESCAPED));
  endpoint_turn(&end, a);
  return end;
}
#endif
