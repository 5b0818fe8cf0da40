/* Tables of directional albedo of GGX lobes; see the header. */
#include "scene/microfacet_energy.h"

#include <pthread.h>

#include "scene/fresnel.h"
#include "scene/microfacet.h"

/* Entries are evenly spaced in roughness, in sqrt(mu), since albedos change fast at grazing angles, and in the fourth root
 * of (eta - 1) / (eta + 1): near eta = 1 they change where mu is as small as the square root of that. */
enum { FINE = 32, ROUGHNESSES = 20, COSINES = 24, ETAS = 32 };
typedef float glass_entries[ETAS][ROUGHNESSES][COSINES];

static float reflection_table[FINE][FINE], reflection_average[1][FINE]; /* [roughness][mu] */
static glass_entries glass_table[2], rise_table;                        /* [1]: inside, eta < 1 */
static float glass_average[2][ETAS][ROUGHNESSES];
static pthread_once_t prepared = PTHREAD_ONCE_INIT;

static double roughness_at(int r) { return r / (ROUGHNESSES - 1.0); }
static double mu_at(int m) { return squared(m / (COSINES - 1.0)); }
static double eta_at(int e)
{
  const double ratio = squared(squared(e / (ETAS - 1.0)));
  return (1 + ratio) / fmax(1 - ratio, 1e-3);
}
static double place_of_eta(double eta)
{
  const double outside = eta < 1 ? 1 / eta : eta;
  return sqrt(sqrt((outside - 1) / (outside + 1)));
}

/* A lattice of Fibonacci numbers in the unit square: point i is ((i + 1/2) / count, i step / count mod 1). Total internal
 * reflection puts a kink into the integrand of the inside, which takes more points for the same error. */
typedef struct lattice {
  int count, step;
} lattice;
static const lattice SMOOTH = {233, 144}, KINKED = {987, 610};

/* Normals visible at one roughness and mu, for the integrals over them at many eta. */
typedef struct normals {
  int count;
  double mu, alpha, masking; /* 1 + Lambda(wo) */
  double total;              /* of the weights, with those of normals that face away */
  /* reflected: weight times G2 / G1 of the mirror direction; mirrored: weight where that is above the surface */
  float weight[987], cos_i[987], cos_n[987], reflected[987], mirrored[987];
} normals;

/* One coordinate is the azimuth, the other the height of the spherical cap, with the points drawn together towards both
 * ends, where the integrand is steep; so it is periodic in both, which is where such lattices converge fast. */
static void sample_normals(normals *n, double roughness, double mu, lattice lattice)
{
  const double alpha = squared(fmax(roughness, 1e-3)), c = fmax(mu, 1e-4);
  const vec3 w = v3(sqrt(fmax(0, 1 - c * c)), 0, c);
  *n = (normals){.mu = c, .alpha = alpha, .masking = 1 + ggx_lambda_isotropic(c, alpha)};
  for (int i = 0; i < lattice.count; i++) {
    const double t = (i + 0.5) / lattice.count, weight = 6 * t * (1 - t);
    n->total += weight;
    const vec3 h = ggx_sample_visible(w, alpha, alpha, (double)i * lattice.step / lattice.count,
                                      t * t * (3 - 2 * t));
    const double cos_i = fmin(v3_dot(w, h), 1), up = reflect(w, h).z;
    if (cos_i <= 0) continue;
    n->weight[n->count] = (float)weight;
    n->cos_i[n->count] = (float)cos_i;
    n->cos_n[n->count] = (float)h.z;
    n->mirrored[n->count] = (float)(up > 0 ? weight : 0);
    n->reflected[n->count++] = (float)(up > 0 ? weight * n->masking / (n->masking + ggx_lambda_isotropic(up, alpha)) : 0);
  }
}

static double integrate_reflection(const normals *n)
{
  double sum = 0;
  for (int i = 0; i < n->count; i++) sum += n->reflected[i];
  return sum / n->total;
}

/* Mean albedo of glass, and in *rise what microfacet_fresnel_rise is. The formulas of fresnel.h and
 * microfacet.h, without branches and with few divisions, so that the compiler makes SIMD of them: under total internal
 * reflection the cosine beyond is 0 and the reflectance comes out as 1. */
static float integrate_glass(const normals *n, double eta_of_table, float *rise)
{
  const float eta = (float)eta_of_table, per_eta = 1 / eta, f0 = (float)fresnel_f0(eta);
  const float alpha2 = (float)squared(n->alpha), masking = (float)n->masking, mu = (float)n->mu;
  float sum = 0, risen = 0;
  for (int i = 0; i < n->count; i++) {
    const float c = n->cos_i[i], cos2_t = 1 - (1 - c * c) * per_eta * per_eta, cos_t = cos2_t > 0 ? sqrtf(cos2_t) : 0;
    const float a = c + eta * cos_t, b = cos_t + eta * c, s = (c - eta * cos_t) * b, p = (cos_t - eta * c) * a;
    const float f = (s * s + p * p) / (2 * a * a * b * b), z = n->cos_n[i] * (cos_t - c * per_eta) + mu * per_eta;
    const float down = z > 0 ? z : 0, shadow = sqrtf(down * down + alpha2 * (1 - down * down)); /* (1 + 2 Lambda) down */
    sum += n->reflected[i] * f + n->weight[i] * (1 - f) * 2 * masking * down / ((2 * masking - 1) * down + shadow);
    risen += n->mirrored[i] * (f > f0 ? f - f0 : 0);
  }
  *rise = risen / ((1 - f0) * (float)n->total);
  return sum / (float)n->total;
}

/* Cosine-weighted average of n entries over mu: trapezoids of 2 mu dmu = 4 t^3 dt. */
static float average_over_mu(const float *entries, int n)
{
  double sum = 0, all = 0;
  for (int m = 0; m < n; m++) {
    const double weight = (m == n - 1 ? 0.5 : 1.0) * m * m * m;
    sum += weight * entries[m];
    all += weight;
  }
  return (float)(sum / all);
}

static void fill_glass(int inside)
{
  normals n;
  for (int r = 0; r < ROUGHNESSES; r++)
    for (int m = 0; m < COSINES; m++) {
      sample_normals(&n, roughness_at(r), mu_at(m), inside ? KINKED : SMOOTH);
      for (int e = 0; e < ETAS; e++) {
        float rise;
        glass_table[inside][e][r][m] = integrate_glass(&n, inside ? 1 / eta_at(e) : eta_at(e), &rise);
        if (!inside) rise_table[e][r][m] = rise;
      }
    }
  for (int e = 0; e < ETAS; e++)
    for (int r = 0; r < ROUGHNESSES; r++)
      glass_average[inside][e][r] = average_over_mu(glass_table[inside][e][r], COSINES);
}

static void fill_tables(void)
{
  normals n;
  for (int r = 0; r < FINE; r++) {
    for (int m = 0; m < FINE; m++) {
      sample_normals(&n, r / (FINE - 1.0), squared(m / (FINE - 1.0)), SMOOTH);
      reflection_table[r][m] = (float)integrate_reflection(&n);
    }
    reflection_average[0][r] = average_over_mu(reflection_table[r], FINE);
  }
  fill_glass(0);
  fill_glass(1);
}

void microfacet_energy_prepare(void) { pthread_once(&prepared, fill_tables); }

/* Position in a table of n entries: index of the lower one, and the fraction towards the next. */
static int locate(double x, int n, double *fraction)
{
  const double position = saturate(x) * (n - 1);
  const int index = position < n - 2 ? (int)position : n - 2;
  *fraction = position - index;
  return index;
}

static double linear(const float *table, int n, double x)
{
  double f;
  const int i = locate(x, n, &f);
  return (1 - f) * table[i] + f * table[i + 1];
}

static double bilinear(const float *table, int rows, int columns, double row, double column)
{
  double fr, fc;
  const int r = locate(row, rows, &fr), c = locate(column, columns, &fc);
  const float *a = table + r * columns + c, *b = a + columns;
  return (1 - fr) * ((1 - fc) * a[0] + fc * a[1]) + fr * ((1 - fc) * b[0] + fc * b[1]);
}

static double trilinear(const glass_entries table, double roughness, double mu, double eta)
{
  double f;
  const int e = locate(place_of_eta(eta), ETAS, &f);
  const double column = sqrt(mu);
  return (1 - f) * bilinear(table[e][0], ROUGHNESSES, COSINES, roughness, column) +
         f * bilinear(table[e + 1][0], ROUGHNESSES, COSINES, roughness, column);
}

double microfacet_reflection_albedo(double roughness, double mu)
{
  return bilinear(reflection_table[0], FINE, FINE, roughness, sqrt(mu));
}

double microfacet_reflection_average(double roughness) { return linear(reflection_average[0], FINE, roughness); }

double microfacet_glass_albedo(double roughness, double mu, double eta)
{
  return trilinear(glass_table[eta < 1], roughness, mu, eta);
}

double microfacet_glass_average(double roughness, double eta)
{
  return bilinear(glass_average[eta < 1][0], ETAS, ROUGHNESSES, place_of_eta(eta), roughness);
}

double microfacet_fresnel_rise(double roughness, double mu, double eta)
{
  return trilinear(rise_table, roughness, mu, eta);
}
