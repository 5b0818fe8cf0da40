/* Hashes and gradient noise in 1 to 4 dimensions, bit for bit those of Blender where they are hashes.
 *
 * Everything is in single precision on purpose: many octaves of noise magnify a rounded coordinate until it shows, and so
 * a scene made for Cycles looks the same only with the same rounding.
 */
#ifndef BENT_SCENE_NOISE_H
#define BENT_SCENE_NOISE_H
#include <stdint.h>

enum { NOISE_DIMENSIONS_MAX = 4 };

/* `n` of the coordinates are used. */
typedef struct noise_point {
  int n;
  float x[NOISE_DIMENSIONS_MAX];
} noise_point;

/* A number in [0, 1] from the bits of 1 to 4 floats. */
float noise_hash_floats(const float *values, int n);
/* Three numbers in [0, 1], each from another hash of the point. */
void noise_hash_color(noise_point p, float color[3]);

/* Perlin's improved noise (Perlin, "Improving noise", SIGGRAPH 2002) with Blender's gradients and scales, about -1 to 1.
 * Repeats after 100000 units; 0 where a coordinate is not finite. */
float noise_perlin(noise_point p);

typedef enum fractal_type {
  FRACTAL_MULTIFRACTAL,
  FRACTAL_RIDGED_MULTIFRACTAL,
  FRACTAL_HYBRID_MULTIFRACTAL,
  FRACTAL_FBM,
  FRACTAL_HETERO_TERRAIN
} fractal_type;

/* Octaves of noise: Musgrave in Ebert et al., "Texturing and Modeling" (3rd ed. 2003), ch. 16. `detail` is the number of
 * octaves beyond the first, in [0, 15], a fraction of it being the weight of the last. */
typedef struct fractal {
  fractal_type type;
  float detail, roughness, lacunarity, offset, gain;
  int normalize; /* FBM only: to [0, 1] */
} fractal;
float noise_fractal(const fractal *f, noise_point p);

/* p + s, p * s */
noise_point noise_point_add(noise_point p, noise_point offset);
noise_point noise_point_scale(noise_point p, float scale);
/* A point far from the others for each seed: the same noise seen from there is another. */
noise_point noise_offset(int n, float seed);
#endif
