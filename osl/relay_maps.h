/* How relay_camera.osl and relay_screen.osl find the last straight leg of a curved camera ray. For OSL only.
 *
 * The core has traced a ray for every part of every pixel through the scene's meshes (blender_addon/cycles/relay_maps.py)
 * and stored where its last leg starts and where it goes. A sample gets the leg of the part that it falls into. Nothing is
 * interpolated: Cycles meets the surface that the core has found, and edges are as clean as the parts are fine.
 *
 * The image with its margin is cut into bands of pixel rows, from the bottom; a band is a set of OpenEXR files for each slice
 * of the shutter's time:
 *   <path><slice>_<band>_cells: a code a pixel: 0, or where the image is compressed n + 8 times the number of its cell in the
 *     maps that are n times as fine;
 *   <path><slice>_<band>_direction, _place: parts x parts for each pixel;
 *   <path><slice>_<band>_<n>x_direction, _<n>x_place: n parts x n parts for each cell.
 * The length of a direction is how bright the light that comes that way is to the camera, 1e-8 or more; 0: none comes. Times
 * 2^64: from the sky. Then the place is not in the maps but far away, along the direction. In its stead the maps hold, if images
 * of the sky are filtered, what the pixel's rays see of it, an ellipse: across the direction its major axis, along the direction
 * how long its minor axis is. Else zeros, which take no memory.
 *
 * Accretion disks are no surfaces to Cycles: the core has evaluated them where rays cross them. Only if there are any, each
 * set has as many values of
 *   <path><slice>_<band>_glow, _<n>x_glow: radiance of the disks on the ray's way, each dimmed by those before it;
 *   <path><slice>_<band>_tint, _<n>x_tint: the color that they give to the light from behind them, 1 in its brightest channel.
 * But for directions, files of which all values are the same have a single one. */
#ifndef BENT_OSL_RELAY_MAPS_H
#define BENT_OSL_RELAY_MAPS_H

#define RELAY_TO_SKY 18446744073709551616.0 /* 2^64 */
#define RELAY_CELL 8

struct RelayMaps {
  string path; /* how the files' names begin */
  int width, height; /* of the image, in pixels */
  int margin; /* pixels around the image that the maps have too */
  int band; /* pixel rows */
  int parts; /* of a pixel in each direction */
  float far; /* where legs to the sky start */
};

/* Slices take their parts shifted against each other, by less than half a part: together they see more places. As
 * relay_maps.py has it, in pixels. */
float relay_shift(int slice, float step, int parts)
{
  return (mod(slice * step + 0.5, 1) - 0.5) / parts;
}

/* What is known of a place of the image: fractions s, t of files whose paths begin with `path`. */
struct RelayPart {
  string path;
  float s, t;
};

color relay_value(RelayPart part, string name)
{
  return texture(concat(part.path, name, ".exr"), part.s, part.t, 0, 0, 0, 0, "interp", "closest", "wrap", "clamp");
}

/* The part for a place, as fractions of the image's width and height from the lower left corner. */
RelayPart relay_part(RelayMaps maps, int slice, float across, float up)
{
  float edge = 0.5 / maps.parts; /* half a part inside of the maps */
  int columns = maps.width + 2 * maps.margin, rows = maps.height + 2 * maps.margin;
  float x = across * maps.width + maps.margin - relay_shift(slice, 0.7548777, maps.parts);
  float y = up * maps.height + maps.margin - relay_shift(slice, 0.5698403, maps.parts);
  x = clamp(x, edge, columns - edge);
  y = clamp(y, edge, rows - edge);
  int band = int(y) / maps.band;
  string path = format("%s%02d_%04d_", maps.path, slice, band);
  RelayPart part = {path, x / columns, (y - band * maps.band) / maps.band};
  color cell = relay_value(part, "cells");
  if (cell[0] > 0) {
    int finer = int(cell[0]) % RELAY_CELL, number = int(cell[0]) / RELAY_CELL;
    int fine = finer * maps.parts;
    part.path = format("%s%dx_", path, finer);
    int size[2];
    gettextureinfo(concat(part.path, "direction.exr"), "resolution", size);
    int cells = size[0] / fine;
    part.s = (mod(number, cells) + x - floor(x)) * fine / size[0];
    part.t = (number / cells + y - floor(y)) * fine / size[1];
  }
  return part;
}

/* The leg of a part; whether it leads to the sky. */
int relay_leg(RelayMaps maps, RelayPart part, output point place, output vector direction)
{
  direction = vector(relay_value(part, "direction"));
  float largest = max(max(abs(direction[0]), abs(direction[1])), abs(direction[2]));
  int to_sky = largest > sqrt(RELAY_TO_SKY);
  place = point(0);
  if (to_sky) {
    direction /= RELAY_TO_SKY;
    place = point(maps.far * normalize(direction));
  } else if (largest > 0) {
    place = point(relay_value(part, "place"));
  }
  return to_sky;
}

/* Of what the rays of a pixel see of the sky in a direction: an ellipse's axes, radians. */
void relay_footprint(RelayPart part, vector direction, output vector major, output vector minor)
{
  vector toward = normalize(direction), told = vector(relay_value(part, "place"));
  float narrow = dot(told, toward);
  major = told - narrow * toward;
  minor = narrow * cross(toward, normalize(major));
}
#endif
