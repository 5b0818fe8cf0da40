/* Rays from the camera towards stars: which of them arrive, and how much light surfaces in front let through. */
#ifndef BENT_RENDER_STAR_RAYS_H
#define BENT_RENDER_STAR_RAYS_H
#include "bentlight/stars.h"
#include "render/path.h"

enum { STAR_RAYS_MAX = 2048 }; /* at a time */

/* Which sky a ray is to end in. */
typedef enum star_sky { STAR_SKY_NEAR, STAR_SKY_FAR /* beyond a throat without exit */, STAR_SKY_ANY } star_sky;

typedef struct star_ray {
  bent_ray ray; /* set by path_set_ray */
  star_sky sky;
  int arrived; /* an answer, as is the next */
  vec3 throughput;
  ray_history history;
  double length;
} star_ray;

typedef struct star_tracer {
  tracer tracer;
  bent_render_settings settings; /* the tracer's */
  uint32_t transparent_bounces;
  closure *closures; /* of a surface in front */
  int under_way[STAR_RAYS_MAX]; /* rays' numbers */
  bent_ray rays[STAR_RAYS_MAX];
  bent_hit hits[STAR_RAYS_MAX];
} star_tracer;

/* Whether a scene is ready to show stars, and a view is one that it can show them in. */
bent_status star_view_check(const bent_scene *scene, const bent_star_view *view, bent_error *error);
/* NULL, with an error, if there is no memory. */
star_tracer *star_tracer_new(const bent_scene *scene, const bent_star_view *view, bent_error *error);
void star_tracer_free(star_tracer *t);
/* A ray that the camera casts, pointed in a unit local direction. */
star_ray star_ray_of(const star_tracer *t, const camera_ray *cast, vec3 direction, star_sky sky);
/* Traces rays, STAR_RAYS_MAX at most, until they arrive or nothing of them is left. */
bent_status star_rays_trace(star_tracer *t, int count, star_ray *rays, bent_progress *progress, bent_error *error);
#endif
