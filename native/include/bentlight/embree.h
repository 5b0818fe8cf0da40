/* Embree, the ray-triangle library that Blender ships, found and bound at run time. Nothing is bundled. */
#ifndef BENTLIGHT_EMBREE_H
#define BENTLIGHT_EMBREE_H
#include <stddef.h>
#include "bentlight/error.h"

/* Binds Embree 4: a copy that the process has loaded already, else the first of `paths` (files, or bare names for the
 * system's search) that loads. With count 0 the platform's usual names are tried. Does nothing once it has succeeded.
 * BENT_ERROR_UNAVAILABLE, naming everything tried, when none is there or it is not version 4. Thread-safe. Committing a
 * scene calls this with count 0. */
bent_status bent_embree_load(size_t count, const char *const *paths, bent_error *error);
/* "4.4.0" or similar; NULL before bent_embree_load has succeeded. Valid for ever. */
const char *bent_embree_version(void);
/* Where the bound copy came from: "already loaded" with its name, or the path that worked; NULL before. */
const char *bent_embree_origin(void);
#endif
