/* Tables of directional albedo of GGX lobes; see the header. */
#include "scene/microfacet_energy.h"

#include <pthread.h>

#include "scene/fresnel.h"
#include "scene/microfacet.h"

enum { FINE = 32, COARSE = 16, SAMPLES = 16 };

/* Entries are evenly spaced in sqrt(mu), since albedos change fast at grazing angles. */
static double reflection_table[FINE][FINE], reflection_average[FINE]; /* [roughness][mu] */
static double glass_table[2][COARSE][COARSE][COARSE], rise_table[COARSE][COARSE][COARSE]; /* [eta][roughness][mu] */
static double glass_average[2][COARSE][COARSE]; /* [eta][roughness] */
static pthread_once_t prepared = PTHREAD_ONCE_INIT;

/* Midpoint rule over the visible normals: equally spaced in azimuth (half a turn is enough), and in the height of the
 * spherical cap with the points drawn together towards both ends, where the integrand is steep. */
microfacet_energy microfacet_integrate(double roughness, double mu, double eta, int samples)
{
  const double alpha = squared(fmax(roughness, 1e-3)), c = fmax(mu, 1e-3);
  const vec3 w = v3(sqrt(fmax(0, 1 - c * c)), 0, c);
  const double lambda = ggx_lambda(c, alpha);
  microfacet_energy sum = {0};
  double total = 0;
  for (int i = 0; i < samples; i++) {
    const double t = (i + 0.5) / samples, u1 = t * t * (3 - 2 * t), weight = 6 * t * (1 - t);
    for (int j = 0; j < samples; j++) {
      const vec3 h = ggx_sample_visible(w, alpha, (j + 0.5) / samples / 2, u1);
      const double cos_i = fmin(v3_dot(w, h), 1);
      total += weight;
      if (cos_i <= 0) continue;
      double cos_t;
      const double f = fresnel_dielectric(cos_i, eta, &cos_t);
      const double up = reflect(w, h).z;
      if (up > 0) {
        const double g = weight * (1 + lambda) / (1 + lambda + ggx_lambda(up, alpha));
        sum.reflection += g;
        sum.rise += g * fresnel_rise(f, eta);
        sum.glass += g * f;
      }
      const double down = cos_t > 0 ? -refract(w, h, cos_i, cos_t, eta).z : 0;
      if (down > 0) sum.glass += weight * (1 - f) * (1 + lambda) / (1 + lambda + ggx_lambda(down, alpha));
    }
  }
  sum.rise /= fmax(sum.reflection, 1e-9);
  sum.reflection /= total;
  sum.glass /= total;
  return sum;
}

/* z in [0, 1) <-> eta >= 1, evenly spread over reflectance. */
static double eta_from_z(double z) { return (1 + z * z) / fmax(1 - z * z, 1e-3); }
static double z_from_eta(double eta) { return sqrt(saturate((eta - 1) / (eta + 1))); }

/* Cosine-weighted average of n entries over mu: trapezoids of 2 mu dmu = 4 t^3 dt. */
static double average_over_mu(const double *entries, int n)
{
  double sum = 0;
  for (int m = 0; m < n; m++) {
    const double t = m / (n - 1.0);
    sum += 4 * t * t * t * entries[m] * (m == n - 1 ? 0.5 : 1) / (n - 1);
  }
  return fmin(sum, 1);
}

static void fill_tables(void)
{
  for (int r = 0; r < FINE; r++) {
    const double roughness = r / (FINE - 1.0);
    for (int m = 0; m < FINE; m++) {
      const double t = m / (FINE - 1.0), mu = t * t;
      reflection_table[r][m] = microfacet_integrate(roughness, mu, 1.5, 2 * SAMPLES).reflection;
    }
    reflection_average[r] = average_over_mu(reflection_table[r], FINE);
  }
  for (int e = 0; e < COARSE; e++)
    for (int r = 0; r < COARSE; r++)
      for (int m = 0; m < COARSE; m++) {
        const double eta = eta_from_z(e / (COARSE - 1.0)), roughness = r / (COARSE - 1.0), mu = squared(m / (COARSE - 1.0));
        const microfacet_energy into = microfacet_integrate(roughness, mu, eta, SAMPLES);
        glass_table[0][e][r][m] = into.glass;
        rise_table[e][r][m] = into.rise;
        glass_table[1][e][r][m] = microfacet_integrate(roughness, mu, 1 / eta, SAMPLES).glass;
      }
  for (int side = 0; side < 2; side++)
    for (int e = 0; e < COARSE; e++)
      for (int r = 0; r < COARSE; r++) glass_average[side][e][r] = average_over_mu(glass_table[side][e][r], COARSE);
}

void microfacet_energy_prepare(void) { pthread_once(&prepared, fill_tables); }

/* Position in a table of n entries: index of the lower one, and the fraction towards the next. */
static int locate(double x, int n, double *fraction)
{
  const double position = saturate(x) * (n - 1);
  const int index = (int)fmin(position, n - 2);
  *fraction = position - index;
  return index;
}

static double bilinear(const double *table, int n, double row, double column)
{
  double fr, fc;
  const int r = locate(row, n, &fr), c = locate(column, n, &fc);
  const double *a = table + r * n + c, *b = a + n;
  return (1 - fr) * ((1 - fc) * a[0] + fc * a[1]) + fr * ((1 - fc) * b[0] + fc * b[1]);
}

static double trilinear(const double table[COARSE][COARSE][COARSE], double slice, double row, double column)
{
  double f;
  const int s = locate(slice, COARSE, &f);
  return (1 - f) * bilinear(&table[s][0][0], COARSE, row, column) + f * bilinear(&table[s + 1][0][0], COARSE, row, column);
}

double microfacet_reflection_albedo(double roughness, double mu)
{
  return bilinear(&reflection_table[0][0], FINE, roughness, sqrt(mu));
}

double microfacet_reflection_average(double roughness)
{
  double f;
  const int i = locate(roughness, FINE, &f);
  return (1 - f) * reflection_average[i] + f * reflection_average[i + 1];
}

double microfacet_glass_albedo(double roughness, double mu, double eta)
{
  return trilinear(glass_table[eta < 1], z_from_eta(eta < 1 ? 1 / eta : eta), roughness, sqrt(mu));
}

double microfacet_glass_average(double roughness, double eta)
{
  return bilinear(&glass_average[eta < 1][0][0], COARSE, z_from_eta(eta < 1 ? 1 / eta : eta), roughness);
}

double microfacet_fresnel_rise(double roughness, double mu, double eta)
{
  return trilinear(rise_table, z_from_eta(eta < 1 ? 1 / eta : eta), roughness, sqrt(mu));
}
