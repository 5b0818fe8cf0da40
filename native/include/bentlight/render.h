/* Path tracing of a committed scene by tiles: the camera, suns, settings, channels, and the call that renders. */
#ifndef BENTLIGHT_RENDER_H
#define BENTLIGHT_RENDER_H
#include "bentlight/intersect.h"

/* Projections as Blender's Cycles defines them. In camera space the view is along -z, x points right and y up. */
typedef enum bent_camera_kind {
  BENT_CAMERA_PERSPECTIVE,
  BENT_CAMERA_ORTHOGRAPHIC,
  BENT_CAMERA_EQUIRECTANGULAR,
  BENT_CAMERA_EQUIANGULAR_CUBEMAP_FACE,
  BENT_CAMERA_MIRRORBALL,
  BENT_CAMERA_FISHEYE_EQUIDISTANT,
  BENT_CAMERA_FISHEYE_EQUISOLID,
  BENT_CAMERA_FISHEYE_LENS_POLYNOMIAL,
  BENT_CAMERA_CENTRAL_CYLINDRICAL,
  BENT_CAMERA_KINDS
} bent_camera_kind;

enum { BENT_APERTURE_BLADES_MAX = 64 }; /* whose polygon has the area of the disk around it to 0.2 % */

/* The opening of the camera's lens, for depth of field, in the plane of x and y around the camera's place; in panoramas
 * across each ray, x towards the axis of sight (in a mirror ball towards camera space's x). */
typedef struct bent_aperture {
  double radius;         /* scene units; 0: a pinhole, and what follows is ignored */
  double focal_distance; /* of what is sharp, positive: depth, in panoramas distance, in the camera's own straight space */
  uint32_t blades;       /* corners of a regular polygon of that circumradius, at most BENT_APERTURE_BLADES_MAX;
                          * below 3 a disk */
  double rotation;       /* of the polygon, radians: the middle of a side lies there, from x towards y */
  double ratio;          /* positive: how much narrower than high it is squeezed (anamorphic bokeh) */
} bent_aperture;

/* Parameters of a kind that is not used are ignored. Angles in radians. */
typedef struct bent_camera {
  bent_camera_kind kind;
  double world_from_camera[4][4]; /* affine; the scale of each axis is removed */
  /* What the image covers: left, right, bottom, top. Perspective: on the plane at distance 1; orthographic: scene
   * units; panoramic: the projection's own (u, v), which is 0, 1, 0, 1 for the whole panorama. */
  double viewplane[4];
  double clip_start, clip_end; /* depth for perspective and orthographic, distance for panoramic; clip_end >
                                * clip_start */
  double longitude[2], latitude[2];      /* equirectangular: at u, v = 0 and 1 */
  double fisheye_fov;                    /* fisheye: full angle of view */
  double fisheye_lens;                   /* equisolid: focal length, mm */
  double sensor_width, sensor_height;    /* equisolid, polynomial: mm */
  double fisheye_polynomial[5];          /* k0 .. k4: angle = -(k0 + k1 r + ... + k4 r^4), r in mm */
  double cylinder_longitude[2], cylinder_height[2], cylinder_radius; /* central cylindrical */
  bent_aperture aperture;
} bent_camera;

/* Like every edit, this takes a bent_scene_commit to become visible. */
bent_status bent_scene_set_camera(bent_scene *scene, const bent_camera *camera, bent_error *error);

/* A sun is a disk on the asymptotic sky: a ray that escapes in its direction sees it. */
typedef struct bent_sun {
  double direction[3]; /* towards the sun, world; any length but 0 */
  double radiance[3];  /* linear RGB, added to the sky's; if the angle is 0: irradiance of a surface that faces the
                        * sun */
  int material;        /* -1, or the radiance is what its program emits: at the place in the direction away from the sun
                        * at distance 1 from the origin, with texture coordinates that map the disk into the unit
                        * square */
  double world_from_sun[4][4]; /* with a material: of its object coordinates, invertible and affine */
  double angle;        /* angular diameter, in [0, pi]; 0: a point that only connections find */
  uint32_t visibility; /* bent_visibility bits: the kinds of ray that see it */
  bent_influence influence;
} bent_sun;

/* Replaces all suns. Irradiance of a surface that faces a sun: pi sin^2(angle/2) radiance. */
bent_status bent_scene_set_suns(bent_scene *scene, size_t count, const bent_sun *suns, bent_error *error);

/* A lamp without size, which only connections find. Lamps with a size are instances of emissive meshes. */
typedef struct bent_lamp {
  double world_from_lamp[4][4]; /* invertible and affine: the lamp's place, and the object coordinates of its
                                 * material */
  int material;        /* the radiance that its program emits towards a direction is the lamp's radiant intensity
                        * there */
  uint32_t visibility; /* bent_visibility bits: the kinds of scattering that it lights */
  bent_influence influence;
} bent_lamp;

/* Replaces all lamps. */
bent_status bent_scene_set_lamps(bent_scene *scene, size_t count, const bent_lamp *lamps, bent_error *error);

/* How lamps, emissive surfaces and the sky are found. The mean of a picture is the same (but for points of light and
 * caustics, which each finds only one of), its noise is not. */
typedef enum bent_light_sampling {
  BENT_LIGHTS_BOTH,        /* weighed against each other (Veach & Guibas 1995, power heuristic) */
  BENT_LIGHTS_SCATTERING,  /* by scattered rays that happen to meet them */
  BENT_LIGHTS_CONNECTIONS, /* by rays that join a point on a light with the surface, where such rays are known */
  BENT_LIGHT_SAMPLINGS
} bent_light_sampling;

/* How light is followed. The mean of a picture is the same, but for points of light behind glass or in mirrors, and
 * their caustics, which only BIDIRECTIONAL finds. */
typedef enum bent_integrator {
  BENT_PATH,          /* from the camera */
  BENT_BIDIRECTIONAL, /* from the lamps too, each way weighed against the others; light_sampling must be BOTH. Suns, the
                       * sky, and lamps that do not shine on all objects are followed from the camera alone; so is
                       * everything where bent_scene_bidirectional_obstacle says why. There is no blur_glossy, and all
                       * caustics are there */
  BENT_INTEGRATORS
} bent_integrator;

typedef enum bent_filter_kind { BENT_FILTER_BLACKMAN_HARRIS, BENT_FILTER_GAUSSIAN, BENT_FILTER_BOX } bent_filter_kind;

/* How the random numbers of neighboring pixels belong together. */
typedef enum bent_sampling_pattern {
  BENT_PATTERN_BLUE_NOISE, /* so that their errors cancel: noise is fine-grained, at every number of samples */
  BENT_PATTERN_CLASSIC,    /* not at all */
  BENT_SAMPLING_PATTERNS
} bent_sampling_pattern;

typedef struct bent_render_settings {
  uint32_t width, height;              /* of the full image, pixels */
  uint32_t first_sample, sample_count; /* the samples of each pixel to take; first_sample + sample_count < 2^31 */
  uint32_t seed;
  bent_sampling_pattern sampling_pattern;
  /* A pixel gets no more samples once its noise is below the threshold: the standard errors of red, green and blue
   * (from means of 8 successive samples), summed, times sqrt(2/pi), over sqrt(red + green + blue). 0: all pixels get
   * all samples. min_samples >= 2: those that every pixel gets at least. Which samples are taken depends on those
   * before, so that means are biased, by less than the threshold. */
  double noise_threshold;
  uint32_t min_samples;
  /* Near the image of a photon sphere the camera sees the whole scene many times over, pressed into fine rings. A pixel
   * there takes m samples where another takes one, its own numbers m k .. m k + m - 1 for the other's number k: one
   * more for every 0.1 radians by which bending spreads the camera rays through its corners, and at most
   * photon_ring_samples, in [1, 64]. At 1 all pixels are alike. */
  uint32_t photon_ring_samples;
  /* The state holds all samples before first_sample already, and is gone on with: as if one call had taken all, the noise
   * threshold's decisions included. Without a state the channels do, to float rounding: sample_count must be among them,
   * and with a noise threshold combined, noise_partial and noise_scatter. */
  int resume;
  /* Scattering events a path may have before its last one, which still gathers emission: as Cycles counts bounces.
   * The total, and by kind of lobe. Straight passes through transparent surfaces are counted apart. */
  uint32_t max_bounces, diffuse_bounces, glossy_bounces, transmission_bounces, transparent_bounces;
  uint32_t roulette_start;   /* bounces before Russian roulette may end a path */
  double tolerance;          /* wanted angular error of each ray, radians, in (0, 0.1]; see bent_scene_render_tile */
  bent_filter_kind filter;
  double filter_width;       /* full support in pixels, in [0.01, 30]; the box is always one pixel wide */
  /* Equirectangular images of the sky that the camera sees, directly or through transparency, are averaged around each ray,
   * by a Gaussian of this standard deviation in pixels, in [0, 1], as bending maps them to the sky; where a pixel takes m
   * samples for another's one, by 1 / sqrt(m) of that. 0: not at all. 1 / sqrt(samples), the distance between a pixel's
   * samples, takes away most of the noise of details that are small beside a pixel: their light falls on many samples, in
   * any place. It goes to 0 as more samples do without. */
  double sky_filter;
  int film_transparent;      /* the sky seen by the camera has alpha 0 and no color in `combined` */
  double clamp_direct;       /* largest contribution (mean of RGB) of light scattered once at most; 0: off */
  double clamp_indirect;     /* the same of light scattered more often */
  /* Cycles' Filter Glossy: after a scattering of pdf p, the least of the path's, microfacets are at least as rough as
   * alpha = sqrt(1 - p / blur_glossy) / 2. Less noise of caustics, but blurred. 0: off. */
  double blur_glossy;
  int caustics_reflective, caustics_refractive; /* 0: rays that were scattered diffusely see no reflection, or no
                                                 * refraction, by microfacets: the caustics are missing */
  bent_integrator integrator;
  bent_light_sampling light_sampling;
  int portal_sampling;       /* some scattered rays are aimed at wormholes' mouths; the mean is the same */
  double light_threshold;    /* connections that would bring a sample less than this are traced by chance only; 0:
                              * all */
  double alpha_threshold;    /* surfaces less opaque than this are not described by depth, position and normal */
  uint32_t light_groups, aovs, matte_ranks; /* items in the channels of lists (bent_items), at most BENT_ITEMS_MAX */
  double mist_start, mist_depth, mist_falloff; /* of the channel mist: lengths, and the power of what is between */
  double occlusion_distance; /* of ambient_occlusion */
} bent_render_settings;
enum { BENT_ITEMS_MAX = 1024 };

/* How the samples of a pixel become its value. */
typedef enum bent_reduction {
  BENT_MEAN,  /* mean over the samples taken */
  BENT_MAX,   /* largest over the samples taken */
  BENT_FIRST, /* the value of the first sample of the range, as Cycles does for depth and position */
  BENT_COUNT, /* the number of samples taken */
  BENT_MATTE, /* coverage of each name, summed over the samples and divided by their number, the largest first */
  BENT_STATE  /* what a call that resumes goes on with; of no use otherwise */
} bent_reduction;

/* Of what a channel has its components. */
typedef enum bent_items {
  BENT_SINGLE,
  BENT_PER_LIGHT_GROUP, /* as many as the settings say */
  BENT_PER_AOV,
  BENT_PER_RANK
} bent_items;

typedef struct bent_channel {
  const char *name;
  int components; /* of each item */
  bent_reduction reduction;
  const char *description;
  bent_items items;
} bent_channel;

/* The one table of what a render can deliver. */
const bent_channel *bent_render_channels(size_t *count);
enum { BENT_CHANNELS_MAX = 48 };

/* What happened in a call; for reports. */
typedef struct bent_render_statistics {
  uint64_t samples;    /* pixel samples finished; 0 when a resumed call found no pixel that wants more */
  uint64_t rays;       /* rays traced, all bounces */
  uint64_t unresolved; /* rays whose tolerance could not be met: black, and pi in the channel `error` */
  uint64_t invalid;    /* samples that came out NaN or infinite (broken input): counted black */
  /* Curved rays that connections between two places, or a place and the sky, have looked for; and those of them that exist
   * but were not found, or not exactly enough (connect.h). Their light comes by scattering, and that of lamps without size
   * not at all. */
  uint64_t joins, lost_joins;
} bent_render_statistics;

/* Of the light that subpaths from lamps bring. */
#define BENT_LIGHT_UNIT 0x1p-32

/* Renders the tile [x, x + width) x [y, y + height), pixels counted from the image's bottom left, into channels[i]:
 * float (height, width, components * items) of the i-th channel, row by row from the bottom, or NULL where not wanted.
 *
 * Every random number is a function of (seed, pixel, sample, dimension), and a pixel's samples are its own, so the
 * result does not depend, to the last bit, on tiles, their order or threads; and merging the states of two sample ranges
 * gives the state of the range that spans both.
 *
 * Tolerance: rays are traced to `tolerance` radians, or a tenth of the central pixel's angle if that is smaller; after
 * a diffuse scattering, which blurs what is seen, ten times more coarsely. Chords stay within that angle times the
 * distance from the ray's origin to the nearest spacetime object of the true ray.
 *
 * Radiance is carried along rays as it is: no shift of frequency, and so no g^3, between emitter and camera.
 *
 * state: NULL, or bent_render_state_width numbers for each pixel, rows from the bottom: what its samples add up to. What a
 * call leaves there can be gone on with, merged and developed without any rounding.
 *
 * light: NULL, or with BENT_BIDIRECTIONAL the light that subpaths from lamps bring to the camera itself, anywhere in
 * the image: (height, width, 3) of the full image, rows from the bottom, shared by all calls and threads, to which each
 * adds in units of BENT_LIGHT_UNIT. Sums of whole numbers do not depend on their order. With N samples taken in all
 * calls together, a pixel's color is `combined` + light * BENT_LIGHT_UNIT * width * height / N. Each pixel's sum must
 * stay below 2^31. What clamp limits is each contribution; the noise threshold looks at `combined` only.
 *
 * progress counts pixel samples, those of photon rings as one where another pixel takes one. On BENT_CANCELLED the
 * channels hold what was finished: the channel sample_count says how many samples each pixel has (0: all its channels
 * are 0). */
bent_status bent_scene_render_tile(const bent_scene *scene, uint32_t x, uint32_t y, uint32_t width, uint32_t height,
                                   const bent_render_settings *settings, float *const channels[BENT_CHANNELS_MAX],
                                   double *state, int64_t (*light)[3], bent_render_statistics *statistics,
                                   bent_progress *progress, bent_error *error);
/* Numbers in the state of each pixel of a render that wants the channels with a byte that is not 0. */
size_t bent_render_state_width(const bent_render_settings *settings, const uint8_t wanted[BENT_CHANNELS_MAX]);
/* Adds to the states of `pixels` pixels those of other samples of theirs, of a render with the same settings and wanted
 * channels. In any order the result is the same to the last bit while sums of magnitudes stay below 2^41 and there are
 * fewer than 2^21 samples a pixel, and no pixel has more names than matte_ranks. Where both have samples, there must have been
 * no noise threshold. */
void bent_render_state_merge(const bent_render_settings *settings, const uint8_t wanted[BENT_CHANNELS_MAX], size_t pixels,
                             double *state, const double *other);
/* The channels, arrays as of bent_scene_render_tile for `pixels` pixels, NULL where not wanted, that a state stands for. */
void bent_render_state_develop(const bent_render_settings *settings, size_t pixels, const double *state,
                               float *const channels[BENT_CHANNELS_MAX]);
/* Why a committed scene is rendered as by BENT_PATH whatever is asked for; NULL if there is no reason. */
const char *bent_scene_bidirectional_obstacle(const bent_scene *scene);
#endif
