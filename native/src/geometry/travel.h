/* Rays on their way through a scene, leg by leg: straight in flat space, curved inside the sphere of a lens. */
#ifndef BENT_GEOMETRY_TRAVEL_H
#define BENT_GEOMETRY_TRAVEL_H
#include "base/isa.h"
#include "geometry/geometry.h"

enum { LEG_FLAT = -1, LEG_OVER = -2, LEG_AWAY = -3 };

typedef struct traveler {
  vec3 position, direction; /* world; the direction is local and unit */
  int leg;                  /* the lens that it is in, LEG_FLAT, LEG_OVER: its bent_hit is complete, or LEG_AWAY: it can
                             * meet nothing any more on its way to infinity in the lens `left` */
  int left;                 /* the lens that it came out of to get here, or -1 */
  int leaving;              /* still on its source triangle */
  int legs;                 /* so far */
} traveler;

/* Takes the travelers index[0 .. n), all in the given lens, to the end of their leg: a hit, the horizon, infinity, the
 * edge of the lens, the throat, or where nothing can be met any more. Adds length, swept and error to their hits. */
BENT_DECLARE_KERNEL(void, bent_travel_curved,
                    (const geometry *g, int lens_index, size_t n, const uint32_t *index, const bent_ray *rays,
                     traveler *travelers, bent_hit *hits))
#endif
