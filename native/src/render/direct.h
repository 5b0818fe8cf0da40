/* Direct light: at each vertex of a path one light is drawn and joined with the vertex by every ray that is known to lead
 * there; each such ray is weighed against the chance that scattering had found it (multiple importance sampling), and its
 * shadow is traced. The other half, what a scattered ray weighs when it meets a light, is here too. */
#ifndef BENT_RENDER_DIRECT_H
#define BENT_RENDER_DIRECT_H
#include "light/join.h"
#include "light/lights.h"
#include "light/surface.h"
#include "render/path.h"
#include "render/portal.h"

/* Paths that are shaded side by side; and the most shadows that one vertex asks for: this, the far side's sky, and a
 * vertex of a light subpath. */
enum { DIRECT_BATCH = 128, DIRECT_SHADOWS_MAX = 3 * JOINTS_MAX };

/* How the scattering before met what the path's ray has met now. */
typedef struct reach {
  int joined;    /* a connection with a light would have found the same ray */
  double spread; /* what that connection weighs by, times its chance of being made */
  vec3 cone;
} reach;

/* Looks up the connections that would have led each of `count` <= DIRECT_BATCH paths where their hits are. */
void direct_reach(const tracer *t, int count, const path *paths, const bent_hit *hits, reach *out);
/* The weights of emission, of sun number `sun` and of the sky that a path's ray has met by scattering; 1 where a
 * connection could not have found it. arrived: the chain there, if light subpaths are traced. `hit`: of fate BENT_HIT, or the asymptotic direction. */
double direct_weight_emission(const tracer *t, const path *p, const reach *reach, const chain *arrived,
                              const bent_hit *hit);
double direct_weight_sun(const tracer *t, const path *p, const reach *reach, size_t sun);
double direct_weight_sky(const tracer *t, const path *p, const reach *reach, vec3 direction);

/* A vertex that scatters; if its light is wanted, the path may have gone on from there already. */
typedef struct lit_vertex {
  surface surface; /* its point's ray: the one before scattering */
  closure_set set;
  portal_mix mix; /* how it draws directions */
  /* The rest is of vertices whose light is wanted. */
  path *path;
  const bent_hit *hit;
  vec3 beta; /* before scattering */
  chain chain; /* on arrival, if light subpaths are traced */
  uint32_t vertex; /* its number on the path */
  double chance; /* with which it is joined with a light at all */
  double u[4];
} lit_vertex;

/* The chance with which the vertex where a path is now is joined with a light: 1 unless that is slow. It is part of the
 * pdf of all its connections, on both sides of the weighing. */
double direct_chance(const tracer *t, const path *p);
/* Draws a light for each of `count` <= DIRECT_BATCH vertices and adds the rays towards it to the block's shadows. */
void direct_draw(const tracer *t, path_block *block, int count, const lit_vertex *vertices, bent_render_statistics *statistics);
/* Counts the rays that n connections have looked for. */
void direct_count_joins(bent_render_statistics *statistics, size_t n, const joints *found);
/* Adds a shadow from s->from to the block, which has room for it; the caller may limit its ray. `surface`: that it leaves,
 * or NULL. */
bent_ray *direct_add_shadow(const tracer *t, path_block *block, const shadow *s, uint32_t visibility, vec3 direction,
                            const bent_hit *surface);
/* Traces all shadows of the block and adds the light that arrives to the paths. */
bent_status direct_trace(const tracer *t, path_block *block, bent_render_statistics *statistics, bent_progress *progress,
                         bent_error *error);
/* What part of the light a surface lets straight through: of a ray of that history that came `length` far. room: for its
 * closures. */
vec3 direct_transmitted(const bent_scene *scene, const bent_hit *hit, double length, const ray_history *ray, closure *room);
/* The vector that stands for a surface's upper side in the choice of lights: 0 if light may also come through. */
vec3 direct_normal(const shade_point *point, const closure_set *set);
#endif
