/* See lights.h. */
#include "light/lights.h"

#include <stdint.h>
#include <stdlib.h>

#include "geometry/geometry.h"
#include "light/casters.h"
#include "light/join.h"
#include "light/light_tree.h"
#include "light/sky_map.h"
#include "light/surface.h"
#include "light/triangle.h"
#include "scene/shading.h"

/* What the tree holds: a triangle, or (instance < 0) a lamp. */
typedef struct emitter {
  int32_t instance, index;
  vec3 corner[3]; /* of a triangle, world */
} emitter;

struct lights {
  size_t count, capacity, first_lamp; /* lamps come after all triangles */
  emitter *emitters;
  light_cluster *clusters; /* of the emitters; only while the tree is built */
  light_tree *tree;        /* NULL without emitters */
  double *flux;            /* running sum over the emitters that light subpaths start from, about */
  uint8_t *sides;          /* of a triangle that shine: SIDE_* */
  casters casters;
  int32_t **of_triangle;   /* for each instance NULL, or for each of its triangles the emitter, or -1 */
  size_t instance_count;
  double even;             /* chance that a place on a triangle is drawn evenly over its area */
  double *sun_weight;      /* irradiance, about */
  double suns_weight, sky_weight;
  sky_map *sky; /* NULL: not worth drawing */
};

enum { SIDE_FRONT = 1, SIDE_BACK = 2 };

/* Where a triangle's mean radiance is looked at: one of Stroud's rules of second degree, and its middle. */
static const double PROBES[4][2] = {{1.0 / 3, 1.0 / 3}, {1.0 / 6, 1.0 / 6}, {2.0 / 3, 1.0 / 6}, {1.0 / 6, 2.0 / 3}};
/* A group of lights is drawn at least this often. */
static const double GROUP_SHARE_MIN = 0.05;
/* Looks at a textured sun, along each side of its disk. */
enum { SUN_PROBES = 16 };
/* lights.even in curved space. */
static const double BENT_EVEN = 0.5;

static int push(lights *l, emitter e, const light_cluster *cluster)
{
  if (l->count == l->capacity) {
    const size_t capacity = l->capacity ? 2 * l->capacity : 256;
    emitter *emitters = realloc(l->emitters, capacity * sizeof *emitters);
    if (emitters) l->emitters = emitters;
    light_cluster *clusters = realloc(l->clusters, capacity * sizeof *clusters);
    if (clusters) l->clusters = clusters;
    if (!emitters || !clusters) return 0;
    l->capacity = capacity;
  }
  l->emitters[l->count] = e;
  l->clusters[l->count++] = *cluster;
  return 1;
}

/* Vertex i of a triangle is corner[i]; half the cross product of two edges is its area vector. */
static vec3 triangle_area(const geometry *g, int instance, int triangle, vec3 corner[3])
{
  for (int i = 0; i < 3; i++) corner[i] = geometry_vertex(g, instance, triangle, i);
  return v3_scale(v3_cross(v3_sub(corner[1], corner[0]), v3_sub(corner[2], corner[0])), 0.5);
}

static vec3 triangle_at(const vec3 corner[3], const double b[2])
{
  return v3_mad(corner[1], b[0], v3_mad(corner[2], b[1], v3_scale(corner[0], 1 - b[0] - b[1])));
}

/* Radiance that a place of a triangle sends back along the `direction` of a ray. */
static vec3 radiance_at(const bent_scene *scene, int instance, int triangle, const double b[2], vec3 position,
                        double length, vec3 direction, const ray_history *ray)
{
  bent_hit hit = {.instance = instance, .triangle = triangle, .barycentric = {b[0], b[1]}};
  v3_to(hit.position, position);
  v3_to(hit.direction, direction);
  const struct instance *inst = &scene->geometry->instances[instance];
  const vec3 *even = shading_even_emission(scene->shading, geometry_material(scene->geometry, inst, triangle));
  if (even) return inst->one_sided && surface_is_backfacing(scene, &hit) ? v3(0, 0, 0) : *even;
  surface surface;
  surface_at(scene, &hit, length, &surface);
  if (surface.see_through) return v3(0, 0, 0);
  surface.point.ray = *ray;
  return shading_emission(scene->shading, surface.material, &surface.point);
}

static double brightness(vec3 radiance)
{
  const double value = v3_average(radiance);
  return value > 0 && isfinite(value) ? value : 0;
}

/* The brightest that a triangle is to the side of `normal` in any of the directions of a cube around the axes of its
 * instance, among which is the beam of a lamp. */
static double beam_brightness(const bent_scene *scene, int instance, int triangle, vec3 at, vec3 normal, double distance)
{
  double most = 0;
  for (int i = 0; i < 27; i++) {
    const vec3 own = v3(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
    const vec3 out = v3_normalize(mat4_vector(&scene->geometry->instances[instance].world_from_mesh, own));
    if (i == 13 || !(v3_dot(out, normal) > 0)) continue;
    most = max2(most, brightness(radiance_at(scene, instance, triangle, PROBES[0], at, distance, v3_scale(out, -1), &RAY_SCATTERED)));
  }
  return most;
}

/* Adds a triangle if it shines to who stands `distance` away; returns 0 only when out of memory. */
static int add_triangle(lights *l, const bent_scene *scene, int instance, int triangle, double distance)
{
  vec3 corner[3];
  const vec3 area = triangle_area(scene->geometry, instance, triangle, corner);
  const double size = v3_length(area);
  if (!(size > 0)) return 1;
  const vec3 normal = v3_scale(area, 1 / size);
  const ray_history *any = &RAY_SCATTERED;
  double front = 0, back = 0;
  for (int i = 0; i < 4; i++) {
    const vec3 at = triangle_at(corner, PROBES[i]);
    front += brightness(radiance_at(scene, instance, triangle, PROBES[i], at, distance, v3_scale(normal, -1), any)) / 4;
    back += brightness(radiance_at(scene, instance, triangle, PROBES[i], at, distance, normal, any)) / 4;
  }
  if (!(front + back > 0) || scene->geometry->instances[instance].visibility & BENT_IMMATERIAL) {
    const vec3 at = triangle_at(corner, PROBES[0]);
    front = max2(front, beam_brightness(scene, instance, triangle, at, normal, distance));
    back = max2(back, beam_brightness(scene, instance, triangle, at, v3_scale(normal, -1), distance));
    if (!(front + back > 0)) return 1;
  }
  light_cluster c = {.low = corner[0], .high = corner[0], .middle = triangle_at(corner, PROBES[0]),
                     .power = max2(front, back) * size,
                     .axis = front > 0 ? normal : v3_scale(normal, -1), .cos_normals = front > 0 && back > 0 ? -1 : 1};
  for (int i = 1; i < 3; i++) {
    c.low = v3(min2(c.low.x, corner[i].x), min2(c.low.y, corner[i].y), min2(c.low.z, corner[i].z));
    c.high = v3(max2(c.high.x, corner[i].x), max2(c.high.y, corner[i].y), max2(c.high.z, corner[i].z));
  }
  const vec3 diagonal = v3_sub(c.high, c.low);
  c.size2 = v3_dot(diagonal, diagonal) / 4;
  l->of_triangle[instance][triangle] = (int32_t)l->count;
  return push(l, (emitter){instance, triangle, {corner[0], corner[1], corner[2]}}, &c);
}

/* From where the light of an instance is judged, as its material may depend on it: well outside of it. */
static double probe_distance(const geometry *g, int index)
{
  const vec3 first = geometry_vertex(g, index, 0, 0);
  double reach = 0;
  for (size_t t = 0; t < g->meshes[g->instances[index].mesh].triangle_count; t++)
    for (int c = 0; c < 3; c++) reach = max2(reach, v3_length(v3_sub(geometry_vertex(g, index, (int)t, c), first)));
  return 2 * reach + 1;
}

static int add_instance(lights *l, const bent_scene *scene, int index)
{
  const geometry *g = scene->geometry;
  const instance *i = &g->instances[index];
  const size_t triangles = g->meshes[i->mesh].triangle_count;
  int shines = 0;
  for (size_t m = 0; m < i->material_count; m++) shines |= shading_may_emit(scene->shading, i->materials[m]);
  if (!shines || !(i->visibility & BENT_VISIBLE_ALL & ~BENT_VISIBLE_CAMERA)) return 1;
  l->of_triangle[index] = malloc(triangles * sizeof **l->of_triangle);
  if (!l->of_triangle[index]) return 0;
  const double distance = triangles ? probe_distance(g, index) : 0;
  for (size_t t = 0; t < triangles; t++) {
    l->of_triangle[index][t] = -1;
    if (shading_may_emit(scene->shading, geometry_material(g, i, (int)t)) && !add_triangle(l, scene, index, (int)t, distance))
      return 0;
  }
  return 1;
}

/* A lamp's mean intensity, from the corners of a cube and the middles of its faces, which a narrow beam may miss. */
static int add_lamp(lights *l, const bent_scene *scene, int index)
{
  const lamp *lamp = &scene->lamps->list[index];
  double sum = 0;
  for (int i = 0; i < 27; i++) {
    const vec3 own = v3(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
    const vec3 direction = v3_normalize(mat4_vector(&lamp->world_from_lamp, own));
    if (i != 13) sum += brightness(lamp_intensity(scene, lamp, direction, 1, &RAY_SCATTERED));
  }
  const light_cluster c = {.low = lamp->position, .high = lamp->position, .middle = lamp->position,
                           .power = sum / 26 + 1e-30, .around = 1};
  return push(l, (emitter){.instance = -1, .index = index}, &c);
}

/* The mean over the disk of a sun. */
static double sun_brightness(const bent_scene *scene, const sun *s)
{
  if (s->material < 0 || s->solid_angle == 0) return brightness(sun_radiance(scene, s, s->disk.axis, &RAY_SCATTERED));
  double sum = 0;
  for (int i = 0; i < SUN_PROBES; i++)
    for (int j = 0; j < SUN_PROBES; j++) {
      const vec3 at = cap_draw(&s->disk, (i + 0.5) / SUN_PROBES, (j + 0.5) / SUN_PROBES);
      sum += brightness(sun_radiance(scene, s, at, &RAY_SCATTERED));
    }
  return sum / (SUN_PROBES * SUN_PROBES);
}

static int add_suns(lights *l, const bent_scene *scene)
{
  const suns *suns = scene->suns;
  if (!suns || !suns->count) return 1;
  l->sun_weight = malloc(suns->count * sizeof *l->sun_weight);
  if (!l->sun_weight) return 0;
  for (size_t i = 0; i < suns->count; i++) {
    const sun *s = &suns->list[i];
    l->sun_weight[i] = sun_brightness(scene, s) * (s->solid_angle > 0 ? s->solid_angle : 1);
    l->suns_weight += l->sun_weight[i];
  }
  return 1;
}

/* Whether all that an emitter lights is found from its own side too: it shines on everything, and what holds its light up
 * holds rays up. */
static int shines_evenly(uint32_t visibility, const bent_influence *influence)
{
  const uint32_t scattering = BENT_VISIBLE_DIFFUSE | BENT_VISIBLE_GLOSSY | BENT_VISIBLE_TRANSMISSION;
  return (visibility & scattering) == scattering && influence->blockers == UINT64_MAX &&
         influence->receivers == UINT64_MAX;
}

/* The running sum of the emitters' fluxes, and the sides that shine. */
static int add_flux(lights *l, const bent_scene *scene)
{
  l->flux = malloc((l->count + 1) * sizeof *l->flux);
  l->sides = malloc(l->count + 1);
  if (!l->flux || !l->sides) return 0;
  double sum = 0;
  for (size_t i = 0; i < l->count; i++) {
    const emitter *e = &l->emitters[i];
    const light_cluster *c = &l->clusters[i];
    const int both = c->cos_normals < 0;
    int even;
    l->sides[i] = SIDE_FRONT;
    if (e->instance >= 0) {
      const instance *inst = &scene->geometry->instances[e->instance];
      vec3 corner[3];
      const int front = v3_dot(triangle_area(scene->geometry, e->instance, e->index, corner), c->axis) > 0;
      l->sides[i] = both ? SIDE_FRONT | SIDE_BACK : front ? SIDE_FRONT : SIDE_BACK;
      even = shines_evenly(inst->visibility, &inst->influence);
    } else {
      const lamp *lamp = &scene->lamps->list[e->index];
      even = shines_evenly(lamp->visibility, &lamp->influence);
    }
    if (even) sum += c->power * (e->instance < 0 ? 4 : both ? 2 : 1);
    l->flux[i] = sum;
  }
  return isfinite(sum);
}

static int is_bent(const geometry *g)
{
  for (size_t i = 0; i < g->lens_count; i++)
    if (!g->lenses[i].flat) return 1;
  return 0;
}

bent_status lights_new(const bent_scene *scene, lights **out, bent_error *error)
{
  const geometry *g = scene->geometry;
  lights *l = calloc(1, sizeof *l);
  if (l) l->of_triangle = calloc(g->instance_count + 1, sizeof *l->of_triangle);
  int ok = l && l->of_triangle;
  if (ok) l->instance_count = g->instance_count, l->even = is_bent(g) ? BENT_EVEN : 0;
  for (size_t i = 0; ok && i < g->instance_count; i++) ok = add_instance(l, scene, (int)i);
  if (ok) l->first_lamp = l->count;
  for (size_t i = 0; ok && scene->lamps && i < scene->lamps->count; i++) ok = add_lamp(l, scene, (int)i);
  if (ok) ok = add_flux(l, scene) && add_suns(l, scene);
  bent_status status = ok ? BENT_OK : bent_fail(error, BENT_ERROR_MEMORY, "lights: out of memory");
  if (!status && l->count) status = light_tree_new(l->clusters, l->count, is_bent(g), &l->tree, error);
  const int keeps_sky = scene->lights && scene->sky_valid;
  if (!status && !keeps_sky) status = sky_map_new(scene->shading, &l->sky, error);
  if (status) {
    lights_free(l);
    return status;
  }
  if (keeps_sky) l->sky = scene->lights->sky, scene->lights->sky = NULL;
  if (lights_any_start(l)) l->casters = casters_find(scene);
  l->sky_weight = l->sky ? M_PI * sky_map_mean(l->sky) : 0;
  free(l->clusters);
  l->clusters = NULL;
  *out = l;
  return BENT_OK;
}

void lights_free(lights *l)
{
  if (!l) return;
  for (size_t i = 0; l->of_triangle && i < l->instance_count; i++) free(l->of_triangle[i]);
  free(l->of_triangle);
  free(l->emitters);
  free(l->clusters);
  free(l->flux);
  free(l->sides);
  free(l->sun_weight);
  light_tree_free(l->tree);
  sky_map_free(l->sky);
  free(l);
}

int lights_any(const lights *l) { return l->tree || l->suns_weight > 0 || l->sky; }

/* How often each group of lights is drawn for a point. */
typedef struct shares {
  double tree, suns, sky;
} shares;

static shares shares_at(const lights *l, vec3 point, vec3 normal)
{
  if (l->tree && !(l->suns_weight > 0) && !l->sky) return (shares){1, 0, 0};
  const double tree = l->tree ? light_tree_weight(l->tree, point, normal) : 0;
  const double total = tree + l->suns_weight + l->sky_weight, least = GROUP_SHARE_MIN * total;
  const shares raised = {tree > 0 ? max2(tree, least) : 0, l->suns_weight > 0 ? max2(l->suns_weight, least) : 0,
                         l->sky ? max2(l->sky_weight, least) : 0};
  const double sum = raised.tree + raised.suns + raised.sky;
  if (!(sum > 0 && isfinite(sum))) return (shares){0, 0, 0};
  return (shares){raised.tree / sum, raised.suns / sum, raised.sky / sum};
}

static void place_on_triangle(const lights *l, const bent_scene *scene, const emitter *e, vec3 point, vec3 normal, double u,
                              double v, light_sample *out)
{
  const triangle_view view = triangle_viewed(e->corner, point, l->even);
  *out = (light_sample){.kind = LIGHT_TRIANGLE, .index = e->instance, .triangle = e->index};
  triangle_draw(&view, normal, u, v, out->barycentric, &out->facing);
  out->target = triangle_at(e->corner, out->barycentric);
  out->area = join_local_area(scene->geometry, out->target, view.area);
  out->probability = triangle_density(&view, out->target);
}

static int draw_emitter(const lights *l, const bent_scene *scene, vec3 point, vec3 normal, double pick, double u, double v,
                        light_sample *out)
{
  double probability;
  const int chosen = light_tree_draw(l->tree, point, normal, &pick, &probability);
  if (chosen < 0) return 0;
  const emitter *e = &l->emitters[chosen];
  if (e->instance >= 0) place_on_triangle(l, scene, e, point, normal, u, v, out);
  else *out = (light_sample){.kind = LIGHT_LAMP, .index = e->index, .target = scene->lamps->list[e->index].position,
                             .probability = 1, .facing = 1};
  out->probability *= probability;
  return 1;
}

static void draw_sun(const lights *l, const bent_scene *scene, double pick, double u, double v, light_sample *out)
{
  size_t i = 0;
  double rest = pick * l->suns_weight;
  while (i + 1 < scene->suns->count && rest >= l->sun_weight[i]) rest -= l->sun_weight[i++];
  *out = (light_sample){.kind = LIGHT_SUN, .index = (int)i, .target = cap_draw(&scene->suns->list[i].disk, u, v),
                        .probability = l->sun_weight[i] / l->suns_weight, .facing = 1};
}

int lights_draw(const lights *l, const bent_scene *scene, vec3 point, vec3 normal, const double u[4], light_sample *out)
{
  const shares share = shares_at(l, point, normal);
  double pick = u[2], group = share.tree;
  if (pick < share.tree) {
    if (!draw_emitter(l, scene, point, normal, min2(pick / share.tree, 1 - 1e-9), u[0], u[1], out)) return 0;
  } else if ((pick -= share.tree) < share.suns) {
    group = share.suns;
    draw_sun(l, scene, min2(pick / share.suns, 1 - 1e-9), u[0], u[1], out);
  } else if (share.sky > 0) {
    group = share.sky;
    *out = (light_sample){.kind = LIGHT_SKY, .facing = 1};
    out->probability = sky_map_draw(l->sky, u[0], u[1], &out->target);
  } else {
    return 0;
  }
  out->probability *= group;
  return out->probability > 0;
}

vec3 lights_radiance(const bent_scene *scene, const light_sample *s, double length, vec3 arrival, const ray_history *ray)
{
  return radiance_at(scene, s->index, s->triangle, s->barycentric, s->target, length, arrival, ray);
}

vec3 lights_triangle_area(const bent_scene *scene, int instance, int triangle, vec3 position)
{
  vec3 corner[3];
  return join_local_area(scene->geometry, position, triangle_area(scene->geometry, instance, triangle, corner));
}

int lights_draw_triangle(const lights *l, int instance, int triangle)
{
  return l->of_triangle[instance] && l->of_triangle[instance][triangle] >= 0;
}

int lights_draw_sky(const lights *l) { return l->suns_weight > 0 || l->sky; }

double lights_triangle_probability(const lights *l, int instance, int triangle, vec3 place, vec3 point,
                                   vec3 normal)
{
  if (!lights_draw_triangle(l, instance, triangle)) return 0;
  const int emitter = l->of_triangle[instance][triangle];
  const double chosen = light_tree_probability(l->tree, emitter, point, normal);
  const triangle_view view = triangle_viewed(l->emitters[emitter].corner, point, l->even);
  return shares_at(l, point, normal).tree * chosen * triangle_density(&view, place);
}

double lights_sun_probability(const lights *l, size_t sun, vec3 point, vec3 normal)
{
  return l->suns_weight > 0 ? shares_at(l, point, normal).suns * l->sun_weight[sun] / l->suns_weight : 0;
}

double lights_sky_pdf(const lights *l, vec3 direction, vec3 point, vec3 normal)
{
  return l->sky ? shares_at(l, point, normal).sky * sky_map_pdf(l->sky, direction) : 0;
}

/* The emitter that a sample or a triangle is of; -1: none. */
static int emitter_of(const lights *l, light_kind kind, int index, int triangle)
{
  if (kind == LIGHT_TRIANGLE) return lights_draw_triangle(l, index, triangle) ? l->of_triangle[index][triangle] : -1;
  return kind == LIGHT_LAMP ? (int)l->first_lamp + index : -1;
}

double lights_place_probability(const lights *l, const light_sample *place, vec3 point, vec3 normal)
{
  if (place->kind == LIGHT_TRIANGLE)
    return lights_triangle_probability(l, place->index, place->triangle, place->target, point, normal);
  const int lamp = emitter_of(l, place->kind, place->index, place->triangle);
  return lamp < 0 ? 0 : shares_at(l, point, normal).tree * light_tree_probability(l->tree, lamp, point, normal);
}

/* ---- Where light subpaths start ---- */

int lights_any_start(const lights *l) { return l->count > 0 && l->flux[l->count - 1] > 0; }

static double start_chance(const lights *l, size_t emitter)
{
  if (!lights_any_start(l)) return 0;
  return (l->flux[emitter] - (emitter ? l->flux[emitter - 1] : 0)) / l->flux[l->count - 1];
}

/* The emitter whose part of the running sum holds `wanted`. */
static size_t emitter_at(const lights *l, double wanted)
{
  size_t low = 0, high = l->count - 1;
  while (low < high) {
    const size_t middle = (low + high) / 2;
    if (l->flux[middle] > wanted) high = middle;
    else low = middle + 1;
  }
  return low;
}

double lights_draw_start(const lights *l, const bent_scene *scene, const double u[3], light_sample *out)
{
  const emitter *e = &l->emitters[emitter_at(l, u[0] * l->flux[l->count - 1])];
  if (e->instance < 0) {
    *out = (light_sample){.kind = LIGHT_LAMP, .index = e->index, .target = scene->lamps->list[e->index].position};
  } else {
    vec3 corner[3];
    const vec3 area = triangle_area(scene->geometry, e->instance, e->index, corner);
    const double root = sqrt(u[1]); /* even over the area (Turk 1990) */
    *out = (light_sample){.kind = LIGHT_TRIANGLE, .index = e->instance, .triangle = e->index,
                          .barycentric = {root * (1 - u[2]), root * u[2]}};
    out->target = triangle_at(corner, out->barycentric);
    out->area = join_local_area(scene->geometry, out->target, area);
  }
  return start_chance(l, (size_t)(e - l->emitters));
}

double lights_start_chance(const lights *l, light_kind kind, int index, int triangle)
{
  const int emitter = emitter_of(l, kind, index, triangle);
  return emitter < 0 ? 0 : start_chance(l, (size_t)emitter);
}

/* The normal of what shines on one side; 0 if both sides do, or all around. */
static vec3 shining_normal(const lights *l, const light_sample *from)
{
  const int emitter = emitter_of(l, from->kind, from->index, from->triangle);
  if (from->kind == LIGHT_LAMP || emitter < 0 || l->sides[emitter] == (SIDE_FRONT | SIDE_BACK)) return v3(0, 0, 0);
  return v3_scale(v3_normalize(from->area), l->sides[emitter] == SIDE_BACK ? -1 : 1);
}

/* By the cosine to the normal, to both sides if `normal` is 0. */
static vec3 draw_by_cosine(const light_sample *from, vec3 normal, const double u[2])
{
  const int both = v3_dot(normal, normal) == 0, back = both && u[0] >= 0.5;
  const double turn = 2 * M_PI * u[1], part = both ? 2 * u[0] - back : u[0], r = sqrt(part);
  const vec3 z = both ? v3_scale(v3_normalize(from->area), back ? -1 : 1) : normal;
  vec3 x, y;
  v3_basis(z, &x, &y);
  return v3_mad(x, r * cos(turn), v3_mad(y, r * sin(turn), v3_scale(z, sqrt(max2(1 - part, 0)))));
}

vec3 lights_draw_direction(const lights *l, const light_sample *from, const double u[3])
{
  const vec3 normal = shining_normal(l, from);
  const caster_mix mix = casters_seen(&l->casters, from->target, normal);
  if (u[2] < mix.chance) return caster_draw(&mix, u[2] / mix.chance, u);
  if (from->kind != LIGHT_LAMP) return draw_by_cosine(from, normal, u);
  const double turn = 2 * M_PI * u[1], z = 1 - 2 * u[0], r = sqrt(max2(1 - z * z, 0));
  return v3(r * cos(turn), r * sin(turn), z);
}

double lights_direction_pdf(const lights *l, const light_sample *from, vec3 direction)
{
  if (from->kind != LIGHT_LAMP && !lights_draw_triangle(l, from->index, from->triangle)) return 0;
  const vec3 normal = shining_normal(l, from);
  const caster_mix mix = casters_seen(&l->casters, from->target, normal);
  double base = 1 / (4 * M_PI);
  if (from->kind != LIGHT_LAMP) {
    const int both = v3_dot(normal, normal) == 0;
    base = both ? fabs(v3_dot(v3_normalize(from->area), direction)) / (2 * M_PI)
                : max2(v3_dot(normal, direction), 0) / M_PI;
  }
  return mix.chance * caster_pdf(&mix, direction) + (1 - mix.chance) * base;
}

uint32_t lights_start_bounces(const bent_scene *scene, const light_sample *from)
{
  return from->kind == LIGHT_LAMP ? scene->lamps->list[from->index].influence.max_bounces
                                  : scene->geometry->instances[from->index].influence.max_bounces;
}
