/* Chooses one of many emitters for a shaded point, each about as often as its light weighs there.
 *
 * A binary tree over boxes, powers and cones of directions (Conty Estevez & Kulla, "Importance Sampling of Many Lights with
 * Adaptive Tree Splitting", HPG 2018). It reckons in flat space: where rays are bent that is a guess, so an emitter that
 * seems to look away keeps a part of its weight there. */
#ifndef BENT_LIGHT_LIGHT_TREE_H
#define BENT_LIGHT_LIGHT_TREE_H
#include <stddef.h>

#include "base/vec3.h"
#include "bentlight/error.h"

/* What the tree knows of one emitter. It shines into directions within `reach` (cosine, sine) of its normal, with the
 * cosine to the normal as far as a quarter turn; `around`: with even strength to all sides. */
typedef struct light_cluster {
  vec3 low, high;         /* box around it, world */
  vec3 middle;            /* of its light */
  double size2;           /* squared distance from the box's center to its corners; of many, the mean by power */
  double power;           /* mean radiance times area; of a point: radiant intensity */
  int around;
  vec3 axis;              /* of the cone of normals */
  double cos_normals, sin_normals; /* half the cone's opening: at most pi */
} light_cluster;

typedef struct light_tree light_tree;

/* From `count` >= 1 emitters of positive power. bent: rays may be curved. */
bent_status light_tree_new(const light_cluster *emitters, size_t count, int bent, light_tree **out, bent_error *error);
void light_tree_free(light_tree *tree);
/* What all emitters together weigh at a point: about their irradiance, rather too much. normal: of the surface there, which light from
 * behind does not reach; 0: light may come from all sides. */
double light_tree_weight(const light_tree *tree, vec3 point, vec3 normal);
/* Draws an emitter by *u in [0, 1), and makes *u uniform again. -1 if none can reach the point. */
int light_tree_draw(const light_tree *tree, vec3 point, vec3 normal, double *u, double *probability);
/* The probability that light_tree_draw has of choosing `emitter`. */
double light_tree_probability(const light_tree *tree, int emitter, vec3 point, vec3 normal);
#endif
