"""Kerr rays in 113-bit arithmetic: kerr_reference.c, compiled once a test run."""

import ctypes
import platform

import numpy as np
from compiled import load, pointer


class KerrReference:
    """The truth about rays round a hole of mass 1, to the rounding of its answer."""

    def __init__(self, folder):
        quad = ["-lquadmath"] if platform.machine() == "x86_64" else []
        self.library = load("kerr_reference.c", folder, *quad)

    def trace(self, spin, origins, directions):
        """Asymptotic directions (n, 3) and swept angles (n,) of escaping rays, NaN of others."""
        n = len(origins)
        asymptotes, swept = np.empty((n, 3)), np.empty(n)
        rays = (pointer(np.ascontiguousarray(x, float)) for x in (origins, directions))
        self.library.kerr_reference(
            ctypes.c_double(spin), ctypes.c_size_t(n), *rays, pointer(asymptotes), pointer(swept)
        )
        return asymptotes, swept
