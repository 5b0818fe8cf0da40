/* Veils: surfaces that the camera's rays pass straight on, each with light of its own, as accretion disks. */
#ifndef BENTLIGHT_VEIL_H
#define BENTLIGHT_VEIL_H
#include "bentlight/intersect.h"

/* What the veils on a ray's way do, linear RGB. */
typedef struct bent_veil {
  double glow[3];         /* radiance that they send to where the ray starts, each dimmed by those before it */
  double transmission[3]; /* the part of the light from behind that passes them all */
  uint32_t layers;        /* how many of them have done anything where the ray met them */
} bent_veil;

/* As bent_scene_intersect for rays of the camera, but through the instances of which is_veil, one flag for each instance, is
 * not 0: a ray goes straight on behind each of them, until it meets something else; or until nothing passes any more, then
 * that veil is its hit. hits are of the whole way from the start. What veils scatter is left out; their materials run as in a
 * render, knowing the ray's whole way and its shift of frequency, but not a pixel's size. A ray that passes more than 64
 * surfaces of veils is BENT_UNRESOLVED. */
bent_status bent_scene_intersect_veiled(const bent_scene *scene, size_t n, const bent_ray *rays, const uint8_t *is_veil,
                                        bent_hit *hits, bent_veil *veils, bent_progress *progress, bent_error *error);
#endif
