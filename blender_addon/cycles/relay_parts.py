"""Into how many parts the relay camera's maps cut a pixel: more where the image is compressed, and at its edges.

What Cycles holds of the maps grows with them. So their number has a limit: where more would take finer parts, rays must
spread farther for that, all over the picture alike. No bpy here.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

# So many times as many parts in each direction, the fewest that spread no more each than parts do where the image is
# not compressed; or the most. Odd: a part in the middle of a pixel stays there.
FINER = np.array([3, 5])
LOST = 0  # the fate of rays that nobody sees
_COMPRESSION = 0.1  # radians by which bending spreads a pixel's rays then. Where the engine takes a second sample.
_EDGE = 1000.0  # compressions: what edges of shadows and of disks count as, more than any rays spread
# Maps of all slices may have so much, or so much for each part where none is finer: the same for 4 x 4 parts in 1920 x
# 1080, where Blender itself and a scene take 0.5 GiB.
_LEAST_BYTES, _BYTES_A_PART = 1520 << 20, 48


def spreads(start: np.ndarray, end: np.ndarray, fate: np.ndarray, layers: np.ndarray, parts: int) -> np.ndarray:
    """How far bending spreads pixels' rays, in compressions: (2, 2, rows, columns) float32, by axis the farthest and
    the usual one. Of rays' directions at their start and their end, (rows * parts, columns * parts, 3), and (rows *
    parts, columns * parts) how they end and how many disks they meet.

    Rays that pass an edge of a thing spread beyond it, too. There fewer than half of the neighbors do.
    """
    shape = fate.shape
    rows, columns = shape[0] // parts, shape[1] // parts
    layers, found = layers.astype(np.int64), np.zeros((2, 2, rows, columns), np.float32)
    for axis in (0, 1):
        before, after = (np.linalg.norm(np.diff(values, axis=axis), axis=-1) for values in (start, end))
        one, other = (np.take(fate, range(*span), axis) for span in ((0, shape[axis] - 1), (1, shape[axis])))
        with np.errstate(invalid="ignore"):
            spread = np.where((one == other) & (one != LOST), (after - before) * (parts / _COMPRESSION), 0)
        spread[((one == LOST) != (other == LOST)) | (np.diff(layers, axis=axis) != 0)] = _EDGE
        spread = np.pad(spread, [(0, int(i == axis)) for i in (0, 1)])
        of_pixel = spread.reshape(rows, parts, columns, parts).swapaxes(1, 2).reshape(rows, columns, -1)
        found[axis, 0] = of_pixel.max(axis=-1)
        found[axis, 1] = np.partition(of_pixel, parts**2 // 2, axis=-1)[..., parts**2 // 2]
    return found


def times_as_fine(spread: np.ndarray, limit: float = 1.0) -> np.ndarray:
    """How many times as many parts each way pixels take, (rows, columns), 0: no more; by `spreads`. Where some rays
    spread more than so many compressions they take more; the most at edges of shadows and disks."""
    widest, usual = np.moveaxis(spread / limit, 1, 0)
    enough = FINER[np.searchsorted(FINER[:-1], np.where(widest * limit >= _EDGE, widest, usual))]
    return np.where(widest > 1, enough, 0).max(axis=0)


def affordable(spread: Sequence[np.ndarray], parts: int, ray_bytes: int, slices: int = 1) -> float:
    """The limit with which the maps of one of so many slices take no more memory than they may: 1 where it can be, a
    power of 2. By the `spreads` of all bands; each ray takes so many bytes."""
    pixels, limit = sum(one[0, 0].size for one in spread), 1.0
    most = max(_BYTES_A_PART * pixels * parts**2, _LEAST_BYTES // slices)
    while ray_bytes * parts**2 * (pixels + sum(np.square(times_as_fine(one, limit)).sum() for one in spread)) > most:
        limit *= 2
    return limit
