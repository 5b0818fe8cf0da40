/* Joints by way of one lens of finite radius, on one side of it or through a throat. Files of this folder only. */
#ifndef BENT_LIGHT_JOIN_LENS_H
#define BENT_LIGHT_JOIN_LENS_H
#include "light/join.h"

enum { JOIN_BLOCK = 128, JOIN_IMAGES = 4 };

/* Adds a joint, whose spread and cone weigh it unless something else is given. If there are too many, one of the two
 * faintest goes by chance, and the other stands for both. */
void joints_add(joints *joints, const joint *j);
/* Whether a straight line from `from`, of `length` along the unit direction, stays outside all spheres but that of the
 * lens `except` (or -1). */
int join_is_clear(const geometry *g, vec3 from, vec3 direction, double length, int except);
/* Where rays go by: outside the horizon; in a wormhole this side of the throat. `at`: in the chart. */
int join_is_place(const lens *l, const double at[3]);
/* Whether the lens is of finite radius and has joints: all rays that go down inside the sphere and turn back leave it. */
int join_is_wide(const lens *l);
/* The chance with which image number `order` by way of a lens is listed, if the second one's is `second`. */
double join_chance(double second, int order);
/* How many images of a pair are to be listed by the even number *u, which is then an even number again; all if u is NULL. */
size_t join_images_wanted(double second, double *u);
/* The chance with which the second image is listed: about its share of the light. Ends in the chart. */
double join_second_chance(const lens *l, vec3 a, vec3 b, int sky);
/* Whether a way is tried that has a chance: 1 if `chances` is NULL, or *u decides, which is then an even number again. */
static inline int join_tries(const double *chances, size_t way, double *u, double *chance)
{
  *chance = chances ? chances[way] : 1;
  if (!(*chance < 1)) return 1;
  const int tried = *u < *chance;
  *u = tried ? *u / *chance : (*u - *chance) / (1 - *chance);
  return tried;
}
/* Joints of n <= JOIN_BLOCK pairs by way of the lens `index`; arguments as in join_points and join_sky. u: as in
 * join_images_wanted; chances as in join_by_chance, or NULL. The ends may stand inside its sphere, or that of its exit, or in flat space. Both inside the same
 * sphere: not here. */
void join_by_lens(const geometry *g, int index, size_t n, const vec3 *from, const vec3 *to, double *u,
                  const double *const *chances, int sky, int far, joints *out);
#endif
