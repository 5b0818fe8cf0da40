/* Rays that can meet nothing any more go to infinity at once, without their path. Rays through a clear sphere with flat
 * space outside: cross.h. */
#ifndef BENT_GEOMETRY_JUMP_H
#define BENT_GEOMETRY_JUMP_H
#include "geometry/travel.h"

/* Builds the deflection table of a lens that is all of space and has one (Schwarzschild, Ellis), if it is not there yet. */
bent_status jump_commit(lens *l, bent_error *error);
/* Completes the hits of the travelers index[0 .. n), n <= TRAVELERS_MAX, which are LEG_AWAY in lens `left`: by the table where
 * its measured error is within the ray's angular tolerance, else by bent_trace_rays. */
void jump(const geometry *g, size_t n, const uint32_t *index, const bent_ray *rays, traveler *travelers,
          bent_hit *hits);
#endif
