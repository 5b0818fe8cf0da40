/* Operations on numbers, and on vectors component by component. The conventions for arguments out of domain are Blender's. */
#include <math.h>

#include "scene/fresnel.h"
#include "scene/program.h"
#include "scene/safe_math.h"

OPERATION(dot) { *out = v3_splat(v3_dot(*in[0], *in[1])); }
OPERATION(aov)
{
  const aov_sink *sink = context->point ? context->point->aovs : NULL;
  if (!sink || (uint32_t)immediates[0] >= sink->count) return;
  float *out_of = sink->values + 4 * immediates[0];
  out_of[0] += (float)in[0]->x, out_of[1] += (float)in[0]->y, out_of[2] += (float)in[0]->z, out_of[3] += 1;
}
OPERATION(average) { *out = v3_splat(v3_average(*in[0])); }
OPERATION(channel) { *out = v3_splat(immediates[0] == 0 ? in[0]->x : immediates[0] == 1 ? in[0]->y : in[0]->z); }
OPERATION(combine) { *out = v3(in[0]->x, in[1]->x, in[2]->x); }
OPERATION(clamp) { *out = v3_saturate(*in[0]); }
OPERATION(multiply) { *out = v3_mul(*in[0], *in[1]); }
OPERATION(mix)
{
  const vec3 f = *in[0], a = *in[1], b = *in[2];
  *out = v3_add(v3_mul(a, v3_sub(v3_splat(1), f)), v3_mul(b, f));
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
    case RADIANS: return a * (M_PI / 180);
    case DEGREES: return a * (180 / M_PI);
  }
  return 0;
}
OPERATION(math) { *out = v3_splat(math_value(immediates[0], in[0]->x, in[1]->x, in[2]->x)); }

/* One component of the Map Range node: how far x lies from a to b, mapped. */
static double map_factor(map_interpolation kind, double x, double a, double b, double steps)
{
  if (kind == MAP_SMOOTHSTEP || kind == MAP_SMOOTHERSTEP) {
    const double t = saturate(safe_divide(x - a, b - a));
    return kind == MAP_SMOOTHSTEP ? t * t * (3 - 2 * t) : t * t * t * (t * (6 * t - 15) + 10);
  }
  const double t = safe_divide(x - a, b - a);
  return kind == MAP_STEPPED ? (steps > 0 ? floor(t * (steps + 1)) / steps : 0) : t;
}
OPERATION(map_range)
{
  const map_interpolation kind = immediates[0];
  const vec3 *v = in[0], *a = in[1], *b = in[2], *steps = in[5];
  const vec3 t = v3(map_factor(kind, v->x, a->x, b->x, steps->x), map_factor(kind, v->y, a->y, b->y, steps->y),
                    map_factor(kind, v->z, a->z, b->z, steps->z));
  *out = v3_add(*in[3], v3_mul(t, v3_sub(*in[4], *in[3])));
  /* a number that comes from an empty range is 0, a vector the start of the range it goes to */
  if (!immediates[1] && a->x == b->x) *out = v3_splat(0);
}

static double clamp_between(double x, double low, double high) { return fmin(fmax(x, low), high); }
OPERATION(clamp_between)
{
  vec3 low = *in[1], high = *in[2];
  if (immediates[0]) {
    low = v3(fmin(in[1]->x, in[2]->x), fmin(in[1]->y, in[2]->y), fmin(in[1]->z, in[2]->z));
    high = v3(fmax(in[1]->x, in[2]->x), fmax(in[1]->y, in[2]->y), fmax(in[1]->z, in[2]->z));
  }
  *out = v3(clamp_between(in[0]->x, low.x, high.x), clamp_between(in[0]->y, low.y, high.y),
            clamp_between(in[0]->z, low.z, high.z));
}

/* Vector operations that are a number's, component by component. */
#define AS_NUMBERS(name) [VECTOR_##name] = name
static const math_operation component_operations[] = {
    AS_NUMBERS(ADD),     AS_NUMBERS(SUBTRACT), AS_NUMBERS(MULTIPLY), AS_NUMBERS(DIVIDE), AS_NUMBERS(MULTIPLY_ADD),
    AS_NUMBERS(POWER),   AS_NUMBERS(ABSOLUTE), AS_NUMBERS(MINIMUM),  AS_NUMBERS(MAXIMUM), AS_NUMBERS(SIGN),
    AS_NUMBERS(FLOOR),   AS_NUMBERS(CEIL),     AS_NUMBERS(MODULO),   AS_NUMBERS(WRAP),   AS_NUMBERS(SNAP),
    AS_NUMBERS(SINE),    AS_NUMBERS(COSINE),   AS_NUMBERS(TANGENT),  [VECTOR_FRACTION] = FRACT};
static vec3 refracted(vec3 incident, vec3 normal, double eta)
{
  const double cosine = v3_dot(normal, incident), k = 1 - eta * eta * (1 - cosine * cosine);
  return k < 0 ? v3_splat(0) : v3_sub(v3_scale(incident, eta), v3_scale(normal, eta * cosine + sqrt(k)));
}
/* a, b, c, scale. A number is the same in all components. */
OPERATION(vector_math)
{
  const vector_operation operation = immediates[0];
  const vec3 a = *in[0], b = *in[1], c = *in[2];
  switch (operation) {
    case VECTOR_CROSS_PRODUCT: *out = v3_cross(a, b); break;
    case VECTOR_PROJECT: *out = v3_scale(b, safe_divide(v3_dot(a, b), v3_dot(b, b))); break;
    case VECTOR_REFLECT: *out = v3_mad(v3_normalize(b), -2 * v3_dot(a, v3_normalize(b)), a); break;
    case VECTOR_REFRACT: *out = refracted(a, v3_normalize(b), in[3]->x); break;
    case VECTOR_FACEFORWARD: *out = v3_dot(c, b) < 0 ? a : v3_scale(a, -1); break;
    case VECTOR_DOT_PRODUCT: *out = v3_splat(v3_dot(a, b)); break;
    case VECTOR_DISTANCE: *out = v3_splat(v3_length(v3_sub(a, b))); break;
    case VECTOR_LENGTH: *out = v3_splat(v3_length(a)); break;
    case VECTOR_SCALE: *out = v3_scale(a, in[3]->x); break;
    case VECTOR_NORMALIZE: *out = v3_normalize(a); break;
    default: {
      const math_operation each = component_operations[operation];
      *out = v3(math_value(each, a.x, b.x, c.x), math_value(each, a.y, b.y, c.y), math_value(each, a.z, b.z, c.z));
    }
  }
}
