/* Values without their derivatives, and derivatives without values. For OSL only. */
#ifndef BENT_OSL_DERIVATIVES_H
#define BENT_OSL_DERIVATIVES_H

/* The same values, but without derivatives, which double what a ray costs: OSL reckons them for all that leads to a value
 * whose derivatives are asked for, by trace() too, except through messages. Their names must be literals, and they arrays:
 * else a vector that was a color once is not found again. */
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

/* A value, with what it changes by from one pixel to the next as its derivatives: all given without any. On a surface. */
vector with_slopes(vector value, vector change_x, vector change_y)
{
  vector x = Dx(P), y = Dy(P);
  return value + slope_of(dot(P, x) / dot(x, x)) * change_x + slope_of(dot(P, y) / dot(y, y)) * change_y;
}
#endif
