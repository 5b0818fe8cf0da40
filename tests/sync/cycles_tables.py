"""The form of Cycles' tables of microfacet energy, to tell by quadrature what they say at places between their entries.

Source: intern/cycles/app/cycles_precompute.cpp and kernel/closure/bsdf_microfacet.h.
"""

import numpy as np

ENTRIES = 16  # along each axis


def ior_of(z, side=0):
    """The IOR at a place in [0, 1) of the table's axis, z^2 = (ior - 1) / (ior + 1); `side` 1: its inverse, inside."""
    return ((1 + z**2) / (1 - z**2)) ** (-1 if side else 1)


def place_of(ior):
    """The place z of an IOR >= 1."""
    return np.sqrt((ior - 1) / (ior + 1))


def interpolate(function, *places):
    """Linear between the values of a function at even steps of each of its arguments in [0, 1]."""
    places = np.array(places) * (ENTRIES - 1)
    corner = np.minimum(places.astype(int), ENTRIES - 2)
    fraction = places - corner
    total = 0.0
    for step in np.ndindex(*(2,) * len(places)):
        weight = np.prod(np.where(step, fraction, 1 - fraction))
        if weight > 0:
            total += weight * function(*(corner + step) / (ENTRIES - 1))
    return total
