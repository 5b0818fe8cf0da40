"""The bending that is left out where a sphere of influence, or a lens of Cycles, ends the curvature of space."""

from __future__ import annotations

import math

import bentlight_native
import numpy as np

from .native import native_spacetime
from .scene_data import SpacetimeData

_DISTANCES = 16  # from the center, at which a soft edge is looked at
_FAR = 1e5  # radii: what is left out beyond them is less than a part in 1e9


def missing_bending(item: SpacetimeData, radius: float, soft_edge: float = 0.0) -> float:
    """The largest bending, in radians, that ending space's curvature at world radius `radius` leaves out.

    That of a ray from afar that would graze the sphere if it were straight, at the hole's equator, with or against its
    spin. In weak fields 4M/R for a black hole and pi/4 (throat/R)^2 for a wormhole. Infinite if such a ray falls in.
    With a soft edge, over the radius (osl/lens.osl), rays a little further inside miss up to 1.06 times as much. What
    share of their bending is inside the sphere is taken as around a hole in weak fields: half the chord over R.
    """
    own = radius / item.scale
    b = np.linspace(1.0, 1.0 - soft_edge, _DISTANCES if soft_edge else 1)
    starts = np.concatenate(
        [np.stack([np.full(len(b), -_FAR), side * b, np.zeros(len(b))], axis=1) for side in (1, -1)]
    )
    ends = bentlight_native.trace_rays(native_spacetime(item), own * starts, [[1.0, 0.0, 0.0]] * len(starts))
    if (ends["fate"] != bentlight_native.FATES.index("escaped")).any():
        return math.inf
    x, y, z = ends["direction"].T
    inside = (1.0 - b) / (soft_edge or 1.0)
    kept = inside**2 * (3.0 - 2.0 * inside) * np.sqrt(1.0 - b**2)
    return float((np.arctan2(np.hypot(y, z), x) * (1.0 - np.tile(kept, 2))).max())
