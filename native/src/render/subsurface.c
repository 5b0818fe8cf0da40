/* See subsurface.h. Distances are drawn for one channel, directions at random or towards the surface; all these ways are
 * weighed together (balance heuristic). */
#include "render/subsurface.h"

#include "geometry/flat.h"
#include "render/dimensions.h"
#include "scene/scene.h"

enum { CHANNELS = 3 };
/* After so many scatterings a medium counts as isotropic, with the mean free path that similarity gives it; as Cycles. */
enum { ISOTROPIC_AFTER = 9 };
/* Paler media are rendered as if of this albedo, and their light dimmed, so that directions to the surface stay defined. */
static const double ALBEDO_MIN = 0.2, ALBEDO_MAX = 0.999999;
static const double LEAST_LIGHT = 1e-6; /* walks with less are given up */

typedef struct medium {
  double extinction[CHANNELS], albedo[CHANNELS];
  double anisotropy;
} medium;

/* A walk in the making. */
typedef struct walk {
  vec3 position, direction;
  double light[CHANNELS];
} walk;

static double polynomial(const double c[8], double x)
{
  double sum = c[7];
  for (int i = 6; i >= 0; i--) sum = sum * x + c[i];
  return sum;
}

/* The albedo of one scattering in a medium that reflects `color` in all, by its anisotropy g: fit of Wrenninge et al. */
static double single_albedo(double color, double g)
{
  static const double A[8] = {1.8260523782, -1.28451056436, -1.79904629312, 9.19393289202,
                              -22.8215585862, 32.0234874259, -23.6264803333, 7.21067002658};
  static const double B[8] = {0, 31.1491581433, -201.847017512, 841.576016723,
                              -2018.09288505, 2731.71560286, -1935.41424244, 559.009054474};
  static const double C[8] = {1.09686102424, -0.394704063468, 1.05258115941, -8.83963712726,
                              28.8643230661, -46.8802913581, 38.5402837518, -12.7181042538};
  static const double D[8] = {0.496310210422, 0.360146581622, -2.15139309747, 17.8896899217,
                              -55.2984010333, 82.065982243, -58.5106008578, 15.8478295021};
  static const double E[8] = {0, 76.7316253952, -594.356773233, 2448.8834203,
                              -5576.68528998, 7116.60171912, -4763.54467887, 1303.5318055};
  static const double F[8] = {2.40602999408, -2.51814844609, 9.18494908356, -79.2191708682,
                              259.082868209, -403.613804597, 302.85712436, -87.4370473567};
  const double b = 4.98511194385 + 0.127355959438 * exp(polynomial(B, g));
  const double e = 4.23190299701 + 0.00310603949088 * exp(polynomial(E, g));
  const double blend = pow(color, 0.25);
  const double dark = polynomial(A, g) * pow(atan(b * color), polynomial(C, g));
  const double bright = polynomial(D, g) * pow(atan(e * color), polynomial(F, g));
  return min2(max2((1 - blend) * dark + blend * bright, 0), ALBEDO_MAX);
}

/* The medium of a lobe; divides its color out of the light, which the walk will put back. */
static medium medium_of(const closure *lobe, double light[CHANNELS])
{
  medium m = {.anisotropy = lobe->anisotropy};
  double color[CHANNELS], radius[CHANNELS];
  v3_to(color, lobe->f0);
  v3_to(radius, lobe->radius);
  for (int k = 0; k < CHANNELS; k++) {
    m.extinction[k] = 1 / (max2(radius[k], 1e-16) * (1 - m.anisotropy));
    const double albedo = single_albedo(color[k], m.anisotropy);
    m.albedo[k] = max2(albedo, ALBEDO_MIN);
    light[k] = color[k] > 0 ? light[k] / color[k] * (albedo / m.albedo[k]) : 0;
  }
  return m;
}

static medium isotropic(const medium *m)
{
  medium out = {.anisotropy = 0};
  for (int k = 0; k < CHANNELS; k++) {
    const double scattering = m->extinction[k] * m->albedo[k] * (1 - m->anisotropy);
    out.extinction[k] = m->extinction[k] * (1 - m->albedo[k]) + scattering;
    out.albedo[k] = scattering / out.extinction[k];
  }
  return out;
}

/* Directions to the surface. In a half space light of all depths has the density 1 / (v - c) of the cosine c to the normal,
 * v its diffusion length: Krivanek and d'Eon, "A Zero-variance-based Sampling Scheme for Monte Carlo Subsurface Scattering"
 * (SIGGRAPH 2014 Talks). */
typedef struct guide {
  vec3 normal;
  double length, log_ratio; /* v, log((v + 1) / (v - 1)) */
} guide;

static guide guide_of(const medium *m, vec3 normal)
{
  const double a = max2(m->albedo[0], max2(m->albedo[1], m->albedo[2]));
  /* d'Eon and Krivanek, "Zero-Variance Theory for Efficient Subsurface Scattering" (SIGGRAPH 2020 Courses), eq. 67 */
  const double v = 1 / sqrt(1 - pow(a, 2.44294 - 0.0215813 * a + 0.578637 / a));
  return (guide){normal, v, log((v + 1) / (v - 1))};
}
static double guide_pdf(const guide *g, double cosine)
{
  return 1 / ((g->length - cosine) * g->log_ratio * 2 * M_PI);
}

/* Henyey and Greenstein's distribution of the angle of one scattering. */
static double phase_pdf(double g, double cosine)
{
  const double d = 1 + g * g - 2 * g * cosine;
  return (1 - g * g) / (4 * M_PI * d * sqrt(d));
}
static double phase_cosine(double g, double u)
{
  if (g < 1e-3) return 1 - 2 * u;
  const double s = (1 - g * g) / (1 - g + 2 * g * u);
  return min2(max2((1 + g * g - s * s) / (2 * g), -1), 1);
}

/* A unit vector at an angle to another. */
static vec3 around(vec3 axis, double cosine, double u)
{
  vec3 x, y;
  v3_basis(axis, &x, &y);
  const double sine = sqrt(max2(1 - cosine * cosine, 0)), phi = 2 * M_PI * u;
  return v3_add(v3_scale(axis, cosine), v3_add(v3_scale(x, sine * cos(phi)), v3_scale(y, sine * sin(phi))));
}

/* Chances of the channels, by the light that is left in each after one more scattering; 0 if there is none. */
static int channel_chances(const medium *m, const double light[CHANNELS], double chance[CHANNELS])
{
  double sum = 0;
  for (int k = 0; k < CHANNELS; k++) sum += chance[k] = light[k] * m->albedo[k];
  for (int k = 0; k < CHANNELS; k++) chance[k] = sum > 0 ? chance[k] / sum : 0;
  return sum > 0 && sum < INFINITY;
}

/* Chooses among n by chances that sum to 1; makes *u again uniform in [0, 1). */
static int choose(const double *chance, int n, double *u)
{
  int k = 0;
  for (; k < n - 1 && *u >= chance[k]; k++) *u -= chance[k];
  *u = chance[k] > 0 ? min2(*u / chance[k], 1 - 1e-12) : 0;
  return k;
}

/* Multiplies the light by what a length in the medium leaves of it, and scatters if it ends inside, over the chance of all
 * that: with `bias` 0 it was drawn at random, else to the part `guided` of the cases towards the surface, where chances of
 * directions are `bias` times as high and extinction is stretched. */
static void pay(const medium *m, double length, int is_out, const double chance[CHANNELS], double guided, double bias,
                double stretch, double light[CHANNELS])
{
  double passed[CHANNELS], pdf = 0;
  for (int k = 0; k < CHANNELS; k++) {
    passed[k] = exp(-m->extinction[k] * length);
    const double aimed = exp(-m->extinction[k] * stretch * length) * (is_out ? 1 : m->extinction[k] * stretch);
    const double plain = passed[k] * (is_out ? 1 : m->extinction[k]);
    pdf += chance[k] * ((1 - guided) * plain + guided * bias * aimed);
  }
  for (int k = 0; k < CHANNELS; k++)
    light[k] *= pdf > 0 ? passed[k] * (is_out ? 1 : m->extinction[k] * m->albedo[k]) / pdf : 0;
}

/* Goes to the next scattering, or out. Returns 1 if it is out: then the place is in `exit`. */
static int step(const geometry *g, const medium *m, const guide *guide, const bent_hit *entry, int is_first,
                const double u[SAMPLER_DIMENSIONS], double guided, walk *w, bent_hit *exit)
{
  double chance[CHANNELS], pick = u[WALK_CHANNEL], bias = 0, stretch = 1;
  if (!channel_chances(m, w->light, chance)) return 0;
  double rate = m->extinction[choose(chance, CHANNELS, &pick)];
  if (is_first) {
    guided = 0;
  } else {
    const int aims = pick < guided;
    const double v = guide->length;
    const vec3 next = aims ? around(guide->normal, v - (v + 1) * exp(-u[WALK_COSINE] * guide->log_ratio), u[WALK_ANGLE])
                           : around(w->direction, phase_cosine(m->anisotropy, u[WALK_COSINE]), u[WALK_ANGLE]);
    const double cosine = v3_dot(next, guide->normal);
    bias = guide_pdf(guide, cosine) / phase_pdf(m->anisotropy, v3_dot(w->direction, next));
    stretch = 1 - cosine / v;
    if (aims) rate *= stretch;
    w->direction = next;
  }
  double length = -log(1 - u[WALK_LENGTH]) / rate;
  const bent_ray leaving = {.source_instance = entry->instance, .source_triangle = entry->triangle};
  const query q = {.start = w->position, .span = w->direction, .far = length, .visibility = UINT32_MAX,
                   .leaving = is_first ? &leaving : NULL, .departure = w->direction,
                   .inside = &g->instances[entry->instance]};
  found f;
  const int is_out = geometry_query(g, &q, &f);
  if (is_out) length = flat_land(g, &f, w->position, w->direction, exit);
  pay(m, length, is_out, chance, guided, bias, stretch, w->light);
  w->position = v3_mad(w->direction, length, w->position);
  return is_out;
}

int subsurface_walk(const tracer *t, const path *p, const closure *lobe, vec3 normal, const bent_hit *entry, vec3 inwards,
                    vec3 *beta, bent_hit *exit)
{
  const geometry *g = t->scene->geometry;
  walk w = {.position = v3_from(entry->position), .direction = inwards};
  v3_to(w.light, *beta);
  const medium m = medium_of(lobe, w.light), late = isotropic(&m);
  const guide guide = guide_of(&m, normal);
  const double guided = 1 - max2(0.5, pow(m.anisotropy, 0.125)); /* as Cycles: a compromise */
  *exit = *entry;
  for (uint32_t i = 0; i < SUBSURFACE_STEPS; i++) {
    double u[SAMPLER_DIMENSIONS];
    sampler_draw(&t->sampler, p->pixel, p->sample, dimensions_walk(p->vertex, i), u);
    const int is_late = i > ISOTROPIC_AFTER;
    if (step(g, is_late ? &late : &m, &guide, entry, i == 0, u, is_late ? 0.75 : guided, &w, exit)) {
      *beta = v3(w.light[0], w.light[1], w.light[2]);
      v3_to(exit->direction, v3_scale(w.direction, -1));
      return v3_is_finite(*beta);
    }
    if (!(max2(w.light[0], max2(w.light[1], w.light[2])) > LEAST_LIGHT)) return 0;
  }
  return 0;
}
