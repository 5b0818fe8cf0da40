/* How relay_camera.osl and relay_screen.osl find the last straight leg of a curved camera ray. For OSL only.
 *
 * The core has traced a ray for every part of every pixel through the scene's meshes (blender_addon/cycles/relay_maps.py)
 * and stored where its last leg starts and where it goes. A sample gets the leg of the part that it falls into. Nothing is
 * interpolated: Cycles meets the surface that the core has found, and edges are as clean as the parts are fine.
 *
 * The image with its margin is cut into bands of pixel rows, from the bottom; a band is a set of OpenEXR files for each slice
 * of the shutter's time:
 *   <path><slice>_<band>_cells: a number a pixel: -1, or that of its cell in the fine maps, where the image is compressed;
 *   <path><slice>_<band>_place, _direction: parts x parts for each pixel;
 *   <path><slice>_<band>_fine_place, _fine_direction: fine x fine for each cell.
 * The length of a direction is how bright the light that comes that way is to the camera; 0: the ray is lost, the sample is
 * black. */
#ifndef BENT_OSL_RELAY_MAPS_H
#define BENT_OSL_RELAY_MAPS_H

struct RelayMaps {
  string path; /* how the files' names begin; "": none could be made */
  int width, height; /* of the image, in pixels */
  int margin; /* pixels around the image that the maps have too */
  int band; /* pixel rows */
  int parts, fine; /* of a pixel, or of a cell, in each direction */
};

/* The texel that has the fractions s, t of a map. */
color relay_texel(string map, float s, float t)
{
  return texture(map, s, t, 0, 0, 0, 0, "interp", "closest", "wrap", "clamp");
}

/* Slices take their parts shifted against each other, by less than half a part: together they see more places. As
 * relay_maps.py has it, in pixels. */
float relay_shift(int slice, float step, int parts)
{
  return (mod(slice * step + 0.5, 1) - 0.5) / parts;
}

/* The leg for a place of the image, as fractions of its width and height from the lower left corner. */
void relay_leg(RelayMaps maps, int slice, float across, float up, output point place, output vector direction)
{
  place = 0;
  direction = 0;
  if (maps.path == "") return;
  float edge = 0.5 / maps.parts; /* half a part inside of the maps */
  int columns = maps.width + 2 * maps.margin, rows = maps.height + 2 * maps.margin;
  float x = across * maps.width + maps.margin - relay_shift(slice, 0.7548777, maps.parts);
  float y = up * maps.height + maps.margin - relay_shift(slice, 0.5698403, maps.parts);
  x = clamp(x, edge, columns - edge);
  y = clamp(y, edge, rows - edge);
  int band = int(y) / maps.band;
  string path = format("%s%02d_%04d_", maps.path, slice, band);
  float s = x / columns, t = (y - band * maps.band) / maps.band;
  float cell = texture(concat(path, "cells.exr"), s, t, 0, 0, 0, 0, "interp", "closest", "wrap", "clamp");
  if (cell >= 0) {
    path = concat(path, "fine_");
    int size[2];
    gettextureinfo(concat(path, "place.exr"), "resolution", size);
    int cells = size[0] / maps.fine, number = int(cell);
    s = (mod(number, cells) + x - floor(x)) * maps.fine / size[0];
    t = (number / cells + y - floor(y)) * maps.fine / size[1];
  }
  place = point(relay_texel(concat(path, "place.exr"), s, t));
  direction = vector(relay_texel(concat(path, "direction.exr"), s, t));
}
#endif
