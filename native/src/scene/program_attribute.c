/* Operations that read attributes of the mesh and the instance, and coordinates a step beside the point. */
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
