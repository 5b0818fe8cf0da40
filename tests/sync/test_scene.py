"""What the sync makes of Blender's geometry: instances, modifiers, curves, normals, UVs, slots, coordinates."""

import math

import bpy
import numpy as np
import pytest

from blender_addon.report import Reporter
from blender_addon.sync.camera import read_camera
from blender_addon.sync.objects import read_scene
from blender_addon.sync.scene_data import SceneData, Visibility
from tests.engine import cycles_pictures, stage
from tests.engine.stage import blender  # noqa: F401 (a fixture)


def read() -> tuple[SceneData, list[str]]:
    """The scene as plain data, and the warnings."""
    scene = bpy.context.scene
    camera = scene.camera or stage.add_camera()
    depsgraph = bpy.context.evaluated_depsgraph_get()
    said = []
    data = read_camera(camera, scene.render, np.array(camera.matrix_world), 0.0)
    return read_scene(depsgraph, data, Reporter(lambda _level, text: said.append(text))), said


def test_instances_share_a_mesh():
    square = stage.add_square(1.0)
    collection = bpy.data.collections.new("group")
    collection.objects.link(square)
    bpy.context.scene.collection.objects.unlink(square)
    places = [(0, 0, 0), (3, 0, 0), (0, -2, 1)]
    for place in places:
        empty = bpy.data.objects.new("instance", None)
        empty.instance_type, empty.instance_collection = "COLLECTION", collection
        empty.location = place
        bpy.context.scene.collection.objects.link(empty)
    copy = bpy.data.objects.new("linked copy", square.data)
    copy.location = (9, 9, 9)
    bpy.context.scene.collection.objects.link(copy)
    data, _ = read()
    assert len(data.meshes) == 1
    found = sorted(tuple(item.world_from_mesh[:3, 3]) for item in data.instances)
    assert found == sorted([*places, (9, 9, 9)])
    assert all(item.world_from_mesh.flags.c_contiguous for item in data.instances)


def test_scene_units_change_nothing():
    """A length is a number of Blender's units, whatever they are called."""
    stage.add_square(2.0, (1, 2, 3))
    stage.add_light("AREA", (0, 0, 5), size=1.0)
    bpy.ops.bentlight.black_hole_add(mass=0.5, location=(4, 5, 6))

    def numbers() -> list:
        data, _ = read()
        return [
            *(item.world_from_mesh.tolist() for item in data.instances),
            *(item.vertices.tolist() for item in data.meshes),
            *((item.mass, item.world_from_spacetime.tolist()) for item in data.spacetimes),
            data.camera.world_from_camera.tolist(),
            (data.camera.window, data.camera.clip_start, data.camera.clip_end),
        ]

    plain = numbers()
    units = bpy.context.scene.unit_settings
    units.system, units.scale_length, units.length_unit = "IMPERIAL", 0.001, "INCHES"
    assert numbers() == plain


def test_geometry_nodes_instances():
    square = stage.add_square(1.0)
    tree = bpy.data.node_groups.new("scatter", "GeometryNodeTree")
    tree.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    nodes, links = tree.nodes, tree.links
    start, end = nodes.new("NodeGroupInput"), nodes.new("NodeGroupOutput")
    scatter, cube = nodes.new("GeometryNodeInstanceOnPoints"), nodes.new("GeometryNodeMeshCube")
    links.new(start.outputs[0], scatter.inputs["Points"])
    links.new(cube.outputs["Mesh"], scatter.inputs["Instance"])
    links.new(scatter.outputs["Instances"], end.inputs[0])
    square.modifiers.new("scatter", "NODES").node_group = tree
    data, said = read()
    assert len(data.instances) == 4
    assert said == []
    assert {len(data.meshes[item.mesh].triangles) for item in data.instances} == {12}
    corners = sorted(tuple(np.round(item.world_from_mesh[:2, 3], 5)) for item in data.instances)
    assert corners == [(-0.5, -0.5), (-0.5, 0.5), (0.5, -0.5), (0.5, 0.5)]


def test_modifiers_at_their_render_level():
    square = stage.add_square(1.0)
    modifier = square.modifiers.new("subdivision", "SUBSURF")
    modifier.subdivision_type = "SIMPLE"
    modifier.levels = modifier.render_levels = 2
    array = square.modifiers.new("array", "ARRAY")
    array.count = 3
    data, _ = read()
    (mesh,) = data.meshes
    assert len(mesh.triangles) == 3 * 16 * 2


def test_objects_with_a_mesh_in_common_but_other_modifiers():
    plain = stage.add_square(1.0)
    other = bpy.data.objects.new("other", plain.data)
    bpy.context.scene.collection.objects.link(other)
    other.modifiers.new("array", "ARRAY").count = 2
    data, _ = read()
    assert sorted(len(mesh.triangles) for mesh in data.meshes) == [2, 4]


def test_curves_text_surfaces_and_metaballs():
    bpy.ops.curve.primitive_bezier_circle_add()
    bpy.context.object.data.bevel_depth = 0.1
    bpy.ops.object.text_add()
    bpy.ops.surface.primitive_nurbs_surface_sphere_add()
    bpy.ops.object.metaball_add(type="BALL")
    bpy.ops.object.metaball_add(type="BALL", location=(0.5, 0, 0))  # of the same family: one mesh for both
    bpy.ops.curve.primitive_bezier_circle_add()  # without thickness or filling: nothing to see
    bpy.context.object.data.fill_mode = "FULL"
    bpy.context.object.data.dimensions = "3D"
    data, said = read()
    assert len(data.instances) == 4
    assert all(len(data.meshes[item.mesh].triangles) > 10 for item in data.instances)
    assert said == []


def test_curves_in_collection_instances():
    bpy.ops.object.text_add()
    text = bpy.context.object
    collection = bpy.data.collections.new("group")
    collection.objects.link(text)
    bpy.context.scene.collection.objects.unlink(text)
    for _ in range(2):
        bpy.ops.object.collection_instance_add(collection="group")
    data, _ = read()
    assert len(data.instances) == 2 and len(data.meshes) == 1


def test_normals_flat_smooth_and_custom():
    bpy.ops.mesh.primitive_uv_sphere_add(segments=8, ring_count=4)
    sphere = bpy.context.object.data
    (mesh,) = read()[0].meshes
    assert mesh.corner_normals is None
    sphere.shade_smooth()
    (mesh,) = read()[0].meshes
    directions = mesh.vertices / np.linalg.norm(mesh.vertices, axis=1, keepdims=True)
    assert (np.einsum("tci,tci->tc", mesh.corner_normals, directions[mesh.triangles]) > 0.97).all()
    sphere.normals_split_custom_set([(0, 0, 1)] * len(sphere.loops))
    (mesh,) = read()[0].meshes
    np.testing.assert_allclose(mesh.corner_normals, np.broadcast_to((0, 0, 1), mesh.corner_normals.shape), atol=1e-3)


def test_the_uv_map_that_renders():
    square = stage.add_square(1.0)
    for name, value in (("shown", 0.25), ("rendered", 0.75)):
        layer = square.data.uv_layers.new(name=name)
        layer.uv.foreach_set("vector", np.full(8, value, np.float32))
    square.data.uv_layers["rendered"].active_render = True
    square.data.uv_layers["shown"].active = True
    (mesh,) = read()[0].meshes
    assert mesh.corner_uvs.shape == (2, 3, 2)
    assert (mesh.corner_uvs == 0.75).all()


def test_material_slots_of_the_data_and_of_the_object():
    red, blue = stage.emission((1, 0, 0), name="red"), stage.emission((0, 0, 1), name="blue")
    vertices = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (2, 0, 0), (2, 1, 0)]
    first = stage.add_mesh("first", vertices, [(0, 1, 2, 3), (1, 4, 5, 2)])
    mesh = first.data
    mesh.materials.append(red)
    mesh.materials.append(red)
    mesh.polygons[1].material_index = 1
    second = bpy.data.objects.new("second", mesh)
    bpy.context.scene.collection.objects.link(second)
    second.material_slots[1].link = "OBJECT"
    second.material_slots[1].material = blue
    data, _ = read()
    assert len(data.meshes) == 1 and len(data.materials) == 2
    assert sorted(data.meshes[0].material_slots) == [0, 0, 1, 1]
    by_name = {item.name: item.materials for item in data.instances}
    assert by_name["first"][0] == by_name["first"][1] == by_name["second"][0] != by_name["second"][1]


def test_black_holes_in_collection_instances():
    hole = bpy.data.objects.new("hole", None)
    hole.bentlight.kind, hole.bentlight.mass = "BLACK_HOLE", 0.1
    collection = bpy.data.collections.new("group")
    collection.objects.link(hole)
    for x in (0, 5):
        bpy.ops.object.collection_instance_add(collection="group", location=(x, 0, 0))
    bpy.ops.object.text_add()
    bpy.context.object.bentlight.kind = "BLACK_HOLE"
    bpy.context.object.location = (0, 0, 3)
    data, _ = read()
    assert sorted(tuple(item.origin) for item in data.spacetimes) == [(0, 0, 0), (0, 0, 3), (5, 0, 0)]


def test_visibility_bits():
    square = stage.add_square(1.0)
    square.visible_diffuse = square.visible_transmission = False
    data, _ = read()
    assert data.instances[0].visibility == Visibility.CAMERA | Visibility.GLOSSY
    collection = bpy.data.collections.new("indirect")
    bpy.context.scene.collection.children.link(collection)
    collection.objects.link(square)
    bpy.context.scene.collection.objects.unlink(square)
    child = bpy.context.view_layer.layer_collection.children["indirect"]
    child.indirect_only = True
    assert read()[0].instances[0].visibility == Visibility.GLOSSY
    child.indirect_only, child.holdout = False, True
    assert read()[0].instances[0].visibility == Visibility.CAMERA | Visibility.GLOSSY | Visibility.HOLDOUT


def test_hair_is_said_not_to_be_rendered():
    curves = bpy.data.hair_curves.new("hair")
    bpy.context.scene.collection.objects.link(bpy.data.objects.new("hair", curves))
    data, said = read()
    assert not data.instances
    assert said == ["Object 'hair': hair cannot be rendered yet"]


def test_a_matrix_without_inverse_is_applied_to_the_vertices():
    """Rotated, flattened to a plane, moved: the mesh in the plane, and its place."""
    bpy.ops.mesh.primitive_uv_sphere_add(segments=8, ring_count=4, location=(10, 20, 30))
    sphere = bpy.context.object
    sphere.data.shade_smooth()
    whole = read()[0].meshes[0]
    sphere.rotation_euler, sphere.scale = (1, 2, 3), (1, 0, 2)
    data, said = read()
    (instance,) = data.instances
    np.testing.assert_array_equal(instance.world_from_mesh, [[1, 0, 0, 10], [0, 1, 0, 20], [0, 0, 1, 30], [0, 0, 0, 1]])
    flat = data.meshes[instance.mesh]
    axes = np.array(sphere.matrix_world)[:3, :3]
    np.testing.assert_allclose(flat.vertices, whole.vertices @ axes.T, atol=1e-6)
    assert flat.corner_normals is None
    np.testing.assert_array_equal(flat.triangles, whole.triangles)
    assert said == []


def show(output: str, node_type: str) -> bpy.types.Material:
    """A material that shines in the color of a coordinate, mapped from [-1, 1] to [0, 1]."""
    material = stage.emission((1, 1, 1))
    tree = material.node_tree
    source, scale = tree.nodes.new(node_type), tree.nodes.new("ShaderNodeMapping")
    scale.inputs["Scale"].default_value = (0.5, 0.5, 0.5)
    scale.inputs["Location"].default_value = (0.5, 0.5, 0.5)
    shader = next(node for node in tree.nodes if node.type == "EMISSION")
    tree.links.new(source.outputs[output], scale.inputs["Vector"])
    tree.links.new(scale.outputs["Vector"], shader.inputs["Color"])
    return material


@pytest.mark.parametrize("output", ["Generated", "Normal", "UV", "Object"])
@pytest.mark.parametrize("instanced", [False, True])
def test_coordinates_are_those_of_cycles(output, instanced, tmp_path):
    """On a deformed, subdivided, smooth shape, turned, squeezed and mirrored: every point is as in Cycles."""
    bpy.ops.mesh.primitive_uv_sphere_add(segments=16, ring_count=8, radius=1.0)
    obj = bpy.context.object
    obj.data.shade_smooth()
    obj.data.materials.append(show(output, "ShaderNodeTexCoord"))
    obj.modifiers.new("subdivision", "SUBSURF").levels = 1
    bend = obj.modifiers.new("bend", "SIMPLE_DEFORM")
    bend.deform_method, bend.angle = "TWIST", 1.0
    obj.rotation_euler = (0.4, 0.9, 0.2)
    # Cycles interpolates normals after squeezing them, unless a mesh has several users: so not squeezed for those.
    obj.scale = (0.9, -0.9, 0.9) if output == "Normal" else (1.0, -0.7, 1.2)
    if instanced:
        collection = bpy.data.collections.new("group")
        collection.objects.link(obj)
        bpy.context.scene.collection.objects.unlink(obj)
        bpy.ops.object.collection_instance_add(collection="group", location=(0.2, 0.1, 0))
        bpy.context.object.rotation_euler = (0, 0, math.pi / 3)
    stage.add_camera((0, 0, 4))
    stage.set_world((0, 0, 0))
    theirs, ours = cycles_pictures.point_pictures(tmp_path)
    seen = (theirs.max(axis=2) > 0) & (ours.max(axis=2) > 0)
    assert seen.sum() > 500
    assert ((theirs.max(axis=2) > 0) != (ours.max(axis=2) > 0)).sum() <= 2
    # A color changes by its slope over half of the pixel filter; across the seam of the UV map it jumps.
    across = np.abs(np.diff(theirs, axis=1, prepend=theirs[:, :1])) + np.abs(
        np.diff(theirs, axis=0, prepend=theirs[:1])
    )
    reach = np.maximum.reduce([np.roll(across, shift, (0, 1)) for shift in ((0, 0), (-1, 0), (0, -1), (-1, -1))])
    wrong = np.abs(ours - theirs) > cycles_pictures.NARROW * reach + 2e-4
    assert wrong[seen].any(axis=1).mean() < 0.005
