/* Cellular noise: Worley, "A Cellular Texture Basis Function" (SIGGRAPH 1996), with Blender's hashes and features, in single
 * precision for the reason given in noise.h. */
#ifndef BENT_SCENE_VORONOI_H
#define BENT_SCENE_VORONOI_H
#include "scene/noise.h"

typedef enum voronoi_feature {
  VORONOI_F1,
  VORONOI_F2,
  VORONOI_SMOOTH_F1,
  VORONOI_DISTANCE_TO_EDGE,
  VORONOI_N_SPHERE_RADIUS
} voronoi_feature;
typedef enum voronoi_metric { METRIC_EUCLIDEAN, METRIC_MANHATTAN, METRIC_CHEBYCHEV, METRIC_MINKOWSKI } voronoi_metric;

typedef struct voronoi {
  voronoi_feature feature;
  voronoi_metric metric;
  int normalize;     /* distance and color to [0, 1] */
  int float_hash;    /* the cells' random numbers as before Blender 5.0 */
  float detail;      /* octaves beyond the first, in [0, 15] */
  float roughness;   /* of each octave's weight to that before, in [0, 1] */
  float lacunarity;
  float smoothness;  /* of SMOOTH_F1, in [0, 0.5] */
  float exponent;    /* of METRIC_MINKOWSKI */
  float randomness;  /* in [0, 1] */
} voronoi;

/* What a feature does not give is 0. */
typedef struct voronoi_result {
  float distance; /* or the radius */
  float color[3];
  noise_point position; /* of the point of the cell */
} voronoi_result;

voronoi_result voronoi_at(const voronoi *v, noise_point p);
#endif
