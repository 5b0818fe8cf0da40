/* Path tracing of a committed scene by tiles. */
#ifndef BENTLIGHT_RENDER_H
#define BENTLIGHT_RENDER_H
#include "bentlight/intersect.h"
#endif
