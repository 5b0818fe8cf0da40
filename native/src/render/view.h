/* A place of a surface as it is looked at from one direction: what scatters there, and how that draws directions. Light that
 * is traced from lamps looks at a surface from both sides of an event: materials may depend on the direction towards the
 * camera in any way, so that the light that they scatter is evaluated as the camera's paths see it, always. */
#ifndef BENT_RENDER_VIEW_H
#define BENT_RENDER_VIEW_H
#include "light/surface.h"
#include "render/chain.h"
#include "render/path.h"
#include "render/portal.h"

typedef struct view {
  shade_point point;
  closure_set set;
  portal_mix mix;
  int see_through; /* from this side it is not there */
} view;

/* closures: room for those of the surface. */
void view_at(const tracer *t, const bent_hit *hit, vec3 wo, closure *closures, view *out);
/* The pdf with which a view's lobes, but for sharp ones, draw wi. */
chain_back view_back(const view *v, vec3 wi);
/* Cosine of a direction to the triangle, not negative. */
static inline double view_cosine(const shade_point *point, vec3 direction)
{
  return fabs(v3_dot(point->geometric_normal, direction));
}
#endif
