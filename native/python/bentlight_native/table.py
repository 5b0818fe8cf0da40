"""Deflection tables: fate and direction of a ray by lookup, in the core and as OpenEXR images for shaders."""

import itertools
import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from .exr import ExrError, read_exr, write_exr

MAP_VERSION, _SCHWARZSCHILD_MAX, _ELLIS_MIN = _core.table_constants()
# Octaves of |b/b_c - 1| that the images cover, and their sizes.
_OCTAVES = {"outside": (-24.0, 24.0), "inside": (-24.0, 0.0)}
_TOTAL_WIDTH = 8192
_OUTWARD_SIZE = 768
_SPHERE_WIDTH = 2048


class MeasuredError(NamedTuple):
    """What lookups differ by from what they stand for, radians, measured between the nodes: of a table from direct
    evaluation, of its images from the table."""

    total_max: float
    total_rms: float
    sweep_max: float
    sweep_rms: float


def map_values(name: str, x: ArrayLike, p: ArrayLike = 0.0, q: ArrayLike = 0.0) -> NDArray[np.float64]:
    """The function `name` of the shared header table/map.h over arrays, e.g. "delta_coordinate"(size, low, high)."""
    x, p, q = np.broadcast_arrays(*(np.asarray(v, dtype=np.float64) for v in (x, p, q)))
    out = np.empty(x.shape)
    flat = [np.ascontiguousarray(v).ravel() for v in (x, p, q)]
    _core.table_map(name, *flat, out.reshape(-1))
    return out


def _in_parallel(build: Callable[[int, int], None], rows: int, threads: int | None) -> None:
    """Call build(first, last) over all rows, in a few ranges a thread."""
    threads = threads or os.cpu_count() or 1
    edges = np.linspace(0, rows, min(rows, 4 * threads) + 1).astype(int).tolist()
    with ThreadPoolExecutor(threads) as pool:
        for done in [pool.submit(build, *span) for span in itertools.pairwise(edges)]:
            done.result()


class DeflectionTable:
    """Lookups for a Schwarzschild or Ellis spacetime; see native/include/bentlight/table.h for what is tabulated.

    Args:
        spacetime: ``Spacetime.schwarzschild`` with a mass, or ``Spacetime.ellis``.
        threads: how many build it (a few milliseconds in all); None: one a processor.
        progress: a ``Progress``: ``done`` counts rows; ``cancel()`` stops the build with ``Cancelled``.

    Errors against direct evaluation are in ``measured`` (total 2e-13, sweep 4e-9 rad).
    """

    def __init__(
        self, spacetime: _core.Spacetime, *, threads: int | None = None, progress: _core.Progress | None = None
    ) -> None:
        self.spacetime = spacetime
        self._core = _core.table_new(spacetime)
        _in_parallel(lambda first, last: self._core.build(first, last, progress), self._core.rows, threads)
        self.measured = MeasuredError(*self._core.measured())

    def total(self, delta: ArrayLike) -> NDArray[np.float64]:
        """Angle swept from infinity to infinity, radians, (n,) for delta = b/b_c - 1; NaN where nothing returns.

        The deflection is this less pi. Ellis: delta < 0 goes through the throat.
        """
        delta = np.ascontiguousarray(delta, dtype=np.float64)
        angle = np.empty_like(delta)
        self._core.total(delta.reshape(-1), angle.reshape(-1))
        return angle

    def sweep(self, radius: ArrayLike, cosine: ArrayLike, sine: ArrayLike) -> tuple[NDArray, NDArray]:
        """Fate (uint8) and swept angle of rays from a chart radius at an angle to the outward radial, (n,) each.

        Both cosine and sine (>= 0) of the angle are asked for: far away neither gives the other. The angle is NaN
        unless the ray escapes.
        """
        radius, cosine, sine = (np.ascontiguousarray(v, dtype=np.float64) for v in (radius, cosine, sine))
        fate, swept = np.empty(len(radius), np.uint8), np.empty(len(radius))
        self._core.sweep(radius, cosine, sine, fate, swept)
        return fate, swept

    def trace(self, origins: ArrayLike, directions: ArrayLike) -> dict[str, NDArray]:
        """Fate and asymptotic direction, as ``trace_rays`` returns them, by lookup. (n, 3) float64 each."""
        origins, directions = (np.ascontiguousarray(v, dtype=np.float64) for v in (origins, directions))
        n = len(origins)
        fate, direction, error, swept = np.empty(n, np.uint8), np.empty((n, 3)), np.empty(n), np.empty(n)
        self._core.trace(origins, directions, fate, direction, error, swept)
        return {"fate": fate, "direction": direction, "error": error, "swept": swept}


def table_header(spacetime: _core.Spacetime, kind: str, **numbers: float) -> dict[str, str]:
    """Header attributes that a reader must find unchanged."""
    strings = {"bentlightKind": kind, "bentlightMapVersion": str(MAP_VERSION), "bentlightSpacetime": repr(spacetime)}
    return strings | {f"bentlight{name.capitalize()}": repr(float(value)) for name, value in numbers.items()}


def _checked(path: str | os.PathLike, wanted: dict[str, str]) -> tuple[dict[str, NDArray[np.float32]], dict[str, str]]:
    channels, header = read_exr(path)
    for name, value in wanted.items():
        if name not in header:
            raise ExrError(f"{path}: its header lacks {name}: it is not a Bentlight table")
        if header[name] != value:
            raise ExrError(f"{path}: {name} is {header[name]}, expected {value}")
    return channels, header


def _linear(row: NDArray, coordinate: NDArray) -> NDArray[np.float64]:
    """Linear interpolation with clamping, texel i at i / (n - 1)."""
    at = np.clip(coordinate, 0, 1) * (len(row) - 1)
    low = np.minimum(at.astype(int), len(row) - 2)
    return row[low] + (at - low) * (row[low + 1].astype(np.float64) - row[low])


class SampledTable:
    """A deflection table as float32 images, the form that shaders read: linear interpolation through table/map.h.

    "total" has one line of channels ``outside`` (delta > 0) and, for Ellis, ``inside``; "outward" is J over position
    (lines) and cosine (pixels). With `sphere_radius` "outward" has one line: a lens sphere of that chart radius.
    Errors against the table are in ``measured`` and in the files' headers.
    """

    measured: MeasuredError

    def __init__(
        self, spacetime: _core.Spacetime, total: dict[str, NDArray], outward: NDArray, radius: float = 0.0
    ) -> None:
        self.spacetime, self._total, self._outward, self.sphere_radius = spacetime, total, outward, radius

    @classmethod
    def from_table(cls, table: DeflectionTable, sphere_radius: float = 0.0) -> "SampledTable":
        """Sample `table`; with a radius, just what a lens sphere of that chart radius needs."""
        total = {}
        for side, (low, high) in _OCTAVES.items():
            if side == "outside" or table.spacetime.kind == "ellis":
                size = map_values("delta_from_coordinate", np.linspace(0, 1, _TOTAL_WIDTH), low, high)
                size = size if side == "outside" else np.minimum(size, 1 - 1e-12)
                angle = table.total(size if side == "outside" else -size)
                total[side] = map_values("total_stored", size, angle).astype(np.float32)
        cosine = np.linspace(0, 1, _SPHERE_WIDTH if sphere_radius else _OUTWARD_SIZE)
        radii = np.array([sphere_radius]) if sphere_radius else _radii(table)
        self = cls(table.spacetime, total, _outward(table, radii, cosine).astype(np.float32), sphere_radius)
        self.measured = MeasuredError(*self._total_error(table), *self._outward_error(table))
        return self

    def _total_error(self, table: DeflectionTable) -> tuple[float, float]:
        """Largest and RMS error of the total angle in the middle between pixels."""
        errors = []
        for side, (low, high) in _OCTAVES.items():
            if side in self._total:
                size = map_values("delta_from_coordinate", _middles(_TOTAL_WIDTH), low, high)
                delta = size if side == "outside" else -size
                errors.append(self.total(delta) - table.total(delta))
        return _max_and_rms(np.concatenate(errors))

    def _outward_error(self, table: DeflectionTable) -> tuple[float, float]:
        """Largest and RMS error of the angle swept going out in the middle of every cell."""
        is_ellis = table.spacetime.kind == "ellis"
        cosine = _middles(self._outward.shape[1])
        sine = np.sqrt((1 - cosine) * (1 + cosine))
        position, radii = np.zeros(1), np.array([self.sphere_radius])
        if not self.sphere_radius:
            low, high = _position_range(is_ellis)
            position = low + (high - low) * _middles(_OUTWARD_SIZE)
            radii = _chart_radius(table.spacetime, position)
        error = self.outward(position[:, None], cosine, sine) - _outward(table, radii, cosine) * sine
        return _max_and_rms(error)

    def total(self, delta: ArrayLike) -> NDArray[np.float64]:
        """As ``DeflectionTable.total``, for 2^-24 <= |delta| <= 2^24 (inside: |delta| < 1)."""
        delta = np.asarray(delta, dtype=np.float64)
        angle = np.full(delta.shape, np.nan)
        for side, row in self._total.items():
            chosen = delta > 0 if side == "outside" else (delta < 0) & (delta > -1)
            size = np.abs(delta[chosen])
            stored = _linear(row, map_values("delta_coordinate", size, *_OCTAVES[side]))
            angle[chosen] = map_values("total_from_stored", size, stored)
        return angle

    def outward(self, position: ArrayLike, cosine: ArrayLike, sine: ArrayLike) -> NDArray[np.float64]:
        """Angle swept going out from `position` (M/r or l/r; ignored for a lens sphere)."""
        lines = self._outward
        if len(lines) == 1:
            return np.asarray(sine) * _linear(lines[0], np.asarray(cosine))
        low, high = _position_range(self.spacetime.kind == "ellis")
        at = np.clip((np.asarray(position) - low) / (high - low), 0, 1) * (len(lines) - 1)
        line = np.minimum(at.astype(int), len(lines) - 2)
        column = np.clip(np.asarray(cosine), 0, 1) * (lines.shape[1] - 1)
        pixel = np.minimum(column.astype(int), lines.shape[1] - 2)
        x, y = at - line, column - pixel
        near = lines[line, pixel] * (1 - y) + lines[line, pixel + 1] * y
        far = lines[line + 1, pixel] * (1 - y) + lines[line + 1, pixel + 1] * y
        return np.asarray(sine) * (near * (1 - x) + far * x)

    def write(self, total_path: str | os.PathLike, outward_path: str | os.PathLike) -> None:
        """Write the two images as OpenEXR, each to a temporary name and then renamed."""
        channels = {side: row[None] for side, row in self._total.items()}
        header = table_header(self.spacetime, "total")
        write_exr(total_path, channels, header | _error_header(self.measured[:2]))
        header = table_header(self.spacetime, "outward", radius=self.sphere_radius)
        write_exr(outward_path, {"outward": self._outward}, header | _error_header(self.measured[2:]))

    @classmethod
    def read(
        cls,
        spacetime: _core.Spacetime,
        total_path: str | os.PathLike,
        outward_path: str | os.PathLike,
        sphere_radius: float = 0.0,
    ) -> "SampledTable":
        """Read both images; ``ExrError`` if one is damaged or of another spacetime, radius or map version."""
        channels, total_header = _checked(total_path, table_header(spacetime, "total"))
        outward, header = _checked(outward_path, table_header(spacetime, "outward", radius=sphere_radius))
        self = cls(spacetime, {side: rows[0] for side, rows in channels.items()}, outward["outward"], sphere_radius)
        self.measured = MeasuredError(*_read_error(total_path, total_header), *_read_error(outward_path, header))
        return self


def _middles(size: int) -> NDArray[np.float64]:
    """Coordinates halfway between the texels of a line."""
    return (np.arange(size - 1) + 0.5) / (size - 1)


def _max_and_rms(error: NDArray) -> tuple[float, float]:
    return float(np.abs(error).max()), float(np.sqrt(np.mean(error**2)))


def _error_header(max_and_rms: tuple[float, float]) -> dict[str, str]:
    return {"bentlightMeasured": " ".join(map(repr, max_and_rms))}


def _read_error(path: str | os.PathLike, header: dict[str, str]) -> tuple[float, float]:
    """Largest and RMS error out of a header."""
    try:
        largest, rms = map(float, header["bentlightMeasured"].split())
    except (KeyError, ValueError):
        raise ExrError(f"{path}: its header lacks bentlightMeasured: it is not a Bentlight table") from None
    return largest, rms


def _position_range(is_ellis: bool) -> tuple[float, float]:
    return (_ELLIS_MIN, 1.0) if is_ellis else (0.0, _SCHWARZSCHILD_MAX)


def _radii(table: DeflectionTable) -> NDArray[np.float64]:
    """Chart radii of the lines of the outward image; the ends that stand for infinity are a hair inside."""
    low, high = _position_range(table.spacetime.kind == "ellis")
    return _chart_radius(table.spacetime, np.clip(np.linspace(low, high, _OUTWARD_SIZE), 1e-12, 1 - 1e-12))


def _chart_radius(spacetime: _core.Spacetime, position: NDArray) -> NDArray[np.float64]:
    """Of positions M/r or l/r."""
    if spacetime.kind == "ellis":
        return spacetime.core_radius / map_values("ratio_ellis", position)
    if spacetime.chart == "areal":
        return 0.5 * spacetime.core_radius / position
    return spacetime.core_radius / map_values("ratio_schwarzschild", position)


def _outward(table: DeflectionTable, radii: NDArray, cosine: NDArray) -> NDArray[np.float64]:
    """J = swept / sin over (radius, cosine); its limit toward cosine 1 is reached a hair before."""
    cosine = np.minimum(cosine, 1 - 1e-9)
    sine = np.sqrt((1 - cosine) * (1 + cosine))
    grid = np.broadcast_arrays(radii[:, None], cosine, sine)
    _, swept = table.sweep(*(v.ravel() for v in grid))
    return swept.reshape(grid[0].shape) / sine
