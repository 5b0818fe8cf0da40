/* Bidirectional path tracing, the camera's side: the chain of a camera's path (chain.h), what it changes in the weights of
 * light that is met or drawn, and connections with the vertices of light subpaths (light_path.h).
 *
 * Only with the tracer's `bidirectional`. Suns, the sky, and lamps that do not shine on all objects have no light subpaths:
 * their weights are those of path tracing. */
#ifndef BENT_RENDER_BIDIRECTIONAL_H
#define BENT_RENDER_BIDIRECTIONAL_H
#include "render/direct.h"
#include "render/path.h"

/* A path leaves the camera in a world direction. */
chain bidirectional_start(const tracer *t, vec3 direction);
/* It has come to a surface. spread: of the arc, times its chance; 0 if no connection is known. */
chain bidirectional_arrive(const tracer *t, const path *p, const shade_point *point, double spread);
/* It has come to a place by a way that light subpaths do not take, from below a surface. */
chain bidirectional_begin(const tracer *t, vec3 position);
/* It goes on from there by an event. closures: room for a view. */
void bidirectional_leave(const tracer *t, chain *c, const bent_hit *hit, const shade_point *point,
                         const bsdf_sample *drawn, closure *closures);
/* The weight of emission that a path has met by scattering. */
double bidirectional_weight_emission(const tracer *t, const path *p, const chain *arrived, const bent_hit *hit);
/* For a connection of a vertex with a drawn place on a lamp, of the given chance: the sum of the squares of all other ways'
 * densities over its own, but for that of meeting the lamp by scattering. */
double bidirectional_rivals(const tracer *t, const path_block *block, const lit_vertex *v, const light_sample *s,
                            const joint *j);
/* Joins each of `count` <= DIRECT_BATCH vertices with one vertex of its sample's light subpath. */
void bidirectional_connect(const tracer *t, path_block *block, int count, const lit_vertex *vertices,
                           bent_render_statistics *statistics);
#endif
