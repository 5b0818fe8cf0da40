"""The maps of the relay camera: where the last straight leg of each curved camera ray starts. No bpy here.

Every part of every pixel gets one ray, which the core traces through the scene to the surface that it meets or to
infinity. What osl/relay_maps.h reads is where that ray's last leg starts (`place`) and its `direction`; and, with
accretion disks, what it gathers on its way through them (`glow`, `tint`). The files are described there. Memory is
bounded: bands of pixel rows are traced, some rays at a time, and written one by one; then those pixels again that take
finer parts (relay_parts.py). Cycles keeps all parts of the maps that it has read, so that places are not read where a
direction says enough: toward a sky that is not filtered. If it is, each ray that ends there has two beside it, which
meet nothing, and tell how far bending spreads a pixel.
"""

from __future__ import annotations

import contextlib
import math
import time
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass, field
from pathlib import Path

import bentlight_native
import numpy as np
from bentlight_native import FATES, write_exr

from ..sync.scene_data import CameraData, Visibility
from .motion import Slice
from .relay_parts import FINER, LOST, affordable, spreads, times_as_fine

ESCAPED, HIT = FATES.index("escaped"), FATES.index("hit")
_MARGIN = 4  # pixels around the image: a pixel filter reaches beyond it
_BAND_RAYS = 1 << 18  # at most, of one thread at a time; what is kept of a ray takes about 70 bytes
_AT_ONCE = 1 << 15  # rays, traced at a time by each thread; one takes about 400 bytes
_COLUMNS = 64  # cells in a row of the fine maps
_CELL = 8  # times a cell's number, in what tells of it (osl/relay_maps.h)
# The last leg starts this far before the surface, as a part of the ray's length and of the largest coordinate (float32
# has 6e-8 of it): Cycles must neither miss the surface nor meet another one first.
_LEG_OF_LENGTH, _LEG_OF_COORDINATES = 1e-4, 4e-6
_FAR = 1e4  # sizes of the scene, at which a leg to infinity starts
_TO_SKY = 2.0**64  # its direction's length, times this: without rounding (osl/relay_maps.h)
_SHIFTS = np.array([0.7548777, 0.5698403])  # of the parts of slices, from one to the next (osl/relay_maps.h)
_MOMENTS = np.array([math.sqrt(2), math.sqrt(3)])  # of parts in a slice: independent of all other lattices
# Of parts on the lens: the additive recurrence in two dimensions with the least discrepancy (Roberts 2018), powers of
# the inverse of the plastic number, the root of x^3 = x + 1.
_LENS = np.array([[0.7548776662466927, 0.5698402909980532], [0.5698402909980532, -0.7548776662466927]])
_APART = 1_000_003  # parts, between the lattices of neighboring slices
_SEEN, _HIDDEN = 1, 2  # how rays end that are not LOST: on their last leg, in a disk that lets nothing pass
_RAY_BYTES, _DISK_BYTES = 24, 12  # in the maps: of a ray, and what more of it disks take
_LARGEST = np.finfo(np.float16).max  # radiance of disks in the maps
_DIMMEST = 1e-8  # that is told of light: times _TO_SKY it must still be longer than all that comes from surfaces


@dataclass(frozen=True)
class RelaySettings:
    """What the maps are to be like. parts: of a pixel in each direction. tolerance: of hits, scene units;
    angular_tolerance: of directions, radians. footprints: whether they tell what pixels see of the sky."""

    parts: int = 4
    tolerance: float = 1e-4
    angular_tolerance: float = 1e-5
    threads: int = 1
    footprints: bool = False


@dataclass
class RelayMaps:
    """Maps on disk. `parameters` are those of the shader."""

    parameters: dict[str, int | float | str]
    files: list[Path] = field(default_factory=list)
    rays: int = 0
    lost: int = 0  # rays that a horizon or an end of space swallows, and unresolved ones
    fine_pixels: int = 0
    limit: float = 1.0  # of finer parts (relay_parts.py)
    seconds: float = 0.0

    def add(self, more: RelayMaps) -> None:
        """Counts files and rays of a part of them."""
        self.files += more.files
        self.rays, self.lost = self.rays + more.rays, self.lost + more.lost
        self.fine_pixels += more.fine_pixels
        self.limit = max(self.limit, more.limit)
        self.seconds += more.seconds


def bake(
    scene: bentlight_native.Scene,
    camera: CameraData,
    prefix: Path,
    settings: RelaySettings,
    part: Slice | None = None,
    early: np.ndarray | None = None,
    disks: np.ndarray | None = None,
) -> RelayMaps:
    """Traces and writes the maps of one slice of the shutter's time, or of a frame in which nothing moves: in the
    world's axes, or in the camera's as Cycles has them (x right, y up, z forward). Their paths begin with `prefix`.

    `scene` is committed and has this camera. `early`: for each of its instances, how much earlier than elsewhere the
    last legs of rays that meet it start; none: nowhere. `disks`: which of them are accretion disks, (instances,) bool.
    """
    start = time.monotonic()
    tracer = _Tracer(scene, camera, settings, part, early, disks)
    width, height = camera.width + 2 * _MARGIN, camera.height + 2 * _MARGIN
    band = _power_of_two(
        min(_BAND_RAYS / (width * settings.parts**2), 2 * height - 1)
    )  # texture caches hold whole tiles
    angle, size = _pixel(camera)
    maps = RelayMaps(
        {
            "Maps": str(prefix),
            "Width": camera.width,
            "Height": camera.height,
            "Margin": _MARGIN,
            "Band": band,
            "Parts": settings.parts,
            "Slices": part.count if part else 0,
            "Disks": int(tracer.sees_disks),
            "Far": _FAR * camera.clip_end,
            "PixelAngle": angle,
            "PixelSize": size,
        }
    )
    with ThreadPoolExecutor(settings.threads) as pool:
        bands = [(tracer, prefix, i, band) for i in range(math.ceil(height / band))]
        made, spread = zip(*_all(pool, _write_band, bands), strict=True)
        ray_bytes = _RAY_BYTES + (_DISK_BYTES if tracer.sees_disks else 0)
        limit = affordable(spread, settings.parts, ray_bytes, part.count if part else 1)
        finer = [(*each, times_as_fine(one, limit)) for each, one in zip(bands, spread, strict=True)]
        for part_of in (*made, RelayMaps({}, limit=limit), *_all(pool, _write_finer, finer)):
            maps.add(part_of)
    maps.seconds = time.monotonic() - start
    return maps


def _all(pool: ThreadPoolExecutor, work: Callable, calls: list[tuple]) -> list:
    """What comes of all calls. What has failed once would fail for long, so that it ends the rest."""
    waiting = [pool.submit(work, *each) for each in calls]
    try:
        for done in as_completed(waiting):
            done.result()
    except BaseException:
        pool.shutdown(wait=False, cancel_futures=True)
        raise
    return [each.result() for each in waiting]


def remove(files: Iterable[Path]) -> None:
    """Deletes maps. Those that are gone already do no harm, nor those that Windows keeps while Cycles has them open."""
    for file in files:
        with contextlib.suppress(PermissionError):
            file.unlink(missing_ok=True)


def _power_of_two(limit: float) -> int:
    """The largest up to the limit; at least 1."""
    return 1 << max(0, math.floor(math.log2(limit)))


def _pixel(camera: CameraData) -> tuple[float, float]:
    """How far neighboring pixels look apart: about so many radians, and scene units."""
    span = (camera.window[1] - camera.window[0]) / camera.width
    if camera.kind == "ORTHOGRAPHIC":
        return 0.0, span
    return (span if camera.kind == "PERSPECTIVE" else 2 * math.pi * span), 0.0


@dataclass
class _Legs:
    """Last legs: (n, 3) each, float32. The length of a direction is how bright light from there is, _TO_SKY times that
    if it leads to the sky; 0: none comes. Places are zero but before surfaces, or toward the sky footprints. If there
    are disks, float16: their light, and the color that they give to what comes from behind them."""

    place: np.ndarray
    direction: np.ndarray
    glow: np.ndarray | None = None
    tint: np.ndarray | None = None

    def write(self, stem: str, shape: tuple[int, int]) -> list[Path]:
        """Images of which all pixels are the same have just one, but for directions, which tell the size."""
        files = []
        for name, values in vars(self).items():
            if values is None:
                continue
            files.append(Path(f"{stem}{name}.exr"))
            image = values.reshape(*shape, 3)
            if name != "direction" and (values == values[0]).all():
                image = image[:1, :1]
            write_exr(files[-1], {channel: image[..., i] for i, channel in enumerate("RGB")}, {})
        return files


@dataclass
class _Traced:
    """What became of n rays: the directions, world, float32, in which they start and end; how they end; and the
    surfaces of disks that they have met."""

    legs: _Legs
    start: np.ndarray
    end: np.ndarray
    fate: np.ndarray
    layers: np.ndarray

    @property
    def lost(self) -> int:
        """How many are."""
        return int((self.fate == LOST).sum())


class _Tracer:
    """Rays through points of the image, in pixels from its lower left corner, to their last legs."""

    def __init__(
        self,
        scene: bentlight_native.Scene,
        camera: CameraData,
        settings: RelaySettings,
        part: Slice | None,
        early: np.ndarray | None,
        disks: np.ndarray | None,
    ) -> None:
        self.camera, self.settings = camera, settings
        self.sees_disks = disks is not None and bool(disks.any())
        self._disks = disks if self.sees_disks else None
        self.number = part.number if part else 0
        self._scene, self._slice, self._early = scene, part, early
        camera_from_world = np.linalg.inv(camera.world_from_camera)
        self._axes = np.eye(4) if part else np.diag([1.0, 1.0, -1.0, 1.0]) @ camera_from_world
        self._drift = part.change @ camera_from_world if part else None  # of the world's points with the camera
        self._shift = (np.mod(self.number * _SHIFTS + 0.5, 1.0) - 0.5) / settings.parts

    def trace(self, points: np.ndarray, parts: int) -> _Traced:
        """Rays through `points` (n, 2)."""
        return _joined([self._trace(points[i : i + _AT_ONCE], parts) for i in range(0, len(points), _AT_ONCE)])

    def _trace(self, points: np.ndarray, parts: int) -> _Traced:
        number = np.floor(points * parts).astype(np.int64) + self.number * _APART
        origins, directions, exists = self._rays(points, number)
        hits = self._scene.intersect(
            origins,
            directions,
            self.settings.tolerance,
            angular_tolerance=self.settings.angular_tolerance,
            length_min=self.camera.clip_start,
            length_max=self.camera.clip_end,
            visibility=Visibility.CAMERA,
            veils=self._disks,
        )
        traced = self._last_legs(hits, exists, directions)
        if self.settings.footprints:
            to_sky = exists & _escaped(hits) & (traced.fate == _SEEN)
            found = self._footprints(points[to_sky], number[to_sky], hits["direction"][to_sky], 0.5 / parts)
            traced.legs.place[to_sky] = found @ self._axes[:3, :3].T
        brightness = self._scene.shift_light(
            origins, directions, hits["position"], hits["direction"], hits["fate"] != HIT
        )
        if self.sees_disks:
            traced.layers = np.where(exists, hits["layers"], 0)
            brightness = brightness * _add_disks(traced.legs, hits, exists)
        brightness = np.where(brightness < _DIMMEST, 0, brightness)
        traced.legs.direction *= brightness[:, None].astype(np.float32)
        return traced

    def _rays(self, points: np.ndarray, number: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Of parts with these numbers, from their own places on the lens and in their own moments: origins and
        directions in which they start, and whether they exist."""
        # Neighboring parts see through places on the lens that complement each other: no random numbers.
        lens = np.mod(number @ _LENS + 0.5, 1.0)
        rays = self._scene.camera_rays((points + self._shift) / (self.camera.width, self.camera.height), lens)
        origins, directions = rays.origins, rays.directions
        exists = np.isfinite(directions[:, 0])
        origins, directions = np.where(exists[:, None], origins, 0.0), np.where(exists[:, None], directions, (0, 0, 1))
        if self._slice is not None:
            origins, directions = self._moved(origins, directions, number)
        return origins, directions, exists

    def _footprints(self, points: np.ndarray, number: np.ndarray, toward: np.ndarray, step: float) -> np.ndarray:
        """What a pixel's rays see of the sky around directions, (n, 3), as osl/relay_maps.h has it: by rays so many
        pixels to one side, or to the other where the first end elsewhere."""
        changes = np.zeros((2, len(points), 3))
        for axis, change in enumerate(changes):
            left = np.arange(len(points))
            for shift in (step, -step):
                beside = points[left] + shift * np.eye(2)[axis]
                origins, directions, exists = self._rays(beside, number[left])
                settings = self.settings
                hits = self._scene.intersect(
                    origins, directions, settings.tolerance, angular_tolerance=settings.angular_tolerance, visibility=0
                )
                found = exists & _escaped(hits)
                change[left[found]] = (hits["direction"][found] - toward[left[found]]) / shift
                left = left[~found]
        return ellipse(toward, *changes)

    def _moved(self, origins: np.ndarray, directions: np.ndarray, number: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Each part of the image looks from where the camera is in a moment of the slice of its own."""
        moment = np.mod(number @ _MOMENTS, 1.0)[:, None] - 0.5
        turn, way = self._drift[:3, :3], self._drift[:3, 3]
        turned = directions + moment * (directions @ turn.T)
        return (
            origins + moment * (origins @ turn.T + way),
            turned / np.linalg.norm(turned, axis=1, keepdims=True),
        )

    def _last_legs(self, hits: dict[str, np.ndarray], exists: np.ndarray, start: np.ndarray) -> _Traced:
        fate, end, direction = hits["fate"], hits["position"], hits["direction"]
        escaped = exists & _escaped(hits)
        hit = exists & (fate == HIT)
        hidden = hit & self._disks[hits["instance"]] if self.sees_disks else np.zeros(len(hit), bool)
        before = _LEG_OF_LENGTH * hits["length"] + _LEG_OF_COORDINATES * np.abs(end).max(axis=1)
        if self._early is not None and len(self._early):
            before = np.minimum(before + self._early[np.where(hit, hits["instance"], 0)], hits["length"])
        end = end - before[:, None] * direction
        seen = (hit | escaped) & ~hidden
        place = np.where((seen & hit)[:, None], end @ self._axes[:3, :3].T + self._axes[:3, 3], 0.0)
        toward = np.where(seen[:, None], direction @ self._axes[:3, :3].T, 0.0)
        toward[seen & escaped] *= _TO_SKY
        legs = _Legs(place.astype(np.float32), toward.astype(np.float32))
        ends = np.where(hidden, _HIDDEN, np.where(seen, _SEEN, LOST)).astype(np.uint8)
        layers = np.zeros(len(ends), np.uint32)
        return _Traced(legs, start.astype(np.float32), direction.astype(np.float32), ends, layers)


def _escaped(hits: dict[str, np.ndarray]) -> np.ndarray:
    """Which rays end in the world's sky."""
    return (hits["fate"] == ESCAPED) & (hits["sky"] < 0)


def ellipse(toward: np.ndarray, right: np.ndarray, up: np.ndarray) -> np.ndarray:
    """(n, 3) of unit directions and their changes, a parallelogram's sides: across the direction the major axis of the
    ellipse whose second moments are the sum of theirs; along the direction how long the minor axis is."""
    right, up = (change - (change * toward).sum(axis=1, keepdims=True) * toward for change in (right, up))
    turn = np.arctan2(2 * (right * up).sum(axis=1), (right**2).sum(axis=1) - (up**2).sum(axis=1)) / 2
    cosine, sine = np.cos(turn)[:, None], np.sin(turn)[:, None]
    narrow = np.linalg.norm(cosine * up - sine * right, axis=1, keepdims=True)
    return cosine * right + sine * up + narrow * toward


def _joined(pieces: list[_Traced]) -> _Traced:
    """One after the other."""

    def join(name: str, of: list[_Traced] | list[_Legs]) -> np.ndarray | None:
        return None if getattr(of[0], name) is None else np.concatenate([getattr(one, name) for one in of])

    legs = [piece.legs for piece in pieces]
    rest = {name: join(name, pieces) for name in ("start", "end", "fate", "layers")}
    return _Traced(_Legs(**{name: join(name, legs) for name in vars(legs[0])}), **rest)


def _add_disks(legs: _Legs, hits: dict[str, np.ndarray], exists: np.ndarray) -> np.ndarray:
    """What disks do to light, in legs that know nothing of them. Not how much they let through: that is returned."""
    passes = hits["transmission"]
    brightest = passes.max(axis=1, keepdims=True)
    legs.glow = np.where(exists[:, None], np.clip(hits["glow"], 0, _LARGEST), 0).astype(np.float16)
    legs.tint = np.divide(passes, brightest, out=np.ones_like(passes), where=brightest > 0).astype(np.float16)
    return brightest[:, 0]


def _write_band(tracer: _Tracer, prefix: Path, number: int, band: int) -> tuple[RelayMaps, np.ndarray]:
    """The files of one band of pixel rows but those of finer parts, and how far its rays spread. The last band may
    reach beyond the margin."""
    parts, width = tracer.settings.parts, tracer.camera.width + 2 * _MARGIN
    rows, columns = _centers(number * band, band, parts), _centers(0, width, parts)
    points = np.stack(np.meshgrid(columns, rows), axis=-1) - _MARGIN
    traced = tracer.trace(points.reshape(-1, 2), parts)
    shape = len(rows), len(columns)
    files = traced.legs.write(_stem(tracer, prefix, number), shape)
    ends = (values.reshape(*shape, -1) for values in (traced.start, traced.end))
    spread = spreads(*ends, traced.fate.reshape(shape), traced.layers.reshape(shape), parts)
    return RelayMaps({}, files, len(points.reshape(-1, 2)), traced.lost), spread


def _write_finer(tracer: _Tracer, prefix: Path, number: int, band: int, times: np.ndarray) -> RelayMaps:
    """The other files of one band: parts so many times as fine, by pixel (rows, columns), and where they are."""
    stem, result = _stem(tracer, prefix, number), RelayMaps({})
    cells = np.zeros(times.shape, np.float32)
    for finer in np.intersect1d(FINER, times):
        pixels = times == finer
        cells[pixels] = np.arange(pixels.sum()) * _CELL + finer
        corners = np.argwhere(pixels)[:, ::-1] + (0, number * band) - _MARGIN
        parts = tracer.settings.parts * finer
        fine, lost = _trace_cells(tracer, corners, parts)
        files = fine.write(f"{stem}{finer}x_", _cells_shape(len(corners), parts))
        result.add(RelayMaps({}, files, len(fine.place), lost, len(corners)))
    result.files.append(Path(f"{stem}cells.exr"))
    write_exr(result.files[-1], {"R": cells if cells.any() else cells[:1, :1]}, {})
    return result


def _stem(tracer: _Tracer, prefix: Path, number: int) -> str:
    return f"{prefix}{tracer.number:02}_{number:04}_"


def _centers(first: int, count: int, parts: int) -> np.ndarray:
    """Middles of the parts of `count` pixels from `first` on."""
    return first + (np.arange(count * parts) + 0.5) / parts


def _cells_shape(count: int, fine: int) -> tuple[int, int]:
    return math.ceil(count / _COLUMNS) * fine, _COLUMNS * fine


def _trace_cells(tracer: _Tracer, corners: np.ndarray, fine: int) -> tuple[_Legs, int]:
    """The maps with `fine` parts each way, row by row, of the pixels with these lower left corners (n, 2), and how
    many of their rays are lost. Cells without a pixel are as the first."""
    inside = np.stack(np.meshgrid(_centers(0, 1, fine), _centers(0, 1, fine)), axis=-1).reshape(-1, 2)
    count = math.ceil(len(corners) / _COLUMNS) * _COLUMNS
    pixels = max(1, _AT_ONCE // fine**2)
    maps: dict[str, np.ndarray] = {}
    lost = 0
    for first in range(0, len(corners), pixels):
        chosen = corners[first : first + pixels]
        traced = tracer.trace((chosen[:, None] + inside).reshape(-1, 2), fine)
        lost += traced.lost
        for name, values in vars(traced.legs).items():
            if values is not None:
                whole = maps.setdefault(name, np.empty((count, fine * fine, 3), values.dtype))
                whole[first : first + len(chosen)] = values.reshape(len(chosen), -1, 3)
    for whole in maps.values():
        whole[len(corners) :] = whole[0]
    return _Legs(**{name: _by_rows(values, fine) for name, values in maps.items()}), lost


def _by_rows(cells: np.ndarray, fine: int) -> np.ndarray:
    """(cells, parts of each, 3) to the pixels of an image with _COLUMNS cells in a row, (n, 3)."""
    grid = cells.reshape(-1, _COLUMNS, fine, fine, 3)
    return grid.transpose(0, 2, 1, 3, 4).reshape(-1, 3)
