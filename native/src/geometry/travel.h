/* Rays on their way through a scene, leg by leg: straight in flat space, curved inside the sphere of a lens. */
#ifndef BENT_GEOMETRY_TRAVEL_H
#define BENT_GEOMETRY_TRAVEL_H
#include "base/isa.h"
#include "geometry/geometry.h"

enum { TRAVELERS_MAX = 256 }; /* side by side */
enum { LEG_FLAT = -1, LEG_OVER = -2, LEG_AWAY = -3 };
/* Where in its lens a traveler is: anywhere, on the sphere on its way in, or on the throat on its way out. */
enum { AT_ANY, AT_SPHERE, AT_THROAT };

typedef struct traveler {
  vec3 position, direction; /* world; the direction is local and unit */
  int leg;                  /* the lens that it is in, LEG_FLAT, LEG_OVER: its bent_hit is complete, or LEG_AWAY: it can
                             * meet nothing any more on its way to infinity in the lens `left` */
  int at;                   /* AT_ANY, AT_SPHERE or AT_THROAT; of no meaning in flat space */
  int left;                 /* the lens that it came out of to get here, or -1 */
  int leaving;              /* still on its source triangle */
  int legs;                 /* so far */
} traveler;

/* Through the throat of a mouth that has an exit, from the traveler's position on it: the same point and tangential
 * direction, outward again, mirrored (the mouths' axes are joined by diag(1, -1, 1)). `direction`: local, in the axes of the
 * mouth's spacetime. */
static inline void traveler_pass_throat(traveler *t, const geometry *g, const lens *mouth, vec3 direction)
{
  const lens *exit = &g->lenses[mouth->exit];
  vec3 x = v3_normalize(mat4_point(&mouth->spacetime_from_world, t->position)), d = direction;
  if (v3_dot(d, x) < 0) d = v3_mad(x, -2 * v3_dot(d, x), d); /* else rounding has put the end beyond already */
  d.y = -d.y;
  x.y = -x.y;
  x = v3_scale(x, 0.5 * exit->spacetime.throat_radius);
  t->position = mat4_point(&exit->world_from_spacetime, x);
  t->direction = v3_normalize(mat4_vector(&exit->world_from_spacetime, d));
  t->leg = mouth->exit;
  t->at = AT_THROAT;
}

/* Takes the travelers index[0 .. n), all in the given lens, to the end of their leg: a hit, the horizon, infinity, the
 * edge of the lens, the throat, or where nothing can be met any more. Adds length, swept and error to their hits. */
BENT_DECLARE_KERNEL(void, bent_travel_curved,
                    (const geometry *g, int lens_index, size_t n, const uint32_t *index, const bent_ray *rays,
                     traveler *travelers, bent_hit *hits))
#endif
