/* Light below a surface: it walks at random, straight from one scattering to the next, until it meets the surface of the same
 * object again and comes out there.
 *
 * Chiang, Kutz, Burley, "Practical and Controllable Subsurface Scattering for Production Path Tracing" (SIGGRAPH 2016
 * Talks); scattering that is not the same in all directions: Wrenninge, Villemin, Hery, "Path Traced Subsurface Scattering
 * using Anisotropic Phase Functions and Non-Exponential Free Flights" (Pixar Technical Memo 17-07). The ways are short, so
 * that space is taken as flat there: straight lines of the scene's coordinates, whatever bends light outside.
 */
#ifndef BENT_RENDER_SUBSURFACE_H
#define BENT_RENDER_SUBSURFACE_H
#include "render/path.h"

/* Walks from a surface, met as `entry` says, into the unit direction `inwards`. Returns 0 if no light comes out; else the
 * place, seen from outside, in `exit`, and in *beta, which must have the lobe's weight, the light that is left. */
int subsurface_walk(const tracer *t, const path *p, const closure *lobe, vec3 normal, const bent_hit *entry, vec3 inwards,
                    vec3 *beta, bent_hit *exit);
#endif
