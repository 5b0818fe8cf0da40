/* Makes src/scene/sheen_table.c: simulates a layer of fibers and fits a linearly transformed cosine to what it reflects.
 *
 *   gcc -O3 -march=native -ffast-math fit_sheen.c -lm -lpthread -o fit_sheen && ./fit_sheen > ../src/scene/sheen_table.c
 *
 * The model is that of Zeltner, Burley, Chiang, "Practical Multiple-Scattering Sheen Using Linearly Transformed Cosines"
 * (SIGGRAPH 2022 Talks): a layer of thickness 1 of white fibers along the normal, density 1, whose flakes are SGGX with
 * the projected areas (1, 1, roughness^2) along (x, y, z) (Heitz et al., "The SGGX Microflake Distribution", 2015) and
 * reflect like mirrors; after the 16th time nothing hinders the light. The fit is theirs too: of the inverse transform
 * ((a, 0, b), (0, a, 0), (0, 0, 1)) by the sum of cubed differences over 32 x 32 equal steps of the polar angles of the
 * reflected light. Where next to nothing is reflected, the shape is that of the next higher roughness.
 *
 * Takes about 20 minutes of one core.
 */
#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdio.h>

enum { NODES = 32, BINS = 32, BOUNCES = 16, THREADS = 2 };
enum { REFLECTED_MIN = 2000, REFLECTED = 700000, SAMPLES_MAX = 3000000 }; /* of one entry */
#define PI 3.14159265358979323846

typedef struct fit {
  double a, b, albedo;
} fit;
static fit table[NODES][NODES]; /* [roughness][mu] */
static atomic_int next_row;

static double node(int i) { return i ? i / (NODES - 1.0) : 0.01; }

/* xorshift64* (Vigna 2016), in [0, 1). */
static double uniform(uint64_t *state)
{
  *state ^= *state >> 12, *state ^= *state << 25, *state ^= *state >> 27;
  return (double)((*state * 2685821657736338717u) >> 11) * 0x1p-53;
}

/* Mirrors w, which points away from where the light comes from, at a flake that is visible from there: normals of the
 * ellipsoid that SGGX is the distribution of. */
static void scatter(double w[3], double across, uint64_t *state)
{
  const double s[3] = {1, 1, across};
  double z[3], length = 0, h[3];
  for (int k = 0; k < 3; k++) z[k] = s[k] * w[k], length += z[k] * z[k];
  for (int k = 0; k < 3; k++) z[k] /= sqrt(length);
  const double r2 = uniform(state), phi = 2 * PI * uniform(state), r = sqrt(r2), up = sqrt(1 - r2);
  const double sign = copysign(1, z[2]), c = -1 / (sign + z[2]), d = z[0] * z[1] * c;
  const double x[3] = {1 + sign * z[0] * z[0] * c, sign * d, -sign * z[0]}, y[3] = {d, sign + z[1] * z[1] * c, -z[1]};
  double norm = 0, cosine = 0;
  for (int k = 0; k < 3; k++) {
    h[k] = s[k] * (r * cos(phi) * x[k] + r * sin(phi) * y[k] + up * z[k]);
    norm += h[k] * h[k];
    cosine += h[k] * w[k];
  }
  for (int k = 0; k < 3; k++) w[k] = 2 * cosine / norm * h[k] - w[k];
}

static double extinction(const double w[3], double across)
{
  return sqrt(w[0] * w[0] + w[1] * w[1] + across * across * w[2] * w[2]);
}

/* Light that comes from (sin, 0, mu) and leaves upwards: its part, and its density over the polar angles. Returns the
 * number of samples that left upwards. */
static long simulate(double mu, double roughness, uint64_t *state, double density[BINS][BINS], double *albedo)
{
  const double across = roughness * roughness, start[3] = {sqrt(1 - mu * mu), 0, mu};
  const double met = -expm1(-extinction(start, across) / mu); /* every path is made to meet a fiber */
  long reflected = 0, samples = 0;
  for (int i = 0; i < BINS * BINS; i++) density[0][i] = 0;
  for (; samples < SAMPLES_MAX && reflected < REFLECTED; samples++) {
    double w[3] = {start[0], start[1], start[2]}; /* towards where the light comes from, then towards where it goes */
    double depth = -log(1 - met * uniform(state)) * mu / extinction(w, across);
    for (int bounce = 0;;) {
      scatter(w, across, state);
      if (++bounce == BOUNCES) break;
      depth += log(1 - uniform(state)) / extinction(w, across) * w[2];
      if (!(depth >= 0 && depth <= 1)) break;
      for (int k = 0; k < 3; k++) w[k] = -w[k];
    }
    if (w[2] <= 0) continue;
    reflected++;
    const double theta = acos(fmin(w[2], 1)), phi = fabs(atan2(w[1], w[0]));
    const int i = (int)fmin(theta / (PI / 2) * BINS, BINS - 1), j = (int)fmin(phi / PI * BINS, BINS - 1);
    density[i][j] += 1 / fmax(sin(theta), 1e-9);
  }
  for (int i = 0; i < BINS * BINS; i++) density[0][i] *= met * BINS * BINS / (PI * PI * (double)samples);
  double mean = 0; /* straight up all azimuths are one */
  for (int j = 0; j < BINS; j++) mean += density[0][j] / BINS;
  for (int j = 0; j < BINS; j++) density[0][j] = mean;
  *albedo = met * (double)reflected / (double)samples;
  return reflected;
}

static double loss(const fit *f, double density[BINS][BINS])
{
  double sum = 0;
  for (int i = 0; i < BINS; i++) {
    const double theta = (i + 0.5) / BINS * PI / 2, z = cos(theta);
    for (int j = 0; j < BINS; j++) {
      const double phi = (j + 0.5) / BINS * PI, x = sin(theta) * cos(phi), y = sin(theta) * sin(phi);
      const double length2 = (f->a * x + f->b * z) * (f->a * x + f->b * z) + f->a * f->a * y * y + z * z;
      const double value = f->albedo / PI * z * (f->a / length2) * (f->a / length2);
      sum += pow(fabs(value - density[i][j]), 3);
    }
  }
  return sum;
}

/* Descends along a and b by steps that grow while they help and shrink while they do not. */
static fit minimize(fit f, double density[BINS][BINS])
{
  double step[2] = {0.05, 0.05}, best = loss(&f, density);
  while (fabs(step[0]) > 1e-6 || fabs(step[1]) > 1e-6)
    for (int k = 0; k < 2; k++) {
      fit moved = f;
      *(k ? &moved.b : &moved.a) += step[k];
      const double found = loss(&moved, density);
      step[k] *= found < best ? 1.5 : -0.5;
      if (found < best) f = moved, best = found;
    }
  return f;
}

/* One mu; roughnesses from the highest down, each fit starting at that of the one before. */
static void *work(void *unused)
{
  (void)unused;
  static _Thread_local double density[BINS][BINS];
  for (int m; (m = next_row++) < NODES;) {
    uint64_t state = 0x9e3779b97f4a7c15u * (uint64_t)(m + 1);
    fit f = {1, 0, 0};
    for (int r = NODES - 1; r >= 0; r--) {
      if (simulate(node(m), node(r), &state, density, &f.albedo) >= REFLECTED_MIN) f = minimize(f, density);
      table[r][m] = f;
    }
    fprintf(stderr, "%d ", m);
  }
  return NULL;
}

int main(void)
{
  pthread_t threads[THREADS];
  for (int i = 0; i < THREADS; i++) pthread_create(&threads[i], NULL, work, NULL);
  for (int i = 0; i < THREADS; i++) pthread_join(threads[i], NULL);
  printf("/* Made by tools/fit_sheen.c, which see. */\n#include \"scene/sheen.h\"\n\n");
  printf("const float sheen_table[SHEEN_NODES][SHEEN_NODES][3] = {\n");
  for (int r = 0; r < NODES; r++)
    for (int m = 0; m < NODES; m++)
      printf("%s{%.4ff, %.4ff, %.5ff}%s", m % 4 ? " " : m ? "     " : "    {", table[r][m].a, table[r][m].b,
             table[r][m].albedo, m == NODES - 1 ? "},\n" : m % 4 == 3 ? ",\n" : ",");
  printf("};\n");
  return 0;
}
