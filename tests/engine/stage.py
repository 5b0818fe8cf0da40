"""Small Blender scenes for tests: building them, rendering them, reading every pass back."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import bpy
import numpy as np
import OpenEXR
import pytest

import blender_addon
from blender_addon import final


@pytest.fixture(autouse=True)
def blender() -> Iterator[None]:
    """Blender with nothing in it but a camera-less scene, our add-on registered and chosen."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    blender_addon.register()
    scene = bpy.context.scene
    scene.render.engine = "BENTLIGHT"
    scene.render.resolution_x, scene.render.resolution_y = 64, 48
    scene.render.threads_mode, scene.render.threads = "FIXED", 2
    scene.bentlight.samples = 4
    scene.view_settings.view_transform = "Raw"
    yield
    blender_addon.unregister()


def add_camera(location=(0.0, 0.0, 0.0), rotation=(0.0, 0.0, 0.0), **settings) -> bpy.types.Object:
    """The scene's camera; without rotation it looks along -z."""
    camera = bpy.data.cameras.new("Camera")
    for name, value in settings.items():
        setattr(camera, name, value)
    obj = bpy.data.objects.new("Camera", camera)
    obj.location, obj.rotation_euler = location, rotation
    bpy.context.scene.collection.objects.link(obj)
    bpy.context.scene.camera = obj
    return obj


def add_mesh(name: str, vertices, faces, location=(0.0, 0.0, 0.0), material=None) -> bpy.types.Object:
    """An object with a mesh of polygons."""
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata([tuple(v) for v in vertices], [], [tuple(f) for f in faces])
    if material:
        mesh.materials.append(material)
    obj = bpy.data.objects.new(name, mesh)
    obj.location = location
    bpy.context.scene.collection.objects.link(obj)
    return obj


def add_square(size: float, location=(0.0, 0.0, 0.0), material=None, name="Square") -> bpy.types.Object:
    """A square across z that faces +z."""
    s = size / 2
    return add_mesh(name, [(-s, -s, 0), (s, -s, 0), (s, s, 0), (-s, s, 0)], [(0, 1, 2, 3)], location, material)


def emission(color, strength=1.0, name="Emission") -> bpy.types.Material:
    """A material that only shines."""
    material = bpy.data.materials.new(name)
    _use_nodes(material)
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    node, output = nodes.new("ShaderNodeEmission"), nodes.new("ShaderNodeOutputMaterial")
    node.inputs["Color"].default_value = (*color, 1.0)
    node.inputs["Strength"].default_value = strength
    links.new(node.outputs[0], output.inputs["Surface"])
    return material


def _use_nodes(owner: bpy.types.Material | bpy.types.World) -> None:
    if bpy.app.version < (5, 0, 0):  # where they are optional
        owner.use_nodes = True


def set_world(color, strength=1.0) -> bpy.types.World:
    """A sky of one color."""
    world = bpy.data.worlds.new("World")
    _use_nodes(world)
    background = next(node for node in world.node_tree.nodes if node.type == "BACKGROUND")
    background.inputs["Color"].default_value = (*color, 1.0)
    background.inputs["Strength"].default_value = strength
    bpy.context.scene.world = world
    return world


def add_light(kind: str, location=(0.0, 0.0, 0.0), rotation=(0.0, 0.0, 0.0), **settings) -> bpy.types.Object:
    """A lamp that the camera sees; without rotation it shines along -z."""
    light = bpy.data.lights.new(kind.title(), kind)
    for name, value in settings.items():
        setattr(light, name, value)
    obj = bpy.data.objects.new(kind.title(), light)
    obj.location, obj.rotation_euler = location, rotation
    obj.visible_camera = True
    bpy.context.scene.collection.objects.link(obj)
    return obj


def animation_curves(action: bpy.types.Action) -> list[bpy.types.FCurve]:
    """All curves of an action, for whatever they are."""
    bags = [bag for layer in action.layers for strip in layer.strips for bag in strip.channelbags]
    return [curve for bag in bags for curve in bag.fcurves]


def make_even(owner: bpy.types.ID) -> None:
    """Lets what is animated go on evenly between keyframes. (Blender's preference is not for those of scripts.)"""
    for curve in animation_curves(owner.animation_data.action):
        for point in curve.keyframe_points:
            point.interpolation = "LINEAR"


def read_exr(path: Path) -> dict[str, np.ndarray]:
    """Every pass of a multilayer EXR by "layer.pass" or "layer.pass.view", (height, width, components), upwards."""
    passes: dict[str, dict[str, np.ndarray]] = {}
    with OpenEXR.File(str(path), separate_channels=True) as file:
        for part in file.parts:  # one for each pass from Blender 5.0 on
            view = part.header.get("view", "")
            for name, channel in part.channels.items():
                owner, _, component = name.rpartition(".")
                passes.setdefault(f"{owner}.{view}".rstrip("."), {})[component] = channel.pixels
    order = "RGBrgbXYZUVWAa"
    return {
        owner: np.stack([parts[c] for c in sorted(parts, key=order.index)], axis=-1)[::-1].astype(np.float32)
        for owner, parts in passes.items()
    }


def render(tmp_path: Path, layer: str = "ViewLayer") -> dict[str, np.ndarray]:
    """Renders the scene by the engine that it names; every pass of one view layer by name, rows upwards."""
    return render_layers(tmp_path)[layer]


def render_layers(tmp_path: Path) -> dict[str, dict[str, np.ndarray]]:
    """The same for every view layer."""
    scene = bpy.context.scene
    set_multilayer(scene)
    path = tmp_path / "render.exr"
    path.unlink(missing_ok=True)
    scene.render.filepath = str(path)
    with counted_renders() as count:
        bpy.ops.render.render(write_still=True)
    assert bool(count) == (scene.render.engine == "BENTLIGHT"), "another engine rendered"
    layers: dict[str, dict[str, np.ndarray]] = {}
    for name, pixels in read_exr(path).items():
        owner, _, item = name.rpartition(".")
        layers.setdefault(owner, {})[item] = pixels
    return layers


def set_multilayer(scene: bpy.types.Scene) -> None:
    """32-bit multilayer EXR."""
    settings = scene.render.image_settings
    if bpy.app.version >= (5, 0, 0):
        settings.media_type = "MULTI_LAYER_IMAGE"
    settings.file_format = "OPEN_EXR_MULTILAYER"
    settings.color_depth = "32"


class counted_renders:  # noqa: N801 (reads as a function)
    """Counts how often our engine is asked to render: `with counted_renders() as count`."""

    def __enter__(self) -> list[None]:
        self._original, calls = final.render, []

        def counted(*args) -> None:
            calls.append(None)
            self._original(*args)

        final.render = counted
        return calls

    def __exit__(self, *_exception) -> None:
        final.render = self._original
