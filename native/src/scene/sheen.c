/* The table of sheen.h between its entries. */
#include "scene/sheen.h"

/* Index of the lower entry, and in *fraction how far x in [0, 1] lies towards the next. */
static int locate(double x, double *fraction)
{
  const double place = x * (SHEEN_NODES - 1);
  const int index = place < SHEEN_NODES - 2 ? (int)place : SHEEN_NODES - 2;
  *fraction = place - index;
  return index;
}

sheen_lobe sheen_lobe_at(double roughness, double mu)
{
  double fr, fm, value[3];
  const int r = locate(roughness, &fr), m = locate(mu, &fm);
  const float(*low)[3] = &sheen_table[r][m], (*high)[3] = &sheen_table[r + 1][m];
  for (int k = 0; k < 3; k++)
    value[k] = (1 - fr) * ((1 - fm) * low[0][k] + fm * low[1][k]) + fr * ((1 - fm) * high[0][k] + fm * high[1][k]);
  return (sheen_lobe){value[0], value[1], value[2]};
}
