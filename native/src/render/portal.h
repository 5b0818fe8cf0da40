/* Wormholes' mouths as light portals: at a surface some directions are drawn among those whose rays go through a throat,
 * the others by the surface's lobes (one-sample multiple importance sampling, balance heuristic: Veach & Guibas 1995). The
 * one place that knows with what pdf a vertex of a path draws its next direction.
 *
 * The directions are a cap, even in solid angle, around that of the mouth's center. From a place of areal radius r, where
 * rays are bent, a ray goes through the throat of radius rho if b = r sin(angle) < rho and it goes down; from outside a
 * finite sphere it has the angle of its straight leg there. Another object on that leg makes the cap a guess, no more.
 *
 * How often a mouth is worth it depends on how bright it is beside the rest: that is learned from paths that start on the
 * throats, by commit. They also learn which ways to lights are mostly blocked: these are tried by chance. */
#ifndef BENT_RENDER_PORTAL_H
#define BENT_RENDER_PORTAL_H
#include "base/cap.h"
#include "bentlight/error.h"
#include "geometry/geometry.h"
#include "light/join.h"
#include "render/bsdf.h"

enum { PORTALS_MAX = 4 }; /* that a vertex looks at */

/* What is known of all throats. */
typedef struct portals portals;

/* Of a scene whose geometry and lights are committed; *out is NULL without wormholes. The same scene always gives the same. */
bent_status portals_new(const bent_scene *scene, portals **out, bent_progress *progress, bent_error *error);
void portals_free(portals *portals);

/* How a vertex draws its directions. */
typedef struct portal_mix {
  double chance; /* with which one is drawn through a mouth; 0: none is */
  int count;
  struct portal {
    cap cap;
    double share; /* of the chance */
  } portals[PORTALS_MAX];
  const portals *known; /* NULL: nothing */
  size_t home;          /* of the vertex */
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

/* ---- Ways to lights ---- */

/* The side of the throat that looks widest from a place; and what stands for the sky instead. */
size_t portal_home(const geometry *g, vec3 position);
static inline size_t portal_sky_home(const geometry *g) { return 2 * g->lens_count; }
/* Where the joint_ways of pairs begin in a list of counts or chances: from a home to another one or the sky. */
static inline size_t portal_cell(const geometry *g, size_t from, size_t to)
{
  return (from * (2 * g->lens_count + 1) + to) * joint_ways(g);
}
/* The chances with which ways from a vertex to a light are to be tried, for join_by_chance. */
const double *portal_way_chances(const bent_scene *scene, const portal_mix *mix, int sky, vec3 target);
#endif
