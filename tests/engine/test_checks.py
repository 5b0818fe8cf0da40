"""Warnings come exactly when they should, name what they are about, and lead there."""

import math

import bpy
import numpy as np
import pytest

from blender_addon import checks
from blender_addon.checks import inside, spacetimes
from blender_addon.sync.scene_data import SpacetimeData
from tests.engine import stage
from tests.engine.warned import add_hole, texts


@pytest.fixture
def hole():
    return add_hole()


def test_nothing_to_tell_of_a_good_scene(hole):
    stage.add_camera(location=(0, -30, 0))
    stage.add_square(20.0, location=(0, 0, -2))
    stage.add_light("POINT", location=(0, 0, 5))
    stage.set_world((1, 1, 1))
    assert texts() == []


@pytest.mark.parametrize(("height", "expected"), [(1.001, False), (0.999, True), (-0.999, True), (-1.001, False)])
def test_a_wall_is_told_as_it_reaches_the_horizon(hole, height, expected):
    """All corners of the wall are far outside."""
    stage.add_square(50.0, location=(0, 0, height), name="Wall")
    assert texts() == (["'Wall' reaches into 'Hole': what is inside is not seen"] if expected else [])


def test_a_room_around_the_hole_is_none_of_it(hole):
    bpy.ops.mesh.primitive_cube_add(size=6, location=(0, 0, 0))
    assert texts() == []
    bpy.context.object.scale = (0.33, 1, 1)  # two walls at 0.99
    assert len(texts()) == 1


def test_what_is_wholly_inside(hole):
    stage.add_square(0.5, name="Tile")
    assert texts() == ["'Tile' is inside 'Hole' and is not seen"]
    bpy.data.objects["Tile"].hide_render = True
    assert texts() == []


@pytest.mark.parametrize(
    ("place", "expected"), [((0, 0, 1.45), 0), ((0, 0, 1.4), 1), ((1.7, 0, 0), 1), ((1.75, 0, 0), 0)]
)
def test_the_horizon_of_a_spinning_hole_is_flat(hole, place, expected):
    """Spin 0.9, mass 1: r+ = 1.436 along the axis, sqrt(r+^2 + a^2) = 1.695 across."""
    hole.bentlight.mass, hole.bentlight.spin = 1.0, 0.9
    stage.add_square(0.02, location=place)
    assert len(texts()) == expected


def test_modifiers_count(hole):
    wall = stage.add_square(1.0, location=(0, 0, 3), name="Wall")
    assert texts() == []
    wall.modifiers.new("Displace", "DISPLACE").strength = -4.2  # by half of this
    assert len(texts()) == 1


def scatter(obj: bpy.types.Object, node: str, **inputs) -> None:
    """An instance of what a geometry node makes at each of an object's vertices, instead of itself."""
    tree = bpy.data.node_groups.new("Scatter", "GeometryNodeTree")
    for way in ("INPUT", "OUTPUT"):
        tree.interface.new_socket("Geometry", in_out=way, socket_type="NodeSocketGeometry")
    before, after = tree.nodes.new("NodeGroupInput"), tree.nodes.new("NodeGroupOutput")
    source, place = tree.nodes.new(node), tree.nodes.new("GeometryNodeInstanceOnPoints")
    for name, value in inputs.items():
        source.inputs[name.replace("_", " ")].default_value = value
    made = next(socket for socket in source.outputs if socket.type == "GEOMETRY")
    tree.links.new(before.outputs[0], place.inputs["Points"])
    tree.links.new(made, place.inputs["Instance"])
    tree.links.new(place.outputs[0], after.inputs[0])
    obj.modifiers.new("Scatter", "NODES").node_group = tree


def test_instances_of_geometry_nodes(hole):
    """Of an object that renders show where it is placed alone, and of meshes that nodes make; told once, not for each,
    and selected by what places them."""
    stone = stage.add_square(0.2, (9, 9, 9), name="Stone")
    stone.hide_render = True
    host = stage.add_square(4.0, (0, 0, 0), name="Host")
    scatter(host, "GeometryNodeObjectInfo", Object=stone, As_Instance=True)
    assert texts() == []  # at (+-2, +-2)
    host.scale = (0.3, 0.3, 1.0)
    (found,) = (texts(), checks.of_scene(bpy.context))[1]
    assert found.text == "Instance of 'Stone' by 'Host' is inside 'Hole' and is not seen"
    assert (found.owner, found.about) == ("Host", ("Hole",))
    host.location.z = 1.0
    assert texts() == []
    host.modifiers.clear()
    scatter(host, "GeometryNodeMeshCube")
    assert texts() == ["'Host' reaches into 'Hole': what is inside is not seen"]
    host.hide_render = True
    assert texts() == []


def test_what_is_told_of_many_instances_is_read_once(hole, monkeypatch):
    """Of each core: what is inside one hole is yet to be told of another."""
    bpy.ops.bentlight.black_hole_add(mass=2.0, location=(9, 0, 0))
    bpy.context.object.name = "Other"
    stone = stage.add_square(0.2, (0, 9, 9), name="Stone")
    stone.hide_render = True
    host = stage.add_mesh("Host", [(x + 0.01 * i, 0, 0) for x in (0, 9) for i in range(20)], [])
    scatter(host, "GeometryNodeObjectInfo", Object=stone, As_Instance=True)
    read, geometry = [], spacetimes._geometry
    monkeypatch.setattr(spacetimes, "_geometry", lambda obj, matrix: read.append(obj.name) or geometry(obj, matrix))
    assert texts() == [
        f"Instance of 'Stone' by 'Host' is inside '{name}' and is not seen" for name in ("Hole", "Other")
    ]
    assert read.count("Stone") == 2


def test_instances_of_collections_and_meshes_of_texts(hole):
    """What a collection does not show in renders is not told."""
    scene, rocks = bpy.context.scene, bpy.data.collections.new("Rocks")
    tile = stage.add_square(0.2, name="Tile")
    scene.collection.objects.unlink(tile)
    rocks.objects.link(tile)
    empty = bpy.data.objects.new("Empty", None)
    empty.instance_type, empty.instance_collection = "COLLECTION", rocks
    scene.collection.objects.link(empty)
    assert texts() == ["Instance of 'Tile' by 'Empty' is inside 'Hole' and is not seen"]
    tile.hide_render = True
    assert texts() == []
    text = bpy.data.objects.new("Text", bpy.data.curves.new("Text", "FONT"))
    text.data.body = "Bentlight"
    text.location.z = 0.9
    scene.collection.objects.link(text)
    assert texts() == ["'Text' reaches into 'Hole': what is inside is not seen"]
    text.location.z = 1.1
    assert texts() == []


def test_distances_to_triangles_are_those_of_the_nearest_of_many_points():
    rng = np.random.default_rng(3)
    corners = rng.normal(size=(200, 3, 3)) * rng.uniform(0.1, 3, (200, 1, 1)) + rng.normal(size=(200, 1, 3))
    u, v = np.meshgrid(np.linspace(0, 1, 200), np.linspace(0, 1, 200))
    keep = u + v <= 1
    weights = np.stack([1 - u - v, u, v], axis=-1)[keep]
    for triangle, distance in zip(corners, inside._distances(corners), strict=True):
        nearest = np.linalg.norm(weights @ triangle, axis=1).min()
        step = np.linalg.norm(triangle - np.roll(triangle, 1, axis=0), axis=1).max() / 199
        assert nearest - step <= distance <= nearest + 1e-12


def test_the_camera_inside_and_too_close(hole):
    """Light orbits at 3 masses, drawn at M (3 - 1 + sqrt(9 - 6)) / 2 = 3.732."""
    camera = stage.add_camera()
    orbit = 2 + math.sqrt(3)
    for distance, word in ((0.99, "is inside"), (1.01, "closer to"), (orbit - 0.01, "closer to"), (orbit + 0.01, None)):
        camera.location = (0, distance, 0)
        found = texts()
        assert len(found) == (word is not None)
        assert all(word in text for text in found)


def test_masses_away_are_the_radius_of_boyer_and_lindquist():
    a = 0.9
    oblate = SpacetimeData("", "BLACK_HOLE", np.diag([2.0, 2.0, 2.0, 1.0]), mass=3.0, spin=a, chart="OBLATE")
    for r, theta in ((2.0, 0.0), (2.5, 0.7), (40.0, math.pi / 2)):
        place = 6 * np.array([math.hypot(r, a) * math.sin(theta), 0, r * math.cos(theta)])
        assert inside.masses_away(oblate, place) == pytest.approx(r, rel=1e-12)
    isotropic = SpacetimeData("", "BLACK_HOLE", np.eye(4), mass=3.0, chart="ISOTROPIC")
    assert inside.masses_away(isotropic, np.array([0, 1.5, 0])) == pytest.approx(2)


def test_objects_that_cannot_be(hole):
    hole.scale = (1, 1, 2)
    assert texts() == ["Black hole 'Hole': its scale must be uniform and positive"]
    hole.scale = (1, 1, 1)
    bpy.ops.bentlight.black_hole_add(mass=2.0, location=(1.5, 0, 0))
    (found,) = (texts(), checks.of_scene(bpy.context))[1]
    assert "overlap" in found.text and {found.owner, *found.about} == {"Hole", "Black Hole"}
    bpy.context.object.location.x = 2.5
    assert texts() == []


def test_a_wormhole_without_exit():
    bpy.ops.bentlight.wormhole_add(location=(0, 0, 0))
    mouth = bpy.context.object
    assert texts() == []
    bpy.data.objects.remove(mouth.bentlight.exit)
    assert len(texts()) == 1 and "has no exit" in texts()[0]
    bpy.ops.bentlight.exit_add()
    assert texts() == []


def test_lamps_inside_lenses_in_cycles_alone(hole):
    stage.add_camera(location=(0, -30, 0))
    lamp = stage.add_light("POINT", location=(0, 0, 5))
    stage.add_light("SUN", location=(0, 0, 2))
    hole.bentlight.lens_radius = 8.0
    bpy.context.scene.render.engine = "CYCLES"
    assert texts() == []
    bpy.ops.bentlight.cycles_setup()
    assert len(texts()) == 1 and "light does not get out" in texts()[0]
    lamp.location.z = 8.01
    assert texts() == []
    lamp.location.z = 5
    bpy.context.scene.render.engine = "BENTLIGHT"
    assert texts() == []


def unsupported_material() -> tuple[bpy.types.Material, bpy.types.Node]:
    material = bpy.data.materials.new("Worn")
    stage._use_nodes(material)
    nodes = material.node_tree.nodes
    bevel = nodes.new("ShaderNodeBevel")
    surface = next(node for node in nodes if node.type == "BSDF_PRINCIPLED")
    material.node_tree.links.new(bevel.outputs[0], surface.inputs["Normal"])
    return material, bevel


def test_unsupported_nodes_come_and_go_and_are_found():
    material, bevel = unsupported_material()
    assert texts() == []  # nothing has it
    square = stage.add_square(1.0, material=material)
    other = stage.add_square(1.0, name="Other")
    (found,) = (texts(), checks.of_scene(bpy.context))[1]
    assert (found.kind, found.owner, found.node) == ("MATERIAL", "Worn", bevel.name)
    bpy.context.view_layer.objects.active = other
    for node in material.node_tree.nodes:
        node.select = True
    assert bpy.ops.bentlight.material_select(name=found.owner, node=found.node) == {"FINISHED"}
    assert bpy.context.view_layer.objects.active == square and square.active_material == material
    assert material.node_tree.nodes.active == bevel and [n.name for n in material.node_tree.nodes if n.select] == [
        "Bevel"
    ]
    material.node_tree.nodes.remove(bevel)
    assert texts() == []


def test_objects_are_selected_by_their_warning(hole):
    wall = stage.add_square(1.0, name="Wall")
    assert bpy.ops.bentlight.object_select(name="Wall") == {"FINISHED"}
    assert bpy.context.view_layer.objects.active == wall and bpy.context.selected_objects == [wall]
    assert bpy.ops.bentlight.object_select(name="gone") == {"CANCELLED"}
    assert bpy.ops.bentlight.material_select(name="gone") == {"CANCELLED"}


def test_nothing_is_found_anew_without_a_change(hole, monkeypatch):
    stage.add_square(50.0)
    assert len(texts()) == 1
    monkeypatch.setattr(checks.findings, "_find", lambda context: pytest.fail("looked again"))
    assert len(checks.of_scene(bpy.context)) == 1


def test_what_cannot_be_rendered_at_all():
    smoke = bpy.data.objects.new("Smoke", bpy.data.volumes.new("Smoke"))
    bpy.context.scene.collection.objects.link(smoke)
    assert texts() == ["'Smoke': volumes cannot be rendered yet"]
    smoke.hide_render = True
    assert texts() == []


def test_moving_objects_compiles_no_material_again(monkeypatch):
    material, bevel = unsupported_material()
    square = stage.add_square(1.0, material=material)
    assert len(texts()) == 1
    monkeypatch.setattr(checks.materials, "compile_material", lambda *_: pytest.fail("compiled again"))
    for i in range(3):
        square.location.x = i
        assert len(texts()) == 1
    monkeypatch.undo()
    material.node_tree.nodes.remove(bevel)
    assert texts() == []


def test_what_keeps_light_from_being_followed_from_lamps(hole):
    """Passes and spin, told before a render as by one; each as long as it is so, and for Bidirectional alone."""
    scene, layer = bpy.context.scene, bpy.context.view_layer
    layer.use_pass_diffuse_direct = True
    assert texts() == []
    scene.bentlight.integrator = "BIDIRECTIONAL"
    said = "Bidirectional is not possible, light is followed from the camera alone: "
    name = "Diffuse Direct" if bpy.app.version >= (5, 0, 0) else "DiffDir"
    assert texts() == [f"{said}the pass '{name}' tells light apart"]
    layer.use_pass_diffuse_direct = False
    assert texts() == []
    layer.lightgroups.add(name="key")
    assert texts() == [f"{said}the pass 'Combined_key' tells light apart"]
    bpy.ops.scene.view_layer_remove_lightgroup()
    hole.bentlight.spin = 0.5
    (found,) = (texts(), checks.of_scene(bpy.context))[1]
    assert found.text == f"{said}'Hole' spins" and (found.kind, found.owner) == ("OBJECT", "Hole")
    scene.render.engine = "CYCLES"
    assert texts() == []


@pytest.fixture
def cube(hole):
    """Around the hole, before a camera, as in Blender's startup file after Add > Black Hole."""
    stage.add_camera(location=(0, -30, 0), rotation=(math.pi / 2, 0, 0))
    bpy.ops.mesh.primitive_cube_add(size=6, location=(0, 0, 0))
    bpy.context.object.name = "Cube"
    return bpy.context.object


def test_a_mesh_all_around_the_hole_hides_it(cube):
    assert texts() == ["'Cube' is all around 'Hole' and hides it from the camera"]
    (found,) = checks.of_scene(bpy.context)
    assert (found.kind, found.owner, found.about) == ("OBJECT", "Cube", ("Hole",))
    cube.location.x = 5
    assert texts() == []


def test_a_room_around_camera_and_hole_hides_nothing(cube):
    cube.scale = (11, 11, 11)
    assert texts() == []


def test_a_mesh_with_a_window_hides_nothing(cube):
    cube.data.clear_geometry()
    corners = [(x, y, z) for x in (-3, 3) for y in (-3, 3) for z in (-3, 3)]
    walls = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4)]
    cube.data.from_pydata(corners, [], walls)
    assert texts() == []
    cube.data.clear_geometry()
    cube.data.from_pydata(corners, [], [*walls, (1, 5, 7, 3)])
    assert len(texts()) == 1


@pytest.mark.parametrize("change", ["Transmission Weight", "Alpha", "ShaderNodeBsdfGlass", "visible_camera"])
def test_what_is_seen_through_hides_nothing(cube, change):
    material = bpy.data.materials.new("Wall")
    material.use_nodes = True
    cube.data.materials.append(material)
    assert len(texts()) == 1
    if change == "visible_camera":
        cube.visible_camera = False
    elif change.startswith("Shader"):
        material.node_tree.nodes.new(change)
    else:
        material.node_tree.nodes["Principled BSDF"].inputs[change].default_value = 0.5
    assert texts() == []


@pytest.mark.parametrize("kind", ["black_hole", "wormhole"])
def test_what_hides_a_new_hole_is_told_as_it_is_added(kind, capfd):
    """As in Blender's startup file, where a cube is at the 3D cursor."""
    bpy.ops.wm.read_homefile(use_factory_startup=True)
    bpy.context.scene.render.engine = "BENTLIGHT"
    getattr(bpy.ops.bentlight, f"{kind}_add")()
    name = bpy.context.object.name
    assert capfd.readouterr().out.count(f"'Cube' is all around '{name}' and hides it from the camera") == 1
