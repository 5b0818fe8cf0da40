/* Prints the largest error of each function of base/lane_math.h, in units in the last place, against long double. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/lane_math.h"

static double ulps(double got, long double wanted)
{
  const double size = fabs((double)wanted);
  return (double)(fabsl(got - wanted) / (nextafter(size, INFINITY) - size));
}

static double uniform(double low, double high) { return low + (high - low) * drand48(); }

/* R_F by plain duplication in long double. */
static long double rf(long double x, long double y, long double z)
{
  for (int i = 0; i < 120; i++) {
    const long double p = sqrtl(x), q = sqrtl(y), r = sqrtl(z), lambda = p * q + p * r + q * r;
    x = (x + lambda) / 4, y = (y + lambda) / 4, z = (z + lambda) / 4;
  }
  return 1 / sqrtl(x);
}

#define WORST(name, count, draw, function, truth)                                  \
  do {                                                                             \
    double worst = 0;                                                              \
    for (int n = 0; n < (count); n += LANES) {                                     \
      lanes x;                                                                     \
      for (int i = 0; i < LANES; i++) x[i] = (draw);                               \
      const lanes got = function(x);                                               \
      for (int i = 0; i < LANES; i++) worst = fmax(worst, ulps(got[i], truth(x[i]))); \
    }                                                                              \
    printf("%s %.3f\n", name, worst);                                              \
  } while (0)

int main(void)
{
  WORST("log", 200000, exp(uniform(-690, 690)), lanes_log, logl);
  WORST("log_near_1", 200000, uniform(0.5, 2), lanes_log, logl);
  WORST("log1p", 200000, exp(uniform(-600, 690)), lanes_log1p, log1pl);
  WORST("log1p_near_1", 200000, uniform(0, 3), lanes_log1p, log1pl);
  WORST("exp", 200000, uniform(-700, 700), lanes_exp, expl);
  WORST("exp_small", 200000, uniform(-1, 1), lanes_exp, expl);
  double worst = 0;
  for (int n = 0; n < 20000; n += LANES) {
    lanes x, y, z;
    for (int i = 0; i < LANES; i++) {
      x[i] = n % 64 < 32 ? 0 : pow(10, uniform(-50, 50));
      y[i] = pow(10, uniform(-10, 10)), z[i] = pow(10, n % 128 < 64 ? uniform(-10, 10) : uniform(-100, 100));
    }
    const lanes got = lanes_rf(x, y, z);
    for (int i = 0; i < LANES; i++) worst = fmax(worst, ulps(got[i], rf(x[i], y[i], z[i])));
  }
  printf("rf %.3f\n", worst);
  return 0;
}
