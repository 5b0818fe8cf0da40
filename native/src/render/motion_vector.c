/* See motion_vector.h. */
#include "render/motion_vector.h"

#include "geometry/geometry.h"
#include "light/join.h"
#include "light/join_follow.h"
#include "scene/motion.h"
#include "scene/scene.h"

/* The first of a pixel's samples: more would hardly make it better. About a hole that spins images are found slowly. */
enum { SAMPLES = 4, SAMPLES_SLOW = 1 };
enum { BLOCK = 64 };
/* Where both are seen in a pixel, surfaces hide how the sky moves: in Cycles it never does. */
static const float SKY_WEIGHT = 0x1p-16f;
/* How much less a sample counts whose image is not known in all moments: it must not shorten what others of its pixel tell. */
static const float UNKNOWN_WEIGHT = 0x1p-16f;
/* By how much, in swept angle, the image of a place may differ from the ray that found it, which only sees it through
 * another part of the camera's lens; and by how much from one moment to another. Else it is another image: radians. */
static const double SWEPT_SAME = 0.1, SWEPT_NEAR = 0.5 * M_PI;
/* By how much launch directions of the ray and the image may differ, in errors that the ray is traced to. */
static const double LAUNCH_SAME = 10;

int motion_is_asked(const tracer *t, uint32_t sample)
{
  return t->scene->motion && sample < (uint32_t)(t->joins_slowly ? SAMPLES_SLOW : SAMPLES);
}

void motion_begin(motion_seen *seen, path *p)
{
  seen->launch = p->scattered.direction;
  seen->image[0] = p->image[0], seen->image[1] = p->image[1];
  p->seen = seen;
}

void motion_see_surface(const tracer *t, motion_seen *seen, const surface *surface, double swept)
{
  const shade_point *p = &surface->point;
  seen->kind = SEEN_SURFACE;
  seen->swept = swept;
  seen->place = p->position;
  for (int k = 0; k < MOMENTS; k++)
    seen->other[k] = moment_place(&t->scene->motion->moments[k], t->scene, p->instance, p->triangle, p->barycentric,
                                  p->position);
}

void motion_see_sky(motion_seen *seen, vec3 direction, int far, double swept)
{
  seen->kind = far ? SEEN_FAR_SKY : SEEN_SKY;
  seen->swept = swept;
  seen->place = seen->other[0] = seen->other[1] = direction;
}

/* The image of one place in one moment; at first that in another moment. */
typedef struct image {
  vec3 place, launch;
  double at[2], swept;
  double reach; /* by how much launch directions of the two may differ */
  int known;
} image;

/* The joint whose image is nearest to `near`, its swept angle within `within` of that one's; NULL if there is none. */
static const joint *nearest(const joints *joints, const image *near, double within)
{
  const joint *found = NULL;
  double distance = near->reach;
  for (int i = 0; i < joints->count; i++) {
    const joint *j = &joints->list[i];
    const double off = v3_length(v3_sub(j->launch, near->launch));
    if (fabs(j->swept - near->swept) < within && off < distance) found = j, distance = off;
  }
  return found;
}

static int bends(const geometry *g)
{
  for (size_t i = 0; i < g->lens_count; i++)
    if (!g->lenses[i].flat) return 1;
  return 0;
}

/* By parallel rays: of places in flat space. */
static void find_parallel(const bent_scene *view, int count, int kind, image *images)
{
  for (int i = 0; i < count; i++) {
    images[i].known &= kind == SEEN_SURFACE && !bends(view->geometry);
    if (images[i].known) camera_place_of_point(view->camera, images[i].place, images[i].at);
  }
}

/* Takes a joint as the image; NULL: there is none. */
static void settle(const camera *camera, const joint *j, image *m)
{
  const double near[2] = {m->at[0], m->at[1]};
  m->known = j && camera_place_near(camera, j->launch, near, m->at);
  if (m->known) m->launch = j->launch, m->swept = j->swept;
}

/* From the image in another moment to that in this one, by the ray alone, about a spinning hole: much quicker than to look for
 * all images, and finds those that are hardly found. Returns 0 if it did not come there. */
static int follow(const bent_scene *view, vec3 eye, image *m)
{
  const geometry *g = view->geometry;
  joint j = {.launch = m->launch, .swept = m->swept, .first_lens = (int)(geometry_lens_at(g, eye) - g->lenses)};
  if (!join_follow(g, eye, m->place, &j)) return 0;
  settle(view->camera, &j, m);
  return 1;
}

/* Turns images that are known in another moment into those of the moment that `view` shows, swept angles within `within`. */
static void find_images(const bent_scene *view, int count, int kind, double within, image *images)
{
  const camera *camera = view->camera;
  if (camera->settings.kind == BENT_CAMERA_ORTHOGRAPHIC) {
    find_parallel(view, count, kind, images);
    return;
  }
  vec3 from[BLOCK], to[BLOCK];
  double all[BLOCK] = {0}; /* joints are listed */
  joints joined[BLOCK];
  int which[BLOCK], n = 0;
  const vec3 eye = mat4_point(&camera->world_from_camera, v3(0, 0, 0));
  const int follows = kind == SEEN_SKY && join_is_slow(view->geometry);
  for (int i = 0; i < count; i++)
    if (images[i].known && !(follows && follow(view, eye, &images[i])))
      from[n] = eye, to[n] = images[i].place, which[n++] = i;
  if (kind == SEEN_SURFACE) join_points(view->geometry, (size_t)n, from, to, all, joined);
  else join_sky(view->geometry, (size_t)n, from, to, all, kind == SEEN_FAR_SKY, joined);
  for (int k = 0; k < n; k++) {
    image *m = &images[which[k]];
    settle(camera, nearest(&joined[k], m, within), m);
  }
}

/* The way from one image to another in pixels, times `weight`. */
static void write_way(const image *from, const image *to, const double size[2], float weight, float out[2])
{
  for (int axis = 0; axis < 2; axis++) {
    const float way = (float)((to->at[axis] - from->at[axis]) * size[axis]);
    if (isfinite(way)) out[axis] = weight * way;
  }
}

/* By how many radians, with some to spare, a ray through the lens' edge may be launched otherwise than that through its middle
 * to the same place: as if it crossed that at the place, or, if nearer, at what is sharp or at what bends it. */
static double reach_of_lens(const tracer *t, int kind, vec3 place)
{
  const bent_aperture *lens = &t->scene->camera->settings.aperture;
  if (!(lens->radius > 0)) return 0;
  double least = min2(lens->focal_distance, geometry_lens_distance(t->scene->geometry, t->eye));
  if (kind == SEEN_SURFACE) least = min2(least, v3_length(v3_sub(place, t->eye)));
  return 2 * lens->radius * max2(1, 1 / lens->ratio) / least;
}

/* Vectors of a few samples that see things of one kind. */
static void write_block(const tracer *t, int count, int kind, const motion_seen *const *seen, sample_record *const *records)
{
  image now[BLOCK], then[MOMENTS][BLOCK];
  const double size[2] = {t->settings->width, t->settings->height};
  for (int i = 0; i < count; i++)
    now[i] = (image){.place = seen[i]->place, .launch = seen[i]->launch, .at = {seen[i]->image[0], seen[i]->image[1]},
                     .swept = seen[i]->swept, .reach = LAUNCH_SAME * t->angle + reach_of_lens(t, kind, seen[i]->place),
                     .known = 1};
  find_images(t->scene, count, kind, SWEPT_SAME, now);
  for (int k = 0; k < MOMENTS; k++) {
    image *images = then[k];
    for (int i = 0; i < count; i++) images[i] = now[i], images[i].place = seen[i]->other[k], images[i].reach = INFINITY;
    find_images(t->scene->motion->moments[k].view, count, kind, SWEPT_NEAR, images);
  }
  for (int i = 0; i < count; i++) {
    float *weight = records[i]->value[CHANNEL_VECTOR_WEIGHT];
    if (!then[0][i].known || !then[1][i].known) *weight *= UNKNOWN_WEIGHT;
    float *out = records[i]->value[CHANNEL_VECTOR];
    for (int k = 0; k < MOMENTS; k++)
      if (then[k][i].known) write_way(&now[i], &then[k][i], size, k ? -*weight : *weight, out + 2 * k);
  }
}

static int is_same(vec3 a, vec3 b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

void motion_write(const tracer *t, size_t count, const motion_seen *seen, sample_record *records)
{
  int stands[MOMENTS];
  for (int k = 0; k < MOMENTS; k++) stands[k] = moment_view_stands(&t->scene->motion->moments[k], t->scene);
  for (int kind = SEEN_SURFACE; kind < SEEN_KINDS; kind++) {
    const motion_seen *some[BLOCK];
    sample_record *of_some[BLOCK];
    int waiting = 0;
    for (size_t i = 0; i < count; i++) {
      if ((int)seen[i].kind != kind) continue;
      records[i].value[CHANNEL_VECTOR_WEIGHT][0] = kind == SEEN_SURFACE ? 1 : SKY_WEIGHT;
      const int rests[MOMENTS] = {is_same(seen[i].place, seen[i].other[0]), is_same(seen[i].place, seen[i].other[1])};
      if (stands[0] && stands[1] && rests[0] && rests[1]) continue; /* nothing moves: 0, as it is */
      some[waiting] = &seen[i], of_some[waiting++] = &records[i];
      if (waiting == BLOCK) write_block(t, waiting, kind, some, of_some), waiting = 0;
    }
    if (waiting) write_block(t, waiting, kind, some, of_some);
  }
}
