"""Stars as a table that a shader finds them in: one star a cell of the sphere. No bpy.

There are `size` / 2 rows of equal height from the south pole to the north pole. A row has size / 2^k cells, with k so
that cells are between 0.7 and 1.4 times as wide as they are high; the first begins at -x and they go around by +y.
"""

from __future__ import annotations

import numpy as np

_SIZES = 256, 2048
_CELLS_PER_STAR = 16


def size_for(count: int) -> int:
    """Cells at the equator for so many stars: a power of two, of at most 50 MB."""
    wanted = 2 ** np.ceil(np.log2(np.sqrt(2 * _CELLS_PER_STAR * max(count, 1))))
    return int(np.clip(wanted, *_SIZES))


def column_counts(size: int) -> np.ndarray:
    """Cells of each row."""
    sines = np.sin(np.pi * (np.arange(size // 2) + 0.5) / (size // 2))
    return size // 2 ** np.floor(0.5 - np.log2(sines)).astype(int)


def star_cells(directions: np.ndarray, irradiance: np.ndarray, size: int) -> np.ndarray:
    """(size / 2, size, 6) float32: the direction and the irradiance of each cell's star; zeros where there is none.

    directions: (n, 3) unit; irradiance: (n, 3). Stars that share a cell become one of all their light between them.
    """
    x, y, z = directions.T
    rows = size // 2
    row = np.clip((np.arctan2(z, np.hypot(x, y)) / np.pi + 0.5) * rows, 0, rows - 1).astype(int)
    columns = column_counts(size)[row]
    column = np.minimum((np.arctan2(y, x) / (2 * np.pi) + 0.5) * columns, columns - 1).astype(int)
    sums = np.zeros((rows, size, 6))
    weights = irradiance.sum(axis=1, keepdims=True)
    np.add.at(sums, (row, column), np.hstack([directions * weights, irradiance]))
    lengths = np.linalg.norm(sums[..., :3], axis=-1, keepdims=True)
    np.divide(sums[..., :3], lengths, out=sums[..., :3], where=lengths > 0)
    return sums.astype(np.float32)
