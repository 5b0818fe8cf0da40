"""Stars: points of the sky without size, whose images in bent space are known by connections instead of chance.

`StarMethods` gives its method to `Scene`. Angles are in radians, colors linear RGB.
"""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core

_IMAGES_MAX = 32  # BENT_STAR_IMAGES_MAX of the C header
_CHUNK = 1024  # stars, or images, a call, so that threads share them


@dataclass(frozen=True)
class StarImages:
    """Where a camera sees stars: m images, in order of their stars.

    star: (m,) int64, which star. place: (m, 2), in the picture, in [0, 1] from its left and bottom edges, or a little
    beyond. throughput: (m, 3), irradiance at the camera over the star's own: the magnification, at most 100, as if
    stars had a size (bentlight/stars.h), times what transparent surfaces in front let through. solid_angle: (m,), of
    directions per area of the picture there, which is 1 as a whole. swept: (m,) radians about spacetime objects: below
    pi a primary image, from pi to 2 pi a secondary one.

    Of an open lens, which is cut into a x b cells (of a pinhole a = b = 0): parallax, (m, 2, 2), change of each
    coordinate of the place per scene unit along either axis of the lens; seen, (m, a, b, 3) uint8, in proportion to
    what surfaces let through on the way to each cell; lens, (a + 1, b + 1, 2), the cells' corners on it. The throughput
    is that of the whole lens.
    """

    star: NDArray[np.int64]
    place: NDArray[np.float64]
    throughput: NDArray[np.float64]
    solid_angle: NDArray[np.float64]
    swept: NDArray[np.float64]
    parallax: NDArray[np.float64]
    seen: NDArray[np.uint8]
    lens: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.star)

    @classmethod
    def sharp(
        cls, star: ArrayLike, place: ArrayLike, throughput: ArrayLike, solid_angle: ArrayLike, swept: ArrayLike
    ) -> "StarImages":
        """Images of a pinhole, from what the camera's lens plays no part in."""
        count = len(star)
        no_cells = np.zeros((count, 0, 0, 3), np.uint8), np.zeros((1, 1, 2))
        return cls(star, place, throughput, solid_angle, swept, np.zeros((count, 2, 2)), *no_cells)

    def part(self, which: slice | NDArray) -> "StarImages":
        """Those of the images that a slice, mask or list of numbers chooses."""
        return StarImages(*(getattr(self, field.name)[which] for field in fields(self)[:-1]), self.lens)

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
        1 wherever it lies: light is conserved. The same to the last bit for any tiles. Through an open lens images are
        spread over its figure.
        """
        pixels = np.zeros((tile[3], tile[2], 3), np.float32)
        light = np.ascontiguousarray(light, np.float64)
        blur = None
        if self.seen.size:
            blur = self.parallax, self.lens, self.seen
        _core.draw_stars(self.place, light, blur, *size, filter, filter_width, tile, pixels)
        return pixels


def star_sum(picture: NDArray[np.float32], samples: int) -> NDArray[np.float64]:
    """What the stars of a moment, (height, width, 3), add to the sum over all samples of a picture: (height, width, 6).

    Such sums are exact, and so the same in any order, as long as they stay below 2**41: values are rounded to a
    multiple of 2**-44, and what of them is a multiple of 2**-12 is summed apart from the rest.
    """
    values = picture.astype(np.float64)
    coarse = np.rint(values * 2.0**12) * 2.0**-12
    return np.concatenate([coarse, np.rint((values - coarse) * 2.0**44) * 2.0**-44], axis=-1) * samples


def star_mean(sums: NDArray[np.float64], samples: ArrayLike) -> NDArray[np.float32]:
    """The picture (height, width, 3) that such sums stand for; samples: how many there are, of each pixel or of all."""
    count = np.maximum(np.asarray(samples, np.float64), 1)
    return ((sums[..., :3] + sums[..., 3:]) / count[..., None]).astype(np.float32)


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
        with ThreadPoolExecutor(max(1, threads)) as pool:
            chunks = _chunks(len(directions))
            found = list(pool.map(lambda chunk: self._find_chunk(directions[chunk], view, progress), chunks))
            images = _joined(found, [chunk.start for chunk in chunks])
            cells = self._star_cells(*size)
            if not any(cells):
                return images
            traced = pool.map(
                lambda chunk: self._trace_cells(images.part(chunk), cells, view, progress), _chunks(len(images))
            )
            return _joined(list(traced))

    def _find_chunk(
        self, directions: NDArray[np.float64], view: tuple, progress: "_core.Progress | None"
    ) -> StarImages:
        n = len(directions)
        count, place = np.empty(n, np.int32), np.empty((n, _IMAGES_MAX, 2))
        throughput, parallax = np.empty((n, _IMAGES_MAX, 3)), np.empty((n, _IMAGES_MAX, 2, 2))
        solid_angle, swept = np.empty((n, _IMAGES_MAX)), np.empty((n, _IMAGES_MAX))
        self._find_stars(directions, view, count, place, throughput, parallax, solid_angle, swept, progress)
        listed = np.arange(_IMAGES_MAX) < count[:, None]
        m = int(count.sum())
        found = (values[listed] for values in (place, throughput, solid_angle, swept, parallax))
        return StarImages(np.nonzero(listed)[0], *found, np.zeros((m, 0, 0, 3), np.uint8), np.zeros((1, 1, 2)))

    def _trace_cells(
        self, images: StarImages, cells: tuple[int, int], view: tuple, progress: "_core.Progress | None"
    ) -> StarImages:
        """The images that some cell of the lens sees."""
        corners = np.empty((cells[0] + 1, cells[1] + 1, 2))
        seen = np.empty((len(images), *cells, 3), np.float32)
        self._trace_star_cells(images.place, images.parallax, view, corners, seen, progress)
        most = seen.max(axis=(1, 2, 3), initial=0.0)
        traced = replace(
            images,
            throughput=images.throughput * np.tensordot(seen, _shares(corners), ([1, 2], [0, 1])),
            seen=np.rint(seen * (255 / np.maximum(most, 1e-30))[:, None, None, None]).astype(np.uint8),
            lens=corners,
        )
        return traced.part(most > 0)


def _chunks(count: int) -> list[slice]:
    return [slice(first, first + _CHUNK) for first in range(0, count, _CHUNK)] or [slice(0, 0)]


def _shares(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """The parts (a, b) of the lens that its cells are, as drawn: quadrilaterals between corners (a + 1, b + 1, 2)."""
    down, up = corners[1:, 1:] - corners[:-1, :-1], corners[:-1, 1:] - corners[1:, :-1]
    areas = np.abs(down[..., 0] * up[..., 1] - up[..., 0] * down[..., 1])
    return areas / areas.sum()


def _joined(parts: Sequence[StarImages], firsts: Sequence[int] = ()) -> StarImages:
    """One list of images; `firsts`: the number of each part's first star, if they count from there."""
    joined = {field.name: [getattr(part, field.name) for part in parts] for field in fields(StarImages)[:-1]}
    if firsts:
        joined["star"] = [star + first for star, first in zip(joined["star"], firsts, strict=True)]
    return StarImages(*map(np.concatenate, joined.values()), parts[0].lens)
