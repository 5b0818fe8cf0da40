"""The circles and spheres that make a black hole or a wormhole: their sizes, and where they are in the scene.

No gpu here. Radii are those of the Boyer-Lindquist coordinate r (without spin: circumference over 2 pi), drawn in the
object's own chart: Bardeen, Press & Teukolsky, Astrophysical Journal 178, 347 (1972), equations 2.18 and 2.21.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from bentlight_native import disk_drawn_radius, disk_isco

from ..scale import horizon
from ..sync.scene_data import SpacetimeData
from ..sync.spacetime import core_radius

_SEGMENTS = 128
_TURN = np.linspace(0, 2 * np.pi, _SEGMENTS + 1)  # closed
_UNIT_CIRCLE = np.stack([np.cos(_TURN), np.sin(_TURN), np.zeros_like(_TURN)], axis=1)


class Mark(NamedTuple):
    """A spheroid about the object's axis, or with `pole` 0 a circle in the plane of its equator. Own units."""

    kind: str  # 'HORIZON', 'PHOTON', 'ISCO', 'DISK' or 'THROAT'
    name: str
    equator: float  # radius as drawn
    pole: float


def photon_orbit(spin: float) -> float:
    """Radius, in masses, of the circular orbit of light that goes around with a spin of a/M, for -1 < a/M < 1.

    A negative spin gives the orbit that goes around against it.
    """
    return 2 * (1 + math.cos(2 / 3 * math.acos(-spin)))


def marks(item: SpacetimeData, disk: tuple[float, float] | None = None) -> list[Mark]:
    """What there is to be seen of an object; disk: inner and outer radius in masses."""
    core = core_radius(item)
    if item.kind == "WORMHOLE":
        return [Mark("THROAT", "Throat", core, core)]
    if not item.mass > 0:
        return []
    pole = core if item.chart == "ISOTROPIC" else item.mass * horizon(item.spin)
    found = [Mark("HORIZON", "Horizon", core, pole)]
    if item.spin:
        a = abs(item.spin)
        found.append(_ring(item, "PHOTON", "Photon Orbit, Prograde", photon_orbit(a)))
        found.append(_ring(item, "PHOTON", "Photon Orbit, Retrograde", photon_orbit(-a)))
    else:
        photon = _ring(item, "PHOTON", "Photon Sphere", 3.0)
        found.append(photon._replace(pole=photon.equator))
    found.append(_ring(item, "ISCO", "Last Stable Orbit", disk_isco(item.spin)))
    if disk:
        found.append(_ring(item, "DISK", "Disk, Inner Edge", disk[0]))
        found.append(_ring(item, "DISK", "Disk, Outer Edge", disk[1]))
    return found


def _ring(item: SpacetimeData, kind: str, name: str, masses: float) -> Mark:
    return Mark(kind, name, item.mass * disk_drawn_radius(masses, item.spin, item.chart == "ISOTROPIC"), 0.0)


def line(item: SpacetimeData, mark: Mark, eye: np.ndarray) -> np.ndarray | None:
    """A closed line (n, 3) in the world: the circle, or the outline of the spheroid as seen from `eye`.

    eye: (4,) world position and 1, or the direction towards a viewer far away and 0. None from within a spheroid.
    """
    if not mark.pole:
        own = mark.equator * _UNIT_CIRCLE
    else:
        axes = np.array([mark.equator, mark.equator, mark.pole])
        seen = _outline(np.linalg.solve(item.world_from_spacetime, eye) / np.append(axes, 1.0))
        if seen is None:
            return None
        own = seen * axes
    matrix = item.world_from_spacetime
    return own @ matrix[:3, :3].T + matrix[:3, 3]


def _outline(eye: np.ndarray) -> np.ndarray | None:
    """Where lines of sight touch the unit sphere: points p with |p| = 1 and p . eye = w. None from within."""
    place, w = eye[:3], eye[3]
    distance = float(np.linalg.norm(place))
    if not distance > w:
        return None
    normal, height = place / distance, w / distance
    side = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal))])
    side /= np.linalg.norm(side)
    x, y = _UNIT_CIRCLE[:, 0, None], _UNIT_CIRCLE[:, 1, None]
    return height * normal + math.sqrt(1 - height * height) * (x * side + y * np.cross(normal, side))
