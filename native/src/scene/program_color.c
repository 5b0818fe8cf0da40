/* Operations on colors. The conventions for arguments out of domain are Blender's. */
#include <math.h>

#include "scene/fresnel.h"
#include "scene/program.h"
#include "scene/safe_math.h"

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
  const blend_type type = immediates[0];
  const double t = in[0]->x;
  const vec3 a = *in[1], b = *in[2];
  *out = type >= BLEND_HUE
             ? blend_hsv(type, t, a, b)
             : v3(blend_channel(type, t, a.x, b.x), blend_channel(type, t, a.y, b.y), blend_channel(type, t, a.z, b.z));
}

/* Hue, saturation and lightness. */
static vec3 hsl_from_rgb(vec3 c)
{
  const double high = v3_max(c), low = fmin(c.x, fmin(c.y, c.z)), range = high - low;
  const double lightness = fmin((high + low) / 2, 1);
  if (range == 0) return v3(0, 0, lightness);
  return v3(hsv_from_rgb(c).x, range / (lightness > 0.5 ? 2 - high - low : high + low), lightness);
}
static vec3 rgb_from_hsl(vec3 c)
{
  const double h = 6 * c.x, chroma = (1 - fabs(2 * c.z - 1)) * c.y;
  const vec3 pure = v3_saturate(v3(fabs(h - 3) - 1, 2 - fabs(h - 2), 2 - fabs(h - 4)));
  return v3_mad(v3_sub(pure, v3_splat(0.5)), chroma, v3_splat(c.z));
}
OPERATION(color_to_model) { *out = immediates[0] == MODEL_HSV ? hsv_from_rgb(*in[0]) : hsl_from_rgb(*in[0]); }
OPERATION(color_from_model) { *out = immediates[0] == MODEL_HSV ? rgb_from_hsv(*in[0]) : rgb_from_hsl(*in[0]); }

static double gamma_channel(double x, double gamma) { return x > 0 ? pow(x, gamma) : x; }
OPERATION(gamma)
{
  const double gamma = in[1]->x;
  const vec3 c = *in[0];
  *out = gamma == 0 ? v3_splat(1) : v3(gamma_channel(c.x, gamma), gamma_channel(c.y, gamma), gamma_channel(c.z, gamma));
}

OPERATION(invert) { *out = v3_mix(*in[1], v3_sub(v3_splat(1), *in[1]), in[0]->x); }

/* Color, brightness, contrast. */
OPERATION(brightness_contrast)
{
  const vec3 c = v3_mad(*in[0], 1 + in[2]->x, v3_splat(in[1]->x - in[2]->x / 2));
  *out = v3(fmax(c.x, 0), fmax(c.y, 0), fmax(c.z, 0));
}

/* Hue (0.5 changes nothing), saturation, value, factor, color. */
OPERATION(hue_saturation)
{
  vec3 hsv = hsv_from_rgb(*in[4]);
  hsv.x = fmod(hsv.x + in[0]->x + 0.5, 1);
  hsv.y = saturate(hsv.y * in[1]->x);
  hsv.z *= in[2]->x;
  const vec3 c = v3_mix(*in[4], rgb_from_hsv(hsv), in[3]->x);
  *out = v3(fmax(c.x, 0), fmax(c.y, 0), fmax(c.z, 0));
}

/* A curve of the table at t, 0 to 1 over it, and beyond as its ends or along their tangents. */
static double curve_at(const float (*entries)[4], int count, int channel, double t, int extrapolate)
{
  const int last = count - 1;
  const double position = saturate(t) * last;
  const int i = (int)position, next = i < last ? i + 1 : last;
  const double inside = entries[i][channel] + (position - i) * ((double)entries[next][channel] - entries[i][channel]);
  if (!extrapolate || last == 0 || (t >= 0 && t <= 1) || isnan(t)) return inside;
  const int end = t < 0 ? 0 : last - 1;
  const double slope = ((double)entries[end + 1][channel] - entries[end][channel]) * last;
  return inside + slope * (t < 0 ? t : t - 1);
}
/* Factor, color; start and width of the range of the curves. */
OPERATION(curves)
{
  const float(*entries)[4] = context->table + immediates[0];
  const int count = immediates[1], beyond = immediates[2];
  const vec3 t = v3_scale(v3_sub(*in[1], *in[2]), safe_divide(1, in[3]->x));
  *out = v3_mix(*in[1], v3(curve_at(entries, count, 0, t.x, beyond), curve_at(entries, count, 1, t.y, beyond),
                           curve_at(entries, count, 2, t.z, beyond)), in[0]->x);
}

/* The color of a black body in linear Rec. 709 with luminance 1, by the fit of Open Shading Language and Cycles (within
 * 1e-3): r and g are a / t + b t + c, b is a cubic. Each row holds from its temperature in K to the next. */
typedef struct blackbody_piece {
  double from, r[3], g[3], b[4];
} blackbody_piece;
static const blackbody_piece blackbody_pieces[] = {
    {800, {1.61919106e+03, -2.05010916e-03, 5.02995757e+00}, {-4.88999748e+02, 6.04330754e-04, -7.55807526e-02},
     {5.96945309e-11, -4.85742887e-08, -9.70622247e-05, -4.07936148e-03}},
    {965, {2.48845471e+03, -1.11330907e-03, 3.22621544e+00}, {-7.55994277e+02, 3.16730098e-04, 4.78306139e-01},
     {2.40430366e-11, 5.55021075e-08, -1.98503712e-04, 2.89312858e-02}},
    {1167, {3.34143193e+03, -4.86551192e-04, 1.76486769e+00}, {-1.02363977e+03, 1.20223470e-04, 9.36662319e-01},
     {-1.40949732e-11, 1.89878968e-07, -3.56632824e-04, 9.10767778e-02}},
    {1449, {4.09461742e+03, -1.27446582e-04, 7.25731635e-01}, {-1.26571316e+03, 4.87340896e-06, 1.27054498e+00},
     {-3.61460868e-11, 2.84822009e-07, -4.93211319e-04, 1.56723440e-01}},
    {1902, {4.67028036e+03, 2.91258199e-05, 1.26703442e-01}, {-1.42529332e+03, -4.01150431e-05, 1.43972784e+00},
     {-1.97075738e-11, 1.75359352e-07, -2.50542825e-04, -2.22783266e-02}},
    {3315, {4.59509185e+03, 2.87495649e-05, 1.50345020e-01}, {-1.17554822e+03, -2.16378048e-05, 1.30408023e+00},
     {-1.61997957e-13, -1.64216008e-08, 3.86216271e-04, -7.38077418e-01}},
    {6365, {3.78717450e+03, 9.35907826e-06, 3.99075871e-01}, {-5.00799571e+02, -4.59832026e-06, 1.09098763e+00},
     {6.72650283e-13, -2.73078809e-08, 4.24098264e-04, -7.52335691e-01}}};

OPERATION(blackbody)
{
  const double t = in[0]->x;
  vec3 c;
  if (!(t >= 800)) {
    c = v3(5.413294490189271, -0.20319390035873933, -0.0822535242887164);
  } else if (t >= 12000) {
    c = v3(0.8262954810464208, 0.9945080501520986, 1.566307710274283);
  } else {
    const blackbody_piece *p = blackbody_pieces + sizeof blackbody_pieces / sizeof *blackbody_pieces - 1;
    while (t < p->from) p--;
    c = v3(p->r[0] / t + p->r[1] * t + p->r[2], p->g[0] / t + p->g[1] * t + p->g[2],
           ((p->b[0] * t + p->b[1]) * t + p->b[2]) * t + p->b[3]);
  }
  *out = v3(fmax(c.x, 0), fmax(c.y, 0), fmax(c.z, 0));
}
