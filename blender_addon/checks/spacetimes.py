"""What is wrong with black holes and wormholes, and with what is near them."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator

import bpy
import mathutils
import numpy as np
from bpy.app.translations import pgettext_rpt as rpt_

from ..overlay.circles import photon_orbit
from ..report import RenderError
from ..sync import spacetime
from ..sync.scene_data import SpacetimeData
from . import around, inside
from .finding import Finding

INSTANCES_MAX = 20_000  # that are looked at: a tenth of a second after each change
_Core = tuple[SpacetimeData, mathutils.Vector, float]  # a hole, its place, and the radius of a ball around its core


def read(view_layer: bpy.types.ViewLayer, depsgraph: bpy.types.Depsgraph) -> list[SpacetimeData]:
    """What renders, whether it can be or not."""
    return [
        spacetime.read_spacetime(obj.evaluated_get(depsgraph), np.array(obj.evaluated_get(depsgraph).matrix_world))
        for obj in view_layer.objects
        if obj.bentlight.kind != "NONE" and not obj.hide_render
    ]


def impossible(items: list[SpacetimeData]) -> list[Finding]:
    """Why these objects cannot be rendered; empty if they can."""
    found = []
    by_name = {item.name: item for item in items}
    for item in items:
        try:
            spacetime.check_alone(item)
            spacetime.check_exit(item, by_name)
        except RenderError as error:
            found.append(Finding(str(error), "OBJECT", item.name))
    if not found:
        try:
            spacetime.influence_radii(items)
        except RenderError as error:
            about = tuple(item.name for item in items if f"'{item.name}'" in str(error))
            found.append(Finding(str(error), "OBJECT", about[0] if about else items[0].name, about))
    return found


class Balls:
    """Balls around meshes in their own coordinates, remembered until the meshes may have changed."""

    def __init__(self) -> None:
        self._known: dict[str, tuple[mathutils.Vector, float]] = {}

    def forget(self, depsgraph: bpy.types.Depsgraph | None) -> None:
        """After a change; see changes.listen."""
        for update in depsgraph.updates if depsgraph else ():
            if update.is_updated_geometry:
                self._known.pop(update.id.name_full, None)
        if depsgraph is None:
            self._known.clear()

    def around(self, obj: bpy.types.Object) -> tuple[mathutils.Vector, float]:
        """Middle and radius in the world of a ball that holds an evaluated object."""
        if obj.name_full not in self._known:
            self._known[obj.name_full] = _box_ball(obj)
        return _placed(self._known[obj.name_full], obj.matrix_world)


def _box_ball(obj: bpy.types.Object) -> tuple[mathutils.Vector, float]:
    """Middle and radius of the ball around an object's box, in its own coordinates."""
    low, high = (mathutils.Vector(obj.bound_box[i]) for i in (0, 6))
    return (low + high) / 2, (high - low).length / 2


def _placed(ball: tuple[mathutils.Vector, float], matrix: mathutils.Matrix) -> tuple[mathutils.Vector, float]:
    """A ball in the world around one that a matrix places there."""
    middle, radius = ball
    longest = max(axis.length for axis in matrix.to_3x3().col)
    return matrix @ middle, math.sqrt(3) * longest * radius  # a bound for shear too


def near_horizons(
    scene: bpy.types.Scene,
    view_layer: bpy.types.ViewLayer,
    depsgraph: bpy.types.Depsgraph,
    items: list[SpacetimeData],
    balls: Balls,
) -> Iterator[Finding]:
    """Meshes and the camera, where sound objects are too near."""
    solid = [item for item in items if item.kind == "WORMHOLE" or item.mass > 0]
    cores = [(item, mathutils.Vector(item.origin), float(inside.core_axes(item).max()) * item.scale) for item in solid]
    if cores:
        for obj in view_layer.objects:
            if obj.type == "MESH" and not obj.hide_render and obj.bentlight.made_for_cycles == "NOTHING":
                evaluated = obj.evaluated_get(depsgraph)
                ball = balls.around(evaluated)
                yield from _mesh(evaluated, evaluated.matrix_world, ball, cores)
                if scene.camera is not None:
                    yield from _cover(evaluated, ball, cores, scene.camera.evaluated_get(depsgraph))
        yield from _instances(depsgraph, cores)
    if scene.camera is not None:
        camera = scene.camera.evaluated_get(depsgraph)
        for item in solid:
            yield from _camera(camera, item)


def _instances(depsgraph: bpy.types.Depsgraph, cores: list[_Core]) -> Iterator[Finding]:
    """Those of geometry nodes, collections, particles and the like, and the meshes of curves and texts; each object by
    each of its instancers is told once. An object that is hidden in renders is seen where another places it, but for
    those in an instanced collection."""
    told: set[tuple[str, str, str]] = set()
    local: dict[int, tuple[mathutils.Vector, float]] = {}
    for instance in itertools.islice(depsgraph.object_instances, INSTANCES_MAX):
        if not instance.is_instance or not instance.show_self:
            continue
        obj, parent = instance.object, instance.parent
        if obj.type != "MESH" or parent.hide_render or obj.bentlight.made_for_cycles != "NOTHING":
            continue
        if obj.hide_render and parent.instance_type == "COLLECTION":
            continue
        mesh = obj.data.as_pointer()
        if mesh not in local:
            local[mesh] = _box_ball(obj)
        world = instance.matrix_world
        untold = [core for core in cores if (obj.name, parent.name, core[0].name) not in told]  # each reads the mesh
        for found in _mesh(obj, world, _placed(local[mesh], world), untold, parent):
            told.add((obj.name, parent.name, found.about[0]))
            yield found


def _mesh(
    obj: bpy.types.Object,
    world: mathutils.Matrix,
    ball: tuple[mathutils.Vector, float],
    cores: list[_Core],
    parent: bpy.types.Object | None = None,
) -> Iterator[Finding]:
    """An evaluated object at a place in the world, in a ball there, as itself or as placed by `parent`."""
    middle, radius = ball
    for item, origin, size in cores:
        if (middle - origin).length >= radius + size or obj.name == item.name:
            continue
        matrix = inside.core_from_world(item) @ np.array(world)
        corners = np.array(obj.bound_box) @ matrix[:3, :3].T + matrix[:3, 3]
        if inside.box_distance(corners) >= 1:
            continue
        vertices, triangles = _geometry(obj, matrix)
        if inside.lies_inside(vertices):
            text = rpt_("{} is inside '{}' and is not seen")
        elif inside.reaches_inside(vertices, triangles):
            text = rpt_("{} reaches into '{}': what is inside is not seen")
        else:
            continue
        is_own = parent is None or parent.name == obj.name
        who = f"'{obj.name}'" if is_own else rpt_("Instance of '{}' by '{}'").format(obj.name, parent.name)
        yield Finding(text.format(who, item.name), "OBJECT", (parent or obj).name, (item.name,))


def _cover(
    obj: bpy.types.Object, ball: tuple[mathutils.Vector, float], cores: list[_Core], camera: bpy.types.Object
) -> Iterator[Finding]:
    """An evaluated object in a ball in the world, where it keeps a hole in its middle from being seen."""
    middle, radius = ball
    for item, origin, _ in cores:
        is_near = (middle - origin).length < radius and obj.name != item.name
        if is_near and around.hides(obj, origin, camera.matrix_world.translation):
            text = rpt_("'{}' is all around '{}' and hides it from the camera")
            yield Finding(text.format(obj.name, item.name), "OBJECT", obj.name, (item.name,))


def _geometry(obj: bpy.types.Object, matrix: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (n, 3), transformed, and triangles (m, 3)."""
    mesh = obj.data
    vertices = np.empty((len(mesh.vertices), 3), np.float32)
    mesh.vertices.foreach_get("co", vertices.reshape(-1))
    mesh.calc_loop_triangles()
    triangles = np.empty((len(mesh.loop_triangles), 3), np.int32)
    mesh.loop_triangles.foreach_get("vertices", triangles.reshape(-1))
    return vertices @ matrix[:3, :3].T + matrix[:3, 3], triangles


def _camera(camera: bpy.types.Object, item: SpacetimeData) -> Iterator[Finding]:
    place = np.array(camera.matrix_world.translation)
    if spacetime.is_inside_core(item, place):
        text = rpt_("The camera is inside '{}', where nothing can be seen from")
    elif item.kind == "BLACK_HOLE" and inside.masses_away(item, place) < photon_orbit(abs(item.spin)):
        text = rpt_("The camera is closer to '{}' than light can orbit: the black hole fills most of its view")
    else:
        return
    yield Finding(text.format(item.name), "OBJECT", camera.name, (item.name,))
