/* Taylor arcs over SIMD lanes. */
#include "base/isa.h"

int BENT_KERNEL(bent_taylor_lanes)(void);
int BENT_KERNEL(bent_taylor_lanes)(void) { return 8; }
