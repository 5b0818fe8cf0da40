"""The bending that is left out where a sphere of influence, or a lens of Cycles, ends the curvature of space."""

from __future__ import annotations

import math

import bentlight_native
import numpy as np

from .native import native_spacetime
from .scene_data import SpacetimeData

_FAR = 1e5  # radii: what is left out beyond them is less than a part in 1e9


def missing_bending(item: SpacetimeData, radius: float) -> float:
    """The largest bending, in radians, that ending space's curvature at world radius `radius` leaves out.

    That of a ray from afar that would graze the sphere if it were straight, at the hole's equator, with or against its
    spin. In weak fields 4M/R for a black hole and pi/4 (throat/R)^2 for a wormhole. Infinite if such a ray falls in.
    """
    own = radius / item.scale
    starts = np.array([[-_FAR * own, own, 0.0], [-_FAR * own, -own, 0.0]])
    ends = bentlight_native.trace_rays(native_spacetime(item), starts, [[1.0, 0.0, 0.0]] * 2)
    if (ends["fate"] != bentlight_native.FATES.index("escaped")).any():
        return math.inf
    x, y, z = ends["direction"].T
    return float(np.arctan2(np.hypot(y, z), x).max())
