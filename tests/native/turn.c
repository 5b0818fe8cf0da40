/* The largest errors of base/turn.h over many angles, measured against long double; test_turn.py reads them. */
#include "base/turn.h"

#include <math.h>
#include <stdio.h>

int main(void)
{
  long double worst = 0;
  for (int i = 0; i < 3000000; i++) {
    const double turns = i * (1.0 / 1048573); /* no binary fractions */
    const long double angle = 2 * acosl(-1) * turns;
    double sine, cosine;
    turn_sincos(turns, &sine, &cosine);
    worst = fmaxl(worst, fmaxl(fabsl(sine - sinl(angle)), fabsl(cosine - cosl(angle))));
  }
  printf("%Lg\n", worst);
  return 0;
}
