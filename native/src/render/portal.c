/* See portal.h. */
#include "render/portal.h"

#include "scene/fresnel.h"
#include "scene/scene.h"

/* Mouths are never drawn more often than this: nobody knows what stands before them. And if less, not at all. */
static const double CHANCE_MAX = 0.75, CHANCE_MIN = 0.01;
/* Lobes as narrow as this look into a mouth by themselves: GGX roughness alpha. */
static const double ALPHA_NARROW = 0.25;

/* The directions in which rays from a place go through the throat of a wormhole. */
static cap mouth_cap(const lens *l, vec3 from)
{
  const vec3 to = v3_sub(l->center, from);
  const double distance = v3_length(to), throat = l->spacetime.throat_radius * l->scale, core = throat / 2;
  const double bent = min2(distance, l->radius); /* where the ray begins to be */
  const double sine = throat / (bent + core * core / bent) * (bent / distance);
  return cap_of_sine(v3_scale(to, (distance > core ? 1 : -1) / distance), min2(sine, 1));
}

/* What part of the light that an evenly diffuse surface scatters comes from a cap, about: exact for a cap above the horizon. */
static double form_factor(const cap *c, vec3 normal)
{
  const double cosine = 1 - c->chord2 / 2, sine2 = max2(1 - cosine * cosine, 0), sine = sqrt(sine2);
  if (v3_dot(normal, normal) == 0) return c->chord2 / 4;
  const double height = v3_dot(normal, c->axis);
  if (height >= sine) return sine2 * height;
  return height > -sine ? 0.25 * sine * squared(height + sine) : 0;
}

/* The part of a set's samples that goes to lobes too wide to find a mouth by themselves. */
static double wide_share(const closure_set *set)
{
  double sum = 0;
  for (int i = 0; i < set->count; i++) {
    const closure *c = &set->closures[i];
    if (closure_is_delta(c)) continue;
    const double alpha2 = c->alpha * c->alpha_y;
    sum += c->share * (closure_is_microfacet(c) ? alpha2 / (alpha2 + squared(ALPHA_NARROW)) : 1);
  }
  return sum;
}

/* Adds a portal, in place of the faintest if there are too many. */
static void add(portal_mix *mix, cap cap, double share)
{
  int at = mix->count < PORTALS_MAX ? mix->count++ : 0;
  for (int i = 0; mix->count == PORTALS_MAX && i < PORTALS_MAX; i++)
    if (mix->portals[i].share < mix->portals[at].share) at = i;
  if (mix->portals[at].share < share) mix->portals[at] = (struct portal){cap, share};
}

portal_mix portal_mix_at(const bent_scene *scene, vec3 position, vec3 normal, const closure_set *set)
{
  portal_mix mix = {.count = 0};
  const geometry *g = scene->geometry;
  double sum = 0;
  for (size_t i = 0; i < g->lens_count; i++) {
    if (g->lenses[i].flat || g->lenses[i].spacetime.kind != BENT_ELLIS) continue;
    const cap cap = mouth_cap(&g->lenses[i], position);
    const double share = form_factor(&cap, normal);
    if (share > 0) add(&mix, cap, share);
  }
  for (int i = 0; i < mix.count; i++) sum += mix.portals[i].share;
  mix.chance = wide_share(set) * min2(sum / (1 + sum), CHANCE_MAX);
  if (!(mix.chance >= CHANCE_MIN)) return (portal_mix){.count = 0};
  for (int i = 0; i < mix.count; i++) mix.portals[i].share /= sum;
  return mix;
}

int portal_draw(const portal_mix *mix, const closure_set *set, const shade_point *point, const double u[3],
                bsdf_sample *out)
{
  double pick = u[2] - mix->chance;
  if (pick >= 0) {
    if (!bsdf_draw(set, point, (const double[3]){u[0], u[1], pick / (1 - mix->chance)}, out)) return 0;
  } else {
    pick = min2(u[2] / mix->chance, 1 - 1e-9);
    int chosen = 0;
    while (chosen + 1 < mix->count && pick >= mix->portals[chosen].share) pick -= mix->portals[chosen++].share;
    const vec3 wi = cap_draw(&mix->portals[chosen].cap, u[0], u[1]);
    if (!bsdf_drawn(set, point, wi, min2(pick / mix->portals[chosen].share, 1), out)) return 0;
  }
  if (!(out->pdf > 0)) { /* a delta lobe */
    out->weight = v3_scale(out->weight, 1 / (1 - mix->chance));
    return 1;
  }
  const double pdf = portal_pdf(mix, out->wi, out->pdf);
  out->weight = v3_scale(out->weight, out->pdf / pdf);
  out->pdf = pdf;
  return 1;
}
