/* See facets.h. */
#include "scene/facets.h"

#include <math.h>

static const double ROOT_PI = 1.77245385090551602730;
/* Slopes beyond this many deviations are not drawn; their chance is below 1e-15. */
static const double SLOPE_MAX = 5.8;

double beckmann_lambda(vec3 w, double alpha_x, double alpha_y)
{
  const double rough = v2_length(alpha_x * w.x, alpha_y * w.y);
  if (!(rough > 1e-8 * fabs(w.z))) return 0;
  const double a = fabs(w.z) / rough;
  return (exp(-a * a) / (a * ROOT_PI) - erfc(a)) / 2;
}

double beckmann_density(vec3 h, double alpha_x, double alpha_y)
{
  const double x = h.x / alpha_x, y = h.y / alpha_y, z2 = h.z * h.z;
  return z2 > 0 ? exp(-(x * x + y * y) / z2) / (MICROFACET_PI * alpha_x * alpha_y * z2 * z2) : 0;
}

/* Where the chance of slopes below it is `u`, of those seen by a direction whose angle to the normal has that tangent (0: of
 * all): the root of 1 + erf(s) + tangent exp(-s^2) / sqrt(pi), which grows up to 1 / tangent, by Newton's method kept
 * within what is known to enclose it. */
static double slope_of(double u, double tangent)
{
  double low = -SLOPE_MAX, high = tangent > 1 / SLOPE_MAX ? 1 / tangent : SLOPE_MAX, s = 0;
  const double k = tangent / ROOT_PI, target = u * (1 + erf(high) + k * exp(-high * high));
  if (s > high) s = high / 2;
  for (int i = 0; i < 40 && high - low > 1e-9; i++) {
    const double bell = exp(-s * s), error = 1 + erf(s) + k * bell - target;
    if (error > 0) high = s;
    else low = s;
    const double next = s - error / (2 / ROOT_PI * bell * (1 - s * tangent));
    if (fabs(next - s) < 1e-10) break;
    s = next > low && next < high ? next : (low + high) / 2;
  }
  return s;
}

vec3 beckmann_sample_visible(vec3 w, double alpha_x, double alpha_y, double u0, double u1)
{
  const vec3 stretched = v3_normalize(v3(alpha_x * w.x, alpha_y * w.y, w.z));
  const double sine = v2_length(stretched.x, stretched.y);
  const double c = sine > 1e-12 ? stretched.x / sine : 1, s = sine > 1e-12 ? stretched.y / sine : 0;
  const double along = slope_of(u0, sine / max2(stretched.z, 1e-9)), across = slope_of(u1, 0);
  return v3_normalize(v3(-alpha_x * (c * along - s * across), -alpha_y * (s * along + c * across), 1));
}

static double exponent(double alpha) { return 2 / (alpha * alpha) - 2; }

double ashikhmin_value(const closure *c, vec3 wi, double *pdf)
{
  const double x = exponent(c->alpha), y = exponent(c->alpha_y);
  const vec3 h = v3_normalize(v3_add(c->wo, wi));
  const double cos_i = max2(v3_dot(h, c->wo), 1e-6), sine2 = h.x * h.x + h.y * h.y;
  const double e = sine2 > 1e-30 ? (x * h.x * h.x + y * h.y * h.y) / sine2 : x;
  *pdf = sqrt((x + 1) * (y + 1)) / (8 * MICROFACET_PI) * pow(min2(h.z, 1), e) / cos_i;
  return *pdf * wi.z / max2(max2(c->wo.z, wi.z), 1e-6);
}

vec3 ashikhmin_sample(const closure *c, double u0, double u1)
{
  const double x = exponent(c->alpha), y = exponent(c->alpha_y), t = 2 * MICROFACET_PI * u0;
  const double phi = atan2(sqrt(x + 1) * sin(t), sqrt(y + 1) * cos(t)), cosine = cos(phi);
  const double z = pow(u1, 1 / (x * cosine * cosine + y * (1 - cosine * cosine) + 1));
  const double r = sqrt(max2(1 - z * z, 0));
  return v3(r * cosine, r * sin(phi), z);
}
