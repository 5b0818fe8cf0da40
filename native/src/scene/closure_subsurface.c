/* Subsurface scattering: from what an artist sets to a lobe whose light walks below the surface.
 *
 * As Cycles 5.0 has it. The scale of "skin" is that of Jensen and Buhler, "A Rapid Hierarchical Rendering Technique for
 * Translucent Materials" (SIGGRAPH 2002), section 4.3: the mean free path of a medium which reflects the color if light
 * spreads in it by a dipole.
 */
#include "scene/closure_build.h"
#include "scene/fresnel.h"

/* Shorter mean free paths, world units, count as none. */
static const double RADIUS_MIN = 1e-8;

/* What a dipole reflects of light, for a reduced albedo and 4/3 A of the boundary. */
static double dipole_reflectance(double albedo, double a43)
{
  const double s = sqrt(3 * (1 - albedo));
  return 0.5 * albedo * (1 + exp(-a43 * s)) * exp(-s);
}

/* sqrt(3 (1 - a)) for the reduced albedo a that reflects `color`; to 12 bits, as in Cycles. */
static double skin_scale(double color, double a43)
{
  if (color < 1e-4) return sqrt(3);
  if (color >= 0.995) return sqrt(3 * 1e-6);
  double low = 0, high = 1, middle = 0.5;
  for (int i = 0; i < 12; i++) {
    middle = (low + high) / 2;
    if (dipole_reflectance(middle, a43) < color) low = middle;
    else high = middle;
  }
  return sqrt(3 * (1 - middle));
}

/* The factors between the radius that is set and the mean free path. */
static vec3 radius_scale(const closure *c)
{
  if (c->method == SUBSURFACE_WALK) return v3_splat(0.25 / M_PI);
  const double inverse = 1 / c->ior; /* diffuse reflectance from inside: Egan and Hilgeman's fit */
  const double inside = inverse * (0.71 - 1.44 * inverse) + 0.668 + 0.0636 * c->ior;
  const double a43 = 4.0 / 3 * (1 + inside) / (1 - inside);
  return v3(skin_scale(c->f0.x, a43), skin_scale(c->f0.y, a43), skin_scale(c->f0.z, a43));
}

/* 1 for the components that are at least RADIUS_MIN, else 0. */
static vec3 has_radius(vec3 radius)
{
  return v3(radius.x >= RADIUS_MIN, radius.y >= RADIUS_MIN, radius.z >= RADIUS_MIN);
}

void closure_add_subsurface(closure_set *set, const shade_point *point, vec3 weight, vec3 color, const subsurface *s,
                            vec3 normal)
{
  const vec3 rho = v3_saturate(v3_positive(color)), all = v3_positive(v3_scale(weight, saturate(s->weight)));
  const vec3 radius = v3_positive(v3_scale(s->radius, s->scale)), deep = has_radius(radius);
  closure_add_diffuse(set, point, v3_mul(all, v3_sub(v3_splat(1), deep)), rho, 0, normal);
  closure *c = closure_next_microfacet(set, CLOSURE_SUBSURFACE, point, v3_mul(v3_mul(all, deep), rho), 0, normal);
  if (!c) return;
  c->tangent = closure_valid_normal(point, normal);
  c->f0 = rho;
  c->method = s->method;
  c->alpha = c->alpha_y = s->method == SUBSURFACE_SKIN ? 1 : saturate(s->alpha);
  c->ior = min2(max2(s->ior, 1.01), 3.8);
  c->anisotropy = min2(max2(s->anisotropy, 0), 0.9);
  c->radius = v3_mul(v3_mul(radius, deep), radius_scale(c));
  closure_finish(set, c, v3_splat(1));
}
