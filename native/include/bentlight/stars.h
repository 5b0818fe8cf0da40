/* Stars: points of the sky without size, as the camera sees them through bent space.
 *
 * A star brings an irradiance E to whoever faces it. Bending shows it in several places of the picture, and there makes
 * it brighter by the magnification, solid angle at the camera per solid angle of sky: radiance stays, images grow. Both
 * are known by connections (connect.h) instead of chance, so that stars neither flicker nor have noise.
 */
#ifndef BENTLIGHT_STARS_H
#define BENTLIGHT_STARS_H
#include "bentlight/render.h"

enum { BENT_STAR_IMAGES_MAX = 32 }; /* of one star, on both sides of a throat */

/* A star exactly behind a hole is a ring of boundless brightness, if it has no size. These have one: the magnification mu
 * of an image is bounded as mu / (1 + (mu / limit)^4)^(1/4), where limit is this, and for images that sweep more than pi
 * less, like their light, e^-(swept - pi). With the whole limit that changes mu by 2.5e-9 at 1, by 2.5e-5 at 10 and by
 * 1.5 % at 50, and belongs to stars as wide as about a hundredth of their ring. */
#define BENT_STAR_MAGNIFICATION_MAX 100.0

/* The picture, and what may hide a star. */
typedef struct bent_star_view {
  uint32_t width, height; /* pixels, 1 to 65536 */
  double margin;          /* pixels around the picture whose images count too, at least 0 */
  double tolerance;       /* of rays, as in bent_render_settings */
  uint32_t transparent_bounces;
} bent_star_view;

/* Caller-owned arrays: image k of star i is entry i * BENT_STAR_IMAGES_MAX + k, k < count[i]. */
typedef struct bent_star_images {
  int32_t *count;         /* (n) */
  double (*place)[2];     /* in the picture, in [0, 1] from its left and bottom edges; a margin beyond */
  double (*throughput)[3]; /* magnification, times what transparent surfaces in front of a pinhole let through; linear RGB */
  double (*parallax)[2][2]; /* [coordinate][axis]: change of the place per scene unit along an axis of the lens; 0 for a pinhole */
  double *solid_angle;    /* of directions per area of the picture there, which is 1 as a whole */
  double *swept;          /* about spacetime objects, radians: in [0, pi] the primary image, in [pi, 2 pi] the secondary ... */
} bent_star_images;

/* Finds the images of stars in the sky directions `directions`, (n, 3) of any length but 0, that the camera of a committed
 * scene sees. A ray along each is traced: what surfaces or holdouts hide is not listed. Of the images that a lone object
 * makes, those fainter than 1e-4 of the ones before are left out, around a spinning hole all after the second, where
 * connections that fail (connect.h) are made up for by Newton's method on traced rays; light by way of two objects, or of
 * a spinning one among several, is not known. Relative error of magnifications: 1e-6, around spinning holes 1e-4. A star's answer depends on that star alone. Panoramas of more than
 * a whole turn show stars several times; of more than 32 places of one star the others are left out. An orthographic camera
 * sees no single directions: BENT_ERROR_ARGUMENT (bent_scene_shows_stars). progress counts stars.
 * Through a lens that is open, images are listed that the blur brings into the picture, and also those that are hidden: see
 * bent_scene_trace_star_cells. */
bent_status bent_scene_find_stars(const bent_scene *scene, size_t n, const double (*directions)[3],
                                  const bent_star_view *view, const bent_star_images *out, bent_progress *progress,
                                  bent_error *error);
/* Nonzero if the scene has a camera in whose picture stars have a place. */
int bent_scene_shows_stars(const bent_scene *scene);

/* ---- A lens that is open ----
 *
 * In the picture that a place on the lens sees, a star's image is moved in proportion to that place: by the parallax. All
 * places together show a figure of the lens itself, on its side and squeezed near a hole, whose images are as near as it is.
 * The lens is cut into cells, each of which sees an image or does not. */

/* How many cells along both sides of the lens there are for a picture of that size; 0, 0 for a pinhole. */
void bent_scene_star_cells(const bent_scene *scene, uint32_t width, uint32_t height, uint32_t cells[2]);
/* The cells' corners, places on the lens in scene units, (cells[0] + 1, cells[1] + 1); of a pinhole nothing is written. */
void bent_scene_star_lens(const bent_scene *scene, const uint32_t cells[2], double (*corners)[2]);
/* seen, (n, cells[0], cells[1], 3): what surfaces let through on the way from images to cells, by rays to cells' middles: to
 * every third one along both sides, and to the others where those do not all see the same. Errors as of
 * bent_scene_find_stars; for a pinhole, which has no cells, BENT_ERROR_ARGUMENT. */
bent_status bent_scene_trace_star_cells(const bent_scene *scene, size_t n, const double (*places)[2],
                                        const double (*parallax)[2][2], const bent_star_view *view,
                                        const uint32_t cells[2], float (*seen)[3], bent_progress *progress,
                                        bent_error *error);

/* Where stars are drawn: the tile (x, y, width, height) of a picture, pixels (height, width, 3) of linear RGB, rows from the
 * bottom, and the pixel filter. */
typedef struct bent_star_canvas {
  uint32_t width, height; /* of the picture */
  bent_filter_kind filter;
  double filter_width;
  uint32_t tile[4];
  float (*pixels)[3];
} bent_star_canvas;

/* Adds n images, at `places` as above. light: the radiance that each image had if it were spread evenly over the whole
 * picture, E * throughput / solid_angle. It is shared among pixels by the pixel filter, whose weights are made to add up to 1
 * wherever the image lies, pixels outside of the picture included: light is conserved exactly. The result is the same
 * to the last bit for any tiles. */
bent_status bent_stars_draw(const bent_star_canvas *canvas, size_t n, const double (*places)[2], const double (*light)[3],
                            bent_error *error);
/* The same through an open lens: the light of an image is shared among cells in proportion to
 * how they see it, (n, cells[0], cells[1], 3), and spread evenly over each. */
bent_status bent_stars_draw_blurred(const bent_star_canvas *canvas, size_t n, const double (*places)[2],
                                    const double (*light)[3], const double (*parallax)[2][2], const uint32_t cells[2],
                                    const double (*corners)[2], const uint8_t (*seen)[3], bent_error *error);
#endif
