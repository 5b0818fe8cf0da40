/* Deflection tables: fate and direction of a ray by lookup instead of integration. */
#ifndef BENTLIGHT_TABLE_H
#define BENTLIGHT_TABLE_H
#include "bentlight/trace.h"
#endif
