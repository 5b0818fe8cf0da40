"""Edits of a scene: what a memory and a native scene that is edited make of them is what a full reading makes."""

import bentlight_native
import bpy
import numpy as np
import pytest

from blender_addon.report import Reporter
from blender_addon.sync import change
from blender_addon.sync.camera import read_camera
from blender_addon.sync.change import is_alike, same, update_scene
from blender_addon.sync.memory import Memory
from blender_addon.sync.native import build_scene
from blender_addon.sync.objects import read_scene
from blender_addon.sync.scene_data import MeshData, SceneData
from tests.engine import stage
from tests.engine.stage import blender  # noqa: F401 (a fixture)


def read(memory: Memory | None = None) -> SceneData:
    scene, depsgraph = bpy.context.scene, bpy.context.evaluated_depsgraph_get()
    camera = read_camera(scene.camera.evaluated_get(depsgraph), scene.render, np.array(scene.camera.matrix_world), 0.0)
    return read_scene(depsgraph, camera, Reporter(lambda _level, _text: None), memory=memory)


def picture(scene: bentlight_native.Scene) -> np.ndarray:
    wanted = bentlight_native.RenderSettings(width=16, height=12, sample_count=2, max_bounces=2)
    channels = {"combined": np.zeros((12, 16, 4), np.float32)}
    scene.render_tile(0, 0, 16, 12, wanted, channels)
    return channels["combined"]


@pytest.fixture
def room(blender):  # noqa: F811
    """Some of everything that edits touch."""
    stage.add_camera((0, 0, 8))
    stage.set_world((0.1, 0.2, 0.3))
    stage.add_square(4.0, (0, 0, -1), stage.emission((0.5, 0.4, 0.3)), "Floor")
    bpy.ops.mesh.primitive_monkey_add(location=(1.5, 0, 0))
    bpy.ops.mesh.primitive_uv_sphere_add(location=(-1.5, 0, 0))
    stage.add_light("POINT", (0, 3, 3), energy=500, shadow_soft_size=0.2)
    stage.add_light("SUN", (0, 0, 5), energy=1)
    bpy.ops.bentlight.black_hole_add(mass=0.1, location=(0, 1, 1))
    image = bpy.data.images.new("picture", 4, 4)
    image.pixels.foreach_set(np.random.default_rng(1).random(64).astype(np.float32))
    material = stage.emission((1, 1, 1), 1.0, "Shown")
    tree = material.node_tree
    texture = tree.nodes.new("ShaderNodeTexImage")
    texture.image = image
    tree.links.new(texture.outputs["Color"], next(n for n in tree.nodes if n.type == "EMISSION").inputs["Color"])
    bpy.data.objects["Sphere"].data.materials.append(material)
    return bpy.data.objects


@pytest.fixture
def memory():
    """One that is told of every update."""
    made = Memory()

    def on_update(_scene, depsgraph):
        made.forget(depsgraph.updates)

    bpy.app.handlers.depsgraph_update_post.append(on_update)
    yield made
    bpy.app.handlers.depsgraph_update_post.remove(on_update)


def edits(rng):
    """What a user does, each with random numbers."""
    objects = bpy.data.objects

    def add():
        bpy.ops.mesh.primitive_cube_add(size=0.5, location=rng.uniform(-2, 2, 3))

    def delete():
        cubes = [obj for obj in objects if obj.name.startswith("Cube")]
        if cubes:
            bpy.data.objects.remove(cubes[rng.integers(len(cubes))])

    def sculpt():
        mesh = objects["Suzanne"].data
        places = np.empty(3 * len(mesh.vertices), np.float32)
        mesh.vertices.foreach_get("co", places)
        mesh.vertices.foreach_set("co", places * np.float32(rng.uniform(0.9, 1.1)))
        mesh.update()

    def paint():
        image = bpy.data.images["picture"]
        image.pixels.foreach_set(rng.random(64).astype(np.float32))
        image.update()
        image.update_tag()

    def shade():
        emission = next(n for n in bpy.data.materials["Emission"].node_tree.nodes if n.type == "EMISSION")
        emission.inputs["Strength"].default_value = rng.uniform(0.1, 2)

    def modify():
        sphere = objects["Sphere"]
        if "Subdivision" in sphere.modifiers:
            sphere.modifiers.remove(sphere.modifiers["Subdivision"])
        else:
            sphere.modifiers.new("Subdivision", "SUBSURF")

    def mass():
        hole = next(obj for obj in objects if obj.bentlight.kind == "BLACK_HOLE")
        hole.bentlight.mass = rng.uniform(0.05, 0.2)
        hole.bentlight.spin = rng.choice([0.0, 0.5])
        hole.update_tag()

    return {
        "move": lambda: setattr(objects["Suzanne"], "location", rng.uniform(-2, 2, 3)),
        "look": lambda: setattr(objects["Camera"], "location", (rng.uniform(-1, 1), 0, 8)),
        "lamp": lambda: setattr(bpy.data.lights[0], "energy", rng.uniform(100, 900)),
        "hide": lambda: setattr(objects["Sphere"], "hide_viewport", bool(rng.integers(2))),
        "swap": lambda: setattr(objects["Floor"], "data", objects[rng.choice(["Suzanne", "Floor"])].data),
        "undo": lambda: None,
        "world": lambda: stage.set_world(rng.uniform(0, 1, 3)),
        **{f.__name__: f for f in (add, delete, sculpt, paint, shade, modify, mass)},
    }


@pytest.mark.parametrize("seed", range(3))
def test_edits_one_by_one_are_as_a_full_reading(room, memory, seed):
    """Random ones: the data are equal to the last bit, and the pictures too."""
    rng = np.random.default_rng(seed)
    data = read(memory)
    native = build_scene(data)
    for name in rng.choice(sorted(edits(rng)), 20):
        edits(rng)[name]()
        bpy.context.view_layer.update()
        old, data, full = data, read(memory), read()
        assert same(data, full), name
        native = update_scene(native, old, data)
        np.testing.assert_array_equal(picture(native), picture(build_scene(full)), err_msg=name)


def test_an_object_that_moves_is_not_read_again(room, memory, monkeypatch):
    """Nor is the native scene built anew for that, a mass, a material, or a mesh whose vertices move."""
    rng = np.random.default_rng(1)
    data = read(memory)
    native = build_scene(data)
    monkeypatch.setattr(change.native, "build_scene", None)
    for name in ("move", "look", "mass", "shade", "world", "lamp", "sculpt"):
        edits(rng)[name]()
        bpy.context.view_layer.update()
        old, data = data, read(memory)
        assert is_alike(old, data), name
        assert update_scene(native, old, data) is native
        new = [mesh for mesh, before in zip(data.meshes, old.meshes, strict=True) if mesh is not before]
        assert len(new) == (1 if name == "sculpt" else 0) + len(new_lamps(data)), name


def new_lamps(data: SceneData) -> list:
    """Lamps with a size are meshes that are made, not read."""
    return [instance for instance in data.instances if instance.name == "Point"]


def test_what_is_the_same():
    vertices = np.zeros((3, 3), np.float32)
    mesh = MeshData(vertices, np.array([[0, 1, 2]], np.uint32))
    assert same(mesh, MeshData(vertices.copy(), mesh.triangles.copy()))
    assert not same(mesh, MeshData(vertices + 1, mesh.triangles))
    assert not same(mesh, MeshData(vertices.astype(np.float64), mesh.triangles))
    assert not same([1, 2], [1, 2, 3])
    assert not same({"a": 1}, {"b": 1})
    assert not same(1, 1.0)


def test_what_has_come_or_gone_is_not_alike(room):
    before = read()
    bpy.ops.mesh.primitive_cube_add()
    bpy.context.view_layer.update()
    after = read()
    assert is_alike(before, before)
    assert not is_alike(before, after)
