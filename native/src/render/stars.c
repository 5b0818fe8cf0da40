/* See bentlight/stars.h. Stars go in batches: joined with the camera, projected, and traced back until nothing is in the
 * way any more. */
#include "bentlight/stars.h"

#include <stdlib.h>

#include "geometry/geometry.h"
#include "light/frequency.h"
#include "light/join_follow.h"
#include "render/camera.h"
#include "render/direct.h"
#include "render/path.h"
#include "scene/scene.h"

enum { BATCH = 64, ENTRIES = BATCH * BENT_STAR_IMAGES_MAX };
_Static_assert((int)BENT_STAR_IMAGES_MAX == 2 * (int)JOINTS_MAX, "images on both sides of a throat");
/* Radians by which a star is moved that lacks an image: it may lie exactly behind a center, or near the caustic of a
 * spinning hole, where not all rays are found (connect.h). */
static const double ASIDE[] = {1e-6, 1e-4, 1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.3};
enum { WITHOUT_SPIN = 1, WITH_SPIN = sizeof ASIDE / sizeof *ASIDE }; /* steps to try */
/* Launch directions that differ by less, radians, are the same image's. */
static const double SAME = 1e-4;

/* An image whose ray is under way. */
typedef struct image {
  int star; /* of the batch */
  int far;  /* beyond a throat without exit */
  double place[2], solid_angle, swept, length;
  vec3 throughput;
  ray_history ray;
} image;

typedef struct finder {
  tracer tracer;
  const bent_star_view *view;
  closure *closures; /* of a surface in front */
  int listed[BATCH]; /* images of each star */
  int count;         /* of the images, rays and hits */
  image images[ENTRIES];
  bent_ray rays[ENTRIES];
  bent_hit hits[ENTRIES];
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
static void add_image(finder *f, int star, int far, const joint *j, const double place[2])
{
  const camera *camera = f->tracer.scene->camera;
  image im = {.star = star, .far = far, .swept = j->swept, .place = {place[0], place[1]}, .ray = {.kinds = RAY_CAMERA}};
  camera_ray ray;
  im.solid_angle = camera_solid_angle(camera, place[0], place[1]);
  if (f->listed[star] == BENT_STAR_IMAGES_MAX || !(im.solid_angle > 0) || !camera_cast(camera, place[0], place[1], &ray))
    return;
  f->listed[star]++;
  ray_history seen = im.ray;
  frequency_leave(f->tracer.scene->geometry, f->tracer.eye, j->launch, &seen);
  const double brightness = bounded(1 / j->spread, j->swept) / j->way_chance;
  im.throughput = shading_shifted(f->tracer.scene->shading, v3_splat(brightness), &seen);
  bent_ray *out = &f->rays[f->count];
  *out = (bent_ray){.length_min = ray.length_min, .length_max = ray.length_max, .visibility = BENT_VISIBLE_CAMERA};
  path_set_ray(&f->tracer, out, ray.origin, j->launch, NULL);
  f->images[f->count++] = im;
}

/* Takes up the image along a joint wherever it lies in the picture. */
static void add_places(finder *f, int star, int far, const joint *j)
{
  const double beside[2] = {f->view->margin / f->view->width, f->view->margin / f->view->height};
  double places[CAMERA_PLACES_MAX][2];
  const int count = camera_places(f->tracer.scene->camera, j->launch, beside, places);
  for (int i = 0; i < count; i++) add_image(f, star, far, j, places[i]);
}

/* Joins the camera with the stars of a batch. */
static void add_images(finder *f, int count, const double (*directions)[3])
{
  const geometry *g = f->tracer.scene->geometry;
  vec3 from[BATCH], to[BATCH];
  double u[BATCH];
  for (int i = 0; i < count; i++) {
    f->listed[i] = 0;
    from[i] = f->tracer.eye, to[i] = v3_normalize(v3_from(directions[i]));
    u[i] = 1e-200 * (2 + to[i].x + 0.5 * to[i].y); /* too small to leave out any, but a star's own, for what is too much */
  }
  for (int far = 0; far <= join_has_far_sky(g); far++) {
    joints found[BATCH];
    join_sky(g, (size_t)count, from, to, u, far, found);
    for (int i = 0; i < count; i++) {
      complete(g, &from[i], &to[i], &u[i], far, &found[i]);
      for (int k = 0; k < found[i].count; k++) add_places(f, i, far, &found[i].list[k]);
    }
  }
}

/* A surface in front of an image: returns 1 if some of its light goes on along *ray. */
static int pass(finder *f, image *im, bent_ray *ray, const bent_hit *hit)
{
  const bent_scene *scene = f->tracer.scene;
  if (scene->geometry->instances[hit->instance].visibility & BENT_HOLDOUT) return 0;
  im->length += hit->length;
  im->throughput = v3_mul(im->throughput, direct_transmitted(scene, hit, im->length, &im->ray, f->closures));
  if (!(v3_max(im->throughput) > 0) || im->ray.transparent++ >= f->view->transparent_bounces) return 0;
  ray->length_min = max2(ray->length_min - hit->length, 0);
  ray->length_max -= hit->length;
  path_set_ray(&f->tracer, ray, v3_from(hit->position), v3_from(hit->direction), hit);
  return ray->length_max > 0;
}

/* Traces the images' rays; those that arrive are written out, stars counted from number `first`. */
static bent_status trace_images(finder *f, size_t first, const bent_star_images *out, bent_progress *progress,
                                bent_error *error)
{
  while (f->count > 0) {
    const int count = f->count;
    const bent_status status = path_intersect(&f->tracer, count, f->rays, f->hits, progress, error);
    if (status) return status;
    f->count = 0;
    for (int i = 0; i < count; i++) {
      image *im = &f->images[i];
      const bent_hit *hit = &f->hits[i];
      if (hit->fate == BENT_HIT && pass(f, im, &f->rays[i], hit)) {
        f->images[f->count] = *im, f->rays[f->count++] = f->rays[i];
      } else if (hit->fate == (im->far ? BENT_ESCAPED_FAR : BENT_ESCAPED)) {
        const size_t star = first + (size_t)im->star;
        const size_t at = star * BENT_STAR_IMAGES_MAX + (size_t)out->count[star]++;
        out->place[at][0] = im->place[0], out->place[at][1] = im->place[1];
        v3_to(out->throughput[at], im->throughput);
        out->solid_angle[at] = im->solid_angle;
        out->swept[at] = im->swept;
      }
    }
  }
  return BENT_OK;
}

int bent_scene_shows_stars(const bent_scene *scene)
{
  return scene->camera && scene->camera->settings.kind != BENT_CAMERA_ORTHOGRAPHIC;
}

static bent_status check(const bent_scene *scene, size_t n, const double (*directions)[3], const bent_star_view *v,
                         bent_error *error)
{
  if (!scene->camera) return bent_fail(error, BENT_ERROR_STATE, "stars: the scene has no camera");
  if (!scene->committed) return bent_fail(error, BENT_ERROR_STATE, "stars: the scene has edits without a commit");
  if (!bent_scene_shows_stars(scene))
    return bent_fail(error, BENT_ERROR_ARGUMENT, "stars: an orthographic camera sees no single directions");
  if (v->width < 1 || v->height < 1 || v->width > 1u << 16 || v->height > 1u << 16)
    return bent_fail(error, BENT_ERROR_ARGUMENT, "stars: the picture must be 1 to 65536 pixels wide and high, got %u x %u",
                     v->width, v->height);
  if (!(v->margin >= 0 && v->margin <= 1000))
    return bent_fail(error, BENT_ERROR_ARGUMENT, "stars: margin must lie in [0, 1000] pixels, got %g", v->margin);
  if (!(v->tolerance > 0 && v->tolerance <= 0.1))
    return bent_fail(error, BENT_ERROR_ARGUMENT, "stars: tolerance must lie in (0, 0.1] radians, got %g", v->tolerance);
  for (size_t i = 0; i < n; i++) {
    const double length = v3_length(v3_from(directions[i]));
    if (!(length > 0) || !isfinite(length))
      return bent_fail(error, BENT_ERROR_ARGUMENT, "stars: direction %zu must be finite and not 0", i);
  }
  return BENT_OK;
}

bent_status bent_scene_find_stars(const bent_scene *scene, size_t n, const double (*directions)[3],
                                  const bent_star_view *view, const bent_star_images *out, bent_progress *progress,
                                  bent_error *error)
{
  bent_status status = check(scene, n, directions, view, error);
  if (status) return status;
  const bent_render_settings settings = {.width = view->width, .height = view->height, .tolerance = view->tolerance,
                                         .filter = BENT_FILTER_BOX, .filter_width = 1};
  finder *f = malloc(sizeof *f);
  if (!f) return bent_fail(error, BENT_ERROR_MEMORY, "stars: out of memory");
  *f = (finder){.view = view, .closures = malloc(((size_t)shading_lobe_max(scene->shading) + 1) * sizeof *f->closures)};
  if (!f->closures) status = bent_fail(error, BENT_ERROR_MEMORY, "stars: out of memory");
  tracer_init(&f->tracer, scene, &settings, &NO_CHANNELS);
  for (size_t i = 0; i < n; i++) out->count[i] = 0;
  if (!path_can_leave(&f->tracer, f->tracer.eye)) n = 0; /* within a horizon: nothing is seen */
  for (size_t first = 0; first < n && !status; first += BATCH) {
    const int count = (int)(n - first < BATCH ? n - first : BATCH);
    f->count = 0;
    add_images(f, count, directions + first);
    status = trace_images(f, first, out, progress, error);
    if (progress && !status) atomic_fetch_add_explicit(&progress->done, (uint64_t)count, memory_order_relaxed);
  }
  free(f->closures);
  free(f);
  return status;
}

/* ---- Drawing ---- */

enum { SPAN_MAX = 32 }; /* pixels along one axis that the widest filter reaches */

/* Shares of neighboring pixels along one axis, from pixel `first` on. */
typedef struct span {
  int64_t first;
  int count;
  double share[SPAN_MAX];
} span;

/* Of a point at `at` pixels. A filter narrower than a pixel may miss all centers: the point's own pixel gets all. */
static span span_at(const pixel_filter *filter, double at)
{
  span s = {.first = (int64_t)ceil(at - filter->half_width - 0.5)};
  const int64_t last = (int64_t)floor(at + filter->half_width - 0.5);
  double sum = 0;
  for (int64_t i = s.first; i <= last && s.count < SPAN_MAX; i++)
    sum += s.share[s.count++] = filter_density(filter, (double)i + 0.5 - at);
  if (!(sum > 0)) return (span){.first = (int64_t)floor(at), .count = 1, .share = {1}};
  for (int i = 0; i < s.count; i++) s.share[i] /= sum;
  return s;
}

/* Adds an image's light to the pixels of a tile that it falls on. */
static void draw(const span *across_x, const span *across_y, const double light[3], const uint32_t tile[4],
                 double (*pixels)[3])
{
  for (int j = 0; j < across_y->count; j++) {
    const int64_t y = across_y->first + j - tile[1];
    if (y < 0 || y >= tile[3]) continue;
    for (int i = 0; i < across_x->count; i++) {
      const int64_t x = across_x->first + i - tile[0];
      if (x < 0 || x >= tile[2]) continue;
      double *pixel = pixels[(size_t)y * tile[2] + (size_t)x];
      for (int k = 0; k < 3; k++) pixel[k] += across_x->share[i] * across_y->share[j] * light[k];
    }
  }
}

bent_status bent_stars_draw(size_t n, const double (*places)[2], const double (*light)[3], uint32_t picture_width,
                            uint32_t picture_height, bent_filter_kind filter, double filter_width,
                            const uint32_t tile[4], float (*pixels)[3], bent_error *error)
{
  if (!(filter_width >= 0.01 && filter_width <= 30))
    return bent_fail(error, BENT_ERROR_ARGUMENT, "stars: filter_width must lie in [0.01, 30] pixels, got %g", filter_width);
  const size_t size = (size_t)tile[2] * tile[3];
  double(*sums)[3] = calloc(size + 1, sizeof *sums);
  if (!sums) return bent_fail(error, BENT_ERROR_MEMORY, "stars: out of memory");
  pixel_filter shape;
  filter_init(&shape, filter, filter_width);
  const double reach = shape.half_width + 1, pixel_count = (double)picture_width * picture_height;
  for (size_t i = 0; i < n; i++) {
    const double x = places[i][0] * picture_width, y = places[i][1] * picture_height;
    if (!(x > tile[0] - reach && x < (double)tile[0] + tile[2] + reach && y > tile[1] - reach &&
          y < (double)tile[1] + tile[3] + reach))
      continue;
    const span sx = span_at(&shape, x), sy = span_at(&shape, y);
    const double each[3] = {light[i][0] * pixel_count, light[i][1] * pixel_count, light[i][2] * pixel_count};
    draw(&sx, &sy, each, tile, sums);
  }
  for (size_t i = 0; i < size; i++)
    for (int k = 0; k < 3; k++) pixels[i][k] += (float)sums[i][k];
  free(sums);
  return BENT_OK;
}
