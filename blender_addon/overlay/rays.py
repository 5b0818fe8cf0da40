"""Curved rays as lines to be drawn, by the core's own paths: straight between spheres of influence, bent within.

No bpy here.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import bentlight_native
import numpy as np

from ..sync import native, spacetime
from ..sync.scene_data import SpacetimeData

ESCAPED, CAPTURED = "ESCAPED", "CAPTURED"
_SAMPLES = 65  # of a path at a time
_TURN = 0.04  # radians between the ends of a piece of a drawn line
_SAGITTA = 1.25e-5  # of a sphere's radius: how far a piece of a drawn line is from the ray
_REFINEMENTS, _POINTS_MAX = 8, 2000  # of a line in one sphere
_DOUBLINGS = 40  # of Mino time: rays that wind for longer count as captured
_CROSSINGS_MAX = 64  # spheres that a ray may enter
_OUTSIDE = 1 + 1e-9  # of a sphere's radius: where a ray that has left goes on


@dataclass(frozen=True)
class Lens:
    """An object that bends rays within a sphere of a world radius; exit: a wormhole's other mouth, by its index."""

    item: SpacetimeData
    space: bentlight_native.Spacetime
    radius: float
    exit: int | None


def lenses(items: list[SpacetimeData], reach: float) -> list[Lens]:
    """Of objects that were checked. `reach`: world radius up to which space that is bent everywhere is drawn bent.

    Raises RenderError for spheres that overlap.
    """
    index = {item.name: i for i, item in enumerate(items)}
    return [
        Lens(item, native.native_spacetime(item), min(radius, reach), index.get(item.exit) if item.exit else None)
        for item, radius in zip(items, spacetime.influence_radii(items), strict=True)
    ]


def trace(found: list[Lens], origin: np.ndarray, direction: np.ndarray, length: float) -> tuple[list[np.ndarray], str]:
    """The lines, (n, 3) world points each, of one ray, and what becomes of it; more than one if it goes through mouths.

    origin, direction (3,), the latter local and in world axes as for Scene.intersect. length: of the last straight
    piece. A start within a horizon gives no line.
    """
    place, heading = np.array(origin, float), np.array(direction, float)
    heading /= np.linalg.norm(heading)
    pieces, lines = [place[None]], []
    for _ in range(_CROSSINGS_MAX):
        at, distance = _next(found, place, heading)
        if at is None:
            pieces.append((place + length * heading)[None])
            return [*lines, np.concatenate(pieces)], ESCAPED
        if distance:
            place = place + distance * heading
            pieces.append(place[None])
        lens = found[at]
        other = None if lens.exit is None else found[lens.exit]
        unit = lens.item.scale / other.item.scale if other else 1.0  # beyond a throat lengths are those of this side
        path = _bent(lens, other, place, heading)
        pieces.append(_to_world(lens.item, path.near))
        out = lens
        if path.far is not None and other:
            lines.append(np.concatenate(pieces))
            pieces, out = [_to_world(other.item, path.far * unit)], other
        if path.end is None:
            return [*lines, np.concatenate(pieces)], CAPTURED
        place = _to_world(out.item, path.end[0][None] * (unit if out is other else 1.0))[0]
        heading = out.item.world_from_spacetime[:3, :3] @ path.end[1] / out.item.scale
        place = out.item.origin + (place - out.item.origin) * _OUTSIDE
    return [*lines, np.concatenate(pieces)], CAPTURED


def _next(found: list[Lens], place: np.ndarray, heading: np.ndarray) -> tuple[int | None, float]:
    """The sphere that holds a place, or the next one on a straight way, and how far it is."""
    nearest = None, math.inf
    for i, lens in enumerate(found):
        away = place - lens.item.origin
        b, c = float(away @ heading), float(away @ away) - lens.radius**2
        if c <= 0:
            return i, 0.0
        if b < 0 and b * b > c and -b - math.sqrt(b * b - c) < nearest[1]:
            nearest = i, -b - math.sqrt(b * b - c)
    return nearest


@dataclass
class _Path:
    """Own points before and (None: it does not get there) beyond a throat, and place and heading where it leaves."""

    near: np.ndarray
    far: np.ndarray | None
    end: tuple[np.ndarray, np.ndarray] | None


def _bent(lens: Lens, other: Lens | None, place: np.ndarray, heading: np.ndarray) -> _Path:
    """A ray within a sphere, from a world place; `other`: a wormhole's other mouth."""
    matrix = lens.item.world_from_spacetime
    start = np.linalg.solve(matrix, np.append(place, 1.0))[:3]
    toward = np.linalg.solve(matrix[:3, :3], heading)
    if not bentlight_native.contains(lens.space, tuple(start)):
        return _Path(np.empty((0, 3)), None, None)
    radius = lens.radius / lens.item.scale
    far_radius = (other or lens).radius / lens.item.scale

    def sample(times: np.ndarray) -> dict[str, np.ndarray]:
        path = bentlight_native.ray_path(lens.space, start, toward, times)
        limit = np.where(path["far"], far_radius, radius)
        path["left"] = np.linalg.norm(path["position"], axis=1) > limit * _OUTSIDE
        path["over"] = path["left"] | np.isnan(path["position"][:, 0])
        return path

    first, last = _ending(sample, 4 / np.linalg.norm(start))
    path = sample(np.array([first, last]))
    leaves = bool(path["left"][1])
    times = _refined(sample, first, _SAGITTA * radius)
    path = sample(times)
    far = path["far"]
    end = sample(np.array([last]))
    return _Path(
        path["position"][~far],
        path["position"][far] if far.any() else None,
        (end["position"][0], end["direction"][0]) if leaves else None,
    )


def _ending(sample: Callable[[np.ndarray], dict[str, np.ndarray]], step: float) -> tuple[float, float]:
    """Mino times, close to each other, before and after a ray leaves the sphere, or ends in it."""
    first, last = 0.0, step
    for _ in range(_DOUBLINGS):
        times = np.linspace(first, last, _SAMPLES)
        over = sample(times)["over"][1:]
        if over.any():
            break
        first, last = last, 2 * last
    else:
        return first, first
    for _ in range(10):
        times = np.linspace(first, last, _SAMPLES)
        over = sample(times)["over"]
        over[0] = False
        i = int(np.argmax(over)) if over.any() else _SAMPLES - 1
        if times[i] - times[i - 1] <= 1e-12 * times[i] or i == 0:
            break
        first, last = times[i - 1], times[i]
    return float(first), float(last)


def _refined(sample: Callable[[np.ndarray], dict[str, np.ndarray]], last: float, sagitta: float) -> np.ndarray:
    """Mino times up to the last at which a line through the points of a path looks smooth, and is near to it."""
    times = np.linspace(0, last, _SAMPLES // 2)
    for _ in range(_REFINEMENTS):
        path = sample(times)
        heading = path["direction"]
        turn = np.arccos(np.clip(np.einsum("ij,ij->i", heading[1:], heading[:-1]), -1, 1))
        length = np.linalg.norm(np.diff(path["position"], axis=0), axis=1)
        rough = (turn > _TURN) | (turn * length / 8 > sagitta)
        if not rough.any() or len(times) > _POINTS_MAX:
            break
        times = np.sort(np.concatenate([times, (times[1:][rough] + times[:-1][rough]) / 2]))
    return times


def _to_world(item: SpacetimeData, own: np.ndarray) -> np.ndarray:
    """Own points (n, 3) in the world."""
    matrix = item.world_from_spacetime
    return own @ matrix[:3, :3].T + matrix[:3, 3]
