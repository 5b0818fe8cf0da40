/* Light subpaths: one for each pixel sample, from a lamp through the scene, whose vertices are joined with the camera at
 * once, and kept for the vertices of the camera's path (bidirectional.h). Numbers are a function of (seed, pixel, sample),
 * so that a picture does not depend on tiles.
 *
 * A subpath carries radiant flux: at each event the light that the camera would see scattered (view.h), times the ratio
 * of the cosines to the triangle of the two directions (Veach 1997, 5.3: shading normals), and on each arc the square of
 * the ratio of frequencies (light/frequency.h). */
#ifndef BENT_RENDER_LIGHT_PATH_H
#define BENT_RENDER_LIGHT_PATH_H
#include "light/join.h"
#include "render/chain.h"
#include "render/path.h"
#include "render/view.h"

/* A place that a light subpath has come to. */
typedef struct light_vertex {
  bent_hit hit;
  vec3 flux;
  double cosine;       /* of the arrival to the triangle */
  chain chain;         /* of the first one: `once` but for the probability of drawing the lamp's place from here */
  light_sample start;  /* the place on the lamp */
  ray_history history; /* the scatterings before this one, but for the one next to the lamp */
  int first;           /* the one next to the lamp */
  int previous;        /* number of another vertex of the same subpath, or -1 */
} light_vertex;

typedef struct light_walk light_walk;

/* The subpaths of one batch of samples. */
typedef struct light_paths {
  light_vertex *list;
  size_t count, capacity;
  int *last, *length; /* of each sample's subpath: a vertex (or -1), from which `previous` goes on, and their number */
  light_walk *walks;  /* in flight */
  bent_ray *rays;
  bent_hit *hits;
  closure *closures; /* room for LIGHT_VIEWS views at once */
} light_paths;
enum { LIGHT_VIEWS = 3 };

/* For `capacity` samples at once of a scene with at most so many lobes at a place. NULL: out of memory. */
light_paths *light_paths_new(int capacity, int lobes);
void light_paths_free(light_paths *paths);
/* Traces the subpaths of `count` samples into block->light, and joins their vertices with the camera. */
bent_status light_paths_trace(const tracer *t, path_block *block, int count, const pixel_sample *wanted,
                              bent_render_statistics *statistics, bent_progress *progress, bent_error *error);
/* The chain of a vertex that the camera's side sees so. */
chain light_vertex_chain(const tracer *t, const light_vertex *vertex, const view *seen);
/* The history of a path on from its camera's part, whose last event scatters light that comes from a light vertex: all
 * scatterings but the one next to the lamp. seen: the light vertex as the camera's side sees it; u in [0, 1) picks the
 * kind of lobe, as often as scattering would have drawn it. Returns 0 if the settings do not allow such a path. */
int light_path_allowed(const tracer *t, ray_history camera, const light_vertex *vertex, const view *seen, double u);
/* Adds light at a point of the image (in [0, 1] from its left and bottom edges) to the pixels around. */
void light_image_add(const tracer *t, const double image[2], vec3 light);
#endif
