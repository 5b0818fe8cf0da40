/* Scene methods for images, materials and the world. */
#include "python.h"

PyMethodDef scene_shading_methods[] = {{0}};
