"""A native scene brought from one SceneData to the next by the edits between them. No bpy here."""

from __future__ import annotations

import dataclasses
from typing import Any

import bentlight_native
import numpy as np

from . import native
from .scene_data import InstanceData, MeshData, SceneData


def update_scene(
    scene: bentlight_native.Scene, old: SceneData, new: SceneData, progress: bentlight_native.Progress | None = None
) -> bentlight_native.Scene:
    """The scene, which shows `old`, edited until it shows `new`, and committed; or one that is built anew where things
    have come or gone. As build_scene(new) to rounding; raises what that raises, and then `scene` is of no more use."""
    if not is_alike(old, new):
        return native.build_scene(new, progress)
    for index, (before, after) in enumerate(zip(old.materials, new.materials, strict=True)):
        if not same(before, after):
            native.set_program(lambda program, index=index: scene.update_material(index, program), after)
    if not same(old.world, new.world):
        native.set_program(scene.set_world, new.world)
    for index, (before, after) in enumerate(zip(old.meshes, new.meshes, strict=True)):
        if not same(before, after):
            scene.update_mesh(index, after.vertices, corner_normals=after.corner_normals, generated=after.generated)
    for index, (before, after) in enumerate(zip(old.instances, new.instances, strict=True)):
        if not same(before, after):
            scene.update_instance(index, after.world_from_mesh)
    if not same(old.suns, new.suns):
        native.set_suns(scene, new.suns)
    if not same(old.lamps, new.lamps):
        native.set_lamps(scene, new.lamps)
    native.check_camera(new.spacetimes, new.camera)
    if not same(old.spacetimes, new.spacetimes):
        native.set_spacetimes(scene, new.spacetimes)
    if old.gravitational != new.gravitational:
        scene.set_gravitational(new.gravitational)
    if not same(old.camera, new.camera):
        native.set_camera(scene, new.camera)
    scene.commit(progress)
    return scene


def is_alike(old: SceneData, new: SceneData) -> bool:
    """Whether the same things are in both, which may have moved, changed their materials, or their vertices' places."""
    return (
        len(old.materials) == len(new.materials)
        and same(old.images, new.images)
        and _all_alike(old.meshes, new.meshes, _is_alike_mesh)
        and _all_alike(old.instances, new.instances, _is_alike_instance)
    )


def _all_alike(old: list, new: list, is_pair_alike: Any) -> bool:
    return len(old) == len(new) and all(map(is_pair_alike, old, new))


def _is_alike_mesh(old: MeshData, new: MeshData) -> bool:
    moved = {name: getattr(new, name) for name in ("vertices", "corner_normals", "generated")}
    has_kept = len(old.vertices) == len(new.vertices) and all(
        (getattr(old, name) is None) == (value is None) for name, value in moved.items()
    )
    return old is new or (has_kept and same(dataclasses.replace(old, **moved), new))


def _is_alike_instance(old: InstanceData, new: InstanceData) -> bool:
    return old is new or same(dataclasses.replace(old, world_from_mesh=new.world_from_mesh), new)


def same(a: Any, b: Any) -> bool:
    """Whether two pieces of scene data are equal, to the last bit of their arrays."""
    if a is b:
        return True
    if type(a) is not type(b):
        return False
    if isinstance(a, np.ndarray):
        return a.shape == b.shape and a.dtype == b.dtype and bool(np.array_equal(a, b))
    if dataclasses.is_dataclass(a):
        return all(same(getattr(a, field.name), getattr(b, field.name)) for field in dataclasses.fields(a))
    if isinstance(a, dict):
        return a.keys() == b.keys() and all(same(a[key], b[key]) for key in a)
    if isinstance(a, (list, tuple)):
        return len(a) == len(b) and all(map(same, a, b))
    return bool(a == b)
