"""What stands still while the shutter is open: objects whose motion blur is switched off. Knows no bpy."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Iterator
from dataclasses import replace
from typing import Any, NamedTuple

from .cycles_setting import cycles_setting
from .scene_data import InstanceData, MeshData, SceneData

Key = tuple[str, str, int]


class Still(NamedTuple):
    """Names of the objects that do not move, and of those that do not change their shape, with those that do not move.
    What they instance does not either."""

    objects: frozenset[str] = frozenset()
    shapes: frozenset[str] = frozenset()


def still_objects(objects: Iterable[Any]) -> Still:
    """By the switches that Cycles has in Blender's objects; `objects`: also those that are only instanced."""
    objects = list(objects)
    placed = frozenset(obj.name for obj in objects if not cycles_setting(obj, "use_motion_blur", True))
    shaped = frozenset(obj.name for obj in objects if not cycles_setting(obj, "use_deform_motion", True))
    return Still(placed, placed | shaped)


def standing(scene: SceneData, frame: SceneData, still: Still, camera: str) -> SceneData:
    """The scene of a moment, but with what is still, and what it instances, as in the frame; `camera`: its name.

    Meshes and instances keep their places in their lists, so that all moments of a frame are alike."""
    framed, meshes, instances = by_key(frame), list(scene.meshes), []
    moving = {item.mesh for item in scene.instances if not _is_of(item, still.shapes)}
    for key, (instance, _) in by_key(scene).items():
        if _is_of(instance, still.shapes) and key in framed:
            before, mesh = framed[key]
            index = instance.mesh
            if index in moving:
                index = len(meshes)
                meshes.append(mesh)
            else:
                meshes[index] = mesh
            placed = before if _is_of(instance, still.objects) else instance
            instance = replace(placed, mesh=index, materials=instance.materials)
        instances.append(instance)
    return replace(
        scene,
        camera=frame.camera if camera in still.objects else scene.camera,
        meshes=meshes,
        instances=instances,
        lamps=_standing(scene.lamps, frame.lamps, still),
        suns=_standing(scene.suns, frame.suns, still),
        spacetimes=_standing(scene.spacetimes, frame.spacetimes, still),
    )


def _standing(items: list[Any], framed: list[Any], still: Still) -> list[Any]:
    known = {key: item for key, item in _numbered(framed) if _is_of(item, still.objects)}
    return [known.get(key, item) for key, item in _numbered(items)]


def _is_of(item: Any, names: Collection[str]) -> bool:
    """Whether an object of these names is shown, or instances what is."""
    return item.name in names or item.carrier in names


def by_key(scene: SceneData) -> dict[Key, tuple[InstanceData, MeshData]]:
    """Instances and their meshes by what finds them in another moment."""
    return {key: (instance, scene.meshes[instance.mesh]) for key, instance in _numbered(scene.instances)}


def _numbered(items: Iterable[Any]) -> Iterator[tuple[Key, Any]]:
    """Things by name, by what instances them, and by how often they came before."""
    seen: Counter[tuple[str, str]] = Counter()
    for item in items:
        name = item.name, item.carrier
        yield (*name, seen[name]), item
        seen[name] += 1
