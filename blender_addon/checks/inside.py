"""Whether a mesh reaches into a horizon or throat. No bpy here."""

from __future__ import annotations

import math

import numpy as np

from ..scale import horizon
from ..sync.scene_data import SpacetimeData
from ..sync.spacetime import core_radius


def core_axes(item: SpacetimeData) -> np.ndarray:
    """Half axes (3,) of the spheroid that a horizon or throat is drawn as, in the object's own units."""
    radius = core_radius(item)
    flat = item.kind == "BLACK_HOLE" and item.chart == "OBLATE"
    return np.array([radius, radius, item.mass * horizon(item.spin) if flat else radius])


def core_from_world(item: SpacetimeData) -> np.ndarray:
    """(4, 4): the world in coordinates in which the horizon or throat is the unit sphere."""
    return np.diag([*(1 / core_axes(item)), 1.0]) @ np.linalg.inv(item.world_from_spacetime)


def box_distance(corners: np.ndarray) -> float:
    """A lower bound of the distance from the origin to what is inside a box of (8, 3) corners."""
    middle = corners.mean(axis=0)
    return float(np.linalg.norm(middle) - np.linalg.norm(corners - middle, axis=1).max())


def reaches_inside(vertices: np.ndarray, triangles: np.ndarray) -> bool:
    """Whether any point of (m, 3) triangles of (n, 3) vertices lies within the unit sphere."""
    if not len(triangles):
        return False
    corners = vertices[triangles]
    middles = corners.mean(axis=1)
    reach = np.linalg.norm(corners - middles[:, None], axis=2).max(axis=1)
    corners = corners[np.linalg.norm(middles, axis=1) - reach < 1]
    return len(corners) > 0 and bool((_distances(corners) < 1).any())


def lies_inside(vertices: np.ndarray) -> bool:
    """Whether all (n, 3) vertices lie within the unit sphere, and so all that is between them."""
    return len(vertices) > 0 and bool((np.linalg.norm(vertices, axis=1) < 1).all())


def _distances(corners: np.ndarray) -> np.ndarray:
    """From the origin to each of (m, 3, 3) triangles: that to its plane if the foot lies in it, else to an edge."""
    ends = np.roll(corners, -1, axis=1)
    edges = ends - corners
    squares = np.maximum(np.einsum("mij,mij->mi", edges, edges), 1e-300)
    along = np.clip(-np.einsum("mij,mij->mi", corners, edges) / squares, 0, 1)
    to_edges = np.linalg.norm(corners + along[..., None] * edges, axis=2).min(axis=1)
    normals = np.cross(edges[:, 0], edges[:, 1])
    sides = np.einsum("mij,mj->mi", np.cross(corners, ends), normals)
    has_foot = (sides > 0).all(axis=1)
    lengths = np.maximum(np.linalg.norm(normals, axis=1), 1e-300)
    to_planes = np.abs(np.einsum("mj,mj->m", corners[:, 0], normals)) / lengths
    return np.where(has_foot, to_planes, to_edges)


def masses_away(item: SpacetimeData, place: np.ndarray) -> float:
    """Boyer-Lindquist radius of a world place, in masses of a black hole; 0 within an isotropic horizon's center."""
    x, y, z = np.linalg.solve(item.world_from_spacetime, np.append(place, 1.0))[:3]
    if item.chart == "ISOTROPIC":
        drawn = math.hypot(x, y, z)
        return drawn / item.mass * (1 + item.mass / (2 * drawn)) ** 2 if drawn > 0 else math.inf
    a = item.spin * item.mass
    b = x * x + y * y + z * z - a * a
    return math.sqrt((b + math.sqrt(b * b + 4 * a * a * z * z)) / 2) / item.mass
