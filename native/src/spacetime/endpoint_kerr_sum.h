/* Kerr, endpoint route, second half: the radial sums, the polar motion and the azimuth at infinity. Kernel code.
 *
 * Polar motion: z = cos(theta) = sqrt(u_+) cos(chi) with chi' = sqrt(g2 + s^2 z^2), a Jacobi amplitude whose modulus is
 * small, so that the nome series (DLMF 22.11) take its place. Azimuth, through the osculating plane:
 *     n_x + i n_y = e^{i (Omega + J)} (z' + i lambda z) / sqrt(eta + s^2 z^2),   Omega' = s^2 lambda z^2 / (eta + s^2 z^2)
 * with J the frame dragging. Bounded and exact at lambda = 0, at the poles, in the equatorial plane and for s -> 0.
 */
#ifndef BENT_SPACETIME_ENDPOINT_KERR_SUM_H
#define BENT_SPACETIME_ENDPOINT_KERR_SUM_H
#include "spacetime/endpoint_kerr.h"

typedef struct kerr_sums {
  lanes time, drag; /* Mino time to infinity and the frame dragging J on the way */
} kerr_sums;

/* Adds one node: weight w, d(tau)/ds = jacobian / sqrt(U or cofactor). One square root and one division. */
LANES_INLINE void kerr_add_node(const kerr_hole *hole, const kerr_task *task, lanes weight, lanes u, lanes radicand,
                                kerr_sums *sums)
{
  const lanes horizon = kerr_u2_delta(hole, u), root = lanes_sqrt(radicand);
  const lanes rate = weight / (root * horizon);
  sums->time += rate * horizon;
  sums->drag += rate * (hole->spin * u) * (2 - hole->spin * task->lambda * u);
}

/* Gauss-Legendre over s, nodes in pairs about the center; is_free: without a barrier. */
LANES_INLINE kerr_sums kerr_sum(const kerr_hole *hole, const kerr_task *task, int rule, int is_free)
{
  const lanes B = hole->spin * hole->spin * task->eta, e_c = lanes_exp(task->center), inverse = 1 / e_c;
  const lanes sinh_c = 0.5 * (e_c - inverse), cosh_c = 0.5 * (e_c + inverse);
  kerr_sums sums = {0};
  for (int i = 0; i < gauss_nodes[rule] / 2; i++) {
    const double *pair = gauss_pairs[gauss_first[rule] + i];
    const lanes e = lanes_exp(pair[0] * task->half), f = 1 / e, ch = 0.5 * (e + f), sh = 0.5 * (e - f);
    for (int side = -1; side <= 1; side += 2) {
      const lanes sinh_s = sinh_c * ch + side * (cosh_c * sh);
      if (is_free) {
        const lanes d = task->scale * sinh_s, cosh_s = cosh_c * ch + side * (sinh_c * sh);
        const lanes U = task->c0 + d * d * (task->c1 + d * (task->c2 - B * d));
        kerr_add_node(hole, task, pair[1] * task->scale * cosh_s, task->origin + d, U, &sums);
      } else {
        const lanes u = task->origin - task->scale * sinh_s * sinh_s;
        kerr_add_node(hole, task, lanes_all(2 * pair[1]), u, task->c0 + u * (task->c1 - B * u), &sums);
      }
    }
  }
  return (kerr_sums){sums.time * task->half, sums.drag * task->half};
}

/* A unit complex number. */
typedef struct phasor {
  lanes re, im;
} phasor;

LANES_INLINE phasor phasor_mul(phasor a, phasor b)
{
  return (phasor){a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
}
LANES_INLINE phasor phasor_of(lanes angle)
{
  phasor p;
  lanes_sincos(angle, &p.im, &p.re);
  return p;
}
/* e^{i x} for |x| < 0.25 */
LANES_INLINE phasor phasor_small(lanes x)
{
  const lanes z = x * x;
  const lanes c = 1 - z * (1.0 / 2) * (1 - z * (1.0 / 12) * (1 - z * (1.0 / 30) * (1 - z * (1.0 / 56) * (1 - z * (1.0 / 90)))));
  const lanes s = x * (1 - z * (1.0 / 6) * (1 - z * (1.0 / 20) * (1 - z * (1.0 / 42) * (1 - z * (1.0 / 72) * (1 - z * (1.0 / 110))))));
  return (phasor){c, s};
}
/* sum of coefficient[m] sin(m x), m = 1 .. count, at p = e^{i x} (Clenshaw) */
LANES_INLINE lanes sine_series(const lanes *coefficient, int count, phasor p)
{
  lanes above = {0}, b = {0};
  for (int m = count; m >= 1; m--) {
    const lanes next = coefficient[m] + 2 * p.re * b - above;
    above = b, b = next;
  }
  return b * p.im;
}

enum { KERR_AMPLITUDE_TERMS = 8, KERR_SERIES_MAX = 16 };

/* am(w, k) = zeta + sum a[m] sin(2 m zeta), zeta = mean * w. */
typedef struct kerr_amplitude {
  lanes a[KERR_AMPLITUDE_TERMS + 1], mean;
} kerr_amplitude;

LANES_INLINE kerr_amplitude kerr_amplitude_of(lanes k2, lanes complement2)
{
  const lanes complement = lanes_sqrt(complement2), root = lanes_sqrt(complement);
  const lanes e = 0.5 * k2 / ((1 + complement) * (1 + root) * (1 + root)), e4 = e * e * e * e;
  const lanes nome = e * (1 + e4 * (2 + 15 * e4)), n2 = nome * nome;
  kerr_amplitude amplitude;
  lanes power = lanes_all(1);
  for (int m = 1; m <= KERR_AMPLITUDE_TERMS; m++) {
    power *= nome;
    const lanes p2 = power * power; /* 1 / (1 + p2) is a short series beyond the first term */
    amplitude.a[m] = (2.0 / m) * power * (m == 1 ? 1 / (1 + p2) : 1 - p2 * (1 - p2));
  }
  const lanes theta = 1 + 2 * nome * (1 + nome * n2 * (1 + nome * n2 * n2));
  amplitude.mean = 1 / (theta * theta);
  return amplitude;
}

/* chi - zeta at e^{2 i chi}: Newton, the derivative to first order in the small terms. */
LANES_INLINE lanes kerr_amplitude_lead(const kerr_amplitude *amplitude, phasor two_chi, phasor *two_zeta)
{
  lanes lead = {0};
  *two_zeta = two_chi;
  for (int i = 0; i < 4; i++) {
    const lanes c = two_zeta->re, slope = 1 + 2 * amplitude->a[1] * c + 4 * amplitude->a[2] * (2 * c * c - 1);
    lead += (sine_series(amplitude->a, KERR_AMPLITUDE_TERMS, *two_zeta) - lead) / slope;
    *two_zeta = phasor_mul(two_chi, phasor_small(-2 * lead));
  }
  return lead;
}

/* cos(pi t / 32) */
static const double kerr_cosines[64] = {
    1.0, 0.9951847266721969, 0.9807852804032304, 0.9569403357322088,
    0.9238795325112867, 0.881921264348355, 0.8314696123025452, 0.773010453362737,
    0.7071067811865476, 0.6343932841636455, 0.5555702330196023, 0.4713967368259978,
    0.38268343236508984, 0.29028467725446233, 0.19509032201612833, 0.09801714032956077,
    0.0, -0.09801714032956065, -0.1950903220161282, -0.29028467725446216,
    -0.3826834323650897, -0.4713967368259977, -0.555570233019602, -0.6343932841636454,
    -0.7071067811865475, -0.773010453362737, -0.8314696123025453, -0.8819212643483549,
    -0.9238795325112867, -0.9569403357322088, -0.9807852804032304, -0.9951847266721968,
    -1.0, -0.9951847266721969, -0.9807852804032304, -0.9569403357322089,
    -0.9238795325112868, -0.881921264348355, -0.8314696123025455, -0.7730104533627371,
    -0.7071067811865477, -0.6343932841636459, -0.5555702330196022, -0.47139673682599786,
    -0.38268343236509034, -0.29028467725446244, -0.19509032201612866, -0.09801714032956045,
    0.0, 0.09801714032956009, 0.1950903220161283, 0.29028467725446205,
    0.38268343236509, 0.4713967368259976, 0.5555702330196018, 0.6343932841636456,
    0.7071067811865474, 0.7730104533627367, 0.8314696123025452, 0.8819212643483548,
    0.9238795325112865, 0.9569403357322088, 0.9807852804032303, 0.9951847266721969,
};

/* Fourier sine series of Omega over chi, from midpoint samples of a quarter period: Omega = w[0] chi + sum w[m] sin(2 m chi). */
LANES_INLINE void kerr_plane_series(double spin, const kerr_task *task, lanes g2, int count, lanes *w)
{
  const lanes kappa = spin * spin / g2, s2u = kappa * task->eta;
  const int stride = KERR_SERIES_MAX / count;
  lanes sample[KERR_SERIES_MAX];
  for (int j = 0; j < count; j++) {
    const double c = 0.5 * (1 + kerr_cosines[(2 * j + 1) * stride]); /* cos^2 chi */
    sample[j] = kappa * task->lambda * c / ((1 + kappa * c) * lanes_sqrt(g2 + s2u * c));
  }
  for (int m = 0; m < count; m++) {
    lanes sum = {0};
    for (int j = 0; j < count; j++) sum += sample[j] * kerr_cosines[m * (2 * j + 1) * stride % 64];
    w[m] = sum * (m ? 1.0 / (count * m) : 1.0 / count);
  }
}

LANES_INLINE endpoint kerr_finish(const kerr_hole *hole, const kerr_task *task, int sum)
{
  const int rule = sum % GAUSS_RULES, is_free = sum / GAUSS_RULES & 1, count = sum / GAUSS_RULES & 2 ? 16 : 8;
  const kerr_sums radial = is_free ? kerr_sum(hole, task, rule, 1) : kerr_sum(hole, task, rule, 0);

  const double spin = hole->spin, s2 = spin * spin;
  const lanes excess = task->q - s2, G = lanes_sqrt(excess * excess + 4 * s2 * task->eta), g2 = 0.5 * (excess + G);
  const lanes u_plus = task->eta / g2, root = lanes_sqrt(u_plus), c_o = task->cosine;
  const kerr_amplitude amplitude = kerr_amplitude_of(s2 * u_plus / G, g2 / G);
  phasor chi = {c_o / root, task->sine * task->p_theta / (root * lanes_sqrt(g2 + s2 * c_o * c_o))};
  const lanes norm = 1 / lanes_sqrt(chi.re * chi.re + chi.im * chi.im);
  chi.re *= norm, chi.im *= norm;
  const phasor two_chi = phasor_mul(chi, chi);
  phasor two_zeta;
  const lanes lead = kerr_amplitude_lead(&amplitude, two_chi, &two_zeta);
  const lanes advance = lanes_sqrt(G) * amplitude.mean * radial.time; /* of zeta */
  two_zeta = phasor_mul(two_zeta, phasor_of(2 * advance));
  const lanes turn = advance - lead + sine_series(amplitude.a, KERR_AMPLITUDE_TERMS, two_zeta); /* of chi */
  const phasor end_chi = phasor_mul(chi, phasor_of(turn)), two_end = phasor_mul(end_chi, end_chi);

  lanes w[KERR_SERIES_MAX];
  kerr_plane_series(spin, task, g2, count, w);
  const lanes plane = w[0] * turn + sine_series(w, count - 1, two_end) - sine_series(w, count - 1, two_chi);

  /* (z' + i lambda z) / sqrt(eta + s^2 z^2) at the end, over the same at the start with its azimuth */
  const lanes z = root * end_chi.re, z_rate = -root * end_chi.im * lanes_sqrt(g2 + s2 * z * z);
  const phasor after = {z_rate, task->lambda * z}, before = {-task->p_theta, -c_o * task->swing};
  const lanes tilt2 = task->eta + s2 * c_o * c_o;
  const lanes size = 1 / lanes_sqrt(tilt2 * (task->eta + s2 * z * z));
  phasor across = phasor_mul(phasor_mul(after, before), phasor_of(plane + radial.drag));
  across = phasor_mul(across, (phasor){task->azimuth[0] * size, task->azimuth[1] * size});

  /* |n'| / chi' at cos^2 chi = 0, 1/2, 1 as a cosine series, and its integral */
  const lanes f0 = lanes_sqrt(task->q / g2), f2 = lanes_sqrt((task->q + s2 * u_plus) / G);
  const lanes f1 = lanes_sqrt((task->q + 0.5 * s2 * u_plus) / (g2 + 0.5 * s2 * u_plus));
  const lanes sine_2 = two_end.im - two_chi.im, sine_4 = two_end.im * two_end.re - two_chi.im * two_chi.re;
  endpoint end = {.fate = lanes_mask_all(1) & BENT_ESCAPED, .error = task->error};
  end.swept = 0.25 * ((f0 + 2 * f1 + f2) * turn + (f2 - f0) * sine_2 + (f0 - 2 * f1 + f2) * 0.5 * sine_4);
  end.direction[0] = across.re, end.direction[1] = across.im, end.direction[2] = z;
  return end;
}
#endif
