/* Light passes: to which channels light goes, by what scattered it first, seen from the camera, and by whose light it is.
 * As in Cycles: a surface that scatters by several lobes at once splits light by what each of them brings. */
#ifndef BENT_RENDER_PARTS_H
#define BENT_RENDER_PARTS_H
#include "render/bsdf.h"
#include "render/channels.h"
#include "light/lights.h"

/* Where some light comes from. */
typedef struct credit {
  vec3 diffuse, glossy; /* the parts, of each color, that were first scattered so; the rest was transmitted */
  int group;            /* light group; -1: none */
} credit;


/* Gives light that was scattered so many times to its channels; what is seen at once goes to light groups alone. */
void parts_add(const channel_layout *layout, sample_record *record, const credit *credit, uint32_t bounces, vec3 light);
/* The group of what lights_draw has drawn. */
int parts_group(const bent_scene *scene, const light_sample *sample);
/* The parts of light from wi that a surface scatters to the camera: by its lobes of the wanted kinds, or, if `drawn` is a
 * delta lobe's, by that. */
void parts_of_scattering(const closure_set *set, const shade_point *point, const bsdf_sample *drawn, uint32_t kinds,
                         credit *out);
/* The same from what lobes bring. */
void parts_set(credit *credit, const bsdf_parts *parts);
/* What the camera sees of colors: adds to the three channels. beta: the throughput. */
void parts_add_colors(sample_record *record, const shade_point *point, const closure_set *set, vec3 beta);
#endif
