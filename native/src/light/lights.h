/* Everything in a scene that shines, and the choice of one light for a shaded point: emissive triangles and lamps by a
 * light tree, suns, and the sky by its map. Made by commit, read-only afterwards. */
#ifndef BENT_LIGHT_LIGHTS_H
#define BENT_LIGHT_LIGHTS_H
#include "base/vec3.h"
#include "light/lamps.h"
#include "light/suns.h"
#include "scene/scene.h"

typedef struct lights lights;

typedef enum light_kind { LIGHT_TRIANGLE, LIGHT_LAMP, LIGHT_SUN, LIGHT_SKY } light_kind;

/* A place on a light, or a direction in which it stands in the sky. */
typedef struct light_sample {
  light_kind kind;
  int index;    /* of the instance, lamp or sun */
  int triangle; /* of the instance */
  double barycentric[2];
  vec3 target;        /* world position; of suns and sky: unit asymptotic direction */
  vec3 area;          /* triangle: its area vector, as the observer at rest at the target measures it */
  /* Of the triangle, times the density of places on it, over the mean; of the lamp; of the sun, whose places are equally likely;
   * of the sky: pdf by solid angle. `facing` times that if what a surface faces was drawn more often: see triangle.h. */
  double probability, facing;
} light_sample;

/* Lights of a scene whose geometry is committed. Takes the map of a sky that is still valid from the scene's last ones. */
bent_status lights_new(const bent_scene *scene, lights **out, bent_error *error);
void lights_free(lights *lights);

/* Whether there is anything to draw. */
int lights_any(const lights *lights);
/* A light for `point`, drawn by u: two for the place on it, one for the choice; returns 0 if none can reach it. normal: as in light_tree_weight. */
int lights_draw(const lights *lights, const bent_scene *scene, vec3 point, vec3 normal, const double u[4],
                light_sample *out);
/* Radiance that a drawn place of a triangle sends back along the direction in which a ray of that length and history arrives
 * there. */
vec3 lights_radiance(const bent_scene *scene, const light_sample *triangle, double length, vec3 arrival,
                     const ray_history *ray);
/* The area vector of a triangle, as the observer at rest at `position` measures it. */
vec3 lights_triangle_area(const bent_scene *scene, int instance, int triangle, vec3 position);
/* Whether lights_draw may choose a triangle, or anything in the sky. */
int lights_draw_triangle(const lights *lights, int instance, int triangle);
int lights_draw_sky(const lights *lights);
/* What lights_draw has as `probability` of a place on a triangle, a sun or a direction of the sky; 0 if it never draws it. */
double lights_triangle_probability(const lights *lights, int instance, int triangle, vec3 place, vec3 point,
                                   vec3 normal);
/* The same of a place on a triangle or of a lamp, whichever it is. */
double lights_place_probability(const lights *lights, const light_sample *place, vec3 point, vec3 normal);
double lights_sun_probability(const lights *lights, size_t sun, vec3 point, vec3 normal);
double lights_sky_pdf(const lights *lights, vec3 direction, vec3 point, vec3 normal);

/* Where light subpaths start: on triangles and lamps that shine on all objects (bent_influence, visibility), each about as
 * often as its flux says; evenly on a triangle; into directions by the cosine to its normal, of a lamp into all alike, and
 * as many towards glass and mirrors (casters.h). */
int lights_any_start(const lights *lights);
/* Draws a place by u; out->probability is not set. Returns the chance of the triangle or lamp. */
double lights_draw_start(const lights *lights, const bent_scene *scene, const double u[3], light_sample *out);
double lights_start_chance(const lights *lights, light_kind kind, int index, int triangle);
/* A direction away from a place, and the pdf of such a one by solid angle. */
vec3 lights_draw_direction(const lights *lights, const light_sample *from, const double u[3]);
double lights_direction_pdf(const lights *lights, const light_sample *from, vec3 direction);
/* The emitter's bent_influence.max_bounces, which the caller heeds. */
uint32_t lights_start_bounces(const bent_scene *scene, const light_sample *from);
#endif
