/* Values without their derivatives, and derivatives without values. For OSL only. */
#ifndef BENT_OSL_DERIVATIVES_H
#define BENT_OSL_DERIVATIVES_H

/* The same value, but without derivatives, which double what a ray costs: OSL reckons them for all that leads to a value
 * whose derivatives are asked for, by trace() too, except through messages. Their names must be literals. */
#define STRIP_DERIVATIVES(name, value, same) \
  setmessage(name, value);                   \
  getmessage(name, same)

/* As x to 1e-6, but with no derivatives. */
float fixed(float x) { return floor(x * 1e6) / 1e6; }

/* Nothing, to 1e-13, but with the derivatives of x. */
float slope_of(float x)
{
  float rest = x - fixed(x);
  return rest - floor(rest * 1e13) / 1e13;
}

/* The same value, with what it changes by from one pixel to the next as its derivatives. On a surface. */
vector with_slopes(vector value, vector change_x, vector change_y)
{
  vector x = Dx(P), y = Dy(P), same = 0, across = 0, up = 0;
  vector given = value, given_x = change_x, given_y = change_y; /* messages of arguments that are products are colors */
  STRIP_DERIVATIVES("value", given, same);
  STRIP_DERIVATIVES("across", given_x, across);
  STRIP_DERIVATIVES("up", given_y, up);
  return same + slope_of(dot(P, x) / dot(x, x)) * across + slope_of(dot(P, y) / dot(y, y)) * up;
}
#endif
