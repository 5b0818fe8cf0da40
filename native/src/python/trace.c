/* Module functions that trace rays to infinity or the horizon. */
#include "python.h"

PyMethodDef trace_functions[] = {{0}};
