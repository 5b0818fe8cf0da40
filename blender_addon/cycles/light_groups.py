"""The light groups of what shines for others: of lenses and the relay camera's screen, which show accretion disks and
what filtering changes in the sky."""

from __future__ import annotations

import bpy

from ..report import told
from . import disk


def of_lens(scene: bpy.types.Scene, hole: bpy.types.Object) -> str:
    """That of the hole's disk, as in the engine; without a disk that of the world."""
    return hole.lightgroup if _has_disk(hole) else _of_world(scene)


def of_screen(scene: bpy.types.Scene) -> str:
    """That of all disks; without any, that of the world. Disks in several are in none (`warnings`)."""
    groups = {hole.lightgroup for hole in _with_disks(scene)} or {_of_world(scene)}
    return groups.pop() if len(groups) == 1 else ""


def warnings(scene: bpy.types.Scene) -> list[str]:
    """What the relay camera's screen puts into no light group."""
    if len({hole.lightgroup for hole in _with_disks(scene)}) < 2:
        return []
    return [told("By the relay camera accretion disks in several light groups are in none")]


def settings(scene: bpy.types.Scene) -> tuple[str, ...]:
    """What decides on warnings."""
    return _of_world(scene), *(hole.lightgroup for hole in _with_disks(scene))


def other_than_of_world(scene: bpy.types.Scene) -> bpy.types.Object | None:
    """A hole whose disk is in another light group than the world's light."""
    return next((hole for hole in _with_disks(scene) if hole.lightgroup != _of_world(scene)), None)


def put(obj: bpy.types.Object, group: str) -> None:
    """An object into a light group, or into none (""); where it is there already Blender is told of no change."""
    if obj.lightgroup != group:
        obj.lightgroup = group


def _with_disks(scene: bpy.types.Scene) -> list[bpy.types.Object]:
    return [obj for obj in scene.objects if not obj.hide_render and _has_disk(obj)]


def _has_disk(hole: bpy.types.Object) -> bool:
    return hole.bentlight.kind == "BLACK_HOLE" and disk.is_shown(hole)


def _of_world(scene: bpy.types.Scene) -> str:
    return scene.world.lightgroup if scene.world else ""
