"""What a viewport is to draw of a scene: lines in the world, with their names. Reads Blender's objects; no gpu here."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable
from typing import NamedTuple

import bpy
import mathutils
import numpy as np

from ..report import RenderError
from ..sync import disk, spacetime
from ..sync.camera import read_camera
from ..sync.native import check_camera
from ..sync.scene_data import SpacetimeData
from . import circles, fans, rays

_REACH = 50.0  # core radii: as far as a ray is drawn at least
_PIECE_TURN = 0.06  # radians
HIT = "HIT"  # a surface; besides the fates of rays


class Line(NamedTuple):
    """World points (n, 3); kind: of a Mark, or a ray's fate; name: "" for rays."""

    kind: str
    name: str
    points: np.ndarray


class Subject(NamedTuple):
    """A hole or a mouth that is shown; disk: radii in masses."""

    item: SpacetimeData
    disk: tuple[float, float] | None


def read_subjects(
    objects: Iterable[bpy.types.Object], is_shown: Callable[[bpy.types.Object], bool], depsgraph: bpy.types.Depsgraph
) -> list[Subject]:
    """Of those of the objects that are shown. Those that cannot be, as a scale of 0 makes them, are left out."""
    found = []
    for obj in objects:
        if not is_shown(obj):
            continue
        evaluated = obj.evaluated_get(depsgraph)
        item = spacetime.read_spacetime(evaluated, np.array(evaluated.matrix_world))
        try:
            spacetime.check_alone(item)
        except RenderError:
            continue
        found.append(Subject(item, _disk_radii(evaluated, item)))
    return found


def _disk_radii(obj: bpy.types.Object, item: SpacetimeData) -> tuple[float, float] | None:
    settings = obj.bentlight.disk
    if item.kind != "BLACK_HOLE" or not settings.enable:
        return None
    try:
        extent = disk.read_extent(settings, item)
    except RenderError:
        return None
    return extent.inner, extent.outer


def mark_lines(subjects: list[Subject], eye: np.ndarray) -> list[Line]:
    """The circles, and the outlines of spheres from `eye`; see circles.line."""
    found = []
    for subject in subjects:
        for mark in circles.marks(subject.item, subject.disk):
            points = circles.line(subject.item, mark, eye)
            if points is not None:
                found.append(Line(mark.kind, mark.name, points))
    return found


def ray_lines(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph, subjects: list[Subject]) -> list[Line]:
    """The rays that the scene's overlay settings ask for. Raises RenderError where none can be followed."""
    settings = scene.bentlight.overlay
    items = [subject.item for subject in subjects if subject.item.kind != "BLACK_HOLE" or subject.item.mass > 0]
    spacetime.check(items)
    if settings.rays == "CAMERA":
        starts, directions = _camera_rays(scene, depsgraph, items)
    else:
        starts, directions = _cursor_rays(scene, items)
    found = []
    reach = _reach(items, starts)
    lenses = rays.lenses(items, reach)
    for start, direction in zip(starts, directions, strict=True):
        lines, fate = rays.trace(lenses, start, direction, reach)
        found += _until_surface(scene, depsgraph, lines, fate)
    return found


def _camera_rays(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph, items: list[SpacetimeData]) -> fans.Rays:
    camera = scene.camera
    if camera is None or camera.type != "CAMERA":
        raise RenderError("No camera: the scene needs an active camera")
    camera = camera.evaluated_get(depsgraph)
    data = read_camera(camera, scene.render, np.array(camera.matrix_world), camera.data.shift_x)
    check_camera(items, data)
    return fans.camera_fan(data, scene.bentlight.overlay.ray_count, _target(items, data.world_from_camera[:3, 3]))


def _cursor_rays(scene: bpy.types.Scene, items: list[SpacetimeData]) -> fans.Rays:
    place = np.array(scene.cursor.location)
    for item in items:
        if spacetime.is_inside_core(item, place):
            raise RenderError("The 3D cursor is inside '{}'", item.name)
    return fans.star(place, scene.bentlight.overlay.ray_count, _target(items, place), np.array([0.0, 0.0, 1.0]))


def _target(items: list[SpacetimeData], start: np.ndarray) -> np.ndarray | None:
    return fans.nearest([item.origin for item in items], start)


def _reach(items: list[SpacetimeData], starts: np.ndarray) -> float:
    """How far rays are drawn: well beyond everything that bends them."""
    cores = [_REACH * spacetime.core_radius(item) * item.scale for item in items]
    distances = [float(np.linalg.norm(item.origin - start)) for item in items for start in starts[:1]]
    return max([1.0, *cores, *(2 * distance for distance in distances)])


def _until_surface(
    scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph, lines: list[np.ndarray], fate: str
) -> list[Line]:
    """A ray's lines up to the first surface that they meet."""
    found: list[Line] = []
    for points in lines:
        for first, last in itertools.pairwise(_nearly_straight(points)):
            if _surface_between(scene, depsgraph, points[first], points[last]) is None:
                continue
            for i in range(first, last):
                place = _surface_between(scene, depsgraph, points[i], points[i + 1])
                if place is not None:
                    kept = np.concatenate([points[: i + 1], place[None]])
                    return [line._replace(kind=HIT) for line in (*found, Line(HIT, "", kept))]
        found.append(Line(fate, "", points))
    return found


def _nearly_straight(points: np.ndarray) -> list[int]:
    """Where to cut a line into pieces that turn by little: looking for surfaces takes long where there are many."""
    ways = np.diff(points, axis=0)
    ways /= np.maximum(np.linalg.norm(ways, axis=1, keepdims=True), 1e-300)
    turns = np.arccos(np.clip(np.einsum("ij,ij->i", ways[1:], ways[:-1]), -1, 1))
    piece = np.floor(np.concatenate([[0.0], np.cumsum(turns)]) / _PIECE_TURN)
    return [0, *(np.flatnonzero(np.diff(piece)) + 1).tolist(), len(points) - 1] if len(points) > 1 else []


def _surface_between(
    scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph, start: np.ndarray, end: np.ndarray
) -> np.ndarray | None:
    """Where a straight line first meets a mesh that is no lens for Cycles."""
    way = mathutils.Vector(end - start)
    length, place = way.length, mathutils.Vector(start)
    if not length > 0:
        return None
    direction, left = way / length, length
    while left > 0:
        hit, where, _, _, obj, _ = scene.ray_cast(depsgraph, place, direction, distance=left)
        if not hit:
            return None
        if obj.bentlight.made_for_cycles == "NOTHING":
            return np.array(where)
        step = (where - place).length + 1e-5 * length
        place, left = place + step * direction, left - step
    return None


def camera_eye(view_matrix: np.ndarray, is_perspective: bool) -> np.ndarray:
    """(4,) for mark_lines: where a viewport is seen from, or the direction towards who looks."""
    world_from_view = np.linalg.inv(view_matrix)
    return world_from_view[:, 3] if is_perspective else world_from_view[:, 2]
