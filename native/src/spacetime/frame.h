/* Local frames in the oblate and the areal chart, which is the oblate one of spin 0. */
#ifndef BENT_SPACETIME_FRAME_H
#define BENT_SPACETIME_FRAME_H
#include "base/isa.h"
#include "bentlight/spacetime.h"

/* As bent_lapse and bent_local_from_covector, for positions outside the horizon of Kerr and areal Schwarzschild holes. */
BENT_DECLARE_KERNEL(double, bent_kerr_lapse, (const bent_spacetime *spacetime, const double position[3]))
BENT_DECLARE_KERNEL(void, bent_kerr_local_from_covector,
                    (const bent_spacetime *spacetime, const double position[3], double matrix[3][3]))
#endif
