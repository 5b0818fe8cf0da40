"""Black holes and wormholes: read from Blender's objects, checked, and given their spheres of influence.

The checks and the geometry are plain numpy; only read_spacetime touches a Blender object.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from ..report import RenderError, told
from .scene_data import SpacetimeData

if TYPE_CHECKING:
    import bpy

KIND_NAMES = {"BLACK_HOLE": "Black hole", "WORMHOLE": "Wormhole"}
_UNIFORM = 1e-4  # relative difference of scales that float32 matrices and rotations may leave


def read_spacetime(obj: bpy.types.Object, world_from_object: np.ndarray) -> SpacetimeData:
    """The black hole or wormhole mouth that an object's properties describe."""
    settings = obj.bentlight
    return SpacetimeData(
        name=obj.name,
        kind=settings.kind,
        world_from_spacetime=np.array(world_from_object, dtype=np.float64, order="C"),
        mass=settings.mass,
        spin=settings.spin,
        chart=effective_chart(settings.chart, settings.spin),
        throat_radius=settings.throat_radius,
        sphere_radius=settings.sphere_radius,
        exit=settings.exit.name if settings.exit else None,
    )


def effective_chart(chart: str, spin: float) -> str:
    """The isotropic chart exists without spin only."""
    return "OBLATE" if spin else chart


def core_radius(item: SpacetimeData) -> float:
    """Radius of the horizon's equator or of the throat as drawn in the scene, in its own units (physics.md, charts)."""
    if item.kind == "WORMHOLE":
        return item.throat_radius / 2
    if item.chart == "ISOTROPIC":
        return item.mass / 2
    a = item.spin * item.mass
    outer_horizon = item.mass + math.sqrt(item.mass**2 - a**2)
    return math.hypot(outer_horizon, a)


def is_inside_core(item: SpacetimeData, world_position: np.ndarray) -> bool:
    """Whether a point lies inside or on the horizon or throat."""
    x, y, z = np.linalg.solve(item.world_from_spacetime, np.append(world_position, 1.0))[:3]
    if item.kind == "WORMHOLE" or item.chart == "ISOTROPIC":
        return math.hypot(x, y, z) <= core_radius(item)
    a = item.spin * item.mass
    b = x * x + y * y + z * z - a * a  # r^2 is the larger root of r^4 - b r^2 - a^2 z^2 = 0
    r_squared = (b + math.sqrt(b * b + 4 * a * a * z * z)) / 2
    return math.sqrt(r_squared) <= item.mass + math.sqrt(item.mass**2 - a**2)


def check(items: list[SpacetimeData]) -> None:
    """Raises RenderError for the first object that cannot be what it says."""
    by_name = {item.name: item for item in items}
    for item in items:
        check_alone(item)
    for item in items:
        check_exit(item, by_name)


def _title(item: SpacetimeData) -> str:
    return told("{} '{}'", told(KIND_NAMES[item.kind]), item.name)


def check_alone(item: SpacetimeData) -> None:
    """Raises RenderError if an object cannot be what it says, whatever else there is."""
    matrix = item.world_from_spacetime
    numbers = [item.mass, item.spin, item.throat_radius, item.sphere_radius]
    if not np.isfinite(matrix).all() or not np.isfinite(numbers).all():
        raise RenderError("{}: its transform or its settings are not finite numbers", _title(item))
    axes = matrix[:3, :3]
    scale = np.linalg.norm(axes[:, 0])
    if not scale > 0:
        raise RenderError("{} has scale 0", _title(item))
    if np.abs(axes.T @ axes / scale**2 - np.eye(3)).max() > _UNIFORM or np.linalg.det(axes) < 0:
        raise RenderError("{}: its scale must be uniform and positive", _title(item))
    if item.kind == "BLACK_HOLE" and item.mass < 0:
        raise RenderError("{}: its mass must not be negative", _title(item))
    if item.kind == "BLACK_HOLE" and not abs(item.spin) < 1:
        raise RenderError("{}: its spin must be smaller than its mass", _title(item))
    if item.kind == "WORMHOLE" and not item.throat_radius > 0:
        raise RenderError("{}: its throat radius must be positive", _title(item))


def check_exit(item: SpacetimeData, by_name: dict[str, SpacetimeData]) -> None:
    """Raises RenderError unless a wormhole's mouth leads to one that leads back; `by_name`: all that renders."""
    if item.kind != "WORMHOLE":
        return
    if item.exit is None:
        raise RenderError("{} has no exit: choose the object that is its other mouth", _title(item))
    if item.exit == item.name:
        raise RenderError("{} is its own exit: choose another object", _title(item))
    other = by_name.get(item.exit)
    if other is None or other.kind != "WORMHOLE":
        raise RenderError("{}: its exit '{}' is not a wormhole mouth that is rendered", _title(item), item.exit)
    if other.exit != item.name:
        raise RenderError("{}: its exit '{}' leads elsewhere; two mouths must name each other", _title(item), item.exit)
    radii = item.throat_radius * item.scale, other.throat_radius * other.scale
    if not math.isclose(*radii, rel_tol=_UNIFORM):
        raise RenderError(
            "{} and its exit '{}' must have one throat radius, not {:g} and {:g}",
            _title(item),
            item.exit,
            radii[0],
            radii[1],
        )


def influence_radii(items: list[SpacetimeData]) -> list[float]:
    """World radius of each object's sphere of influence; infinity for a black hole alone that sets none.

    An automatic sphere reaches half-way to the neighbor, or to the edge of a neighbor's sphere that the user has set.
    Raises RenderError where objects or spheres overlap.
    """
    distances = [[float(np.linalg.norm(a.origin - b.origin)) for b in items] for a in items]
    given = [item.sphere_radius * item.scale for item in items]
    radii = [
        given[i]
        or min(
            (distances[i][j] - given[j] if given[j] else distances[i][j] / 2 for j in range(len(items)) if j != i),
            default=math.inf,
        )
        for i in range(len(items))
    ]
    for i, a in enumerate(items):
        for j in range(i):
            if given[i] and given[j] and given[i] + given[j] > distances[i][j] * (1 + 1e-9):
                raise RenderError("The spheres of influence of '{}' and '{}' overlap", items[j].name, a.name)
    for item, radius in zip(items, radii, strict=True):
        if radius <= core_radius(item) * item.scale:
            raise RenderError(_too_close(item, items))
    return radii


def _too_close(item: SpacetimeData, items: list[SpacetimeData]) -> str:
    if item.sphere_radius:
        return told("{}: its sphere of influence does not reach out of its horizon or throat", _title(item))
    others = [other for other in items if other is not item]
    nearest = min(others, key=lambda other: float(np.linalg.norm(other.origin - item.origin)))
    return told("{} and '{}' overlap: move them apart", _title(item), nearest.name)
