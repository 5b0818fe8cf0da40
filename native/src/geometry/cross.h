/* Rays cross the finite sphere of a lens at once, by table (bentlight/sphere.h), while it is clear: nothing that rays can meet
 * reaches into it. Schwarzschild and Ellis; what a table does not answer within a ray's tolerances is left to be marched. */
#ifndef BENT_GEOMETRY_CROSS_H
#define BENT_GEOMETRY_CROSS_H
#include "geometry/travel.h"

/* Finds out which spheres are clear where that is unknown, and builds the tables that are missing. */
bent_status cross_commit(geometry *g, bent_error *error);
/* Takes those of the travelers index[0 .. n), n <= TRAVELERS_MAX, all in the given lens, that can across it. Returns how many
 * are left to march, moved to the front of `index`. */
size_t cross(const geometry *g, int lens_index, size_t n, uint32_t *index, const bent_ray *rays, traveler *travelers,
             bent_hit *hits);
#endif
