"""Rays to infinity or the horizon."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core

FATES = ("unresolved", "escaped", "captured", "escaped on the far side", "hit")
_ROUTES = {"auto": 0, "endpoint": 1, "taylor": 2}


def trace_rays(
    spacetime: _core.Spacetime,
    origins: ArrayLike,
    directions: ArrayLike,
    tolerance: float = 1e-8,
    *,
    route: str = "auto",
    progress: _core.Progress | None = None,
) -> dict[str, NDArray]:
    """Trace light rays backwards from finite observers until they escape or fall into a hole.

    Args:
        spacetime: a ``Spacetime``.
        origins: (n, 3) positions in the spacetime's own axes (its chart), outside the horizon. An Ellis origin closer
            than half the throat radius stands on the far side.
        directions: (n, 3) local directions (frame of the zero-angular-momentum observer), of any nonzero length.
        tolerance: wanted angular error of the result, radians. Rays near the critical one lose 1/|b/b_c - 1| of double
            precision whatever the tolerance; see ``"error"``.
        route: "auto", "endpoint" (separated integrals, declines what it cannot do) or "taylor" (Taylor arcs, anything).
        progress: counts finished rays in ``done``; ``cancel()`` from another thread stops the call with ``Cancelled``.

    Returns:
        dict of arrays of n entries. ``"fate"`` uint8: index into ``FATES``. ``"direction"`` (n, 3) float64: asymptotic
        unit direction (fate 3: the angular position on the far side), NaN unless fate is 1 or 3. ``"error"`` float64:
        estimated angular error, radians, at least half of the true one on every test ray, up to the largest spin below
        the mass; NaN where the endpoint route declined. Rays whose error exceeds 0.5 (and the tolerance) are
        unresolved. ``"steps"`` uint32: Taylor arcs, 0 on the endpoint route. ``"swept"`` float64: angle swept about the
        center, radians, without frame dragging, for Kerr to 1e-4 of 1 + itself; NaN where a captured ray has no path.

    Raises:
        ValueError: for shapes other than (n, 3), non-finite or zero directions, origins inside a horizon, or a
            tolerance that is not positive. The message names the argument and the first bad ray.

    The GIL is released; any number of threads may call at once. float64 C-contiguous arrays are used without a copy.
    """
    if route not in _ROUTES:
        raise ValueError(f"route: expected one of {', '.join(_ROUTES)}, got {route!r}")
    origins = np.ascontiguousarray(origins, dtype=np.float64)
    directions = np.ascontiguousarray(directions, dtype=np.float64)
    n = len(origins) if origins.ndim == 2 else 0
    fate = np.empty(n, np.uint8)
    direction = np.empty((n, 3))
    error = np.empty(n)
    steps = np.empty(n, np.uint32)
    swept = np.empty(n)
    _core.trace_rays(
        spacetime, origins, directions, tolerance, _ROUTES[route], fate, direction, error, steps, swept, progress
    )
    return {"fate": fate, "direction": direction, "error": error, "steps": steps, "swept": swept}


def ray_path(
    spacetime: _core.Spacetime,
    origin: ArrayLike,
    direction: ArrayLike,
    mino_times: ArrayLike,
    tolerance: float = 1e-8,
) -> dict[str, NDArray]:
    """Points along one light ray, traced backwards from a finite observer.

    Args:
        spacetime: a ``Spacetime``.
        origin: (3,) position in the spacetime's own axes, outside the horizon.
        direction: (3,) local direction, of any nonzero length.
        mino_times: (n,) ascending Mino times, d(lambda) = d(affine) / Sigma with local energy 1, in 1/length; in flat
            space lengths along the ray.
        tolerance: wanted angular error, radians.

    Returns:
        dict. ``"position"`` (n, 3) and ``"direction"`` (n, 3) local unit directions of travel, NaN beyond the ray's
        end (infinity, or just above the horizon); ``"far"`` (n,) bool: beyond the throat, where position and direction
        are in the other mouth's axes.

    Raises:
        ValueError: as ``trace_rays``, and for Mino times that do not ascend.
    """
    mino_times = np.ascontiguousarray(mino_times, dtype=np.float64)
    n = len(mino_times) if mino_times.ndim else 0
    position, heading, sides = np.empty((n, 3)), np.empty((n, 3)), np.empty(n, np.uint8)
    origin = np.ascontiguousarray(origin, dtype=np.float64)
    direction = np.ascontiguousarray(direction, dtype=np.float64)
    _core.ray_path(spacetime, origin, direction, tolerance, mino_times, position, heading, sides)
    return {"position": position, "direction": heading, "far": sides.astype(bool)}
