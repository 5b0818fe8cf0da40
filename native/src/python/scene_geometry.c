/* Scene methods for meshes, instances, spacetime objects, commit and intersect. */
#include "python.h"

PyMethodDef scene_geometry_methods[] = {{0}};
