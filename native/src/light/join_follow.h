/* From a joint that is known to one that is not: where connections around a spinning hole fail, its neighbors' are followed. */
#ifndef BENT_LIGHT_JOIN_FOLLOW_H
#define BENT_LIGHT_JOIN_FOLLOW_H
#include "light/join.h"

/* Turns *j, a joint from `from` with some direction of the sky by way of a lens that is all of space, into one with the
 * unit direction `to`, by Newton's method on traced rays. Its launch, spread and swept angle become those of that ray, its
 * miss is below 1e-8 radians. Returns 0, and leaves *j alone, if the method does not come there. */
int join_follow(const geometry *g, vec3 from, vec3 to, joint *j);
#endif
