"""Stars: points of the sky without size, whose images in bent space are known by connections instead of chance.

`StarMethods` gives its method to `Scene`. Angles are in radians, colors linear RGB.
"""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core

_IMAGES_MAX = 32  # BENT_STAR_IMAGES_MAX of the C header
_CHUNK = 1024  # stars a call, so that threads share them


@dataclass(frozen=True)
class StarImages:
    """Where a camera sees stars: m images, in order of their stars.

    star: (m,) int64, which star. place: (m, 2), in the picture, in [0, 1] from its left and bottom edges, or a little
    beyond. throughput: (m, 3), irradiance at the camera over the star's own: the magnification, at most 100, as if
    stars had a size (bentlight/stars.h), times what transparent surfaces in front let through. solid_angle: (m,), of
    directions per area of the picture there, which is 1 as a whole. swept: (m,) radians about spacetime objects: below
    pi a primary image, from pi to 2 pi a secondary one.
    """

    star: NDArray[np.int64]
    place: NDArray[np.float64]
    throughput: NDArray[np.float64]
    solid_angle: NDArray[np.float64]
    swept: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.star)

    def light(self, irradiance: ArrayLike) -> NDArray[np.float64]:
        """(m, 3): the radiance of each image if it were spread over the whole picture; irradiance: (n, 3), of stars."""
        return np.asarray(irradiance, np.float64)[self.star] * self.throughput / self.solid_angle[:, None]

    def draw(
        self,
        light: NDArray[np.float64],
        size: tuple[int, int],
        tile: tuple[int, int, int, int],
        filter: str = "BLACKMAN_HARRIS",
        filter_width: float = 3.0,
    ) -> NDArray[np.float32]:
        """The images in a tile (x, y, width, height) of a picture of `size` pixels: (height, width, 3), rows upwards.

        light: (m, 3), as `light` gives it. The pixel filter shares each image among pixels with weights that add up to
        1 wherever it lies: light is conserved. The same to the last bit for any tiles.
        """
        pixels = np.zeros((tile[3], tile[2], 3), np.float32)
        light = np.ascontiguousarray(light, np.float64)
        _core.draw_stars(self.place, light, *size, filter, filter_width, tile, pixels)
        return pixels


class StarMethods:
    """The method of `Scene` that concerns stars."""

    def find_stars(
        self,
        directions: ArrayLike,
        size: tuple[int, int],
        *,
        margin: float = 2.0,
        tolerance: float = 1e-4,
        transparent_bounces: int = 8,
        threads: int = 1,
        progress: "_core.Progress | None" = None,
    ) -> StarImages:
        """All images of stars that the camera of a committed scene sees; what surfaces in front hide is left out.

        directions: (n, 3), towards the stars, of any length but 0. size: of the picture, pixels. margin: pixels around
        it whose images count too; half the pixel filter's width. tolerance: of rays, as of a render. progress: counts
        stars; after cancel() the call raises Cancelled.
        Raises ValueError for bad arguments and for cameras whose pictures have no place for single stars (see
        shows_stars), RuntimeError without a camera or before commit(). The answer does not depend on `threads`.
        """
        directions = np.ascontiguousarray(directions, np.float64).reshape(-1, 3)
        view = (*size, margin, tolerance, transparent_bounces)
        chunks = [slice(first, first + _CHUNK) for first in range(0, len(directions), _CHUNK)] or [slice(0, 0)]
        with ThreadPoolExecutor(max(1, threads)) as pool:
            found = list(pool.map(lambda chunk: self._find_chunk(directions[chunk], view, progress), chunks))
        return _joined(found, [chunk.start for chunk in chunks])

    def _find_chunk(
        self, directions: NDArray[np.float64], view: tuple, progress: "_core.Progress | None"
    ) -> StarImages:
        n = len(directions)
        count, place = np.empty(n, np.int32), np.empty((n, _IMAGES_MAX, 2))
        throughput, solid_angle = np.empty((n, _IMAGES_MAX, 3)), np.empty((n, _IMAGES_MAX))
        swept = np.empty((n, _IMAGES_MAX))
        self._find_stars(directions, view, count, place, throughput, solid_angle, swept, progress)
        listed = np.arange(_IMAGES_MAX) < count[:, None]
        return StarImages(np.nonzero(listed)[0], place[listed], throughput[listed], solid_angle[listed], swept[listed])


def _joined(parts: Sequence[StarImages], firsts: Sequence[int]) -> StarImages:
    """One list of images; `firsts`: the number of each part's first star."""
    star = np.concatenate([part.star + first for part, first in zip(parts, firsts, strict=True)])
    rest = (
        np.concatenate([getattr(part, name) for part in parts])
        for name in ("place", "throughput", "solid_angle", "swept")
    )
    return StarImages(star, *rest)
