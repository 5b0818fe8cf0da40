/* The channel `vector`: how far in the picture what a pixel shows has moved since the frame before, and will move until the
 * next, in pixels, as Cycles has it: the place before less the present one, and the present one less the place after.
 *
 * Through a lens things move otherwise than without: of the same place on a surface, or of the same direction of the sky, the
 * image is looked for in all three moments, each with its own camera and its own bent space: among all that are known
 * (light/join.h), or by following the ray (light/join_follow.h). Of several images of the present the one is taken that the
 * path's own ray is, and in the other moments that next to it. A sample tells nothing, and hardly
 * counts, where one of them is not known: the ray's own kind of image is not listed, or there is none in the other moment. */
#ifndef BENT_RENDER_MOTION_VECTOR_H
#define BENT_RENDER_MOTION_VECTOR_H
#include "light/surface.h"
#include "render/path.h"

/* What is seen by the camera's ray of a path. */
typedef struct motion_seen {
  enum { SEEN_NOTHING, SEEN_SURFACE, SEEN_SKY, SEEN_FAR_SKY, SEEN_KINDS } kind;
  vec3 launch;     /* of the ray */
  double image[2]; /* the place in the picture through which it goes */
  double swept;    /* about spacetime objects until there, radians */
  vec3 place;      /* on a surface, or the direction in the sky */
  vec3 other[2];   /* in the moments before and after */
} motion_seen;

/* The path has begun, and is to say what it sees. */
void motion_begin(motion_seen *seen, path *p);
/* Whether the sample of a pixel is one of those that tell its vector: each takes longer than many others of its channels. */
int motion_is_asked(const tracer *t, uint32_t sample);
void motion_see_surface(const tracer *t, motion_seen *seen, const surface *surface, double swept);
/* direction: asymptotic; far: of a sky beyond a wormhole. */
void motion_see_sky(motion_seen *seen, vec3 direction, int far, double swept);
/* Writes the vectors of `count` samples to their records. */
void motion_write(const tracer *t, size_t count, const motion_seen *seen, sample_record *records);
#endif
