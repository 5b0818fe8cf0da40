/* What a path's ray brings by itself: what a surface emits, and the sky; weighed against connections with them. */
#ifndef BENT_RENDER_GATHER_H
#define BENT_RENDER_GATHER_H
#include "render/direct.h"
#include "render/footprint.h"

/* Where a path has arrived: how connections would have done so, the chain there, and the place. */
typedef struct arrival {
  const reach *reach;
  chain chain;
  const bent_hit *hit;
} arrival;

/* The ray escaped: sky and suns. */
void gather_sky(const tracer *t, path *p, const bent_ray *ray, const bent_hit *hit, const footprint *footprint,
                const reach *reach, sample_record *record);
/* It met something that emits light. */
void gather_emission(const tracer *t, path *p, const arrival *at, vec3 emission, sample_record *record);
#endif
