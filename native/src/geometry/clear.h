/* Whether the sphere of a lens is clear of triangles. */
#ifndef BENT_GEOMETRY_CLEAR_H
#define BENT_GEOMETRY_CLEAR_H
#include "geometry/geometry.h"

/* Nonzero unless a triangle of an instance that rays see (degenerate ones count) touches the closed sphere, or may for all
 * that Embree's float32 tells. The instances' float errors must be known. About 10 ms for a mesh of a million triangles
 * around the sphere. */
int is_clear(const geometry *g, const lens *l);
#endif
