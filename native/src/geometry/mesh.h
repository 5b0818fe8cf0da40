/* What the files of the geometry share about single meshes and matrices. */
#ifndef BENT_GEOMETRY_MESH_H
#define BENT_GEOMETRY_MESH_H
#include "geometry/geometry.h"

/* Frees what a mesh holds, not the struct itself. */
void mesh_clear(mesh *m);

void instance_clear(instance *i);

/* Checks that `matrix` is affine, finite and invertible, and inverts it. `name` begins the error message. */
bent_status affine_check(const char *name, const double matrix[4][4], mat4 *inverse, bent_error *error);
#endif
