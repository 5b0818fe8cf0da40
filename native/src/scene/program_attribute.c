/* Operations that read attributes of the mesh and the instance; and bump, which compares heights here and a step beside.
 *
 * The step is Cycles': the filter width times the size of a pixel on the surface, along two axes in the triangle's plane.
 * A pixel's size grows with the length of all of light's way from the camera, straight or bent: how lenses stretch it is
 * left out, so that the look of a surface does not change where its images are magnified. */
#include <math.h>

#include "scene/attribute.h"
#include "scene/program.h"

/* How Cycles shows an attribute as a vector, a number and an alpha. */
static void store(int components, const double value[4], vec3 *out)
{
  const vec3 v = v3_from(value);
  out[0] = components == 1 ? v3_splat(v.x) : components == 2 ? v3(v.x, v.y, 0) : v;
  out[1] = v3_splat(components < 3 ? v.x : v3_average(v));
  out[2] = v3_splat(components == 4 ? value[3] : 1);
}

static void read_attribute(const shade_point *p, int id, vec3 *out)
{
  double value[4] = {0};
  const attribute *a = attribute_find(p->mesh_attributes, id);
  if (a) {
    const double w[3] = {1 - p->barycentric[0] - p->barycentric[1], p->barycentric[0], p->barycentric[1]};
    const float *corner = a->values + (size_t)p->triangle * 3 * (size_t)a->components;
    for (int c = 0; c < 3; c++)
      for (int k = 0; k < a->components; k++) value[k] += w[c] * *corner++;
  } else if ((a = attribute_find(p->instance_attributes, id))) {
    for (int k = 0; k < a->components; k++) value[k] = a->values[k];
  } else { /* as Cycles, which takes it for a number that is 0 */
    store(1, value, out);
    return;
  }
  store(a->components, value, out);
}

OPERATION(attribute) { read_attribute(context->point, immediates[0], out); }

/* A pixel's extent along two axes of the triangle's plane; of the sky, that of what images are averaged over. */
static void pixel_axes(const shade_point *p, vec3 axes[2])
{
  if (p->across_sky) {
    axes[0] = p->across_sky[0], axes[1] = p->across_sky[1];
    return;
  }
  const vec3 n = p->geometric_normal, a = v3(n.z - n.y, n.x - n.z, n.y - n.x), b = v3(n.z - n.y, n.x + n.z, -n.y - n.x);
  double size = p->footprint;
  if (!(size > 0)) { /* nobody looks closely */
    const double first = v3_length(p->edges[0]), second = v3_length(p->edges[1]);
    size = 1e-3 * (first + second > 0 ? first + second : 1);
  }
  const vec3 x = v3_normalize(n.x != n.y || n.x != n.z ? a : b);
  axes[0] = v3_scale(x, size);
  axes[1] = v3_scale(v3_cross(n, x), size);
}

/* The point a step along an axis further on in the plane of its triangle: what its coordinates are made of. Seen from
 * behind, what is bound to the triangle is stepped through the other way, so that a hill becomes a hollow; what depends on
 * the place in space is not (as in Cycles). */
static shade_point beside(const shade_point *p, int axis, double width)
{
  shade_point q = *p;
  vec3 axes[2];
  pixel_axes(p, axes);
  const vec3 step = v3_scale(axes[axis], width);
  const vec3 own = p->object_from_world ? mat4_vector(p->object_from_world, step) : step;
  const vec3 e1 = p->edges[0], e2 = p->edges[1], normal = v3_cross(e1, e2);
  const double square = p->backfacing ? -v3_dot(normal, normal) : v3_dot(normal, normal);
  double change[2] = {0};
  if (square != 0) {
    change[0] = v3_dot(v3_cross(e2, normal), own) / square;
    change[1] = v3_dot(v3_cross(normal, e1), own) / square;
  }
  q.position = v3_add(p->position, step);
  if (p->across_sky) { /* where all coordinates are the direction */
    q.generated = q.position;
    q.wo = q.geometric_normal = q.normal = v3_scale(q.position, -1);
    return q;
  }
  for (int i = 0; i < 2; i++) {
    q.barycentric[i] += change[i];
    if (p->corner_uvs)
      for (int k = 0; k < 2; k++) q.uv[k] += change[i] * ((double)p->corner_uvs[i + 1][k] - p->corner_uvs[0][k]);
    if (p->corner_generated[0]) {
      const float *from = p->corner_generated[0], *to = p->corner_generated[i + 1];
      q.generated = v3_mad(v3((double)to[0] - from[0], (double)to[1] - from[1], (double)to[2] - from[2]), change[i],
                           q.generated);
    }
  }
  return q;
}

OPERATION(coordinate_beside)
{
  const shade_point point = beside(context->point, immediates[1], in[0]->x);
  const program_context there = {.point = &point};
  op_coordinate(&there, in, immediates, out);
}

OPERATION(attribute_beside)
{
  const shade_point point = beside(context->point, immediates[1], in[0]->x);
  read_attribute(&point, immediates[0], out);
}

/* Mikkelsen, "Bump Mapping Unparametrized Surfaces on the GPU" (2010), as Cycles has it. */
OPERATION(bump)
{
  const double strength = fmax(in[0]->x, 0), distance = immediates[0] ? -in[1]->x : in[1]->x;
  const double along_x = in[3]->x - in[2]->x, along_y = in[4]->x - in[2]->x;
  const vec3 normal = *in[6];
  vec3 axes[2];
  pixel_axes(context->point, axes);
  for (int i = 0; i < 2; i++) axes[i] = v3_scale(axes[i], in[5]->x);
  const vec3 rx = v3_cross(axes[1], normal), ry = v3_cross(normal, axes[0]);
  const double determinant = v3_dot(axes[0], rx);
  const vec3 slope = v3_add(v3_scale(rx, along_x), v3_scale(ry, along_y));
  const double sign = (determinant > 0) - (determinant < 0);
  const vec3 bent = v3_normalize(v3_mad(slope, -distance * sign, v3_scale(normal, fabs(determinant))));
  *out = v3_dot(bent, bent) > 0
             ? v3_normalize(v3_add(v3_scale(bent, strength), v3_scale(normal, 1 - strength)))
             : normal;
}
