/* The light that a luminaire was measured to send, by direction: IES files as Cycles reads them. */
#include <math.h>

#include "scene/program.h"

/* A grid of angles in radians, rising, and what is sent there: `across` by horizontal angle, then vertical. */
typedef struct luminaire {
  int horizontal, vertical;
  const float *h, *v, *sent;
} luminaire;

/* As a table has it: both counts, the angles, the values. Returns 0 if it is none. */
static int luminaire_of(const float *data, int length, luminaire *out)
{
  if (length < 2 || !(data[0] >= 2 && data[1] >= 2 && data[0] < 1e5f && data[1] < 1e5f)) return 0;
  *out = (luminaire){.horizontal = (int)data[0], .vertical = (int)data[1]};
  out->h = data + 2, out->v = out->h + out->horizontal, out->sent = out->v + out->vertical;
  return 2 + (int64_t)out->horizontal + out->vertical + (int64_t)out->horizontal * out->vertical <= length;
}

/* The interval in which x is; angles[0] <= x < angles[count - 1]. */
static int interval(const float *angles, int count, float x)
{
  int i = 0;
  while (i < count - 2 && angles[i + 1] < x) i++;
  return i;
}

/* Between b and c, with their neighbors: Catmull and Rom's spline. */
static float spline(float a, float b, float c, float d, float x)
{
  return 0.5f * (((d + 3 * (b - c) - a) * x + (2 * a - 5 * b + 4 * c - d)) * x + (c - a)) * x + b;
}

/* Along one half circle. Beyond a pole the light is taken to be the same on the other side. */
static float sent_at(const luminaire *l, int row, int i, float x)
{
  const float *s = l->sent + (int64_t)row * l->vertical;
  const int n = l->vertical, from_pole = l->v[0] < 1e-7f, to_pole = l->v[n - 1] > (float)M_PI - 1e-7f;
  const float before = i > 0 ? s[i - 1] : from_pole ? s[1] : s[i];
  const float after = i + 2 < n ? s[i + 2] : to_pole ? s[n - 2] : s[i + 1];
  return spline(before, s[i], s[i + 1], after, x);
}

/* vector -> what is sent there. */
OPERATION(ies)
{
  luminaire l;
  *out = v3(0, 0, 0);
  const double length = v3_length(*in[0]);
  if (!luminaire_of(context->table[immediates[0]], 4 * immediates[1], &l) || !(length > 0 && length < INFINITY)) return;
  const vec3 to = v3_scale(*in[0], 1 / length);
  const float v = (float)acos(min2(max2(-to.z, -1), 1)), h = (float)(atan2(to.x, to.y) + M_PI);
  if (!(v >= l.v[0] && v < l.v[l.vertical - 1] && h >= l.h[0] && h < l.h[l.horizontal - 1])) return;
  const int i = interval(l.v, l.vertical, v), j = interval(l.h, l.horizontal, h), last = l.horizontal - 1;
  const float x = (v - l.v[i]) / (l.v[i + 1] - l.v[i]), y = (h - l.h[j]) / (l.h[j + 1] - l.h[j]);
  const float here = sent_at(&l, j, i, x); /* which as in Cycles stands for what is missing at the seam of the circle */
  const float before = j > 0 ? sent_at(&l, j - 1, i, x) : here, after = j + 2 <= last ? sent_at(&l, j + 2, i, x) : here;
  *out = v3_splat(fmaxf(spline(before, here, sent_at(&l, j + 1, i, x), after, y), 0));
}
