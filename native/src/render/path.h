/* Paths of light, traced backwards from the camera, many at a time: each round intersects all living paths' rays as one
 * batch, then shades every hit and draws its next ray. */
#ifndef BENT_RENDER_PATH_H
#define BENT_RENDER_PATH_H
#include "base/vec3.h"
#include "bentlight/render.h"
#include "render/camera.h"
#include "render/channels.h"
#include "render/filter.h"
#include "render/sampler.h"
#include "scene/closure.h"

/* What all paths of a call share. */
typedef struct tracer {
  const bent_scene *scene;
  const bent_render_settings *settings;
  sampler sampler;
  pixel_filter filter;
  double angle; /* wanted angular error of a ray, radians */
} tracer;

/* A path in the making. */
typedef struct path {
  vec3 beta;         /* throughput from here to the camera */
  vec3 radiance;     /* gathered so far */
  vec3 feature_beta; /* throughput of mirrors and glass before the surface that denoising features describe */
  double alpha, travelled, depth_per_length;
  double winding, error; /* of the camera ray: half turns and radians */
  uint32_t pixel_key, sample;
  uint32_t vertex; /* surfaces met; numbers the random sets */
  uint32_t bounces, diffuse, glossy, transmission, transparent;
  int record;
  int described, featured; /* whether depth, position, normal and denoising features are written */
  int last;                /* nothing but emission is gathered at the next surface */
} path;

/* Room for `capacity` paths in flight in one scene. */
typedef struct path_block {
  int capacity;
  path *paths;
  bent_ray *rays;
  bent_hit *hits;
  sample_record *records; /* one a path, kept when the path ends */
  closure *closures;      /* of the surface that is being shaded */
} path_block;

bent_status path_block_new(path_block *out, const bent_scene *scene, int capacity, bent_error *error);
void path_block_free(path_block *block);

/* A pixel sample to take. */
typedef struct pixel_sample {
  uint32_t x, y, sample;
} pixel_sample;

void tracer_init(tracer *tracer, const bent_scene *scene, const bent_render_settings *settings);
/* Traces `count` <= capacity pixel samples to their ends; records[i] is the answer to wanted[i] and depends on nothing
 * else. Looks at `progress` for a cancel, then returns BENT_CANCELLED and no record is valid. */
bent_status path_trace(const tracer *tracer, path_block *block, int count, const pixel_sample *wanted,
                       bent_render_statistics *statistics, bent_progress *progress, bent_error *error);
#endif
