/* Textures as operations. */
#include <math.h>

#include "scene/fresnel.h"
#include "scene/program.h"
#include "scene/sky_levels.h"

/* Vector, two colors, scale. Nudged off the integers, where rounding would decide, by the same amounts as Cycles. */
OPERATION(checker)
{
  const vec3 p = v3_scale(v3_add(v3_scale(*in[0], in[3]->x), v3_splat(1e-6)), 0.999999);
  const double sum = floor(p.x) + floor(p.y) + floor(p.z);
  const int first = fmod(sum, 2) != 0;
  out[0] = first ? *in[1] : *in[2];
  out[1] = v3_splat(first);
}

OPERATION(ramp)
{
  const float(*entries)[4] = context->table + immediates[0];
  const int last = immediates[1] - 1;
  const double position = saturate(in[0]->x) * last;
  const int i = (int)position, next = i < last ? i + 1 : last;
  const double t = immediates[2] ? position - i : 0;
  double c[4];
  for (int k = 0; k < 4; k++) c[k] = (1 - t) * entries[i][k] + t * entries[next][k];
  out[0] = v3(c[0], c[1], c[2]);
  out[1] = v3_splat(c[3]);
}

static void store(texel t, vec3 *out)
{
  out[0] = v3_from(t.color);
  out[1] = v3_splat(t.alpha);
}

OPERATION(image)
{
  store(image_lookup(&context->images[immediates[0]], in[0]->x, in[0]->y, (interpolation)immediates[1],
                     (extension)immediates[2], immediates[3]), out);
}

/* As in Cycles, what is less than a tile to the left of the first or below it looks that tile up too. */
OPERATION(image_tiles)
{
  const double column = trunc(in[0]->x), row = trunc(in[0]->y);
  if (column >= 0 && column < 10 && row >= 0)
    for (int i = 0; i < immediates[2]; i++)
      if (context->table[immediates[1] + i][0] == 1001 + 10 * row + column) {
        store(image_lookup(&context->images[immediates[0] + i], in[0]->x - column, in[0]->y - row,
                           (interpolation)immediates[3], (extension)immediates[4], immediates[5]), out);
        return;
      }
  out[0] = v3(1, 0, 1); /* as Cycles shows what is missing */
  out[1] = v3_splat(1);
}

/* Position in the unit cube to image coordinates on a sphere or tube around its center. */
OPERATION(project)
{
  const vec3 v = *in[0], c = v3_sub(v3_scale(v, 2), v3_splat(1));
  if (immediates[0] == PROJECTION_FLAT) {
    *out = v;
    return;
  }
  const double around = c.x == 0 && c.y == 0 ? 0 : (1 - atan2(c.x, c.y) / M_PI) / 2, length = v3_length(c);
  *out = immediates[0] == PROJECTION_TUBE ? v3(around, v.z, 0)
                                          : v3(around, length > 0 ? 1 - acos(saturate((c.z / length + 1) / 2) * 2 - 1) / M_PI : 0, 0);
}

/* Direction, and the same as far beside the point as its sky is looked at at once; to equirectangular (sky_levels.h) or
 * mirror-ball coordinates, in Blender's orientation. */
OPERATION(environment)
{
  const image *image = &context->images[immediates[0]];
  const interpolation interpolation = immediates[1];
  const vec3 d = v3_normalize(*in[0]);
  double u, v;
  if (immediates[2] == 0 && context->point->across_sky) {
    const double scale = 1 / v3_length(*in[0]);
    const vec3 across[2] = {v3_scale(v3_sub(*in[1], *in[0]), scale), v3_scale(v3_sub(*in[2], *in[0]), scale)};
    store(sky_lookup(image, d, across, interpolation), out);
    return;
  }
  if (immediates[2] == 0) {
    sky_place(d, &u, &v);
  } else {
    const double scale = 2 * sqrt(fmax(-0.5 * (d.y - 1), 0));
    u = 0.5 * ((scale > 0 ? d.x / scale : d.x) + 1);
    v = 0.5 * ((scale > 0 ? d.z / scale : d.z) + 1);
  }
  store(image_lookup(image, u, v, interpolation, EXTEND_REPEAT, 0), out);
}

/* Darkened towards the limb as 1 - 0.6 (1 - cos) (a common fit for visible light). */
OPERATION(sun_disk)
{
  const vec3 a = *in[0], b = *in[1];
  const double x = atan2(v3_length(v3_cross(a, b)), v3_dot(a, b)) / in[2]->x;
  *out = v3_splat(x < 1 ? 1 - 0.6 * (1 - sqrt(1 - x * x)) : 0);
}
