/* How matter of an accretion disk (disk.h) looks at a place of its surface. */
#ifndef BENT_SCENE_DISK_SEEN_H
#define BENT_SCENE_DISK_SEEN_H
#include "scene/shading.h"

typedef struct disk_view {
  double r, azimuth;            /* Boyer-Lindquist radius over mass, 0 where there is none; in [0, 2 pi) */
  double doppler, gravitational; /* their product is g = nu_observed / nu_emitted; 0 at the horizon and within */
} disk_view;

/* The disk lies in the plane z = 0 of the point's object, whose axes and unit of length are the hole's. spin: over mass. The
 * gravitational factor leads from the local observer to the path's beginning; where nothing is known of the path, to
 * infinity. */
disk_view disk_look(const shade_point *point, double mass, double spin, int is_isotropic);
#endif
