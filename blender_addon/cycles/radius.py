"""How large lenses are: given by the user, or chosen so that neither the camera nor a mesh is inside if that can be."""

from __future__ import annotations

import dataclasses
import itertools
import math

import bpy
import mathutils

from ..sync import spacetime
from ..sync.scene_data import SpacetimeData

_MARGIN = 0.95  # of the distance to what must stay outside
_NEAREST = 16  # core radii: smaller is not worth the bending that is left out; what is nearer will be inside
_LEFT_OUT_RAD = 0.02  # bending that may be left out where there is room enough
_ROUNDING = 1e-6  # properties are float32, by whose rounding lenses that touch must not overlap


def with_lens_radius(item: SpacetimeData, obj: bpy.types.Object) -> SpacetimeData:
    """The hole with the sphere that Cycles uses."""
    return dataclasses.replace(item, sphere_radius=obj.bentlight.lens_radius or item.sphere_radius)


def soft_edge(obj: bpy.types.Object) -> float:
    """How far from the edge a lens' bending fades, over its radius. Lenses that are spheres of influence have none."""
    return obj.bentlight.lens_soft_edge if obj.bentlight.lens_radius else 0.0


def automatic(item: SpacetimeData, influence: float, obstacles: dict[str, float], reach: float = 0.0) -> float:
    """World radius for a hole that has none of its own. obstacles: distances of the camera and of meshes; reach: of its
    disk, which must be inside."""
    largest = item.scale * (
        4 * item.mass / _LEFT_OUT_RAD
        if item.kind == "BLACK_HOLE"
        else item.throat_radius * math.sqrt(math.pi / 4 / _LEFT_OUT_RAD)
    )
    smallest = _NEAREST * spacetime.core_radius(item) * item.scale
    room = min([distance for distance in obstacles.values() if distance > 0], default=math.inf)
    return min(max(min(max(_MARGIN * room, smallest), largest), reach / _MARGIN), influence * (1 - _ROUNDING))


def distances(
    scene: bpy.types.Scene,
    depsgraph: bpy.types.Depsgraph,
    origin: mathutils.Vector,
    within: float = math.inf,
    most: int | None = None,
) -> dict[str, float]:
    """How far the surfaces of rendered meshes are from a point, by the object's name; "" is the camera.

    Those farther than `within` may be missing; at most `most` objects and instances are looked at."""
    found = {}
    if scene.camera:
        found[""] = (scene.camera.evaluated_get(depsgraph).matrix_world.translation - origin).length
    for instance in itertools.islice(depsgraph.object_instances, most):
        obj = instance.object
        is_surface = obj.type == "MESH" and obj.bentlight.made_for_cycles == "NOTHING"
        if not is_surface or obj.hide_render or not obj.data.polygons:
            continue
        matrix = instance.matrix_world
        if abs(matrix.determinant()) < 1e-30 or _is_beyond(obj, matrix, origin, within):
            continue
        hit, near, _, _ = obj.closest_point_on_mesh(matrix.inverted() @ origin)
        if hit:
            distance = (matrix @ near - origin).length
            found[obj.name] = min(distance, found.get(obj.name, math.inf))
    return found


def _is_beyond(obj: bpy.types.Object, matrix: mathutils.Matrix, origin: mathutils.Vector, distance: float) -> bool:
    """Whether the ball around an object's box is farther away: much quicker to tell than where its surface is."""
    if math.isinf(distance):
        return False
    corners = [matrix @ mathutils.Vector(corner) for corner in obj.bound_box]
    middle = (corners[0] + corners[6]) / 2
    return (middle - origin).length - max((corner - middle).length for corner in corners) > distance
