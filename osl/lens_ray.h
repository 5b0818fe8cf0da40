/* One ray across a lens sphere, and how the rays beside it part. For OSL only.
 *
 * Places q and unit directions d are in the lens' object space, where the sphere has radius 1.
 */
#ifndef BENT_OSL_LENS_RAY_H
#define BENT_OSL_LENS_RAY_H
#include "derivatives.h"
#include "lens_table.h"
#include "transport.h"

struct Lens {
  Space space;
  string total, outward; /* images of tables */
  float soft_edge;
  vector far_x, far_y, far_z; /* axes of the other mouth's sphere, in the world */
};

/* The straight line through q along d, as far as it lies inside the sphere. */
struct Chord {
  vector aside; /* its place nearest the center */
  float half;   /* half its length; 0: it misses the sphere */
  float first, last; /* along d from q: where it starts to bend, and where it would leave if nothing bent it */
  int entering;      /* it starts to bend on the sphere, not inside */
};

/* `before`: how much of the line before q the ray has traveled. */
Chord chord_of(point q, vector d, float before)
{
  Chord chord;
  float closest = -dot(d, vector(q));
  chord.aside = vector(q) + closest * d;
  chord.half = sqrt(max(1 - dot(chord.aside, chord.aside), 0));
  chord.first = max(closest - chord.half, -before);
  chord.last = closest + chord.half;
  chord.entering = chord.first == closest - chord.half;
  return chord;
}

int misses(Chord chord) { return chord.half < 1e-4 || chord.first > chord.last - 1e-6; }

/* How far a ray has come in a straight line to P, in the world. */
float traveled()
{
  float distance = 0;
  getattribute("path:ray_length", distance);
  if (raytype("camera")) {
    /* what Cycles hands over starts at the camera's near clipping plane */
    vector back = P - transform("camera", "world", point(0));
    if (length(cross(back, normalize(I))) < 1e-5 * length(back)) distance = length(back);
  }
  return distance;
}

/* Toward the sphere's edge less and less of a ray's bending remains. */
void soften(Lens lens, Chord chord, point q, vector d, output point p, output vector out)
{
  if (lens.soft_edge <= 0) return;
  float bent = smoothstep(0, lens.soft_edge, 1 - length(chord.aside)), radius = lens.space.radius;
  p = radius * normalize(mix(vector(q) + chord.last * d, vector(p) / radius, bent));
  out = normalize(mix(d, out, bent));
}

/* Past no disk: fate, and where and in which direction the ray leaves, in masses or throat radii. */
int cross_lens(Lens lens, Chord chord, point q, vector d, output point p, output vector out)
{
  point start = lens.space.radius * point(q + chord.first * d);
  int fate = chord.entering && is_tabulated(lens.space)
                 ? cross_by_table(lens.space, lens.total, lens.outward, start, d, p, out)
                 : follow(lens.space, start, d, p, out);
  if (fate == FATE_NEAR) soften(lens, chord, q, d, p, out);
  return fate;
}

/* A direction between a wormhole's mouths: the world beyond would look mirrored without. */
vector mirrored(int fate, vector d) { return fate == FATE_FAR ? vector(d[0], -d[1], d[2]) : d; }

/* A direction that leaves with this fate, in the world. */
vector leaving(Lens lens, int fate, vector out)
{
  return normalize(fate == FATE_FAR ? out[0] * lens.far_x + out[1] * lens.far_y + out[2] * lens.far_z
                                    : transform("object", "world", out));
}

/* How the direction in which a ray leaves, `toward`, changes where the ray is shifted and turned: from a ray to one side, or
 * to the other if the first ends elsewhere; 0 if both do. */
vector change_beside(Lens lens, point q, vector d, float before, vector shift, vector turn, int fate, vector toward)
{
  vector change = 0;
  for (int side = 1; side > -2 && change == vector(0); side -= 2) {
    point beside = q + side * shift, p;
    vector along = normalize(d + side * turn), out = along;
    Chord chord = chord_of(beside, along, before);
    int end = misses(chord) ? FATE_NEAR : cross_lens(lens, chord, beside, along, p, out);
    if (end == fate) change = side * (leaving(lens, end, out) - toward);
  }
  return change;
}

/* The same without spin, along the unit vector `square` to the plane of the ray, in closed form: that plane turns with d and
 * `aside`, and `out`, where the ray leaves in the object, stays the same sum of the two. */
vector change_of_plane(Lens lens, Chord chord, vector d, vector square, float shift, float turn, int fate, vector out)
{
  vector within = mirrored(fate, out);
  float shifted = shift + (chord.last - chord.half) * turn; /* `aside` */
  float change = dot(within, chord.aside) / dot(chord.aside, chord.aside) * shifted + dot(within, d) * turn;
  return change * leaving(lens, fate, mirrored(fate, square));
}

/* `toward`, with the derivatives that it has over `pixels` of the picture, by rays so far apart. Cycles tells how far rays of
 * neighboring pixels are apart here, and their angle, but not which way: two directions square to each other stand for all,
 * one of them in the plane of the ray. `out`: `toward` in the object.
 */
vector with_derivatives(Lens lens, point q, vector d, float before, Chord chord, int fate, vector out, vector toward,
                        float pixels)
{
  vector beside[2], same[2];
  float to_object = length(transform("world", "object", normalize(I)));
  float angle = pixels * length(Dx(I)), apart = pixels * to_object * length(Dx(P));
  if (apart == 0) return toward;
  int is_plane = lens.space.a == 0 && length(chord.aside) > 1e-3;
  vector aside = is_plane ? chord.aside : cross(d, abs(d[2]) < 0.9 ? vector(0, 0, 1) : vector(1, 0, 0));
  beside[0] = normalize(aside);
  beside[1] = cross(d, beside[0]);
  for (int i = 0; i < 2; i++) {
    if (is_plane && i == 1)
      beside[i] = change_of_plane(lens, chord, d, beside[i], apart, angle, fate, out);
    else
      beside[i] = change_beside(lens, q, d, before, apart * beside[i], angle * beside[i], fate, toward);
  }
  STRIP_DERIVATIVES("changes", beside, same);
  return with_slopes(toward, same[0], same[1]);
}
#endif
