/* See portal.h. */
#include "render/portal.h"

#include <stdlib.h>

#include "render/dimensions.h"
#include "render/path.h"
#include "scene/fresnel.h"
#include "scene/scene.h"

/* Mouths are never drawn more often than this: nobody knows what stands before them. And if less, not at all. */
static const double CHANCE_MAX = 0.75, CHANCE_MIN = 0.01;
/* Lobes as narrow as this look into a mouth by themselves: GGX roughness alpha. */
static const double ALPHA_NARROW = 0.25;
/* With which ways are tried that are nearly always blocked. */
static const double WAY_CHANCE_MIN = 0.1;
/* No side of a throat counts as darker than this part of the other. */
static const double DARKEST = 1e-3;
enum { THIS_SIDE, FAR_SIDE, SIDES };
/* Paths from each side of a throat, as many as one block takes; and how they are traced. */
enum { LEARNING_PATHS = 1024, WAYS_MAX = 1 << 20 };
static const uint32_t LEARNING_SEED = 0x7072746c;
static const bent_render_settings LEARNING = {
    .width = 1, .height = 1, .sample_count = 1, .max_bounces = 3, .diffuse_bounces = 3, .glossy_bounces = 3,
    .transmission_bounces = 3, .transparent_bounces = 8, .roulette_start = 2, .tolerance = 1e-3, .filter_width = 1,
    .light_sampling = BENT_LIGHTS_BOTH, .light_threshold = 0.01, .caustics_reflective = 1, .caustics_refractive = 1};

struct portals {
  double *radiance;    /* that comes to a throat from each of its sides, mean; by home */
  double *way_chances; /* by cell and way; NULL: too many to know */
};

static size_t home_of(size_t lens, int side) { return SIDES * lens + (size_t)side; }
static int is_mouth(const lens *l) { return !l->flat && l->spacetime.kind == BENT_ELLIS; }

/* ---- Directions ---- */

/* The directions in which rays from a place go through the throat of a wormhole; *side: on which it stands. */
static cap mouth_cap(const lens *l, vec3 from, int *side)
{
  const vec3 to = v3_sub(l->center, from);
  const double distance = v3_length(to), throat = l->spacetime.throat_radius * l->scale, core = throat / 2;
  const double bent = min2(distance, l->radius); /* where the ray begins to be */
  const double sine = throat / (bent + core * core / bent) * (bent / distance);
  *side = distance > core ? THIS_SIDE : FAR_SIDE;
  return cap_of_sine(v3_scale(to, (*side == THIS_SIDE ? 1 : -1) / distance), min2(sine, 1));
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

size_t portal_home(const geometry *g, vec3 position)
{
  double widest = 0;
  size_t home = 0;
  for (size_t i = 0; i < g->lens_count; i++) {
    int side;
    const cap cap = is_mouth(&g->lenses[i]) ? mouth_cap(&g->lenses[i], position, &side) : (struct cap){.chord2 = 0};
    if (cap.chord2 > widest) widest = cap.chord2, home = home_of(i, side);
  }
  return home;
}

const double *portal_way_chances(const bent_scene *scene, const portal_mix *mix, int sky, vec3 target)
{
  const geometry *g = scene->geometry;
  if (!mix->known || !mix->known->way_chances) return NULL;
  return mix->known->way_chances + portal_cell(g, mix->home, sky ? portal_sky_home(g) : portal_home(g, target));
}

portal_mix portal_mix_at(const bent_scene *scene, vec3 position, vec3 normal, const closure_set *set)
{
  portal_mix mix = {.count = 0};
  const geometry *g = scene->geometry;
  const portals *known = mix.known = scene->portals;
  if (!known) return mix;
  double sum = 0, widest = 0;
  for (size_t i = 0; i < g->lens_count; i++) {
    const lens *l = &g->lenses[i];
    if (!is_mouth(l)) continue;
    int side;
    const cap cap = mouth_cap(l, position, &side);
    const size_t own = home_of(i, side), other = l->exit < 0 ? home_of(i, !side) : home_of((size_t)l->exit, side);
    if (cap.chord2 > widest) widest = cap.chord2, mix.home = own;
    const double share = cap_form_factor(&cap, normal) * known->radiance[other];
    if (share > 0) add(&mix, cap, share);
  }
  for (int i = 0; i < mix.count; i++) sum += mix.portals[i].share;
  if (sum > 0) mix.chance = wide_share(set) * min2(sum / (sum + known->radiance[mix.home]), CHANCE_MAX);
  if (!(mix.chance >= CHANCE_MIN)) mix.chance = mix.count = 0;
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
  out->lobes_pdf = out->pdf;
  out->pdf = pdf;
  return 1;
}

/* ---- Learning ---- */

/* Starts a path on the throat, evenly over its area and with the cosine of its direction, to one side. */
static void start(const tracer *t, const lens *l, int side, sampler_pixel pixel, uint32_t sample, path *p, bent_ray *ray)
{
  double u[SAMPLER_DIMENSIONS];
  sampler_draw(&t->sampler, pixel, sample, dimensions_camera(), u);
  const cap all = {v3(0, 0, 1), 4}; /* the sphere */
  const vec3 place = cap_draw(&all, u[0], u[1]), outward = side == THIS_SIDE ? place : v3_scale(place, -1);
  vec3 x, y;
  v3_basis(outward, &x, &y);
  const double across = sqrt(u[2]), turn = 2 * M_PI * u[3];
  const vec3 direction = v3_normalize(v3_mad(x, across * cos(turn), v3_mad(y, across * sin(turn), v3_scale(outward, sqrt(1 - u[2])))));
  const double core = bent_spacetime_core_radius(&l->spacetime) * l->scale * (side == THIS_SIDE ? 1 + 1e-6 : 1 - 1e-6);
  const vec3 origin = v3_mad(place, core, l->center);
  *p = (path){.scattered = {.position = origin, .first_lens = -1}, .beta = {1, 1, 1}, .least_pdf = INFINITY, .ray = RAY_SCATTERED,
              .pixel = pixel, .sample = sample, .described = 1, .featured = 1};
  *ray = (bent_ray){.length_max = INFINITY, .visibility = BENT_VISIBLE_DIFFUSE};
  path_set_ray(t, ray, origin, direction, NULL);
}

/* The mean radiance that comes to the throat of lens `index` from one side. */
static bent_status learn(const tracer *t, path_block *block, size_t index, int side, double *radiance,
                         bent_progress *progress, bent_error *error)
{
  const sampler_pixel pixel = sampler_pixel_at(&t->sampler, LEARNING_SEED, (uint32_t)index, (uint32_t)side);
  for (int i = 0; i < LEARNING_PATHS; i++) {
    start(t, &t->scene->geometry->lenses[index], side, pixel, (uint32_t)i, &block->paths[i], &block->rays[i]);
    block->records[i] = (sample_record){0};
    block->paths[i].record = i;
  }
  bent_render_statistics unused = {0};
  const bent_status status = path_run(t, block, LEARNING_PATHS, &unused, progress, error);
  if (status) return status;
  *radiance = 0;
  for (int i = 0; i < LEARNING_PATHS; i++) {
    const float *value = block->records[i].value[CHANNEL_COMBINED];
    *radiance += ((double)value[0] + value[1] + value[2]) / (3 * LEARNING_PATHS);
  }
  return BENT_OK;
}

/* How many cells and ways there are. */
static size_t way_count(const geometry *g) { return portal_cell(g, SIDES * g->lens_count, 0); }

static bent_status learn_all(const tracer *t, path_block *block, portals *p, bent_progress *progress, bent_error *error)
{
  const geometry *g = t->scene->geometry;
  double brightest = 0;
  for (size_t i = 0; i < g->lens_count; i++)
    for (int side = 0; is_mouth(&g->lenses[i]) && side < (g->lenses[i].exit < 0 ? SIDES : 1); side++) {
      double *radiance = &p->radiance[home_of(i, side)];
      const bent_status status = learn(t, block, i, side, radiance, progress, error);
      if (status) return status;
      brightest = max2(brightest, *radiance);
    }
  for (size_t k = 0; k < SIDES * g->lens_count; k++) p->radiance[k] = max2(p->radiance[k], DARKEST * brightest);
  for (size_t k = 0; p->way_chances && k < way_count(g); k++) { /* noise falls best with time at the root of the part that arrives */
    const shadow_count *c = &block->counts[k];
    p->way_chances[k] = max2(sqrt((c->arrived + 1.0) / (c->traced + 1.0)), WAY_CHANCE_MIN);
  }
  return BENT_OK;
}

bent_status portals_new(const bent_scene *scene, portals **out, bent_progress *progress, bent_error *error)
{
  const geometry *g = scene->geometry;
  size_t mouths = 0;
  *out = NULL;
  for (size_t i = 0; i < g->lens_count; i++) mouths += (size_t)is_mouth(&g->lenses[i]);
  if (!mouths) return BENT_OK;
  path_block block;
  bent_status status = path_block_new(&block, scene, &NO_CHANNELS, LEARNING_PATHS, error);
  if (status) return status;
  portals *p = calloc(1, sizeof *p);
  const int knows_ways = way_count(g) <= WAYS_MAX;
  if (p) p->radiance = calloc(SIDES * g->lens_count, sizeof *p->radiance);
  if (p && knows_ways) p->way_chances = calloc(way_count(g), sizeof *p->way_chances);
  if (knows_ways) block.counts = calloc(way_count(g), sizeof *block.counts);
  if (!p || !p->radiance || (knows_ways && (!p->way_chances || !block.counts))) {
    status = bent_fail(error, BENT_ERROR_MEMORY, "portals: out of memory");
  } else {
    tracer t;
    tracer_init(&t, scene, &LEARNING, &NO_CHANNELS);
    status = learn_all(&t, &block, p, progress, error);
  }
  free(block.counts);
  path_block_free(&block);
  if (status) portals_free(p);
  else *out = p;
  return status;
}

void portals_free(portals *p)
{
  if (!p) return;
  free(p->radiance);
  free(p->way_chances);
  free(p);
}
