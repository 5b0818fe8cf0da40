/* Loading a shared library at run time: the only platform-specific code of the core. */
#ifndef BENT_GEOMETRY_LIBRARY_H
#define BENT_GEOMETRY_LIBRARY_H
#include <stddef.h>

typedef struct library library;
typedef void (*library_function)(void);

/* The file names under which Embree 4 is known on this platform, most specific first; NULL-terminated. */
extern const char *const LIBRARY_EMBREE_NAMES[];

/* A library that the process has loaded already, or NULL. `name` is a file name without a folder. */
library *library_find_loaded(const char *name);
/* Loads `path`, UTF-8: a path, or a bare name for the system's search. On failure NULL, and the reason in `reason`. */
library *library_open(const char *path, char *reason, size_t size);
/* NULL if the library has no such function. */
library_function library_symbol(library *lib, const char *name);
void library_close(library *lib);
#endif
