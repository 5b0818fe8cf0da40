"""The maps of the relay camera: where the last straight leg of each curved camera ray starts. No bpy here.

Every part of every pixel gets one ray, which the core traces through the scene to the surface that it meets or to
infinity. What osl/relay_maps.h reads is where that ray's last leg starts (`place`) and its `direction`. The files are
described there. Memory is bounded: bands of pixel rows are traced and written one by one.
"""

from __future__ import annotations

import math
import time
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass, field
from pathlib import Path

import bentlight_native
import numpy as np
from bentlight_native import FATES, write_exr

from ..sync.scene_data import CameraData, Visibility
from .aperture import Aperture
from .motion import Slice

ESCAPED, HIT = FATES.index("escaped"), FATES.index("hit")
_MARGIN = 4  # pixels around the image: a pixel filter reaches beyond it
_BAND_RAYS = 1 << 18  # at most, of one thread at a time; a ray takes about 300 bytes
_FINER = 5  # times as many parts in each direction where the image is compressed
_FINE_PIXELS = 1 << 9  # traced at a time
_COLUMNS = 64  # cells in a row of the fine maps
# Bending spreads the rays of a pixel by so many radians: a compressed image. Where the engine takes a second sample.
_COMPRESSION = 0.1
# The last leg starts this far before the surface, as a part of the ray's length and of the largest coordinate (float32
# has 6e-8 of it): Cycles must neither miss the surface nor meet another one first.
_LEG_OF_LENGTH, _LEG_OF_COORDINATES = 1e-4, 4e-6
_FAR = 1e4  # sizes of the scene, at which a leg to infinity starts
_SHIFTS = np.array([0.7548777, 0.5698403])  # of the parts of slices, from one to the next (osl/relay_maps.h)
_MOMENTS = np.array([math.sqrt(2), math.sqrt(3)])  # of parts in a slice: independent of all other lattices
_APART = 1_000_003  # parts, between the lattices of neighboring slices


@dataclass(frozen=True)
class RelaySettings:
    """What the maps are to be like. parts: of a pixel in each direction. tolerance: of hits, scene units;
    angular_tolerance: of directions, radians."""

    parts: int = 4
    tolerance: float = 1e-4
    angular_tolerance: float = 1e-5
    threads: int = 1


@dataclass
class RelayMaps:
    """Maps on disk. `parameters` are those of the shader."""

    parameters: dict[str, int | float | str]
    files: list[Path] = field(default_factory=list)
    rays: int = 0
    lost: int = 0  # rays that a horizon or an end of space swallows, and unresolved ones
    fine_pixels: int = 0
    seconds: float = 0.0

    def add(self, more: RelayMaps) -> None:
        """Counts files and rays of a part of them."""
        self.files += more.files
        self.rays, self.lost = self.rays + more.rays, self.lost + more.lost
        self.fine_pixels += more.fine_pixels
        self.seconds += more.seconds


def bake(
    scene: bentlight_native.Scene,
    camera: CameraData,
    prefix: Path,
    settings: RelaySettings,
    aperture: Aperture | None = None,
    part: Slice | None = None,
    early: np.ndarray | None = None,
) -> RelayMaps:
    """Traces and writes the maps of one slice of the shutter's time, or of a frame in which nothing moves: in the
    world's axes, or in the camera's as Cycles has them (x right, y up, z forward). Their paths begin with `prefix`.

    `scene` is committed and has this camera. `early`: for each of its instances, how much earlier than elsewhere the
    last legs of rays that meet it start; none: nowhere.
    """
    start = time.monotonic()
    tracer = _Tracer(scene, camera, settings, aperture, part, early)
    width, height = camera.width + 2 * _MARGIN, camera.height + 2 * _MARGIN
    band = max(1, min(height, _BAND_RAYS // (width * settings.parts**2)))
    angle, size = _pixel(camera)
    maps = RelayMaps(
        {
            "Maps": str(prefix),
            "Width": camera.width,
            "Height": camera.height,
            "Margin": _MARGIN,
            "Band": band,
            "Parts": settings.parts,
            "Fine": settings.parts * _FINER,
            "Slices": part.count if part else 0,
            "PixelAngle": angle,
            "PixelSize": size,
        }
    )
    with ThreadPoolExecutor(settings.threads) as pool:
        waiting = [pool.submit(_write_band, tracer, prefix, i, band) for i in range(math.ceil(height / band))]
        for done in as_completed(waiting):
            maps.add(done.result())
    maps.seconds = time.monotonic() - start
    return maps


def remove(files: list[Path]) -> None:
    """Deletes maps; those that are gone already do no harm."""
    for file in files:
        file.unlink(missing_ok=True)


def _pixel(camera: CameraData) -> tuple[float, float]:
    """How far neighboring pixels look apart: about so many radians, and scene units."""
    span = (camera.window[1] - camera.window[0]) / camera.width
    if camera.kind == "ORTHOGRAPHIC":
        return 0.0, span
    return (span if camera.kind == "PERSPECTIVE" else 2 * math.pi * span), 0.0


@dataclass
class _Legs:
    """Last legs: (n, 3) float32 each. The length of a direction is how bright light from there is; 0: a lost ray."""

    place: np.ndarray
    direction: np.ndarray

    def write(self, stem: str, shape: tuple[int, int]) -> list[Path]:
        files = []
        for name, values in (("place", self.place), ("direction", self.direction)):
            files.append(Path(f"{stem}{name}.exr"))
            write_exr(files[-1], {channel: values[:, i].reshape(shape) for i, channel in enumerate("RGB")}, {})
        return files


class _Tracer:
    """Rays through points of the image, in pixels from its lower left corner, to their last legs."""

    def __init__(
        self,
        scene: bentlight_native.Scene,
        camera: CameraData,
        settings: RelaySettings,
        aperture: Aperture | None,
        part: Slice | None,
        early: np.ndarray | None,
    ) -> None:
        self.camera, self.settings = camera, settings
        self.number = part.number if part else 0
        self._scene, self._aperture, self._slice, self._early = scene, aperture, part, early
        camera_from_world = np.linalg.inv(camera.world_from_camera)
        self._axes = np.eye(4) if part else np.diag([1.0, 1.0, -1.0, 1.0]) @ camera_from_world
        self._drift = part.change @ camera_from_world if part else None  # of the world's points with the camera
        self._shift = (np.mod(self.number * _SHIFTS + 0.5, 1.0) - 0.5) / settings.parts

    def trace(self, points: np.ndarray, parts: int) -> tuple[_Legs, np.ndarray, np.ndarray]:
        """Legs of rays through `points` (n, 2), and the directions, world, in which they start and end."""
        number = np.floor(points * parts).astype(np.int64) + self.number * _APART
        rays = self._scene.camera_rays((points + self._shift) / (self.camera.width, self.camera.height))
        origins, directions = rays.origins, rays.directions
        exists = np.isfinite(directions[:, 0])
        origins, directions = np.where(exists[:, None], origins, 0.0), np.where(exists[:, None], directions, (0, 0, 1))
        if self._aperture is not None:
            lens = self._aperture.sample(number)
            origins, directions = self._aperture.refract(self.camera.world_from_camera, origins, directions, lens)
        if self._slice is not None:
            origins, directions = self._moved(origins, directions, number)
        hits = self._scene.intersect(
            origins,
            directions,
            self.settings.tolerance,
            angular_tolerance=self.settings.angular_tolerance,
            length_min=self.camera.clip_start,
            length_max=self.camera.clip_end,
            visibility=Visibility.CAMERA,
        )
        legs = self._legs(hits, exists)
        brightness = self._scene.shift_light(
            origins, directions, hits["position"], hits["direction"], hits["fate"] != HIT
        )
        legs.direction *= brightness[:, None].astype(np.float32)
        return legs, directions, hits["direction"]

    def _moved(self, origins: np.ndarray, directions: np.ndarray, number: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Each part of the image looks from where the camera is in a moment of the slice of its own."""
        moment = np.mod(number @ _MOMENTS, 1.0)[:, None] - 0.5
        turn, way = self._drift[:3, :3], self._drift[:3, 3]
        turned = directions + moment * (directions @ turn.T)
        return (
            origins + moment * (origins @ turn.T + way),
            turned / np.linalg.norm(turned, axis=1, keepdims=True),
        )

    def _legs(self, hits: dict[str, np.ndarray], exists: np.ndarray) -> _Legs:
        fate, end, direction = hits["fate"], hits["position"], hits["direction"]
        escaped = exists & (fate == ESCAPED) & (hits["sky"] < 0)
        hit = exists & (fate == HIT)
        before = _LEG_OF_LENGTH * hits["length"] + _LEG_OF_COORDINATES * np.abs(end).max(axis=1)
        if self._early is not None and len(self._early):
            before = np.minimum(before + self._early[np.where(hit, hits["instance"], 0)], hits["length"])
        end = np.where(hit[:, None], end - before[:, None] * direction, _FAR * direction * self.camera.clip_end)
        seen = (hit | escaped)[:, None]
        place = np.where(seen, end @ self._axes[:3, :3].T + self._axes[:3, 3], 0.0)
        toward = np.where(seen, direction @ self._axes[:3, :3].T, 0.0)
        return _Legs(place.astype(np.float32), toward.astype(np.float32))


def _write_band(tracer: _Tracer, prefix: Path, number: int, band: int) -> RelayMaps:
    """The files of one band of pixel rows; the last band may reach beyond the margin."""
    parts, width = tracer.settings.parts, tracer.camera.width + 2 * _MARGIN
    stem = f"{prefix}{tracer.number:02}_{number:04}_"
    rows, columns = _centers(number * band, band, parts), _centers(0, width, parts)
    points = np.stack(np.meshgrid(columns, rows), axis=-1) - _MARGIN
    legs, start, end = tracer.trace(points.reshape(-1, 2), parts)
    shape = len(rows), len(columns)
    result = RelayMaps({}, legs.write(stem, shape), legs.place.shape[0], _lost(legs))
    compressed = _is_compressed(
        start.reshape(*shape, 3), end.reshape(*shape, 3), legs.direction.reshape(*shape, 3), parts
    )
    cells = np.full(compressed.shape, -1.0, np.float32)
    cells[compressed] = np.arange(compressed.sum())
    result.files.append(Path(f"{stem}cells.exr"))
    write_exr(result.files[-1], {"R": cells}, {})
    if compressed.any():
        corners = np.argwhere(compressed)[:, ::-1] + (0, number * band) - _MARGIN
        fine = _trace_cells(tracer, corners)
        result.files += fine.write(f"{stem}fine_", _cells_shape(len(corners), parts * _FINER))
        result.fine_pixels = len(corners)
        result.rays, result.lost = result.rays + len(fine.place), result.lost + _lost(fine)
    return result


def _centers(first: int, count: int, parts: int) -> np.ndarray:
    """Middles of the parts of `count` pixels from `first` on."""
    return first + (np.arange(count * parts) + 0.5) / parts


def _lost(legs: _Legs) -> int:
    return int((~legs.direction.any(axis=1)).sum())


def _is_compressed(start: np.ndarray, end: np.ndarray, legs: np.ndarray, parts: int) -> np.ndarray:
    """Which pixels (rows, columns) take finer parts: their rays spread much, or are lost in part.

    Arguments: (rows * parts, columns * parts, 3) directions before and after, and in the maps.
    """
    seen = legs.any(axis=-1)
    wide = np.zeros(seen.shape, bool)
    for axis in (0, 1):
        one, other = (np.take(seen, range(*span), axis) for span in ((0, seen.shape[axis] - 1), (1, seen.shape[axis])))
        before, after = (np.linalg.norm(np.diff(values, axis=axis), axis=-1) for values in (start, end))
        with np.errstate(invalid="ignore"):
            spread = (one & other & (after > before + _COMPRESSION / parts)) | (one != other)
        wide[: spread.shape[0], : spread.shape[1]] |= spread
    rows, columns = wide.shape[0] // parts, wide.shape[1] // parts
    return wide.reshape(rows, parts, columns, parts).any(axis=(1, 3))


def _cells_shape(count: int, fine: int) -> tuple[int, int]:
    return math.ceil(count / _COLUMNS) * fine, _COLUMNS * fine


def _trace_cells(tracer: _Tracer, corners: np.ndarray) -> _Legs:
    """The fine maps, row by row, of the pixels with these lower left corners (n, 2); cells without a pixel are lost."""
    fine = tracer.settings.parts * _FINER
    inside = np.stack(np.meshgrid(_centers(0, 1, fine), _centers(0, 1, fine)), axis=-1).reshape(-1, 2)
    count = math.ceil(len(corners) / _COLUMNS) * _COLUMNS
    place, direction = (np.zeros((count, fine * fine, 3), np.float32) for _ in range(2))
    for first in range(0, len(corners), _FINE_PIXELS):
        chosen = corners[first : first + _FINE_PIXELS]
        legs, _, _ = tracer.trace((chosen[:, None] + inside).reshape(-1, 2), fine)
        place[first : first + len(chosen)] = legs.place.reshape(len(chosen), -1, 3)
        direction[first : first + len(chosen)] = legs.direction.reshape(len(chosen), -1, 3)
    return _Legs(*(_by_rows(values, fine) for values in (place, direction)))


def _by_rows(cells: np.ndarray, fine: int) -> np.ndarray:
    """(cells, parts of each, 3) to the pixels of an image with _COLUMNS cells in a row, (n, 3)."""
    grid = cells.reshape(-1, _COLUMNS, fine, fine, 3)
    return grid.transpose(0, 2, 1, 3, 4).reshape(-1, 3)
