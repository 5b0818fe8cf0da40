/* See bentlight/stars.h. Stars go in batches: joined with the camera, projected, and, if its lens is a pinhole, traced back
 * until nothing is in the way any more. */
#include "bentlight/stars.h"

#include <stdlib.h>
#include <string.h>

#include "geometry/geometry.h"
#include "light/frequency.h"
#include "light/join_follow.h"
#include "render/camera.h"
#include "render/star_lens.h"
#include "render/star_rays.h"
#include "scene/scene.h"

enum { BATCH = 64, ENTRIES = BATCH * BENT_STAR_IMAGES_MAX };
_Static_assert((int)BENT_STAR_IMAGES_MAX == 2 * (int)JOINTS_MAX, "images on both sides of a throat");
/* Radians by which a star is moved that lacks an image: it may lie exactly behind a center, or near the caustic of a
 * spinning hole, where not all rays are found (connect.h). */
static const double ASIDE[] = {1e-6, 1e-4, 1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.3};
enum { WITHOUT_SPIN = 1, WITH_SPIN = sizeof ASIDE / sizeof *ASIDE }; /* steps to try */
/* Launch directions that differ by less, radians, are the same image's. */
static const double SAME = 1e-4;
/* From one eye to the next launch directions of an image differ by less, radians. */
static const double TURN_MAX = 1e-2;

/* Where stars are looked for: the lens' middle, and, if it is open, places a little aside along each of the camera's axes. */
enum { EYES = 4 };
static const double APART = 1e-2; /* of the lens' radius */

/* An image of a star of the batch. */
typedef struct image {
  int star;
  double place[2], parallax[2][2], solid_angle, swept;
  vec3 brightness;
} image;

typedef struct finder {
  star_tracer *tracer;
  const camera *camera;
  double beside[2]; /* of the picture's width and height, whose images count too */
  vec3 eyes[EYES];
  double apart;     /* of the others from the first; 0: the lens is a pinhole, and there are none */
  int listed[BATCH]; /* images of each star */
  int count;
  image images[ENTRIES];
  star_ray rays[ENTRIES];
  joints found[EYES][BATCH];
} finder;

/* A magnification as of a star that has some size; see the header. */
static double bounded(double magnification, double swept)
{
  const double part = magnification / (BENT_STAR_MAGNIFICATION_MAX * exp(-max2(swept - M_PI, 0)));
  return magnification / sqrt(sqrt(1 + part * part * part * part));
}

/* Unit directions beside d, by the angle `aside` to one of four sides. */
static vec3 beside(vec3 d, double aside, int side)
{
  const vec3 right = v3_normalize(v3_cross(d, fabs(d.z) < 0.5 ? v3(0, 0, 1) : v3(1, 0, 0))), up = v3_cross(right, d);
  return v3_normalize(v3_mad(side & 1 ? up : right, side & 2 ? -aside : aside, d));
}

/* Whether a joint is one of a list. */
static int is_listed(const joints *list, const joint *j)
{
  for (int i = 0; i < list->count; i++)
    if (v3_length(v3_sub(list->list[i].launch, j->launch)) < SAME) return 1;
  return 0;
}

/* The joint of `others` that is farthest from all of a list. */
static const joint *farthest(const joints *list, const joints *others)
{
  const joint *best = &others->list[0];
  double most = -1;
  for (int k = 0; k < others->count; k++) {
    double least = INFINITY;
    for (int i = 0; i < list->count; i++)
      least = min2(least, v3_length(v3_sub(list->list[i].launch, others->list[k].launch)));
    if (least > most) most = least, best = &others->list[k];
  }
  return best;
}

/* Gives a star that lacks images those of a place beside it: around a spinning hole followed back to the star itself, or, on
 * the caustic, where that leads nowhere, as they are. */
static void complete(const geometry *g, const vec3 *from, const vec3 *to, const double *u, int far, joints *found)
{
  const int spins = join_is_slow(g), wanted = spins ? 2 : g->lens_count > 0;
  joints nearest = {.count = 0};
  for (int step = 0; step < (spins ? WITH_SPIN : WITHOUT_SPIN); step++)
    for (int side = 0; side < 4 && found->count < wanted; side++) {
      joints others;
      const vec3 moved = beside(*to, ASIDE[step], side);
      join_sky(g, 1, from, &moved, u, far, &others);
      if (!nearest.count && others.count >= wanted) nearest = others;
      for (int i = 0; i < others.count && found->count < JOINTS_MAX; i++) {
        joint *j = &others.list[i];
        if ((spins && !join_follow(g, *from, *to, j)) || is_listed(found, j)) continue;
        found->list[found->count++] = *j;
      }
    }
  while (found->count < wanted && nearest.count >= wanted) {
    found->list[found->count] = *farthest(found, &nearest);
    found->count++;
  }
}

/* Takes up the image along a joint at one of its places in the picture. */
static void add_image(finder *f, int star, star_sky sky, const joint *j, const vec3 turn[3], const double place[2])
{
  const bent_scene *scene = f->tracer->tracer.scene;
  image im = {.star = star, .swept = j->swept, .place = {place[0], place[1]}};
  camera_ray cast;
  im.solid_angle = camera_solid_angle(f->camera, place[0], place[1]);
  if (f->listed[star] == BENT_STAR_IMAGES_MAX || !(im.solid_angle > 0) || !camera_cast(f->camera, place[0], place[1], &cast))
    return;
  f->listed[star]++;
  if (f->apart > 0) star_parallax(f->camera, j->launch, turn, place, im.parallax);
  ray_history seen = {.kinds = RAY_CAMERA};
  frequency_leave(scene->geometry, f->eyes[0], j->launch, &seen);
  const double brightness = bounded(1 / j->spread, j->swept) / j->way_chance;
  im.brightness = shading_shifted(scene->shading, v3_splat(brightness), &seen);
  f->rays[f->count] = star_ray_of(f->tracer, &cast, j->launch, sky);
  f->images[f->count++] = im;
}

/* How a joint's launch direction turns per scene unit along each of the camera's axes: by the nearest ones from there. What
 * turns faster than light by a hole does (another image, where connections miss one) counts as not turning. */
static void launch_turns(const finder *f, int star, const joint *j, vec3 out[3])
{
  for (int k = 0; k < 3; k++) {
    const joints *others = &f->found[k + 1][star];
    vec3 least = v3(INFINITY, 0, 0);
    for (int i = 0; i < others->count; i++) {
      const vec3 change = v3_sub(others->list[i].launch, j->launch);
      if (v3_length(change) < v3_length(least)) least = change;
    }
    out[k] = v3_length(least) < TURN_MAX ? v3_scale(least, 1 / f->apart) : v3(0, 0, 0);
  }
}

/* Takes up the image along a joint wherever it lies in the picture. */
static void add_places(finder *f, int star, star_sky sky, const joint *j)
{
  double places[CAMERA_PLACES_MAX][2];
  vec3 turn[3] = {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
  const int count = camera_places(f->camera, j->launch, f->beside, places);
  if (count && f->apart > 0) launch_turns(f, star, j, turn);
  for (int i = 0; i < count; i++) add_image(f, star, sky, j, turn, places[i]);
}

/* Joins the places on the lens with the stars of a batch. */
static void add_images(finder *f, int count, const double (*directions)[3])
{
  const geometry *g = f->tracer->tracer.scene->geometry;
  vec3 from[BATCH], to[BATCH];
  double u[BATCH];
  for (int i = 0; i < count; i++) {
    f->listed[i] = 0;
    to[i] = v3_normalize(v3_from(directions[i]));
    u[i] = 1e-200 * (2 + to[i].x + 0.5 * to[i].y); /* too small to leave out any, but a star's own, for what is too much */
  }
  for (int far = 0; far <= join_has_far_sky(g); far++) {
    for (int eye = 0; eye < (f->apart > 0 ? EYES : 1); eye++) {
      for (int i = 0; i < count; i++) from[i] = f->eyes[eye];
      join_sky(g, (size_t)count, from, to, u, far, f->found[eye]);
      for (int i = 0; i < count; i++) complete(g, &from[i], &to[i], &u[i], far, &f->found[eye][i]);
    }
    for (int i = 0; i < count; i++)
      for (int k = 0; k < f->found[0][i].count; k++)
        add_places(f, i, far ? STAR_SKY_FAR : STAR_SKY_NEAR, &f->found[0][i].list[k]);
  }
}

/* Writes out the images that are seen, stars counted from number `first`. Through an open lens that is left to others. */
static bent_status write_images(finder *f, size_t first, const bent_star_images *out, bent_progress *progress,
                                bent_error *error)
{
  bent_status status = BENT_OK;
  for (int begin = 0; begin < f->count && !(f->apart > 0) && !status; begin += STAR_RAYS_MAX) {
    const int count = f->count - begin < STAR_RAYS_MAX ? f->count - begin : STAR_RAYS_MAX;
    status = star_rays_trace(f->tracer, count, f->rays + begin, progress, error);
  }
  for (int i = 0; i < f->count && !status; i++) {
    const image *im = &f->images[i];
    const star_ray *ray = &f->rays[i];
    if (!ray->arrived && !(f->apart > 0)) continue;
    const size_t star = first + (size_t)im->star;
    const size_t at = star * BENT_STAR_IMAGES_MAX + (size_t)out->count[star]++;
    v3_to(out->throughput[at], v3_mul(im->brightness, ray->throughput));
    out->solid_angle[at] = im->solid_angle;
    out->swept[at] = im->swept;
    memcpy(out->place[at], im->place, sizeof im->place);
    memcpy(out->parallax[at], im->parallax, sizeof im->parallax);
  }
  return status;
}

int bent_scene_shows_stars(const bent_scene *scene)
{
  return scene->camera && scene->camera->settings.kind != BENT_CAMERA_ORTHOGRAPHIC;
}

static bent_status check_directions(size_t n, const double (*directions)[3], bent_error *error)
{
  for (size_t i = 0; i < n; i++) {
    const double length = v3_length(v3_from(directions[i]));
    if (!(length > 0) || !isfinite(length))
      return bent_fail(error, BENT_ERROR_ARGUMENT, "stars: direction %zu must be finite and not 0", i);
  }
  return BENT_OK;
}

/* Pixels to each side over which images are spread: near a hole as what is as near as that. */
static double widest_blur(const star_tracer *t, uint32_t width, uint32_t height)
{
  const bent_scene *scene = t->tracer.scene;
  const double focus = scene->camera->settings.aperture.focal_distance, blur = star_blur(scene->camera, width, height);
  return blur > 0 ? blur * (1 + focus / geometry_lens_distance(scene->geometry, t->tracer.eye)) : 0;
}

/* A finder for a view; NULL, with an error, if there is no memory. */
static finder *finder_new(const bent_scene *scene, const bent_star_view *view, bent_error *error)
{
  finder *f = malloc(sizeof *f);
  star_tracer *tracer = f ? star_tracer_new(scene, view, error) : NULL;
  if (!tracer) {
    free(f);
    bent_fail(error, BENT_ERROR_MEMORY, "stars: out of memory");
    return NULL;
  }
  const double blur = widest_blur(tracer, view->width, view->height);
  f->tracer = tracer, f->camera = scene->camera;
  f->beside[0] = view->margin / view->width + min2(blur / view->width, 1); /* star_parallax follows them no farther */
  f->beside[1] = view->margin / view->height + min2(blur / view->height, 1);
  f->apart = APART * scene->camera->settings.aperture.radius;
  for (int eye = 0; eye < EYES; eye++) {
    const vec3 aside = v3(eye == 1, eye == 2, eye == 3);
    f->eyes[eye] = v3_add(tracer->tracer.eye, mat4_vector(&scene->camera->world_from_camera, v3_scale(aside, f->apart)));
  }
  return f;
}

bent_status bent_scene_find_stars(const bent_scene *scene, size_t n, const double (*directions)[3],
                                  const bent_star_view *view, const bent_star_images *out, bent_progress *progress,
                                  bent_error *error)
{
  bent_status status = star_view_check(scene, view, error);
  if (!status) status = check_directions(n, directions, error);
  if (status) return status;
  finder *f = finder_new(scene, view, error);
  if (!f) return BENT_ERROR_MEMORY;
  for (size_t i = 0; i < n; i++) out->count[i] = 0;
  if (!path_can_leave(&f->tracer->tracer, f->eyes[0])) n = 0; /* within a horizon: nothing is seen */
  for (size_t first = 0; first < n && !status; first += BATCH) {
    const int count = (int)(n - first < BATCH ? n - first : BATCH);
    f->count = 0;
    add_images(f, count, directions + first);
    status = write_images(f, first, out, progress, error);
    if (progress && !status) atomic_fetch_add_explicit(&progress->done, (uint64_t)count, memory_order_relaxed);
  }
  star_tracer_free(f->tracer);
  free(f);
  return status;
}
