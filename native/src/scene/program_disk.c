/* Operations that only the material of an accretion disk has (disk.h). The disk lies in the plane z = 0 of its instance,
 * whose axes and unit of length are the hole's. */
#include "scene/disk.h"

#include "scene/disk_seen.h"
#include "scene/program.h"

/* Mass, spin over mass -> radius over mass, azimuth in [0, 2 pi), the Doppler factor and the gravitational one (disk_seen.h),
 * and how often the ray that looks has crossed the disk's plane before. */
OPERATION(disk)
{
  const disk_view v = disk_look(context->point, in[0]->x, in[1]->x, immediates[0] == CHART_ISOTROPIC);
  out[0] = v3_splat(v.r);
  out[1] = v3_splat(v.azimuth);
  out[2] = v3_splat(v.doppler);
  out[3] = v3_splat(v.gravitational);
  out[4] = v3_splat(context->point->ray.image_order);
}

/* Radius, spin. */
OPERATION(disk_flux) { *out = v3_splat(disk_flux(in[0]->x, fabs(in[1]->x))); }

/* Radius, azimuth, spin, phase, period, scale, contrast. */
OPERATION(disk_pattern)
{
  const double azimuth = in[2]->x < 0 ? -in[1]->x : in[1]->x;
  const double noise = disk_pattern(in[0]->x, fabs(in[2]->x), azimuth, in[3]->x, in[4]->x, in[5]->x);
  out[0] = v3_splat(isfinite(noise) ? noise : 0);
  out[1] = v3_splat(disk_pattern_factor(out[0].x, in[6]->x));
}

/* Temperature, lowest and highest of the table: RGB over luminance, and the luminance as disk.h stores it. Darkness below the
 * lowest; above the highest light grows with the temperature (Rayleigh & Jeans) and keeps its color. */
OPERATION(blackbody_light)
{
  const double kelvin = in[0]->x, low = in[1]->x, high = in[2]->x, clamped = fmin(kelvin, high);
  const int last = immediates[1] - 1;
  *out = v3_splat(0);
  if (!(kelvin >= low) || last < 1) return;
  const double at = fmax(log(clamped / low) / log(high / low) * last, 0);
  const int i = at < last ? (int)at : last - 1;
  const float *a = context->table[immediates[0] + i], *b = context->table[immediates[0] + i + 1];
  const double t = at - i;
  double c[4];
  for (int k = 0; k < 4; k++) c[k] = (1 - t) * a[k] + t * b[k];
  *out = v3_scale(v3(c[0], c[1], c[2]), disk_luminance_from_stored(c[3], clamped) * fmax(kelvin / high, 1));
}
