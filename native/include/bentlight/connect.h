/* Connections: all light rays that join two given points, or a point and a direction of the sky.
 *
 * Where an ordinary renderer has one straight shadow ray and 1 / distance^2, curved space has a whole series of rays,
 * in order of the angle swept about the center: the primary image phi, the secondary 2 pi - phi, the relativistic
 * images 2 pi + phi, 4 pi - phi, ..., where phi in [0, pi] is the angle between the two ends. Outside a horizon, and on
 * both sides of a wormhole's throat, each of them exists exactly once. From the secondary on each is fainter than the
 * one before, by e^-2 pi every two; the primary is the brightest, unless phi is close to 0: a caustic of the others.
 *
 * Flat space has its one straight ray. A Kerr hole with spin has the same images, in the same order, as long as phi is
 * the angle between a and b in axes that the hole drags along as the ray goes: each image has its own. Where without
 * spin the line through the center is a caustic, with spin it is a narrow tube of astroid cross section, moved aside by
 * the dragging; within it two more images exist, and which are listed is left open. Near the horizon of a fast hole not
 * every image is found. Those of random pairs that are (first / second), radii even in the logarithm: a = 0.9 M, 3 to
 * 100 horizons: 99.99 % / 99.98 %; 1.001 to 1000 horizons: 99.9 % / 99.9 %; a = 0.999 M: 99.99 % / 99.95 % and 99.2 % /
 * 98.9 %. The others are FAILED.
 * Unlike those of the other spacetimes, Kerr rays that join b with a are not those that join a with b: against time the
 * hole spins the other way. Rays are traced against time, from a: the light goes from b to a, as in trace.h.
 */
#ifndef BENTLIGHT_CONNECT_H
#define BENTLIGHT_CONNECT_H
#include <stddef.h>
#include "bentlight/spacetime.h"

/* The eighth image is e^-7 pi = 3e-10 fainter than the first; of later ones double precision hardly knows the way. */
#define BENT_CONNECT_IMAGES_MAX 8

typedef enum bent_connection_status {
  BENT_CONNECTION_NONE = 0,   /* too faint, or space is flat: no image, all values NaN */
  BENT_CONNECTION_MET = 1,    /* found, its error is within the tolerance */
  BENT_CONNECTION_RING = 2,   /* the same, but a, the center and b are in line: one ray of a ring, spread 0; Kerr: in
                               * line
                                 along the axis */
  BENT_CONNECTION_COARSE = 3, /* found, but its error is beyond the tolerance: `error` says how large */
  BENT_CONNECTION_FAILED = 4  /* not found, or the ends coincide: all values but `swept` NaN */
} bent_connection_status;

/* How many images of a call have each status; their sum is n * max_images. */
typedef struct bent_connection_count {
  size_t none, met, ring, coarse, failed;
} bent_connection_count;

/* Caller-owned arrays of n * max_images entries, image k of pair i at i * max_images + k; any pointer may be NULL. */
typedef struct bent_connections {
  uint8_t *status;       /* bent_connection_status */
  double (*launch)[3];   /* local unit direction at a in which the ray leaves */
  double (*arrival)[3];  /* local unit direction of travel in which it reaches b */
  /* dA / d(omega): area at b, across the ray, that a thin cone of rays from a covers, over the solid angle of the cone
   * at a, in local measures: length^2. Flat space: distance^2. Its inverse is the geometric factor that stands for
   * 1 / distance^2; spread / g is the same both ways (Etherington 1933). It is the product of a width in the plane of
   * the orbit, which never vanishes, and one across it, which is proportional to sin(phi): with a, the center and b in
   * line it is 0 (a caustic). If b is in the sky: solid angle of sky per solid angle at a; flat space: 1. Relative
   * error at tolerance 1e-8, two images, ordinary pairs: 1e-8.
   * Kerr: area that a ZAMO at b measures, any observer the same; spread / g is that of the way back in the hole of the
   * other spin. What rests in the chart moves past the ZAMO, with velocity v (bent_zamo_speed; against time, so along
   * +phi for positive spin): a piece of it with local area vector A gets rays from the solid angle
   * |A.(n + v)| / (spread (1 + n.v)) at a, where n is the arrival. Relative error: 3 (median), 20 (99 %) times the
   * tolerance. */
  double *spread;
  double *frequency_ratio; /* g = nu(a) / nu(b) of light from b to a, both at rest: lapse(b) / lapse(a); Kerr: of
                            * ZAMOs */
  /* Angle swept about the center, radians; exact: it defines the image. Kerr: as trace.h has it, in axes that the hole
   * drags along, with the error that it has there; of a failed image the one that was looked for, about. */
  double *swept;
  /* Estimated distance at which a ray launched in this direction misses b, over the scene radius of b; if b is in the
   * sky, the angle to the wanted direction. Images far along the series are COARSE: their landing points magnify the
   * rounding of the launch direction by e^swept. Measured on 3e5 random pairs, in Kerr on 2000: never less than the
   * true miss. */
  double *error;
} bent_connections;

/* points_a, points_b: (n, 3) positions in the chart, outside the horizon. In a wormhole points closer than half the
 * throat radius stand on the far side; directions there are those of the same continuous chart, whose "outward" points
 * to the throat. max_images: 1 to BENT_CONNECT_IMAGES_MAX a pair. min_share: in [0, 1); a pair's list ends before the
 * first image whose 1 / spread is below this share of the sum over the images before it. tolerance: wanted `error`,
 * positive. count: may be NULL. progress: counts pairs; may be NULL. A pair's answer depends on that pair alone. Pairs
 * in line have the same ring twice, as the limit of two images.
 *
 * Method: in x(t), t from 0 to 1 along the ray, the orbit with swept angle Phi obeys x'' = Phi^2 F(x) with x = M / r,
 * F = 3 x^2 - x (Darwin 1959), or x = arctan(l / rho), F = sin x cos x (Ellis 1973), for radial rays (Phi = 0) and to
 * infinity as well. x(1) grows steadily with the launch slope x'(0): a bracketed Newton search finds it. Each trial
 * integrates the orbit by Taylor series, and its derivative by the slope, which is the deviation in the plane.
 * Kerr: Newton's method for launch direction and Mino time, from the orbit without spin between corresponding places;
 * the trials integrate the ray and its deviations by Taylor series. An image counts as found when the final trial, at
 * full precision, comes to b but for the tolerance. Newton's next step is still taken, to first order: `error` is what
 * that leaves and what truncation and rounding may add. About 8 times the time of an image pair without spin, 9 to
 * 10 times where points come near the horizon. */
bent_status bent_connect(const bent_spacetime *spacetime, size_t n, const double (*points_a)[3],
                         const double (*points_b)[3], size_t max_images, double min_share, double tolerance,
                         const bent_connections *out, bent_connection_count *count, bent_progress *progress,
                         bent_error *error);

/* The same with b in the sky, at the asymptotic angular positions `directions`, (n, 3) of any nonzero length. far_side:
 * not 0 for the sky beyond a wormhole's throat, where arrival directions are minus the angular positions (Ellis). */
bent_status bent_connect_sky(const bent_spacetime *spacetime, size_t n, const double (*points)[3],
                             const double (*directions)[3], int far_side, size_t max_images, double min_share,
                             double tolerance, const bent_connections *out, bent_connection_count *count,
                             bent_progress *progress, bent_error *error);
#endif
