/* Reflectance under a thin film, by the waves that leave it after different numbers of ways through it.
 *
 * Belcour and Barla, "A Practical Extension to Microfacet Theory for the Modeling of Varying Iridescence" (SIGGRAPH 2017):
 * a channel's mean of cos(2 pi way / wavelength + phase) over the wavelengths that it sees is the real part of its
 * sensitivity's Fourier transform at that way, turned by the phase. Amplitudes: Fresnel's equations, Born and Wolf,
 * "Principles of Optics", sections 1.5 and 14.2, with the index n + i k. What is added to physics is Cycles'.
 */
#include <complex.h>

#include "scene/fresnel.h"

enum { CHANNELS = 3, WAYS = 3 }; /* more than three times to and fro are not seen */

/* Reflected part of a wave's energy, and the phase that it gets, as a unit number. */
typedef struct reflection {
  double part;
  double complex phase;
} reflection;

static reflection of_amplitude(double complex r)
{
  const double length = cabs(r);
  return (reflection){length * length, length > 0 ? r / length : 1};
}

/* Of waves polarized across ([0]) and in ([1]) the plane of incidence, from a medium of index n1, under `cosine`, at one of
 * index n2. */
static void reflect_waves(double n1, double cosine, double complex n2, reflection out[2])
{
  const double complex square = n2 * n2, inside = csqrt(square - n1 * n1 * (1 - cosine * cosine));
  out[0] = of_amplitude((n1 * cosine - inside) / (n1 * cosine + inside));
  out[1] = of_amplitude((square * cosine - n1 * inside) / (square * cosine + n1 * inside));
}

static double component(vec3 v, int k) { return k == 0 ? v.x : k == 1 ? v.y : v.z; }

/* The sensitivity of a channel to a difference of ways: linear between entries, of which there are two rows each. */
static double complex sensitivity(const thin_film *film, int channel, double way)
{
  const double place = min2(way / film->reach, 1) * (film->count / 2 - 1);
  const int low = place < film->count / 2 - 2 ? (int)place : film->count / 2 - 2;
  const float (*e)[4] = film->sensitivity + 2 * low;
  const double t = place - low;
  return (1 - t) * (e[0][channel] + I * e[1][channel]) + t * (e[2][channel] + I * e[3][channel]);
}

/* All waves together (equation 10). */
static double interfere(const thin_film *film, int channel, double way, reflection top, reflection bottom)
{
  const double let_in = 1 - top.part, both = top.part * bottom.part;
  const double again = let_in * let_in * bottom.part / (1 - both);
  const double complex turn = -conj(top.phase) * bottom.phase;
  double complex phase = 1;
  double sum = top.part + again, strength = again - let_in;
  for (int m = 1; m <= WAYS; m++) {
    strength *= sqrt(both);
    phase *= turn;
    sum += 2 * strength * creal(phase * conj(sensitivity(film, channel, m * way)));
  }
  return sum;
}

/* A metal's index n + i k by its color in front r and at the edge g: Gulbrandsen, "Artist Friendly Metallic Fresnel" (JCGT
 * 2014). */
static double complex index_of_metal(double r, double g)
{
  r = min2(r, 0.999);
  const double root = sqrt(r), n = (1 - g) * (1 + root) / (1 - root) + g * (1 - r) / (1 + r);
  return n + I * sqrt(max2((r * squared(n + 1) - squared(n - 1)) / (1 - r), 0));
}

/* The reflectance of such a metal in a film: Schlick's with its dip at the edge, from what the film changes in front. */
static double metal_in_film(double complex n, double edge, double film_ior, double cosine)
{
  const double complex relative = n / film_ior;
  const double front = (squared(creal(relative) - 1) + squared(cimag(relative))) /
                       (squared(creal(relative) + 1) + squared(cimag(relative)));
  const double f = 6.0 / 7, f5 = squared(squared(f)) * f, dip = (front + (1 - front) * f5 - edge) * 7 / (f5 * f);
  return fresnel_conductor(cosine, v3_splat(front), v3_splat(dip)).x;
}

/* Reflection at the bottom of the film, in one channel. */
static void reflect_below(const closure *c, int channel, double film_ior, double cosine, reflection out[2])
{
  if (c->fresnel == FRESNEL_FILM_ON_TINTED) {
    reflect_waves(film_ior, cosine, c->ior, out);
  } else if (c->fresnel == FRESNEL_FILM_ON_COMPLEX) {
    reflect_waves(film_ior, cosine, component(c->f0, channel) + I * component(c->edge, channel), out);
  } else {
    const double edge = component(fresnel_conductor(1.0 / 7, c->f0, c->edge), channel);
    const double complex n = index_of_metal(component(c->f0, channel), edge);
    reflect_waves(film_ior, cosine, n, out);
    out[0].part = out[1].part = metal_in_film(n, edge, film_ior, cosine);
  }
}

/* Brings a dielectric's reflectance from its own value in front to f0, the less the more it reflects. */
static double tint(double reflectance, double ior, double f0)
{
  const double own = fresnel_f0(ior);
  if (own <= 1e-5 || reflectance >= 1) return reflectance;
  return reflectance * (1 + saturate((1 - reflectance) / (1 - own)) * (f0 / own - 1));
}

vec3 fresnel_of_film(const closure *c, double cos_i, double *cos_t)
{
  const thin_film *film = &c->film;
  const double x = saturate(film->thickness / film->thinnest), there = x * x * (3 - 2 * x);
  const double ior = 1 + (film->ior - 1) * there, sine2 = 1 - cos_i * cos_i;
  const double cosine2 = 1 - sine2 / (ior * ior), below2 = 1 - sine2 / (c->ior * c->ior);
  const int on_dielectric = c->fresnel == FRESNEL_FILM_ON_TINTED;
  *cos_t = 0;
  if (cosine2 <= 0 || (on_dielectric && below2 <= 0)) return v3_splat(1);
  if (on_dielectric) *cos_t = sqrt(below2);
  const double cosine = sqrt(cosine2), way = 2 * ior * film->thickness * cosine;
  reflection top[2], bottom[2];
  reflect_waves(1, cos_i, ior, top);
  double sum[CHANNELS];
  for (int k = 0; k < CHANNELS; k++) {
    if (k == 0 || !on_dielectric) reflect_below(c, k, ior, cosine, bottom);
    sum[k] = saturate((interfere(film, k, way, top[0], bottom[0]) + interfere(film, k, way, top[1], bottom[1])) / 2);
    if (on_dielectric) sum[k] = saturate(tint(sum[k], c->ior, component(c->f0, k)));
  }
  return v3(sum[0], sum[1], sum[2]);
}
