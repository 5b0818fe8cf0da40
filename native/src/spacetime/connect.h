/* The kernel behind bentlight/connect.h. */
#ifndef BENT_SPACETIME_CONNECT_H
#define BENT_SPACETIME_CONNECT_H
#include "base/isa.h"
#include "bentlight/connect.h"

/* What is asked of each pair. */
typedef struct connect_request {
  size_t max_images;
  double min_share, tolerance;
  int sky, far_side;
} connect_request;

/* Pairs of a call, and between looks at whether to stop: around a spinning hole, a third of a second. The last of a call
 * do not fill the lanes. */
enum { CONNECT_BLOCK = 32768 };

/* Pairs 0 .. n-1 of checked points (`b`: nonzero vectors if request->sky); results at 0 .. n * max_images - 1 of `out`.
 * Schwarzschild, Kerr without spin, and Ellis; curved only. Adds to `count`. */
BENT_DECLARE_KERNEL(void, bent_connect_pairs,
                    (const bent_spacetime *spacetime, size_t n, const double (*a)[3], const double (*b)[3],
                     const connect_request *request, const bent_connections *out, bent_connection_count *count))
/* The same for Kerr with spin. */
BENT_DECLARE_KERNEL(void, bent_connect_kerr,
                    (const bent_spacetime *spacetime, size_t n, const double (*a)[3], const double (*b)[3],
                     const connect_request *request, const bent_connections *out, bent_connection_count *count))
#endif
