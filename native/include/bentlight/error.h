/* Status codes, error messages, and the progress/cancel cell that long calls share with their caller. */
#ifndef BENTLIGHT_ERROR_H
#define BENTLIGHT_ERROR_H
#include <stdatomic.h>
#include <stdint.h>

typedef enum bent_status {
  BENT_OK = 0,
  BENT_ERROR_ARGUMENT,    /* a value is out of its documented domain */
  BENT_ERROR_MEMORY,      /* allocation failed */
  BENT_ERROR_STATE,       /* called in the wrong order, e.g. intersect before commit */
  BENT_ERROR_UNAVAILABLE, /* something outside is missing, e.g. Embree */
  BENT_ERROR_DATA,        /* damaged or mismatched data, e.g. a table of another spacetime */
  BENT_CANCELLED          /* the caller asked to stop; what is done is valid */
} bent_status;

typedef struct bent_error {
  bent_status status;
  char message[512];
} bent_error;

/* Shared between a running call and its caller's threads: the call adds to `done`, the caller may set `cancel`.
 * Checked at least every few hundred rays. */
typedef struct bent_progress {
  _Atomic uint64_t done;
  _Atomic int cancel;
} bent_progress;

/* Fills `error` (may be NULL) by printf rules and returns `status`. */
bent_status bent_fail(bent_error *error, bent_status status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
#endif
