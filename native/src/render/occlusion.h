/* Ambient occlusion of what the camera sees, as a pass: how much of the hemisphere above a surface is free. */
#ifndef BENT_RENDER_OCCLUSION_H
#define BENT_RENDER_OCCLUSION_H
#include "render/direct.h"

/* Adds a ray in a direction drawn by its cosine to the block's shadows; it sees occlusion_distance far along its curve. */
void occlusion_add(const tracer *t, path_block *block, const path *p, const bent_hit *hit, const shade_point *point,
                   const closure_set *set);
#endif
