/* Across a lens sphere by deflection tables: Schwarzschild and Ellis. For OSL only.
 *
 * A ray that enters depends on one number, delta = b/b_c - 1. `Total` holds the angle that it sweeps from infinity to
 * infinity, `Outward` the part of it from a radius to infinity; what is inside the sphere is the difference
 * (native/include/bentlight/table.h says what the tables are, map.h how they are read). Two images a kind of space
 * serve all masses and radii. Measured: 6e-6 rad at most, 7e-7 in the mean square.
 */
#ifndef BENT_OSL_LENS_TABLE_H
#define BENT_OSL_LENS_TABLE_H
#include "map.h"
#include "transport.h"

/* Sizes and ranges of the images, as native/python/bentlight_native/table.py samples them (a test compares). */
#define TOTAL_WIDTH 8192
#define OUTWARD_SIZE 768
#define SCHWARZSCHILD_MAX 0.25
#define ELLIS_MIN 0.24253562503633297

/* Texel i of n stands for i / (n - 1) and lies at (i + 1/2) / n. */
float texel(float coordinate, int size) { return (clamp(coordinate, 0, 1) * (size - 1) + 0.5) / size; }

/* From infinity to infinity, or through the throat. */
float total_swept(string image, int wormhole, float delta)
{
  float size = max(abs(delta), exp2(-24));
  int channel = wormhole && delta > 0; /* in the file the names are sorted: inside, outside */
  float stored = texture(image, texel(map_delta_coordinate(size, -24, delta < 0 ? 0 : 24), TOTAL_WIDTH), 0.5, 0, 0, 0, 0,
                         "wrap", "clamp", "interp", "linear", "firstchannel", channel);
  return map_total_from_stored(stored, size);
}

/* From position x (M/r or l/r), at this angle to the outward radial, to infinity. */
float outward_swept(string image, int wormhole, float x, float cosine, float sine)
{
  float low = wormhole ? ELLIS_MIN : 0, high = wormhole ? 1 : SCHWARZSCHILD_MAX;
  return sine * (float)texture(image, texel(cosine, OUTWARD_SIZE), texel((x - low) / (high - low), OUTWARD_SIZE), 0, 0, 0,
                               0, "wrap", "clamp", "interp", "linear");
}

/* Whether spheres are within what the tables hold. */
int is_tabulated(Space space)
{
  if (space.chart == CHART_WORMHOLE) return min(space.radius, space.far_radius) >= 0.65;
  return space.a == 0 && space.radius >= 4;
}

/* A ray that enters at `start` on the sphere, inward: fate, exit and direction there. */
int cross_by_table(Space space, string total, string outward, point start, vector direction, output point p,
                   output vector d)
{
  int wormhole = space.chart == CHART_WORMHOLE;
  float R = space.radius;
  vector n = normalize(vector(start));
  float inward = -dot(direction, n);
  vector across = direction + inward * n;
  float sine = length(across);
  across = sine > 1e-12 ? across / sine : vector(0);
  float x = wormhole ? map_x_ellis(0.5 / R) : (space.chart == CHART_ISOTROPIC ? map_x_schwarzschild(0.5 / R) : 1 / R);
  float delta = wormhole ? map_delta_ellis(x, sine) : map_delta_schwarzschild(x, sine);
  if (delta <= 0 && !wormhole) return FATE_LOST;
  float before = outward_swept(outward, wormhole, x, inward, sine), after = before; /* outside the spheres */
  int side = delta > 0 ? 1 : -1;
  if (side < 0) {
    R = space.far_radius;
    x = map_x_ellis(0.5 / R);
    sine = min((1 + delta) * sqrt((1 - x) * (1 + x)), 1);
    inward = sqrt((1 - sine) * (1 + sine));
    after = outward_swept(outward, wormhole, x, inward, sine);
  }
  float swept = total_swept(total, wormhole, delta) - before - after;
  float turned = cos(swept), along = sin(swept);
  vector there = turned * n + along * across;
  vector ahead = turned * across - along * n;
  vector mirror = vector(1, side, 1);
  p = R * there * mirror;
  d = normalize((inward * there + sine * ahead) * mirror);
  return side > 0 ? FATE_NEAR : FATE_FAR;
}
#endif
