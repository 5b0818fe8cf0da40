/* Operations on numbers and colors. The conventions for arguments out of domain are Blender's. */
#include <math.h>

#include "scene/fresnel.h"
#include "scene/program.h"

#define PI 3.14159265358979323846
#define OPERATION(name)                                                                                                \
  void op_##name(const program_context *context, const vec3 *const *in, const int32_t *immediates, vec3 *out)
#define UNUSED (void)context, (void)in, (void)immediates

OPERATION(dot) { UNUSED; *out = v3_splat(v3_dot(*in[0], *in[1])); }
OPERATION(average) { UNUSED; *out = v3_splat(v3_average(*in[0])); }
OPERATION(channel) { UNUSED; *out = v3_splat(immediates[0] == 0 ? in[0]->x : immediates[0] == 1 ? in[0]->y : in[0]->z); }
OPERATION(combine) { UNUSED; *out = v3(in[0]->x, in[1]->x, in[2]->x); }
OPERATION(clamp) { UNUSED; *out = v3_saturate(*in[0]); }
OPERATION(multiply) { UNUSED; *out = v3_mul(*in[0], *in[1]); }
OPERATION(mix)
{
  UNUSED;
  const vec3 f = *in[0], a = *in[1], b = *in[2];
  *out = v3_add(v3_mul(a, v3_sub(v3_splat(1), f)), v3_mul(b, f));
}

static double safe_divide(double a, double b) { return b != 0 ? a / b : 0; }
static double safe_power(double a, double b) { return a < 0 && b != trunc(b) ? 0 : pow(a, b); }
static double safe_log(double a, double b) { return a <= 0 || b <= 0 ? 0 : safe_divide(log(a), log(b)); }
static double smooth_min(double a, double b, double c)
{
  if (c == 0) return fmin(a, b);
  const double h = fmax(c - fabs(a - b), 0) / c;
  return fmin(a, b) - h * h * h * c / 6;
}
static double wrap_range(double x, double high, double low)
{
  const double range = high - low;
  return range != 0 ? x - range * floor((x - low) / range) : low;
}
static double ping_pong(double a, double b)
{
  if (b == 0) return 0;
  const double t = (a - b) / (2 * b);
  return fabs((t - floor(t)) * 2 * b - b);
}

static double math_value(math_operation operation, double a, double b, double c)
{
  switch (operation) {
    case ADD: return a + b;
    case SUBTRACT: return a - b;
    case MULTIPLY: return a * b;
    case DIVIDE: return safe_divide(a, b);
    case MULTIPLY_ADD: return a * b + c;
    case POWER: return safe_power(a, b);
    case LOGARITHM: return safe_log(a, b);
    case SQRT: return a > 0 ? sqrt(a) : 0;
    case INVERSE_SQRT: return a > 0 ? 1 / sqrt(a) : 0;
    case ABSOLUTE: return fabs(a);
    case EXPONENT: return exp(a);
    case MINIMUM: return fmin(a, b);
    case MAXIMUM: return fmax(a, b);
    case LESS_THAN: return a < b;
    case GREATER_THAN: return a > b;
    case SIGN: return (a > 0) - (a < 0);
    case COMPARE: return a == b || fabs(a - b) <= fmax(c, 1.1920929e-7);
    case SMOOTH_MIN: return smooth_min(a, b, c);
    case SMOOTH_MAX: return -smooth_min(-a, -b, c);
    case ROUND: return floor(a + 0.5);
    case FLOOR: return floor(a);
    case CEIL: return ceil(a);
    case TRUNC: return trunc(a);
    case FRACT: return a - floor(a);
    case MODULO: return b != 0 ? fmod(a, b) : 0;
    case FLOORED_MODULO: return b != 0 ? a - floor(a / b) * b : 0;
    case WRAP: return wrap_range(a, b, c);
    case SNAP: return floor(safe_divide(a, b)) * b;
    case PINGPONG: return ping_pong(a, b);
    case SINE: return sin(a);
    case COSINE: return cos(a);
    case TANGENT: return tan(a);
    case ARCSINE: return asin(fmin(fmax(a, -1), 1));
    case ARCCOSINE: return acos(fmin(fmax(a, -1), 1));
    case ARCTANGENT: return atan(a);
    case ARCTAN2: return atan2(a, b);
    case SINH: return sinh(a);
    case COSH: return cosh(a);
    case TANH: return tanh(a);
    case RADIANS: return a * (PI / 180);
    case DEGREES: return a * (180 / PI);
  }
  return 0;
}
OPERATION(math) { UNUSED; *out = v3_splat(math_value(immediates[0], in[0]->x, in[1]->x, in[2]->x)); }

/* One channel of a blend mode that treats the channels alone; t is the factor, s = 1 - t. */
static double blend_channel(blend_type type, double t, double a, double b)
{
  const double s = 1 - t;
  double x;
  switch (type) {
    case BLEND_DARKEN: return fmin(a, b) * t + a * s;
    case BLEND_MULTIPLY: return a * (s + t * b);
    case BLEND_BURN:
      x = s + t * b;
      return x <= 0 ? 0 : saturate(1 - (1 - a) / x);
    case BLEND_LIGHTEN: return fmax(a, b) * t + a * s;
    case BLEND_SCREEN: return 1 - (s + t * (1 - b)) * (1 - a);
    case BLEND_DODGE:
      if (a == 0) return a;
      x = 1 - t * b;
      return x <= 0 ? 1 : fmin(a / x, 1);
    case BLEND_ADD: return a + t * b;
    case BLEND_OVERLAY: return a < 0.5 ? a * (s + 2 * t * b) : 1 - (s + 2 * t * (1 - b)) * (1 - a);
    case BLEND_SOFT_LIGHT: x = 1 - (1 - b) * (1 - a); return s * a + t * ((1 - a) * b * a + a * x);
    case BLEND_LINEAR_LIGHT: return a + t * (2 * b - 1);
    case BLEND_DIFFERENCE: return s * a + t * fabs(a - b);
    case BLEND_EXCLUSION: return fmax(s * a + t * (a + b - 2 * a * b), 0);
    case BLEND_SUBTRACT: return a - t * b;
    case BLEND_DIVIDE: return b != 0 ? s * a + t * a / b : a;
    default: return s * a + t * b;
  }
}

/* Hue, saturation and value, each in [0, 1] for colors in [0, 1]. */
static vec3 hsv_from_rgb(vec3 c)
{
  const double high = v3_max(c), low = fmin(c.x, fmin(c.y, c.z)), range = high - low;
  if (high == 0 || range == 0) return v3(0, 0, high);
  const vec3 d = v3_scale(v3_sub(v3_splat(high), c), 1 / range);
  double h = c.x == high ? d.z - d.y : c.y == high ? 2 + d.x - d.z : 4 + d.y - d.x;
  h /= 6;
  return v3(h < 0 ? h + 1 : h, range / high, high);
}
static vec3 rgb_from_hsv(vec3 c)
{
  const double h = c.x == 1 ? 0 : 6 * c.x, s = c.y, v = c.z, i = floor(h), f = h - i;
  if (s == 0) return v3_splat(v);
  const double p = v * (1 - s), q = v * (1 - s * f), t = v * (1 - s * (1 - f));
  return i == 0 ? v3(v, t, p) : i == 1 ? v3(q, v, p) : i == 2 ? v3(p, v, t) : i == 3 ? v3(p, q, v)
       : i == 4 ? v3(t, p, v) : v3(v, p, q);
}

/* The blend modes that exchange a part of hue, saturation and value. */
static vec3 blend_hsv(blend_type type, double t, vec3 a, vec3 b)
{
  vec3 ha = hsv_from_rgb(a);
  const vec3 hb = hsv_from_rgb(b);
  if (type == BLEND_VALUE) return ha.z = (1 - t) * ha.z + t * hb.z, rgb_from_hsv(ha);
  if (type == BLEND_SATURATION) return ha.y != 0 ? (ha.y = (1 - t) * ha.y + t * hb.y, rgb_from_hsv(ha)) : a;
  if (hb.y == 0) return a; /* a gray has no hue to give */
  ha.x = hb.x;
  if (type == BLEND_COLOR) ha.y = hb.y;
  return v3_mix(a, rgb_from_hsv(ha), t);
}

OPERATION(blend)
{
  UNUSED;
  const blend_type type = immediates[0];
  const double t = in[0]->x;
  const vec3 a = *in[1], b = *in[2];
  *out = type >= BLEND_HUE
             ? blend_hsv(type, t, a, b)
             : v3(blend_channel(type, t, a.x, b.x), blend_channel(type, t, a.y, b.y), blend_channel(type, t, a.z, b.z));
}
