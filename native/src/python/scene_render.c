/* Scene methods for the camera and rendering tiles. */
#include "python.h"

PyMethodDef scene_render_methods[] = {{0}};
