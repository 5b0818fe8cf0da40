/* See frequency.h. */
#include "light/frequency.h"

/* nu just inside the rim of a lens times the lapse there, where it is 1 outside. */
static double rim_factor(const lens *l)
{
  if (isinf(l->radius)) return 1;
  const double rim[3] = {l->radius / l->scale, 0, 0};
  return bent_lapse(&l->spacetime, rim) / bent_length_scale(&l->spacetime, rim);
}

double frequency_at(const geometry *g, vec3 position)
{
  const lens *l = geometry_lens_at(g, position);
  if (!l || l->flat) return 1;
  double at[3];
  v3_to(at, mat4_point(&l->spacetime_from_world, position));
  const double lapse = bent_lapse(&l->spacetime, at);
  return lapse > 0 ? rim_factor(l) / lapse : 1;
}

int frequency_is_of_place(const geometry *g)
{
  for (size_t i = 0; i < g->lens_count; i++) {
    const lens *l = &g->lenses[i];
    if (l->flat || l->spacetime.kind != BENT_ELLIS || l->exit < 0) continue;
    const lens *exit = &g->lenses[l->exit];
    const double here = rim_factor(l) * l->scale * l->spacetime.throat_radius;
    const double there = rim_factor(exit) * exit->scale * exit->spacetime.throat_radius;
    if (fabs(here / there - 1) > 1e-6) return 0;
  }
  return 1;
}
