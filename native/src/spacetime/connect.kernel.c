/* Connections of LANES pairs at a time, image by image: geometry of the pair, root search, results. */
#include "spacetime/connect.h"

#include "spacetime/connect_plane.h"
#include "spacetime/connect_search.h"

/* Truncation error of a step of the first trial. */
#define ORBIT_TRUNCATION 1e-6

typedef struct image {
  lanes_mask status;
  lanes launch[3], arrival[3], spread, frequency_ratio, swept, error;
} image;

/* Image `order` of the lanes in `wanted`. share: 1 / spread up to the sin(phi) that all images of a pair share. */
LANES_INLINE image image_of(const bent_spacetime *s, const pair_plane *pair, const connect_request *request, int order,
                            lanes_mask wanted, lanes *share)
{
  const int ellis = s->kind == BENT_ELLIS;
  const orbit_end *a = &pair->a, *b = &pair->b;
  const lanes turn = lanes_all(order & 1 ? -1 : 1);
  const lanes swept = 2 * M_PI * ((order + 1) / 2) + turn * pair->angle;
  const search_precision precision = {request->tolerance, ORBIT_ORDER, ORBIT_TRUNCATION};
  const orbit_root root = search_root(ellis, a, b, swept, search_guess(ellis, a, b, swept), precision, wanted);
  image image = {.swept = swept, .error = root.error};
  direction_of(ellis, a, pair->toward_a, turn, swept, root.size, root.rate, image.launch);
  direction_of(ellis, b, pair->toward_b, turn, swept, root.size, root.arrival_rate, image.arrival);
  /* Widths of the cone at b: eta size / (w_a w_b lapse_a) in the plane, sin(Phi) / Phi size / (w_a w_b lapse_a) across.
   * */
  const double length = request->sky ? 1 : ellis ? s->throat_radius : s->mass;
  const lanes scale = length * root.size / (a->w * a->lapse * (request->sky ? lanes_all(1) : b->w));
  const lanes across = lanes_select(swept > 0, pair->sine / swept, lanes_all(1));
  image.spread = lanes_abs(root.eta * across) * scale * scale;
  image.frequency_ratio = b->lapse / a->lapse;
  *share = swept / lanes_max(lanes_abs(root.eta) * scale * scale, lanes_all(1e-300));
  const lanes_mask ring = (pair->sine == 0) & (swept > 0);
  const lanes_mask sound =
      root.found & lanes_is_finite(image.spread) & lanes_is_finite(image.launch[0] + image.arrival[0]);
  const lanes_mask good = root.error <= request->tolerance;
  const lanes_mask met = (ring & BENT_CONNECTION_RING) | (~ring & BENT_CONNECTION_MET);
  image.status = (sound & good & met) | (sound & ~good & BENT_CONNECTION_COARSE) | (~sound & BENT_CONNECTION_FAILED);
  return image;
}

/* Lane `lane` of `image` is entry `at`; an image that was not found has no values. */
static void store(const image *image, int lane, size_t at, const bent_connections *out, bent_connection_count *count)
{
  const bent_connection_status status = (bent_connection_status)image->status[lane];
  const int known = status != BENT_CONNECTION_NONE && status != BENT_CONNECTION_FAILED;
  size_t *const counters[] = {&count->none, &count->met, &count->ring, &count->coarse, &count->failed};
  ++*counters[status];
  if (out->status) out->status[at] = (uint8_t)status;
  if (out->spread) out->spread[at] = known ? image->spread[lane] : NAN;
  if (out->frequency_ratio) out->frequency_ratio[at] = known ? image->frequency_ratio[lane] : NAN;
  if (out->swept) out->swept[at] = status != BENT_CONNECTION_NONE ? image->swept[lane] : NAN;
  if (out->error) out->error[at] = known ? image->error[lane] : NAN;
  for (int k = 0; k < 3; k++) {
    if (out->launch) out->launch[at][k] = known ? image->launch[k][lane] : NAN;
    if (out->arrival) out->arrival[at][k] = known ? image->arrival[k][lane] : NAN;
  }
}

static void connect_lanes(const bent_spacetime *s, const pair_plane *pair, const connect_request *request, size_t first,
                          size_t present, const bent_connections *out, bent_connection_count *count)
{
  lanes_mask wanted = lanes_mask_from_bits(((unsigned)1 << present) - 1);
  lanes sum = {0};
  for (int order = 0; order < (int)request->max_images; order++) {
    image image = {.status = {0}};
    if (lanes_any(wanted)) {
      lanes share;
      image = image_of(s, pair, request, order, wanted, &share);
      wanted &= (image.status == BENT_CONNECTION_FAILED) | (share >= request->min_share * sum);
      image.status &= wanted;
      sum += lanes_select(lanes_is_finite(share), share, lanes_all(0));
    }
    for (size_t i = 0; i < present; i++)
      store(&image, (int)i, (first + i) * request->max_images + (size_t)order, out, count);
  }
}

void BENT_KERNEL(bent_connect_pairs)(const bent_spacetime *spacetime, size_t n, const double (*a)[3],
                                     const double (*b)[3], const connect_request *request, const bent_connections *out,
                                     bent_connection_count *count)
{
  for (size_t first = 0; first < n; first += LANES) {
    lanes from[3], to[3];
    lanes_load_rows(a, NULL, first, n, from);
    lanes_load_rows(b, NULL, first, n, to);
    pair_plane pair;
    if (spacetime->kind == BENT_ELLIS) {
      ellis_end(spacetime, from, 0, 0, &pair.a);
      ellis_end(spacetime, to, request->sky, request->far_side, &pair.b);
    } else {
      schwarzschild_end(spacetime, from, 0, &pair.a);
      schwarzschild_end(spacetime, to, request->sky, &pair.b);
    }
    plane_of(&pair);
    connect_lanes(spacetime, &pair, request, first, n - first < LANES ? n - first : LANES, out, count);
  }
}
