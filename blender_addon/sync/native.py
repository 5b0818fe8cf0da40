"""SceneData into a committed native scene. No bpy here."""

from __future__ import annotations

from collections.abc import Callable

import bentlight_native
import numpy as np

from ..report import RenderError
from . import spacetime
from .scene_data import CameraData, InstanceData, LampData, SceneData, SpacetimeData, SunData

_INSIDE_HORIZON = "The camera is inside the horizon of black hole '{}'"
_INSIDE_THROAT = "The camera is inside the throat of wormhole '{}'"


def build_scene(data: SceneData, progress: bentlight_native.Progress | None = None) -> bentlight_native.Scene:
    """A committed native scene. Raises RenderError for materials and spacetime objects that cannot be.

    Cancelled if another thread cancels `progress` in the meantime.
    """
    scene = bentlight_native.Scene()
    for image in data.images:
        scene.add_image(*image)
    for material in data.materials:
        set_program(scene.add_material, material)
    set_program(scene.set_world, data.world)
    for mesh in data.meshes:
        index = scene.add_mesh(
            mesh.vertices,
            mesh.triangles,
            corner_normals=mesh.corner_normals,
            corner_uvs=mesh.corner_uvs,
            material_slots=mesh.material_slots,
            generated=mesh.generated,
        )
        for number, values in mesh.attributes.items():
            scene.set_mesh_attribute(index, number, values)
    for instance in data.instances:
        _add_instance(scene, instance)
    set_suns(scene, data.suns)
    set_lamps(scene, data.lamps)
    check_camera(data.spacetimes, data.camera)
    set_spacetimes(scene, data.spacetimes)
    scene.set_gravitational(data.gravitational)
    set_camera(scene, data.camera)
    scene.commit(progress)
    return scene


def set_camera(scene: bentlight_native.Scene, camera: CameraData) -> None:
    """The camera alone; takes a commit to become visible. Raises RenderError for settings that make no picture."""
    try:
        scene.set_camera(
            camera.kind,
            camera.world_from_camera,
            camera.window,
            camera.clip_start,
            camera.clip_end,
            aperture=camera.aperture,
            **camera.panorama,
        )
    except ValueError as error:
        raise RenderError("Camera: {}", error) from error


def set_program(setter: Callable, program: bentlight_native.Program | None) -> None:
    """Gives a material's or the world's program to a setter. Raises RenderError naming its owner."""
    try:
        setter(program)
    except ValueError as error:
        raise RenderError("{}: {}", program.owner, error) from error


def _add_instance(scene: bentlight_native.Scene, instance: InstanceData) -> None:
    try:
        index = scene.add_instance(
            instance.mesh,
            instance.world_from_mesh,
            materials=np.array(instance.materials, np.int32),
            visibility=instance.visibility,
            object_index=instance.object_index,
            one_sided=instance.one_sided,
            color=instance.color,
            random=instance.random,
            influence=instance.influence,
            receiver_set=instance.receiver_set,
            blocker_set=instance.blocker_set,
        )
        for number, value in instance.attributes.items():
            scene.set_instance_attribute(index, number, value)
    except ValueError as error:
        raise RenderError("Object '{}': {}", instance.name, error) from error


def set_suns(scene: bentlight_native.Scene, suns: list[SunData]) -> None:
    """Replaces all suns."""
    scene.set_suns(
        [sun.direction for sun in suns],
        [sun.radiance for sun in suns],
        [sun.angle for sun in suns],
        [sun.visibility for sun in suns],
        [sun.influence for sun in suns],
        [sun.material for sun in suns],
        np.array([sun.world_from_sun for sun in suns]).reshape(-1, 4, 4),
    )


def set_lamps(scene: bentlight_native.Scene, lamps: list[LampData]) -> None:
    """Replaces all lamps without size."""
    try:
        scene.set_lamps(
            [lamp.world_from_lamp for lamp in lamps],
            [lamp.material for lamp in lamps],
            [lamp.visibility for lamp in lamps],
            [lamp.influence for lamp in lamps],
        )
    except ValueError as error:
        raise RenderError("Lights {}: {}", ", ".join(lamp.name for lamp in lamps), error) from error


def check_camera(items: list[SpacetimeData], camera: CameraData) -> None:
    """Raises RenderError for a camera where nothing can be seen from, and for spacetime objects that cannot be."""
    spacetime.check(items)
    place = camera.world_from_camera[:3, 3]
    for item in items:
        if spacetime.is_inside_core(item, place):
            is_hole = item.kind == "BLACK_HOLE"
            raise RenderError(_INSIDE_HORIZON if is_hole else _INSIDE_THROAT, item.name)


def set_spacetimes(scene: bentlight_native.Scene, items: list[SpacetimeData]) -> None:
    """Replaces all black holes and wormholes."""
    index = {item.name: i for i, item in enumerate(items)}
    scene.set_spacetime_objects(
        [
            (native_spacetime(item), item.world_from_spacetime, radius, index[item.exit] if item.exit else -1)
            for item, radius in zip(items, spacetime.influence_radii(items), strict=True)
        ]
    )


def native_spacetime(item: SpacetimeData) -> bentlight_native.Spacetime:
    """One hole or mouth in its own units."""
    if item.kind == "WORMHOLE":
        return bentlight_native.Spacetime.ellis(item.throat_radius)
    if item.chart == "ISOTROPIC":
        return bentlight_native.Spacetime.schwarzschild(item.mass, "isotropic")
    if item.spin == 0:
        return bentlight_native.Spacetime.schwarzschild(item.mass, "areal")
    return bentlight_native.Spacetime.kerr(item.mass, item.spin * item.mass)
