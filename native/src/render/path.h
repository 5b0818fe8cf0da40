/* Paths of light, traced backwards from the camera, many at a time: each round intersects all living paths' rays as one
 * batch, then shades every hit and draws its next ray. */
#ifndef BENT_RENDER_PATH_H
#define BENT_RENDER_PATH_H
#include "base/vec3.h"
#include "bentlight/render.h"
#include "render/camera.h"
#include "render/bsdf.h"
#include "render/chain.h"
#include "render/channels.h"
#include "render/filter.h"
#include "render/parts.h"
#include "light/lights.h"
#include "render/sampler.h"
#include "scene/closure.h"

/* What all paths of a call share. */
typedef struct tracer {
  const bent_scene *scene;
  const bent_render_settings *settings;
  const channel_layout *layout; /* of the records; never NULL */
  sampler sampler;
  pixel_filter filter;
  double angle; /* wanted angular error of a ray, radians */
  double pixel_size, pixel_slope; /* of the central pixel: its size at the camera, and by how much that grows per length */
  int bidirectional; /* light subpaths are traced too */
  vec3 eye;          /* the camera's place */
  int64_t (*light)[3]; /* where they add what they bring to the camera, as in render.h */
  int joins_slowly;    /* see join_is_slow */
  int asks_scattering; /* some material wants to know by what kind of scattering a ray came */
  int asks_frequency;  /* and some how its frequency is shifted */
  int filters_sky;     /* images of the sky are averaged for the camera */
} tracer;

/* The last scattering of a path, which the light that it meets is weighed by. */
typedef struct scattering {
  vec3 position, normal; /* at first the camera's ray; normal: as direct_normal has it */
  vec3 direction;        /* drawn */
  double pdf;            /* of the direction, by solid angle; 0: a mirror's or the camera's, which no light sampling finds */
  double join_chance;    /* with which the place was joined with a light */
  uint32_t receiver_set; /* of the instance there */
  /* from there to the ray's origin, by way of surfaces that it went through, as in bent_hit */
  double swept;
  int first_lens;
  uint32_t borders;
  double length;
} scattering;

/* A path in the making. */
typedef struct path {
  scattering scattered;
  chain chain;       /* of the camera's subpath, as it was left; only if light subpaths are traced too */
  vec3 beta;         /* throughput from here to the camera */
  vec3 radiance;     /* gathered so far */
  vec3 feature_beta; /* throughput of mirrors and glass before the surface that denoising features describe */
  double image[2], lens[2]; /* the place in the picture and on the lens, as camera_cast_lens has them */
  double sky_filter; /* of this path, pixels, as in bent_render_settings */
  double alpha, travelled, depth_per_length;
  double way; /* length of all rays before this one */
  double winding, error; /* of the camera ray: half turns and radians */
  sampler_pixel pixel;
  uint32_t sample;
  double least_pdf; /* of all scatterings by lobes that are not sharp: how blurred the view is, at least */
  uint32_t vertex; /* surfaces met; numbers the random sets */
  ray_history ray;
  int record;
  vec3 diffuse_part, glossy_part; /* of what its first scattering brings: see credit; only if light is told apart */
  struct motion_seen *seen; /* where it says what its vector is of; NULL: nowhere */
  int described, featured; /* whether depth, position, normal and denoising features are written */
  int last;                /* nothing but emission is gathered at the next surface */
} path;

enum { CREDIT_NONE = -1, CREDIT_OCCLUSION = -2 };

/* A ray that is to find out what stands between a vertex and a light: the light that it brings if nothing does. */
typedef struct shadow {
  int credit; /* number of the block's, CREDIT_NONE, or CREDIT_OCCLUSION: it is light for ambient occlusion only */
  int path; /* of the block; -1: the light goes to the point `image` of the picture */
  double image[2];
  light_kind kind;
  vec3 target;  /* as in light_sample */
  int instance, triangle; /* that the target lies on; instance -1: none */
  double swept;     /* left until the target, radians */
  uint32_t borders; /* also, as in bent_hit */
  int straight;     /* no lens on the way */
  int far;      /* the target is in the sky beyond a wormhole */
  size_t cell;  /* in which the block counts it */
  vec3 light;
  uint64_t blockers;    /* sets of instances that hold the light up */
  vec3 from;            /* the vertex */
  double length;        /* since then */
  ray_history ray;
} shadow;

enum { SHADOWS = 16384 };

/* What became of some shadow rays. */
typedef struct shadow_count {
  uint32_t traced, arrived;
} shadow_count;

/* Room for `capacity` paths in flight in one scene. */
typedef struct path_block {
  int capacity;
  path *paths;
  bent_ray *rays;
  bent_hit *hits;
  uint8_t *goes_on;       /* whether a path lives on after this round */
  sample_record *records; /* one a path, kept when the path ends */
  closure *closures;      /* of the surfaces that are being shaded, `lobes` each, and as many for where paths come out */
  int lobes;
  int shadow_count;       /* of at most SHADOWS */
  shadow *shadows;
  bent_ray *shadow_rays;
  bent_hit *shadow_hits;
  credit *credits;        /* of shadows, if light is told apart; else NULL */
  int credit_count;
  float *lists;           /* of the records */
  struct motion_seen *seen; /* what each sample sees; NULL unless vectors are wanted */
  shadow_count *counts;   /* by portal_cell, to be counted up; NULL: nobody counts */
  struct light_paths *light; /* light_path.h, freed with the block; NULL if light subpaths are not traced */
} path_block;

bent_status path_block_new(path_block *out, const bent_scene *scene, const channel_layout *layout, int capacity,
                           bent_error *error);
void path_block_free(path_block *block);

/* A pixel sample to take. */
typedef struct pixel_sample {
  uint32_t x, y, sample;
  uint32_t multiple; /* samples that the pixel takes where others take one */
} pixel_sample;

/* The history of what a kind of lobe of a set scatters of a ray; `sharp`: by a delta lobe. */
ray_history path_scattered(ray_history ray, const closure_set *set, bsdf_lobe lobe, int sharp);
/* Whether the surface that a path with that history meets is its last. */
int path_is_last(const bent_render_settings *settings, const ray_history *ray);
/* Whether light can leave from a place: not from inside a horizon, nor from where rounding sees one. */
int path_can_leave(const tracer *t, vec3 origin);
/* About the size of a pixel at a place that light subpaths come to as well: along the straight way. */
double path_footprint(const tracer *t, vec3 position);
/* Points `ray`, whose visibility is set, away from a surface, or from the camera if that is NULL. */
void path_set_ray(const tracer *t, bent_ray *ray, vec3 origin, vec3 direction, const bent_hit *surface);
/* Intersects n rays, some at a time: looks for a cancel in between. */
bent_status path_intersect(const tracer *t, int n, const bent_ray *rays, bent_hit *hits, bent_progress *progress,
                           bent_error *error);
/* What a contribution to the picture counts after so many scatterings: limited by Cycles' clamp direct or indirect. */
vec3 path_limited(const tracer *t, uint32_t bounces, vec3 contribution);
/* Light comes to a path's camera by its ray that has been scattered so many times. credit: NULL if light is not told apart. */
void path_receive(const tracer *t, path *p, sample_record *record, const credit *credit, uint32_t bounces, vec3 light);
/* layout: what records are to hold. */
void tracer_init(tracer *tracer, const bent_scene *scene, const bent_render_settings *settings,
                 const channel_layout *layout);
/* Traces the block's first `count` paths along their rays to the end. A path's radiance is in the channel `combined` of its
 * record. */
bent_status path_run(const tracer *tracer, path_block *block, int count, bent_render_statistics *statistics,
                     bent_progress *progress, bent_error *error);
/* Traces `count` <= capacity pixel samples to their ends; records[i] is the answer to wanted[i] and depends on nothing
 * else. Looks at `progress` for a cancel, then returns BENT_CANCELLED and no record is valid. */
bent_status path_trace(const tracer *tracer, path_block *block, int count, const pixel_sample *wanted,
                       bent_render_statistics *statistics, bent_progress *progress, bent_error *error);
#endif
