"""Crossing a lens sphere by table: a sphere around a hole or a wormhole's mouth, with flat space outside."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core


class SphereError(NamedTuple):
    """What lookups differ by from direct evaluation, measured between the nodes: radians, and units of the radius."""

    swept_max: float
    swept_rms: float
    length_max: float
    length_rms: float


class LensSphere:
    """Where and how rays leave a lens sphere that they enter; see native/include/bentlight/sphere.h for the table.

    Args:
        spacetime: ``Spacetime.schwarzschild`` with a mass, or ``Spacetime.ellis``.
        radius: of the sphere, in the chart; from 4 M in the areal radius on, or l = rho / 4, up to 1e6 times that.

    Built in about a millisecond. Errors against direct evaluation are in ``measured`` (swept 2e-13 rad, length 2e-13 of
    the radius).
    """

    def __init__(self, spacetime: _core.Spacetime, radius: float) -> None:
        self.spacetime, self.radius = spacetime, float(radius)
        self._core = _core.sphere_new(spacetime, self.radius)
        self.measured = SphereError(*self._core.measured())

    def cross(self, points: ArrayLike, directions: ArrayLike) -> dict[str, NDArray]:
        """Rays that enter at `points` (n, 3) of the sphere in inward `directions` (n, 3), both in spacetime axes.

        Returns "fate" (n,) uint8: 1 leaves the sphere, 2 captured, 3 goes into the throat, 0 declined (within 2e-10
        of the range of b/b_c - 1 around the critical ray, or not inward); "exit" (n, 3): where it leaves the sphere
        or meets the throat; "direction" (n, 3): local, there; "swept" (n,), radians, and "length" (n,), as the chart
        draws it, of the way inside, to the horizon if captured; "error" (n,) of the angles. NaN where a fate leaves
        nothing to say.
        """
        return self._pass(self._core.cross, points, directions)

    def emerge(self, points: ArrayLike, directions: ArrayLike) -> dict[str, NDArray]:
        """Rays that come out of the throat at `points` (n, 3) of it in outward `directions` (n, 3), as ``cross``."""
        return self._pass(self._core.emerge, points, directions)

    @staticmethod
    def _pass(function: Callable[..., None], points: ArrayLike, directions: ArrayLike) -> dict[str, NDArray]:
        points, directions = (np.ascontiguousarray(v, dtype=np.float64) for v in (points, directions))
        n = len(points)
        out = {"fate": np.empty(n, np.uint8), "exit": np.empty((n, 3)), "direction": np.empty((n, 3))}
        out |= {name: np.empty(n) for name in ("swept", "length", "error")}
        function(points, directions, *out.values())
        return out
