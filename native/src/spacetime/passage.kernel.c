/* Joints through lens spheres, LANES pairs at a time, image by image: a bracketed secant search for psi, on a scale that is
 * logarithmic in its distance to the critical ray, then the spread from the derivative there. */
#include "spacetime/passage.h"

#include "spacetime/passage_course.h"

enum { TRIALS_MAX = 60 };
/* |log| of the smallest distance to the critical ray that is tried, over the largest. */
#define DEPTH_MAX 36.0
/* Wanted error of the swept angle before the last Newton step. */
#define MISS_MAX 1e-7

/* psi at depth t: -log of the distance to the critical ray over the largest one. */
typedef struct scale {
  lanes range; /* psi = critical +- range exp(-t) */
  double side;
} scale;

LANES_INLINE scale scale_of(const route *r)
{
  if (r->kind == PASSAGE_ACROSS) return (scale){0.5 * M_PI - r->critical, 1};
  return (scale){r->critical, -1};
}

LANES_INLINE lanes gap_at(const scale *s, lanes depth) { return s->range * lanes_exp(-depth); }

/* The straight line of flat space or a weak lens (pi - swept = b (1/L_a + 1/L_b) - 4 M / b): the impact parameter. */
LANES_INLINE lanes guess_weak(const route *r, lanes swept)
{
  const bent_spacetime *s = r->spacetime;
  const double pull = s->kind == BENT_ELLIS ? s->throat_radius : 4 * s->mass;
  const lanes a = lanes_select(r->out_a, r->lever_a, r->first.lever), sum = 1 / a + 1 / r->lever_b, turn = swept - M_PI;
  return 0.5 * (lanes_sqrt(turn * turn + 4 * pull * sum) - turn) / sum;
}

/* psi of the straight line from a to b in flat space. */
LANES_INLINE lanes guess_straight(const route *r, lanes swept)
{
  lanes sine, cosine;
  lanes_sincos(swept, &sine, &cosine);
  const lanes a = lanes_select(r->out_a, r->lever_a, r->first.lever), ratio = a / r->lever_b;
  const lanes psi = lanes_angle(sine, cosine - ratio); /* at a, to the outward radial */
  if (r->kind == PASSAGE_OUT) return psi;
  lanes aim_sine, aim_cosine;
  lanes_sincos(psi, &aim_sine, &aim_cosine);
  const lanes at_rim = lanes_min(aim_sine * a / r->first.lever, lanes_all(0.999));
  return lanes_angle(at_rim, lanes_sqrt((1 - at_rim) * (1 + at_rim)));
}

/* Close to the critical ray |b / b_c - 1| = C zeta_a zeta_b exp(-swept inside) (connect_search.h). */
LANES_INLINE lanes guess_depth(const route *r, const scale *s, lanes swept)
{
  const int ellis = r->spacetime->kind == BENT_ELLIS;
  const course critical = course_at(r, r->critical);
  const lanes zeta = r->first.zeta * (r->endless ? lanes_all(1) : r->last.zeta);
  const lanes off = (ellis ? 8 : 216) * zeta * lanes_exp(critical.straight - swept);
  const lanes_mask below = lanes_mask_all(r->kind == PASSAGE_THROUGH) | r->first.within;
  const lanes sine = r->first.critical_sine * lanes_select(below, 1 - off, 1 + off);
  const lanes acute = lanes_angle(sine, lanes_sqrt(lanes_max((1 - sine) * (1 + sine), lanes_all(0))));
  const lanes strong = lanes_abs(acute - r->first.critical);
  lanes weak;
  if (r->kind == PASSAGE_THROUGH) {
    weak = s->range * lanes_max(1 - swept * (1 / M_PI), lanes_all(0.1));
  } else {
    const lanes b = lanes_min(guess_weak(r, swept) / r->first.lever, lanes_all(0.999));
    const lanes bent = lanes_angle(b, lanes_sqrt((1 - b) * (1 + b)));
    const lanes psi = lanes_select(swept < 2.5, guess_straight(r, swept), r->kind == PASSAGE_OUT ? M_PI - bent : bent);
    weak = s->side * (psi - r->critical);
  }
  const lanes gap = lanes_select((off < 0.5) & (sine < 1), strong, weak);
  const lanes part = lanes_min(lanes_max(gap / s->range, lanes_all(1e-12)), lanes_all(0.999));
  return -lanes_log(part);
}

/* Depth of the ray that sweeps `swept`, of lanes in *open; those without one leave *open. */
LANES_INLINE lanes search(const route *r, const scale *s, lanes swept, lanes_mask *open)
{
  const lanes tolerance = MISS_MAX * lanes_min(swept, lanes_all(1));
  lanes low = lanes_all(0), high = lanes_all(DEPTH_MAX), depth = guess_depth(r, s, swept);
  lanes before = low, miss_before = low;
  lanes_mask left = *open, found = {0};
  for (int i = 0; i < TRIALS_MAX && lanes_any(left); i++) {
    const course c = course_at(r, r->critical + s->side * gap_at(s, depth));
    const lanes miss = course_swept(r, &c) - swept;
    const lanes_mask hit = left & (lanes_abs(miss) <= tolerance), over = ~(miss < 0);
    found |= hit, left &= ~hit;
    high = lanes_select(over, lanes_min(depth, high), high), low = lanes_select(over, low, lanes_max(depth, low));
    const lanes near = lanes_min(lanes_max(-miss, lanes_all(-0.05)), lanes_all(0.05));
    const lanes secant = i == 0 ? near : -miss * (depth - before) / (miss - miss_before);
    const lanes next = depth + secant;
    const lanes_mask good = (next > low) & (next < high) & lanes_mask_all(i % 8 != 7);
    const lanes middle = lanes_min(0.5 * (low + high), low + 4);
    left &= high - low > 1e-13 * high;
    before = lanes_select(left, depth, before), miss_before = lanes_select(left, miss, miss_before);
    depth = lanes_select(left, lanes_select(good, next, middle), depth);
  }
  *open = found;
  return depth;
}

/* What one image is found to be, in lanes. */
typedef struct image {
  lanes swept;
  course course;
  lanes spread, spread_back;
  lanes share; /* 1 / spread but for the sine of the swept angle, which all images of a pair share */
} image;

/* dA/d(omega) = (l_b L_a)^2 |d(swept)/db| cos_a cos_b |sin(swept)| / b: l the length of a radian at b. */
LANES_INLINE void set_spreads(const route *r, lanes rate, lanes sine_swept, const double *radius_a, const double *radius_b,
                              image *image)
{
  const course *c = &image->course;
  lanes a, b;
  memcpy(&a, radius_a, sizeof a);
  memcpy(&b, radius_b, sizeof b);
  const lanes one = lanes_all(1), lever = r->first.lever;
  const lanes b_cosine = r->endless ? one : lanes_select(r->out_b, c->b_cosine, c->last_cosine);
  const lanes plane = lanes_abs(rate) / lever * b_cosine * lanes_select(r->out_a, c->a_cosine / lanes_abs(c->cosine), one);
  const lanes radial = lanes_abs(rate) / lever;
  const lanes across = lanes_select(c->sine < 1e-6, radial * sine_swept / image->swept, sine_swept / (lever * c->sine));
  const lanes size_b = lanes_select(lanes_is_finite(b), r->endless ? one : lanes_select(r->out_b, b, r->last.size), one);
  const lanes size_a = lanes_select(r->out_a, a, r->first.size);
  const lanes lever_a = lanes_select(r->out_a, r->lever_a, lever);
  const lanes lever_b = r->endless ? one : lanes_select(r->out_b, r->lever_b, r->last.lever);
  const lanes forth = size_b * lever_a, back = size_a * lever_b;
  const lanes core = plane * lanes_select(image->swept > 0, across, radial);
  image->spread = core * forth * forth, image->spread_back = core * back * back;
  image->share = lever * lanes_max(c->sine, lanes_all(1e-9)) / (plane * forth * forth);
}

LANES_INLINE image image_of(const route *r, const scale *s, lanes swept, lanes depth, lanes sine, const double *radius_a,
                            const double *radius_b)
{
  image image = {.swept = swept};
  const lanes gap = gap_at(s, depth), psi = r->critical + s->side * gap;
  image.course = course_at(r, psi);
  const lanes rate = course_rate(r, &image.course, gap), miss = course_swept(r, &image.course) - swept;
  const lanes step = -miss / rate;
  image.course = course_at(r, psi + lanes_select(lanes_abs(step) < 0.5 * gap, step, lanes_all(0)));
  set_spreads(r, rate, sine, radius_a, radius_b, &image);
  return image;
}

static void store(const route *r, const image *image, int lane, passage *out)
{
  const course *c = &image->course;
  const double sine = c->sine[lane], cosine = c->cosine[lane], b = r->first.lever[lane] * sine;
  out->found = isfinite(image->spread[lane]) && isfinite(c->straight[lane]);
  out->swept = image->swept[lane], out->inside = fmax(image->swept[lane] - c->straight[lane], 0);
  out->launch = (passage_direction){r->kind == PASSAGE_OUT ? cosine : -cosine, sine};
  if (r->out_a[lane]) out->launch = (passage_direction){-c->a_cosine[lane], b / r->lever_a[lane]};
  out->arrival = (passage_direction){r->endless ? 1 : c->last_cosine[lane], c->last_sine[lane]};
  if (r->out_b[lane]) out->arrival = (passage_direction){c->b_cosine[lane], b / r->lever_b[lane]};
  out->rim_sine = c->last_sine[lane];
  out->spread = image->spread[lane], out->spread_back = image->spread_back[lane];
}

/* The pairs `first` .. as a route, and their radii. */
LANES_INLINE route route_of(const passage_request *q, const lanes *a, const lanes *b)
{
  route r = {.spacetime = q->spacetime, .kind = q->kind, .endless = isinf(q->rim_b)};
  r.out_a = *a >= q->rim_a, r.out_b = (*b >= q->rim_b) & lanes_mask_all(!r.endless);
  r.first = shell_at(r.spacetime, lanes_min(*a, lanes_all(q->rim_a)));
  r.last = shell_at(r.spacetime, lanes_min(*b, lanes_all(r.endless ? q->rim_a : q->rim_b)));
  r.lever_a = r.first.lever * (*a / q->rim_a);
  r.lever_b = r.endless ? lanes_all(INFINITY) : r.last.lever * (*b / q->rim_b);
  const int outward = q->kind == PASSAGE_OUT;
  r.critical = lanes_select(lanes_mask_all(outward) & ~r.first.within, M_PI - r.first.critical, r.first.critical);
  return r;
}

static void join_lanes(const passage_request *q, size_t present, const double *most, const double *radius_a,
                       const double *radius_b, const double *angles, passage *out)
{
  lanes images, a, b, angle, sine, cosine, sum = {0};
  memcpy(&images, most, sizeof images);
  memcpy(&a, radius_a, sizeof a);
  memcpy(&b, radius_b, sizeof b);
  memcpy(&angle, angles, sizeof angle);
  lanes_sincos(angle, &sine, &cosine);
  sine = lanes_select(angle < M_PI, lanes_abs(sine), lanes_all(0));
  const route r = route_of(q, &a, &b);
  const scale s = scale_of(&r);
  lanes least = {0};
  if (q->kind == PASSAGE_ACROSS) least = course_at(&r, lanes_all(0.5 * M_PI)).straight;
  lanes_mask wanted = lanes_mask_from_bits(((unsigned)1 << present) - 1);
  for (size_t k = 0; k < q->images; k++) {
    wanted &= images > (double)k;
    if (!lanes_any(wanted)) break;
    const lanes swept = 2 * M_PI * (double)((k + 1) / 2) + (k % 2 ? -angle : angle);
    lanes_mask found = wanted & ((swept > least) | (lanes_mask_all(q->kind != PASSAGE_ACROSS) & (swept == 0)));
    const lanes depth = search(&r, &s, swept, &found);
    if (!lanes_any(found)) continue;
    const image image = image_of(&r, &s, swept, depth, sine, radius_a, radius_b);
    wanted &= ~(found & ~(image.share >= q->min_share * sum));
    sum += lanes_select(found, image.share, lanes_all(0));
    for (unsigned left = lanes_bits(found & wanted); left; left &= left - 1) {
      const int lane = __builtin_ctz(left);
      store(&r, &image, lane, &out[(size_t)lane * q->images + k]);
    }
  }
}

void BENT_KERNEL(bent_passages)(const passage_request *request, size_t n, const size_t *images, const double *radius_a,
                                const double *radius_b, const double *angle, passage *out)
{
  for (size_t i = 0; i < n * request->images; i++) out[i].found = 0;
  for (size_t first = 0; first < n; first += LANES) {
    double most[LANES], a[LANES], b[LANES], phi[LANES];
    for (size_t i = 0; i < LANES; i++) {
      const size_t at = first + i < n ? first + i : n - 1;
      most[i] = (double)images[at], a[i] = radius_a[at], b[i] = radius_b[at], phi[i] = angle[at];
    }
    join_lanes(request, n - first < LANES ? n - first : LANES, most, a, b, phi, out + first * request->images);
  }
}
