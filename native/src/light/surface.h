/* From a hit to what a material needs to know about the place. The only part of rendering that meets curved space: it
 * turns normals and tangents into the local frame of the observer at rest there. */
#ifndef BENT_LIGHT_SURFACE_H
#define BENT_LIGHT_SURFACE_H
#include "bentlight/intersect.h"
#include "scene/shading.h"

typedef struct surface {
  shade_point point;
  int material;  /* for shading_evaluate */
  int see_through; /* a one-sided surface seen from behind: not there */
} surface;

/* hit: of fate BENT_HIT; length: of the ray's way as it is drawn, since it was scattered or started. */
void surface_at(const bent_scene *scene, const bent_hit *hit, double length, surface *out);
/* Whether a hit, of which instance, triangle, position and direction are set, is on the back of its triangle. */
int surface_is_backfacing(const bent_scene *scene, const bent_hit *hit);
#endif
