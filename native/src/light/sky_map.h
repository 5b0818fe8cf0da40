/* Draws directions of the sky about as often as it shines there: a map of its brightness in cells of equal solid angle. */
#ifndef BENT_LIGHT_SKY_MAP_H
#define BENT_LIGHT_SKY_MAP_H
#include "base/vec3.h"
#include "scene/shading.h"

typedef struct sky_map sky_map;

/* *out is NULL for a sky that is black or the same everywhere, for which directions of a surface's own choice are best. */
bent_status sky_map_new(const shading *shading, sky_map **out, bent_error *error);
void sky_map_free(sky_map *map);
/* Mean brightness over the sphere. */
double sky_map_mean(const sky_map *map);
/* A unit direction for (u, v) in [0, 1)^2; returns its pdf by solid angle. */
double sky_map_draw(const sky_map *map, double u, double v, vec3 *direction);
double sky_map_pdf(const sky_map *map, vec3 direction);
#endif
