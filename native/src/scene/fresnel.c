/* Reflectance of the lobes that are not of a dielectric. */
#include "scene/fresnel.h"

vec3 fresnel_of_metal(const closure *c, double cos_i)
{
  if (c->fresnel == FRESNEL_CONDUCTOR) return fresnel_conductor(cos_i, c->f0, c->edge);
  if (c->fresnel == FRESNEL_COMPLEX) return fresnel_complex_colors(cos_i, c->f0, c->edge);
  return v3_splat(1);
}
