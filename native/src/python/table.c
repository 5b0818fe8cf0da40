/* Module functions for deflection tables. */
#include "python.h"

PyMethodDef table_functions[] = {{0}};
