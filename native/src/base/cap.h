/* Spherical caps: round sets of directions, such as a sun's disk or a wormhole's mouth as a point sees it. */
#ifndef BENT_BASE_CAP_H
#define BENT_BASE_CAP_H
#include "base/turn.h"
#include "base/vec3.h"

typedef struct cap {
  vec3 axis;
  double chord2; /* squared distance on the unit sphere from axis to rim: precise for small caps, unlike a cosine */
} cap;

/* Around a unit vector; sine of the half angle, which is at most a quarter turn. */
static inline cap cap_of_sine(vec3 axis, double sine)
{
  return (cap){axis, 2 * sine * sine / (1 + sqrt(max2(1 - sine * sine, 0)))};
}

/* The chord's square is even over a cap's solid angle (Archimedes). */
static inline double cap_solid_angle(const cap *c) { return M_PI * c->chord2; }

static inline int cap_covers(const cap *c, vec3 direction)
{
  const vec3 chord = v3_sub(direction, c->axis);
  return v3_dot(chord, chord) <= c->chord2;
}

/* A unit direction drawn evenly, (u, v) in [0, 1)^2. */
static inline vec3 cap_draw(const cap *c, double u, double v)
{
  const double chord2 = c->chord2 * u, down = chord2 / 2, across = sqrt(max2(chord2 - down * down, 0));
  double sine, cosine;
  turn_sincos(v, &sine, &cosine);
  vec3 x, y;
  v3_basis(c->axis, &x, &y);
  return v3_normalize(v3_mad(x, across * cosine, v3_mad(y, across * sine, v3_scale(c->axis, 1 - down))));
}

/* What part of the light that an evenly diffuse surface scatters comes from a cap, about: exact for a cap above
 * the horizon. normal 0: from all around. */
static inline double cap_form_factor(const cap *c, vec3 normal)
{
  const double cosine = 1 - c->chord2 / 2, sine2 = max2(1 - cosine * cosine, 0), sine = sqrt(sine2);
  if (v3_dot(normal, normal) == 0) return c->chord2 / 4;
  const double height = v3_dot(normal, c->axis);
  if (height >= sine) return sine2 * height;
  return height > -sine ? 0.25 * sine * (height + sine) * (height + sine) : 0;
}
#endif
