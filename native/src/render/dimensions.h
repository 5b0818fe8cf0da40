/* The layout of a path's random numbers: what each of a set's four dimensions is for. The first two are the best spread
 * together, so they go to what has two dimensions itself. */
#ifndef BENT_RENDER_DIMENSIONS_H
#define BENT_RENDER_DIMENSIONS_H
#include <stdint.h>

/* The camera's ray. */
enum {
  CAMERA_X, CAMERA_Y,          /* place in the pixel filter */
  CAMERA_LENS_U, CAMERA_LENS_V /* and on the lens */
};

/* A vertex' scattering. */
enum {
  SCATTER_U, SCATTER_V, /* direction within a lobe, or towards a portal */
  SCATTER_LOBE,         /* a portal, or which lobe */
  SCATTER_SURVIVAL      /* Russian roulette */
};

/* A vertex' light. */
enum {
  LIGHT_U, LIGHT_V, /* place on the light */
  LIGHT_CHOICE,     /* lamps and surfaces, suns or sky; then which one */
  LIGHT_IMAGES      /* whether any at all; how many images, and which faint ones get a shadow ray */
};

/* One scattering of a walk below a surface. */
enum {
  WALK_CHANNEL, /* color that the length is drawn for */
  WALK_LENGTH,
  WALK_COSINE, WALK_ANGLE /* direction */
};
enum { SUBSURFACE_STEPS = 256 }; /* of one walk, at most */

/* The sets' numbers. Vertices count from 0, the first surface that the camera's ray meets; there are less than 2^15. */
static inline uint32_t dimensions_camera(void) { return 0; }
static inline uint32_t dimensions_scattering(uint32_t vertex) { return 1 + 2 * vertex; }
static inline uint32_t dimensions_light(uint32_t vertex) { return 2 + 2 * vertex; }
static inline uint32_t dimensions_walk(uint32_t vertex, uint32_t step)
{
  return (1u << 16) + SUBSURFACE_STEPS * vertex + step;
}
/* The choice of a vertex of the light subpath that a vertex is joined with. */
static inline uint32_t dimensions_connection(uint32_t vertex) { return (1u << 24) + vertex; }

/* A direction of ambient occlusion. */
static inline uint32_t dimensions_occlusion(uint32_t vertex) { return (1u << 25) + vertex; }

/* A light subpath, whose seed is another: where on a lamp and in which direction it starts; then at each of its vertices
 * scattering, as of camera paths, and joints. */
static inline uint32_t dimensions_start_place(void) { return 0; }
static inline uint32_t dimensions_start_direction(void) { return 1; }
static inline uint32_t dimensions_subpath(uint32_t vertex) { return 2 + 2 * vertex; }
static inline uint32_t dimensions_subpath_joints(uint32_t vertex) { return 3 + 2 * vertex; }
/* The place on the camera's lens that a vertex is joined with. */
static inline uint32_t dimensions_subpath_lens(uint32_t vertex) { return (1u << 24) + vertex; }
#endif
