/* Wormholes' mouths as light portals: at a surface some directions are drawn among those whose rays go through a throat,
 * the others by the surface's lobes (one-sample multiple importance sampling, balance heuristic: Veach & Guibas 1995). The
 * one place that knows with what pdf a vertex of a path draws its next direction.
 *
 * The directions are a cap, even in solid angle, around that of the mouth's center. From a place of areal radius r, where
 * rays are bent, a ray goes through the throat of radius rho if b = r sin(angle) < rho and it goes down; from outside a
 * finite sphere it has the angle of its straight leg there. Another object on that leg makes the cap a guess, no more. */
#ifndef BENT_RENDER_PORTAL_H
#define BENT_RENDER_PORTAL_H
#include "base/cap.h"
#include "geometry/geometry.h"
#include "render/bsdf.h"

enum { PORTALS_MAX = 4 }; /* that a vertex looks at */

/* How a vertex draws its directions. */
typedef struct portal_mix {
  double chance; /* with which one is drawn through a mouth; 0: none is */
  int count;
  struct portal {
    cap cap;
    double share; /* of the chance */
  } portals[PORTALS_MAX];
} portal_mix;

/* For a vertex with that closure set, whose shares are for its own wo. normal: as direct_normal has it. */
portal_mix portal_mix_at(const bent_scene *scene, vec3 position, vec3 normal, const closure_set *set);
/* The pdf with which the vertex draws wi, by solid angle; bsdf_pdf: that of its lobes (bsdf_evaluate). Of delta lobes, which
 * no mouth draws: their part of it. */
static inline double portal_pdf(const portal_mix *mix, vec3 wi, double bsdf_pdf)
{
  double pdf = 0;
  for (int i = 0; i < mix->count; i++) {
    const struct portal *p = &mix->portals[i];
    if (cap_covers(&p->cap, wi)) pdf += p->share / cap_solid_angle(&p->cap);
  }
  return mix->chance * pdf + (1 - mix->chance) * bsdf_pdf;
}
/* bsdf_draw for the mixture: weight and pdf are the mixture's. */
int portal_draw(const portal_mix *mix, const closure_set *set, const shade_point *point, const double u[3],
                bsdf_sample *out);
#endif
