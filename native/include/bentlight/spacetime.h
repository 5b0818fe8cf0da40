/* The spacetimes, the charts that draw them in a flat scene, and the local frames of observers and surfaces.
 *
 * Every position here is in the spacetime's own axes: the hole or throat at the origin, the spin axis along +z. A chart
 * says where an event is drawn: isotropic (conformally flat: angles in the scene are local angles), areal, or oblate.
 * A direction at a finite point is a unit vector in the orthonormal frame of the zero-angular-momentum observer (ZAMO),
 * written in scene axes: the flat basis of the chart stands for the ZAMO tetrad. See docs in physics terms: Bardeen,
 * Press & Teukolsky 1972 (ZAMO frames); Carter 1968 (separation); Ellis 1973 (wormhole).
 */
#ifndef BENTLIGHT_SPACETIME_H
#define BENTLIGHT_SPACETIME_H
#include "bentlight/error.h"

typedef enum bent_spacetime_kind { BENT_MINKOWSKI, BENT_SCHWARZSCHILD, BENT_KERR, BENT_ELLIS } bent_spacetime_kind;
typedef enum bent_chart { BENT_CHART_CARTESIAN, BENT_CHART_ISOTROPIC, BENT_CHART_AREAL, BENT_CHART_OBLATE } bent_chart;

/* A plain value; make it with the functions below, which check their arguments. Lengths in spacetime-local units. */
typedef struct bent_spacetime {
  bent_spacetime_kind kind;
  bent_chart chart;
  double mass;          /* M >= 0: Schwarzschild, Kerr */
  double spin;          /* a as a length, |a| < M: Kerr */
  double throat_radius; /* rho > 0: Ellis */
} bent_spacetime;

bent_spacetime bent_minkowski(void);
/* chart: BENT_CHART_ISOTROPIC or BENT_CHART_AREAL. mass 0 is flat space. */
bent_status bent_schwarzschild(double mass, bent_chart chart, bent_spacetime *out, bent_error *error);
bent_status bent_kerr(double mass, double spin, bent_spacetime *out, bent_error *error);
bent_status bent_ellis(double throat_radius, bent_spacetime *out, bent_error *error);

/* Nonzero for flat space: Minkowski, and holes of mass 0. */
int bent_spacetime_is_flat(const bent_spacetime *spacetime);
/* Nonzero when `position` lies outside every horizon, is finite, and a ray may start there. In an Ellis
 * wormhole that is every point but the origin: points closer than half the throat radius stand on the far side. */
int bent_spacetime_contains(const bent_spacetime *spacetime, const double position[3]);
/* Scene radius (in the chart) of the horizon or throat along the equator; 0 for flat space. */
double bent_spacetime_core_radius(const bent_spacetime *spacetime);
/* Local components of a flat-scene covector (e.g. a surface normal): local = matrix * covector, e_(a)^i d_i f with the
 * ZAMO tetrad written in scene axes. The identity up to a factor in the conformally flat charts. */
void bent_local_from_covector(const bent_spacetime *spacetime, const double position[3], double matrix[3][3]);
/* Length that the local observer measures for a unit of scene length, in the conformally flat charts: what the matrix
 * above leaves out. 1 in the others, where the matrix is complete. */
double bent_length_scale(const bent_spacetime *spacetime, const double position[3]);
/* Lapse alpha of the ZAMO at `position`: the ratio of its clock to the one at infinity; 0 where no ray may start. */
double bent_lapse(const bent_spacetime *spacetime, const double position[3]);
/* Speed with which the ZAMO measures places of the chart to move along -phi (it moves along +phi past them, for
 * positive spin): 2 M a r sin(theta) / (Sigma sqrt(Delta)), beyond 1 in the ergosphere. 0 but for Kerr, and where no
 * ray may start. */
double bent_zamo_speed(const bent_spacetime *spacetime, const double position[3]);
#endif
