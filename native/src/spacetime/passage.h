/* Rays that join two ends by way of one lens sphere, or by way of both mouths of a wormhole: bent inside, straight outside.
 *
 * In the plane of the ends and the center such a ray is its impact parameter b, and what it sweeps is a sum:
 *     E(r_0, x_0) - E(r_1, x_1) + sum over ends outside of (asin(p / R) - asin(p / d)),
 * where E(r, x) is the angle swept from radius r at the angle x to the outward radial on to infinity (endpoint.h), r_0 and
 * r_1 are the radii at which the ends, or their sides' spheres of radius R, stand, and p = R sin(x) at the sphere, through
 * which directions go unchanged. In the lens, and at its rim, neighboring rays of the plane only diverge (the optical
 * metric has negative curvature: Gibbons & Werner 2008; the rim adds more of it): so the sum grows steadily towards the
 * critical ray, where it diverges, and each image exists once: all that sweep more than the ray that grazes the sphere,
 * for which the straight line stands, or all if an end is inside or they are joined through the throat.
 */
#ifndef BENT_SPACETIME_PASSAGE_H
#define BENT_SPACETIME_PASSAGE_H
#include <stddef.h>

#include "base/isa.h"
#include "bentlight/spacetime.h"

typedef enum passage_kind {
  PASSAGE_ACROSS, /* both ends outside, on the same side */
  PASSAGE_OUT,    /* a inside, b outside, on the same side */
  PASSAGE_THROUGH /* from one side of the throat to the other, each end inside or outside (Ellis) */
} passage_kind;

typedef struct passage_request {
  const bent_spacetime *spacetime; /* Schwarzschild or Ellis */
  passage_kind kind;
  double rim_a, rim_b; /* chart radii of the spheres on each end's side: outside the photon sphere or throat. rim_b may be
                        * INFINITY: the far sky of a wormhole without exit */
  size_t images;       /* room for those of each pair */
  double min_share;    /* a pair's list ends before an image fainter than this share of those before */
} passage_request;

/* Directions of travel at an end: cosine to the outward radial, and sine in the sense in which the ray turns. */
typedef struct passage_direction {
  double cosine, sine;
} passage_direction;

typedef struct passage {
  int found;
  double swept, inside; /* angle in all, and inside the spheres */
  passage_direction launch, arrival;
  double rim_sine; /* of the angle to the outward radial at which the ray leaves, or would leave, b's sphere */
  /* dA / d(omega), chart units^2, as bent_connections has it (in the sky: solid angle), from a to b and from b to a.
   * Finite; 0 with ends in line. Relative error: 3e-7 at most, measured against traced rays. */
  double spread, spread_back;
} passage;

/* At most images[i] <= request->images of each of n pairs of ends at these chart radii (b: INFINITY in the sky) that see an angle of 0 .. pi between them from the
 * center; through a throat the angle is that of the chart that goes on beyond it. Image k of pair i is
 * out[i * request->images + k]; its swept angle is angle, 2 pi - angle, 2 pi + angle, ... for k = 0, 1, 2, ... */
BENT_DECLARE_KERNEL(void, bent_passages,
                    (const passage_request *request, size_t n, const size_t *images, const double *radius_a, const double *radius_b,
                     const double *angle, passage *out))
#endif
