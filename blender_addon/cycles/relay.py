"""The relay camera in a scene: an OSL camera beside the user's own, its maps baked anew when they no longer fit."""

from __future__ import annotations

import hashlib
import math
import secrets
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import bpy
import mathutils
import numpy as np

from ..report import RenderError, Reporter, told
from ..sync import shutter
from ..sync.camera import read_camera
from ..sync.native import build_scene
from ..sync.objects import read_scene
from ..sync.scene_data import CameraData, MeshData, SceneData, Visibility
from ..sync.standing import Still, standing, still_objects
from . import disk, files, filtered_sky, light_groups, relay_maps, screen, shaders
from .motion import Slice, camera_change, swept

SHADER = "relay_camera"
_CLIP_END = 1e6  # of the relay camera
_SESSION = secrets.token_hex(4)  # in the files' names: another Blender with the same scene deletes its own alone
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
    relay.constraints.new("COPY_TRANSFORMS").target = source
    relay.bentlight.relay_source = source
    relay.hide_select = True
    (source.users_collection or (scene.collection,))[0].objects.link(relay)
    lens.type = "CUSTOM"
    lens.clip_end = _CLIP_END
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
    screen.hide(relay)
    if relay.bentlight.relay_switched_osl and not scene.bentlight.cycles_before:
        scene.cycles.shading_system = False
    lens = relay.data
    bpy.data.objects.remove(relay)
    bpy.data.cameras.remove(lens)
    return True


def update(
    scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph, reporter: Reporter | None = None
) -> relay_maps.RelayMaps | None:
    """Bakes the maps of the scene's relay camera unless they fit the scene as it is; None without such a camera.

    The reporter is told what the camera cannot see as it should."""
    relay = scene.camera
    source = source_of(relay)
    if source is None:
        return None
    _show_lenses(scene, False)
    reporter = reporter or Reporter(lambda level, text: None)
    sky, texts = filtered_sky.read(scene, depsgraph)
    texts += [text for obj in scene.objects if not obj.hide_render for text in disk.warnings(obj)]
    for text in texts + light_groups.warnings(scene):
        reporter.warn(text)
    seen = _read_all(scene, depsgraph, source, reporter)
    settings = relay_maps.RelaySettings(
        parts=math.ceil(scene.bentlight.relay_parts / math.sqrt(len(seen))),
        tolerance=_tolerance(seen[0]),
        angular_tolerance=scene.bentlight.tolerance / 10,
        threads=scene.render.threads,
        footprints=sky is not None,
    )
    moving = shutter.is_open(scene)
    fingerprint = _fingerprint(seen, settings, moving)
    known, maps = _baked.get(relay.name, ("", None))
    if known != fingerprint or not all(file.exists() for file in maps.files):
        _forget(relay.name)
        maps = _bake(seen, files.folder("relay") / f"{_SESSION}_{fingerprint}_", settings, moving)
        _baked[relay.name] = fingerprint, maps
    if maps.limit > 1:
        text = "The relay camera's image is compressed in so many pixels that not all of them take more rays: "
        reporter.warn(told(text + "raise Relay Parts for finer details, which takes more memory"))
    _show(scene, maps, seen[len(seen) // 2], sky)
    return maps


def _read_all(
    scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph, source: bpy.types.Object, reporter: Reporter
) -> list[SceneData]:
    """All slices of the shutter's time. Objects whose motion blur is switched off stand as in the frame."""
    still = still_objects(bpy.data.objects) if shutter.is_open(scene) else Still()
    frame = _read(scene, depsgraph, source, reporter, None) if any(still) else None
    seen: list[SceneData] = []
    for _ in _moments(scene):
        moment = _read(scene, depsgraph, source, reporter, seen[-1] if seen else frame)
        if frame:
            moment = standing(moment, frame, still, source.name)
        seen.append(moment)
    return seen


def _moments(scene: bpy.types.Scene) -> Iterator[int]:
    """The numbers of all slices, with the scene in that slice's middle; afterwards it is in its frame again.

    A shutter that is never open for long has one slice, the frame as it is."""
    if not shutter.is_open(scene):
        yield 0
        return
    opened, count = shutter.Shutter(scene), scene.bentlight.relay_slices
    frame, subframe = scene.frame_current, scene.frame_subframe
    try:
        for number in range(count):
            time = opened.frame((number + 0.5) / count)
            scene.frame_set(math.floor(time), subframe=time - math.floor(time))
            yield number
    finally:
        scene.frame_set(frame, subframe=subframe)


def _read(
    scene: bpy.types.Scene,
    depsgraph: bpy.types.Depsgraph,
    source: bpy.types.Object,
    reporter: Reporter,
    before: SceneData | None,
) -> SceneData:
    """The scene as it is: the geometry, and what accretion disks look like; what surfaces are made of is for Cycles to
    know. Meshes that have not changed since the moment before are its own."""
    evaluated = source.evaluated_get(depsgraph)
    camera = read_camera(evaluated, scene.render, np.array(evaluated.matrix_world), evaluated.data.shift_x)
    data = read_scene(depsgraph, camera, reporter, bare=True)
    meshes = [MeshData(mesh.vertices, mesh.triangles) for mesh in data.meshes]
    for i, (mesh, old) in enumerate(zip(meshes, before.meshes if before else (), strict=False)):
        if np.array_equal(mesh.vertices, old.vertices) and np.array_equal(mesh.triangles, old.triangles):
            meshes[i] = old
    return replace(data, meshes=meshes, suns=[], lamps=[])


def _bake(
    seen: list[SceneData], prefix: Path, settings: relay_maps.RelaySettings, moving: bool
) -> relay_maps.RelayMaps:
    """The maps of all slices, one after the other. All or none: they may be what has filled the disk."""
    maps = None
    try:
        for number in range(len(seen)):
            made = _bake_slice(seen, number, prefix, settings, moving)
            if maps is None:
                maps = made
            else:
                maps.add(made)
    except BaseException:
        relay_maps.remove(prefix.parent.glob(f"{prefix.name}*"))
        raise
    return maps


def _bake_slice(
    seen: list[SceneData], number: int, prefix: Path, settings: relay_maps.RelaySettings, moving: bool
) -> relay_maps.RelayMaps:
    data, travel = swept(seen, number)
    change = camera_change([moment.camera for moment in seen], number)
    return relay_maps.bake(
        build_scene(data),
        data.camera,
        prefix,
        settings,
        Slice(number, len(seen), change) if moving else None,
        travel + _room_for_lamps(data),
        np.array([instance.is_disk for instance in data.instances], bool),
    )


def _room_for_lamps(data: SceneData) -> np.ndarray:
    """How much earlier legs to each instance start: Cycles draws round lamps as disks across the line from where a ray
    starts to the lamp's center. From four radii away they are 3 % too small."""
    room = np.zeros(len(data.instances))
    for i, instance in enumerate(data.instances):
        if instance.visibility & Visibility.IMMATERIAL and not instance.one_sided:
            corners = data.meshes[instance.mesh].vertices @ instance.world_from_mesh[:3, :3].T
            room[i] = 4 * np.linalg.norm(corners, axis=1).max(initial=0.0)
    return room


def _show(scene: bpy.types.Scene, maps: relay_maps.RelayMaps, data: SceneData, sky: filtered_sky.Sky | None) -> None:
    """Gives Cycles the maps: by the camera alone, or also by the screen before one that stands still."""
    parameters = maps.parameters | {"SkyFilter": filtered_sky.pixels(scene) if sky else 0.0}
    screened = parameters["Slices"] > 0 or parameters["Disks"] > 0 or parameters["SkyFilter"] > 0
    relay = scene.camera
    shader = shaders.compiled(SHADER)
    lens = relay.data
    if lens.custom_bytecode_hash != shader.key:
        lens.custom_mode = "INTERNAL"
        lens.custom_bytecode, lens.custom_bytecode_hash = shader.code, shader.key
    near = lens.clip_start = _typical_distance(data)
    for name, value in (parameters | {"Near": near}).items():
        lens.cycles_custom[name] = value
    for constraint in relay.constraints:
        constraint.mute = screened
    if screened:
        relay.matrix_world = mathutils.Matrix(data.camera.world_from_camera)
        screen.show(relay, parameters, near, sky, light_groups.of_screen(scene))
        relay.bentlight.relay_switched_osl |= not scene.cycles.shading_system
        scene.cycles.shading_system = True  # of which the screen is
    else:
        screen.hide(relay)
    lens.update_tag()


def _typical_distance(data: SceneData) -> float:
    """From the camera to things."""
    place = data.camera.world_from_camera[:3, 3]
    things = [item.world_from_mesh[:3, 3] for item in data.instances] + [item.origin for item in data.spacetimes]
    return max(float(np.median([np.linalg.norm(thing - place) for thing in things] or [1.0])), 1e-3)


def _show_lenses(scene: bpy.types.Scene, shown: bool) -> None:
    """Lenses bend what surfaces scatter; camera rays are bent already."""
    for obj in scene.objects:
        if obj.bentlight.made_for_cycles == "LENS" and obj.visible_camera != shown:
            obj.visible_camera = shown


def darken(scene: bpy.types.Scene) -> None:
    """Takes the maps away from the scene's relay camera: better black than a picture of another frame."""
    _forget(scene.camera.name)
    custom = scene.camera.data.cycles_custom
    custom["Maps"], custom["Slices"] = "", 0


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


def _fingerprint(seen: list[SceneData], settings: relay_maps.RelaySettings, moving: bool) -> str:
    """Of all that the maps depend on: no change of a lamp or a material, but for disks', bakes them anew."""
    digest = hashlib.blake2b(digest_size=12)
    digest.update(repr((settings, moving)).encode())
    hashed: dict[int, bytes] = {}  # of meshes, which moments share
    for data in seen:
        holes = [_plain(item) for item in data.spacetimes]
        digest.update(repr((_plain(data.camera), holes, data.gravitational)).encode())
        for mesh in data.meshes:
            if id(mesh) not in hashed:
                one = hashlib.blake2b(np.ascontiguousarray(mesh.vertices))
                one.update(np.ascontiguousarray(mesh.triangles))
                hashed[id(mesh)] = one.digest()
            digest.update(hashed[id(mesh)])
        for instance in data.instances:
            digest.update(repr((instance.mesh, instance.materials, instance.visibility, instance.one_sided)).encode())
            digest.update(np.ascontiguousarray(instance.world_from_mesh))
        for program in data.materials:
            for part in (program.code, program.constants, program.table):
                digest.update(np.ascontiguousarray(part))
        for image in data.images:
            digest.update(repr((image.values.shape, image.srgb)).encode())
            digest.update(np.ascontiguousarray(image.values))
    return digest.hexdigest()


def _plain(item: CameraData | object) -> dict:
    return {
        name: value.tobytes() if isinstance(value, np.ndarray) else value for name, value in sorted(vars(item).items())
    }
