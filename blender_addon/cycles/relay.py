"""The relay camera in a scene: an OSL camera beside the user's own, its maps baked anew when they no longer fit."""

from __future__ import annotations

import hashlib

import bentlight_native
import bpy
import numpy as np

from ..report import RenderError, Reporter
from ..sync.camera import read_camera
from ..sync.native import build_scene
from ..sync.objects import read_scene
from ..sync.scene_data import CameraData, SceneData
from . import files, relay_maps, shaders
from .aperture import Aperture

SHADER = "relay_camera"
_CLIP = 1e-6, 1e6  # of the relay camera: the last leg is as short as can be
_baked: dict[str, tuple[str, relay_maps.RelayMaps]] = {}  # by the relay camera's name: fingerprint and maps


def source_of(camera: bpy.types.Object | None) -> bpy.types.Object | None:
    """The user's camera that a relay camera stands for; None for other objects."""
    return camera.bentlight.relay_source if camera is not None and camera.type == "CAMERA" else None


def setup(scene: bpy.types.Scene) -> bpy.types.Object:
    """Makes the scene's camera a relay camera of the one it has. Returns it; does nothing if it is one already."""
    if source_of(scene.camera):
        return scene.camera
    source = scene.camera
    if source is None or source.type != "CAMERA":
        raise RenderError("No camera: the scene needs an active camera")
    lens = bpy.data.cameras.new(f"{source.name} Relay")
    relay = bpy.data.objects.new(lens.name, lens)
    relay.parent = source
    relay.bentlight.relay_source = source
    relay.hide_select = True
    (source.users_collection or (scene.collection,))[0].objects.link(relay)
    lens.type = "CUSTOM"
    lens.clip_start, lens.clip_end = _CLIP
    scene.camera = relay
    return relay


def clear(scene: bpy.types.Scene) -> bool:
    """Gives the scene its own camera back and removes the relay camera with its maps. False if there was none."""
    relay = scene.camera
    source = source_of(relay)
    if source is None:
        return False
    scene.camera = source
    _show_lenses(scene, True)
    _forget(relay.name)
    lens = relay.data
    bpy.data.objects.remove(relay)
    bpy.data.cameras.remove(lens)
    return True


def update(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> relay_maps.RelayMaps | None:
    """Bakes the maps of the scene's relay camera unless they fit the scene as it is; None without such a camera."""
    relay = scene.camera
    source = source_of(relay)
    if source is None:
        return None
    _show_lenses(scene, False)
    evaluated = source.evaluated_get(depsgraph)
    camera = read_camera(evaluated, scene.render, np.array(evaluated.matrix_world), evaluated.data.shift_x)
    data = read_scene(depsgraph, camera, Reporter(lambda level, text: None))
    data.instances = [instance for instance in data.instances if not instance.is_disk]  # Cycles has no mesh of it
    settings = relay_maps.RelaySettings(
        parts=scene.bentlight.relay_parts,
        tolerance=_tolerance(data),
        angular_tolerance=scene.bentlight.tolerance / 10,
        threads=scene.render.threads,
    )
    aperture = _aperture(evaluated, scene)
    fingerprint = _fingerprint(data, settings, aperture)
    known, maps = _baked.get(relay.name, ("", None))
    if known != fingerprint or not all(file.exists() for file in maps.files):
        _forget(relay.name)
        folder = files.folder("relay")
        maps = relay_maps.bake(_build(data), camera, folder / f"{fingerprint}_", settings, aperture)
        _baked[relay.name] = fingerprint, maps
    _set_parameters(relay.data, maps)
    return maps


def _build(data: SceneData) -> bentlight_native.Scene:
    """The geometry alone: what surfaces are made of is for Cycles to know."""
    for instance in data.instances:
        instance.materials, instance.attributes = (), {}
    for mesh in data.meshes:
        mesh.attributes = {}
    return build_scene(SceneData(data.camera, data.meshes, data.instances, spacetimes=data.spacetimes))


def _set_parameters(lens: bpy.types.Camera, maps: relay_maps.RelayMaps) -> None:
    shader = shaders.compiled(SHADER)
    if lens.custom_bytecode_hash != shader.key:
        lens.custom_mode = "INTERNAL"
        lens.custom_bytecode, lens.custom_bytecode_hash = shader.code, shader.key
    for name, value in maps.parameters.items():
        lens.cycles_custom[name] = value
    lens.update_tag()


def _show_lenses(scene: bpy.types.Scene, shown: bool) -> None:
    """Lenses bend what surfaces scatter; camera rays are bent already."""
    for obj in scene.objects:
        if obj.bentlight.is_lens and obj.visible_camera != shown:
            obj.visible_camera = shown


def darken(scene: bpy.types.Scene) -> None:
    """Takes the maps away from the scene's relay camera: better black than a picture of another frame."""
    _forget(scene.camera.name)
    scene.camera.data.cycles_custom["Maps"] = ""


def _forget(name: str) -> None:
    if name in _baked:
        relay_maps.remove(_baked.pop(name)[1].files)


def forget_all() -> None:
    """Deletes all maps of this session."""
    for name in list(_baked):
        _forget(name)


def _tolerance(data: SceneData) -> float:
    """Of hits: far below what is seen, a hundred thousandth of the scene's size or less."""
    points = [instance.world_from_mesh[:3, 3] for instance in data.instances]
    points += [item.origin for item in data.spacetimes] + [data.camera.world_from_camera[:3, 3]]
    return max(1e-5 * float(np.ptp(points, axis=0).max()), 1e-6)


def _aperture(camera: bpy.types.Object, scene: bpy.types.Scene) -> Aperture | None:
    """Depth of field as Cycles takes it from a perspective camera."""
    lens = camera.data
    dof = lens.dof
    if not dof.use_dof or lens.type != "PERSP" or dof.aperture_fstop <= 0:
        return None
    distance = dof.focus_distance
    if dof.focus_object is not None:
        to_focus = dof.focus_object.matrix_world.translation - camera.matrix_world.translation
        forward = -camera.matrix_world.to_3x3().normalized().col[2]
        distance = abs(to_focus.dot(forward))
    millimeters = 1e-3 / scene.unit_settings.scale_length
    return Aperture(
        lens.lens * millimeters / (2 * dof.aperture_fstop),
        max(distance, 1e-6),
        dof.aperture_blades,
        dof.aperture_rotation,
        dof.aperture_ratio,
    )


def _fingerprint(data: SceneData, settings: relay_maps.RelaySettings, aperture: Aperture | None) -> str:
    """Of all that the maps depend on: no change of a material or a lamp bakes them anew."""
    digest = hashlib.blake2b(digest_size=12)
    digest.update(repr((settings, aperture, _plain(data.camera), [_plain(item) for item in data.spacetimes])).encode())
    for mesh in data.meshes:
        digest.update(np.ascontiguousarray(mesh.vertices))
        digest.update(np.ascontiguousarray(mesh.triangles))
    for instance in data.instances:
        digest.update(repr((instance.mesh, instance.visibility, instance.one_sided)).encode())
        digest.update(np.ascontiguousarray(instance.world_from_mesh))
    return digest.hexdigest()


def _plain(item: CameraData | object) -> dict:
    return {
        name: value.tobytes() if isinstance(value, np.ndarray) else value for name, value in sorted(vars(item).items())
    }
