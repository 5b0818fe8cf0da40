"""All light rays that join two points, or a point and a direction of the sky."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core

CONNECTION_STATES = ("none", "met", "ring", "coarse", "failed")


def connect(
    spacetime: _core.Spacetime,
    points_a: ArrayLike,
    points_b: ArrayLike,
    max_images: int = 2,
    tolerance: float = 1e-8,
    *,
    min_share: float = 0.0,
    progress: _core.Progress | None = None,
) -> dict[str, NDArray | dict[str, int]]:
    """Find the light rays from points a to points b, for each pair in order of the angle swept about the center.

    With phi in [0, pi] the angle between a and b seen from the center, the primary image sweeps phi, the secondary
    2 pi - phi, the relativistic ones 2 pi + phi, 4 pi - phi and so on. From the secondary on each is fainter than the
    one before, by e^-2 pi every two. Flat space has the first only. With spin the angle counts in axes that the hole
    drags along; see bentlight/connect.h for what that means, and for the few images that are not found.

    Args:
        spacetime: any (a Kerr hole without spin counts as Schwarzschild in the areal chart).
        points_a, points_b: (n, 3) positions in the spacetime's own axes (its chart), outside the horizon. In a
            wormhole, points closer than half the throat radius stand on the far side; directions there are those of
            the same continuous chart, whose "outward" points to the throat.
        max_images: 1 to 8 images a pair.
        tolerance: wanted ``"error"``.
        min_share: in [0, 1). A pair's list ends before the first image whose light, 1 / spread, is less than this
            share of the sum of the images before it.
        progress: counts finished pairs in ``done``; ``cancel()`` from another thread stops the call with
            ``Cancelled``.

    Returns:
        dict of arrays (n, max_images), NaN where there is no image:

        - ``"status"`` uint8: index into ``CONNECTION_STATES``. none: too faint, or flat space; met: found, error within
          the tolerance; ring: the same, but a, the center and b are in line: one ray of a ring (listed twice, as the
          limit of two images; with spin on the axis only); coarse: found, error beyond the tolerance; failed: not
          found, or a = b.
        - ``"launch"``, ``"arrival"`` (n, max_images, 3): local unit directions of travel at a and at b.
        - ``"spread"``: dA / d(omega), the area at b across the ray over the solid angle at a of a thin cone, length^2;
          1 / spread stands for the 1 / distance^2 of flat space. 0 on the caustic, where a, the center and b are in
          line: there it falls like sin(phi). With spin: as the ZAMO at b measures it.
        - ``"frequency_ratio"``: nu(a) / nu(b) of light from b to a, both at rest (with spin: ZAMOs).
        - ``"swept"``: radians; with spin as ``trace_rays`` has it.
        - ``"error"``: estimated miss of b by a ray launched in that direction, over the scene radius of b.
        - ``"counts"``: dict of how many images have each status. Nothing is dropped silently.

    Raises:
        ValueError: wrong shapes, points inside a horizon or not finite, max_images, min_share or tolerance out of
            their domain. The message names the argument.

    The GIL is released; any number of threads may call at once. A pair's answer depends on that pair alone.
    """
    return _connect(spacetime, (points_a, points_b), False, False, max_images, tolerance, min_share, progress)


def connect_sky(
    spacetime: _core.Spacetime,
    points: ArrayLike,
    directions: ArrayLike,
    max_images: int = 2,
    tolerance: float = 1e-8,
    *,
    far_side: bool = False,
    min_share: float = 0.0,
    progress: _core.Progress | None = None,
) -> dict[str, NDArray | dict[str, int]]:
    """As ``connect``, from points to directions of the sky: the rays whose asymptotic directions those are.

    Args:
        directions: (n, 3), of any nonzero length; with ``far_side`` angular positions in the sky beyond a wormhole's
            throat, as ``trace_rays`` returns them.

    Returns:
        As ``connect``, but ``"spread"`` is the solid angle of sky per solid angle at the point (flat space: 1),
        ``"error"`` the angle between the wanted and the true asymptotic direction, and ``"arrival"`` the direction of
        travel, minus the angular position on the far side.
    """
    return _connect(spacetime, (points, directions), True, far_side, max_images, tolerance, min_share, progress)


def _connect(
    spacetime: _core.Spacetime,
    ends: tuple[ArrayLike, ArrayLike],
    sky: bool,
    far_side: bool,
    max_images: int,
    tolerance: float,
    min_share: float,
    progress: _core.Progress | None,
) -> dict[str, NDArray | dict[str, int]]:
    a, b = (np.ascontiguousarray(end, dtype=np.float64) for end in ends)
    shape = (len(a) if a.ndim == 2 else 0, max(0, max_images))
    status = np.empty(shape, np.uint8)
    vectors = {name: np.empty((*shape, 3)) for name in ("launch", "arrival")}
    scalars = {name: np.empty(shape) for name in ("spread", "frequency_ratio", "swept", "error")}
    results = (status, *vectors.values(), *scalars.values())
    counts = _core.connect(spacetime, a, b, sky, far_side, max_images, min_share, tolerance, *results, progress)
    return {"status": status, **vectors, **scalars, "counts": dict(zip(CONNECTION_STATES, counts, strict=True))}
