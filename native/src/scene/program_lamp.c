/* Operations that only the materials of lamps have: where a lamp shines, as Cycles 4.5 and 5.0 define it (the files of its
 * kernel/light). A lamp stands at the origin of its object and shines along -z. Directions are local, so that a lamp in
 * curved space is to its neighborhood what it is in flat space. */
#include <math.h>

#include "scene/program.h"

/* Where the light is seen from, relative to the lamp. */
static vec3 viewer_of(const shade_point *p)
{
  const vec3 center = p->world_from_object ? mat4_point(p->world_from_object, v3(0, 0, 0)) : v3(0, 0, 0);
  return v3_mad(p->wo, p->ray_length, v3_sub(p->position, center));
}

/* A sphere is seen from outside on its front and from inside on its back: once by each ray. A soft one stands for a disk of
 * that radius through its center that faces the viewer; at the distance d that looks as large as the part of the sphere
 * whose normals N have sin(N, wo)^2 < 1 / (1 + (radius / d)^2). */
OPERATION(sphere_lamp)
{
  const shade_point *p = context->point;
  const double radius2 = in[0]->x * in[0]->x, cosine = v3_dot(p->normal, p->wo);
  const vec3 viewer = viewer_of(p);
  const double distance2 = v3_dot(viewer, viewer);
  int shines = p->backfacing == (distance2 <= radius2);
  if (immediates[0])
    shines = shines && v3_dot(viewer, p->wo) > 0 && (1 - cosine * cosine) * (distance2 + radius2) <= distance2;
  *out = v3_splat(shines);
}

static double smoothstep(double x)
{
  const double t = fmin(fmax(x, 0), 1);
  return t * t * (3 - 2 * t);
}

/* The cone is one of object coordinates, an ellipse where those are scaled. Within a sphere (radius not 0) there is none, but
 * light goes only away from the middle. */
OPERATION(spot_cone)
{
  const shade_point *p = context->point;
  const double cosine = in[0]->x, width = in[1]->x, radius = in[2]->x;
  const vec3 viewer = viewer_of(p);
  if (radius > 0 && v3_dot(viewer, viewer) <= radius * radius) {
    *out = v3_splat(v3_dot(viewer, p->wo) > 0);
    return;
  }
  const vec3 beam = p->object_from_world ? mat4_vector(p->object_from_world, p->wo) : p->wo;
  const double inside = -v3_normalize(beam).z - cosine;
  *out = v3_splat(width > 0 ? smoothstep(inside / width) : inside > 0);
}

/* What the slats of a soft box leave of the light at an angle to its normal. */
OPERATION(area_spread)
{
  const shade_point *p = context->point;
  const double cosine = v3_dot(p->geometric_normal, p->wo);
  const double tangent = v3_length(v3_cross(p->geometric_normal, p->wo)) / cosine;
  *out = v3_splat(cosine > 0 ? fmax((in[0]->x - tangent) * in[1]->x, 0) : 0);
}

/* Strength, smoothing. */
OPERATION(light_falloff)
{
  const double length = context->point->ray_length, length2 = length * length, smoothing = in[1]->x;
  double strength = in[0]->x;
  if (length >= SKY_LENGTH) {
    out[0] = out[1] = out[2] = v3_splat(strength);
    return;
  }
  if (smoothing > 0) strength *= length2 / (smoothing + length2);
  out[0] = v3_splat(strength);
  out[1] = v3_splat(strength * length);
  out[2] = v3_splat(strength * length2);
}
