/* Places on a triangle, drawn by the solid angle that they cover as seen straight from a point (Arvo 1995), and more often
 * where the point's surface faces them. In curved space some places are drawn evenly over the area: light may come from
 * where the straight view is edge-on. */
#ifndef BENT_LIGHT_TRIANGLE_H
#define BENT_LIGHT_TRIANGLE_H
#include "base/vec3.h"

/* A triangle as a point sees it. */
typedef struct triangle_view {
  vec3 point;
  double even;          /* chance that a place is drawn evenly over the area; 1 if the view is too small or edge-on */
  vec3 area;            /* vector */
  double solid_angle;
  vec3 seen[3];         /* unit directions to the corners */
  double nearness[3];   /* 1 / distance of the corners */
  double cosine[3];     /* between the directions to corners 0 and 1, 1 and 2, 2 and 0 */
  double volume;        /* |seen[0] . (seen[1] x seen[2])| */
} triangle_view;

triangle_view triangle_viewed(const vec3 corner[3], vec3 point, double even);
/* How often a place is drawn per area, over the mean of the triangle, but for the facing of the point's surface. */
double triangle_density(const triangle_view *view, vec3 place);
/* Draws a place by (u, v) in [0, 1)^2: weights of the second and third corner. normal: of the point's surface, towards its lit
 * side; 0: it is lit from all around. The place is drawn *facing * triangle_density times as often as on average. The weight
 * 1 / (facing * density) makes an unbiased estimate, and so do weights of multiple importance sampling that are made of
 * triangle_density alone on both sides. */
void triangle_draw(const triangle_view *view, vec3 normal, double u, double v, double barycentric[2], double *facing);
#endif
