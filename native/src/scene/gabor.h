/* Gabor noise: sparse little waves in cells, as Blender has it. Single precision, and its hashes, for the reasons of noise.h.
 *
 * Lagae et al., "Procedural Noise using Sparse Gabor Convolution" (SIGGRAPH 2009), with waves that are complex: Tricard et
 * al., "Procedural Phasor Noise" (SIGGRAPH 2019).
 */
#ifndef BENT_SCENE_GABOR_H
#define BENT_SCENE_GABOR_H

typedef struct gabor {
  int dimensions; /* 2 or 3 */
  float frequency, isotropy; /* 0: all waves go along `orientation` */
  float angle;               /* in 2 dimensions */
  float orientation[3];      /* in 3, a unit vector */
} gabor;

/* value, phase and intensity, each about in [0, 1]. */
void gabor_noise(const gabor *g, const float place[3], float out[3]);
#endif
