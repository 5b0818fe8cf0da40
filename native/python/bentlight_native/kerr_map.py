"""Where rays from a fixed radius of a Kerr hole end, as an image for shaders, with its own map of errors.

Three numbers in (polar angle of the observer; angle psi from the inward radial; position angle chi), the asymptotic
direction out. At each position angle psi is measured from the shadow's edge, logarithmically (table/map.h). By the
symmetry of the hole only the northern half is stored. The core itself traces Kerr rays directly: it is as fast and
exact; this is for shaders only.
"""

import os
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from .exr import ExrError, read_exr, write_exr
from .table import map_values, table_header
from .trace import trace_rays

_BISECTIONS = 44
_SMALLEST = 1e-4  # distance from the edge, in units of its range, where the image begins


class KerrMapError(NamedTuple):
    """Angular errors of lookups against tracing, radians: of rays within three radii of the shadow's middle."""

    median: float
    rms: float
    p95: float
    maximum: float


def _unit(vectors: NDArray) -> NDArray:
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


class KerrMap:
    """Asymptotic directions of rays from Boyer-Lindquist radius `radius`, for every polar angle and direction.

    Args:
        spacetime: ``Spacetime.kerr``; mass and spin are read from it.
        radius: Boyer-Lindquist radius of the observers, outside the region where the shadow fills half the sky.
        shape: (polar angles, position angles, distances from the edge).
        threads, progress: as in ``DeflectionTable``; ``progress.done`` counts polar angles.

    Attributes: ``edge`` (polar, position) float32, psi of the shadow's edge; ``direction`` (polar, position, distance,
    3) float32 at observer azimuth 0; ``error`` (polar - 1, position, distance - 1) float32, radians, measured in the
    middle of each cell.
    """

    def __init__(
        self,
        spacetime: _core.Spacetime,
        radius: float,
        shape: tuple[int, int, int] = (33, 256, 128),
        *,
        threads: int | None = None,
        progress: _core.Progress | None = None,
    ) -> None:
        if spacetime.kind != "kerr":
            raise ValueError("spacetime: expected Spacetime.kerr")
        if not (np.isfinite(radius) and radius >= 4 * spacetime.mass > 0):
            raise ValueError(f"radius: must be at least 4 masses, got {radius}")
        if min(shape) < 3:
            raise ValueError(f"shape: each size must be at least 3, got {shape}")
        self.spacetime, self.radius, self.shape = spacetime, float(radius), shape
        self.polar = np.linspace(0, np.pi / 2, shape[0])
        self.position = np.arange(shape[1]) * (2 * np.pi / shape[1])
        self._build(threads, progress)

    def _build(self, threads: int | None, progress: _core.Progress | None) -> None:
        def row(polar: float) -> tuple[NDArray, NDArray]:
            if progress is not None and progress.cancelled:
                raise _core.Cancelled("building a Kerr map was cancelled")
            result = self._row(polar)
            if progress is not None:
                progress.advance(1)
            return result

        with ThreadPoolExecutor(threads or os.cpu_count()) as pool:
            rows = list(pool.map(row, self.polar))
        self.edge = np.stack([edge for edge, _ in rows]).astype(np.float32)
        self.direction = np.stack([direction for _, direction in rows]).astype(np.float32)
        self.error = self._error_map()

    def rays(self, polar: ArrayLike, psi: ArrayLike, chi: ArrayLike) -> tuple[NDArray, NDArray]:
        """Chart positions and local directions (n, 3): psi from the inward radial, chi from east toward south."""
        polar, psi, chi = np.broadcast_arrays(*(np.asarray(v, dtype=np.float64) for v in (polar, psi, chi)))
        r, a = self.radius, self.spacetime.spin
        h, sine, cosine = np.hypot(r, a), np.sin(polar), np.cos(polar)
        root = np.sqrt(r * r + a * a * cosine * cosine)
        zero = np.zeros_like(sine)
        outward = np.stack([r * sine, zero, h * cosine], axis=-1) / root[..., None]
        south = np.stack([h * cosine, zero, -r * sine], axis=-1) / root[..., None]
        east = np.array([0.0, 1.0, 0.0])
        across = np.cos(chi)[..., None] * east + np.sin(chi)[..., None] * south
        position = np.stack([h * sine, zero, r * cosine], axis=-1)
        return position, np.sin(psi)[..., None] * across - np.cos(psi)[..., None] * outward

    def _trace(self, polar: ArrayLike, psi: ArrayLike, chi: ArrayLike) -> dict[str, NDArray]:
        position, direction = self.rays(polar, psi, chi)
        return trace_rays(self.spacetime, position.reshape(-1, 3), direction.reshape(-1, 3), 1e-8)

    def _row(self, polar: float) -> tuple[NDArray, NDArray]:
        """Edge of the shadow by bisection of the fate, then directions beyond it."""
        low, high = np.zeros(self.shape[1]), np.full(self.shape[1], np.pi)
        for _ in range(_BISECTIONS):
            middle = 0.5 * (low + high)
            escaped = self._trace(polar, middle, self.position)["fate"] == 1
            low, high = np.where(escaped, low, middle), np.where(escaped, middle, high)
        psi = map_values("psi_from_coordinate", np.linspace(0, 1, self.shape[2]), high[:, None], _SMALLEST)
        direction = self._trace(polar, psi, self.position[:, None])["direction"]
        return high, direction.reshape(*self.shape[1:], 3)

    def lookup(self, polar: ArrayLike, psi: ArrayLike, chi: ArrayLike) -> tuple[NDArray, NDArray]:
        """Fate (uint8) and asymptotic direction (n, 3) at observer azimuth 0 by linear interpolation.

        Closer to the shadow's edge than the image reaches, the nearest stored direction is returned.
        """
        polar, psi, chi = (np.atleast_1d(np.asarray(v, dtype=np.float64)) for v in (polar, psi, chi))
        south = polar > np.pi / 2
        polar, chi = np.where(south, np.pi - polar, polar), np.where(south, -chi, chi)
        weights, corners = self._corners(polar, chi)
        edge = sum(w * self.edge[i, j] for w, (i, j) in zip(weights, corners, strict=True))
        fate = np.where(psi > edge, 1, 2).astype(np.uint8)
        beyond = np.maximum(psi, edge + _SMALLEST * (np.pi - edge))
        at = np.clip(map_values("edge_coordinate", beyond, edge, _SMALLEST), 0, 1) * (self.shape[2] - 1)
        k = np.minimum(at.astype(int), self.shape[2] - 2)
        t = (at - k)[:, None]
        direction = sum(
            w[:, None] * ((1 - t) * self.direction[i, j, k] + t * self.direction[i, j, k + 1])
            for w, (i, j) in zip(weights, corners, strict=True)
        )
        direction = _unit(direction) * np.where(south[:, None], [1, 1, -1], 1)
        return fate, np.where((fate == 1)[:, None], direction, np.nan)

    def _corners(self, polar: NDArray, chi: NDArray) -> tuple[list[NDArray], list[tuple[NDArray, NDArray]]]:
        """Bilinear weights and indices of the four stored (polar, position) columns around each ray."""
        u = polar / (np.pi / 2) * (self.shape[0] - 1)
        v = np.mod(chi / (2 * np.pi), 1) * self.shape[1]
        i, j = np.minimum(u.astype(int), self.shape[0] - 2), v.astype(int) % self.shape[1]
        x, y, right = u - i, v - np.floor(v), (j + 1) % self.shape[1]
        weights = [(1 - x) * (1 - y), (1 - x) * y, x * (1 - y), x * y]
        return weights, [(i, j), (i, right), (i + 1, j), (i + 1, right)]

    def _difference(self, polar: NDArray, psi: NDArray, chi: NDArray) -> NDArray[np.float64]:
        """Angle between lookup and tracing; pi where the fates differ."""
        traced = self._trace(polar, psi, chi)
        fate, direction = self.lookup(polar, psi, chi)
        apart = 2 * np.arcsin(np.clip(0.5 * np.linalg.norm(direction - traced["direction"], axis=1), 0, 1))
        return np.where(fate != traced["fate"], np.pi, np.where(fate == 1, apart, 0))

    def _error_map(self) -> NDArray[np.float32]:
        polar = 0.5 * (self.polar[1:] + self.polar[:-1])
        chi = self.position + np.pi / self.shape[1]
        at = (np.arange(self.shape[2] - 1) + 0.5) / (self.shape[2] - 1)
        grid_polar, grid_chi, grid_at = (g.ravel() for g in np.meshgrid(polar, chi, at, indexing="ij"))
        weights, corners = self._corners(grid_polar, grid_chi)
        edge = sum(w * self.edge[i, j] for w, (i, j) in zip(weights, corners, strict=True))
        psi = map_values("psi_from_coordinate", grid_at, edge, _SMALLEST)
        shape = (self.shape[0] - 1, self.shape[1], self.shape[2] - 1)
        return self._difference(grid_polar, psi, grid_chi).reshape(shape).astype(np.float32)

    def measure(self, count: int = 20000, seed: int = 0) -> KerrMapError:
        """Errors of `count` rays, uniform in solid angle within three radii of the shadow, from all over the sphere."""
        random = np.random.default_rng(seed)
        widest = min(3 * float(self.edge.max()), np.pi)
        polar = np.arccos(random.uniform(-1, 1, count))
        psi = np.arccos(random.uniform(np.cos(widest), 1, count))
        error = self._difference(polar, psi, random.uniform(0, 2 * np.pi, count))
        rms = np.sqrt(np.mean(error**2))
        return KerrMapError(*map(float, (np.median(error), rms, np.percentile(error, 95), error.max())))

    def _header(self, kind: str) -> dict[str, str]:
        return table_header(self.spacetime, kind, radius=self.radius, smallest=_SMALLEST) | {
            "bentlightShape": " ".join(map(str, self.shape))
        }

    def write(self, path: str | os.PathLike, error_path: str | os.PathLike) -> None:
        """Write the image (channels R, G, B: direction; A: edge; one line a column) and the error map beside it."""
        lines = self.direction.reshape(-1, self.shape[2], 3)
        edge = np.repeat(self.edge.reshape(-1, 1), self.shape[2], axis=1)
        channels = {"R": lines[..., 0], "G": lines[..., 1], "B": lines[..., 2], "A": edge}
        write_exr(path, channels, self._header("kerr"))
        write_exr(error_path, {"error": self.error.reshape(-1, self.shape[2] - 1)}, self._header("kerr error"))

    @classmethod
    def read(cls, spacetime: _core.Spacetime, radius: float, path: str | os.PathLike) -> "KerrMap":
        """Read an image of this spacetime and radius, without its ``error``; ``ExrError`` if damaged or another's."""
        channels, header = read_exr(path)
        self = object.__new__(cls)
        self.spacetime, self.radius = spacetime, float(radius)
        try:
            self.shape = tuple(int(size) for size in header["bentlightShape"].split())
        except (KeyError, ValueError):
            raise ExrError(f"{path}: its header lacks bentlightShape: it is not a Kerr map") from None
        for name, value in self._header("kerr").items():
            if header.get(name) != value:
                raise ExrError(f"{path}: {name} is {header.get(name)}, expected {value}")
        self.polar = np.linspace(0, np.pi / 2, self.shape[0])
        self.position = np.arange(self.shape[1]) * (2 * np.pi / self.shape[1])
        self.direction = np.stack([channels[c] for c in "RGB"], axis=-1).reshape(*self.shape, 3)
        self.edge = channels["A"][:, 0].reshape(self.shape[:2])
        return self
