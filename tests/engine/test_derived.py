"""What is made of a mesh for materials: tangents, pointiness, numbers of islands; through the whole engine, against
Cycles."""

import bmesh
import bpy
import numpy as np
import pytest

from tests.engine import stage
from tests.engine.cycles_pictures import NARROW, point_pictures
from tests.engine.test_attributes import asking

SIZE = 24  # pixels


def add_islands(material: bpy.types.Material, is_smooth: bool) -> bpy.types.Object:
    """Three bumpy spheres in one mesh, with an uneven UV map that is mirrored on one of them."""
    mesh = bpy.data.meshes.new("islands")
    made = bmesh.new()
    for x in (-1.1, 0.1, 1.2):
        bmesh.ops.create_icosphere(made, subdivisions=2, radius=0.7)
        bmesh.ops.translate(made, verts=made.verts[-162:], vec=(x, 0.3 * x, 0))
    rng = np.random.default_rng(2)
    layer = made.loops.layers.uv.new("UV")
    for vertex in made.verts:
        vertex.co += vertex.co.__class__(rng.uniform(-0.06, 0.06, 3))
    for face in made.faces:
        face.smooth = is_smooth
        for loop in face.loops:
            x, y, z = loop.vert.co
            side = -1 if x > 0.7 else 1
            loop[layer].uv = (side * x + 0.2 * np.sin(3 * y), y + 0.4 * z)
    made.to_mesh(mesh)
    made.free()
    mesh.materials.append(material)
    obj = bpy.data.objects.new("islands", mesh)
    obj.scale, obj.rotation_euler = (1.0, 0.8, 1.3), (0.3, 0.2, 0.4)
    bpy.context.scene.collection.objects.link(obj)
    return obj


def pictures(tmp_path, material, is_smooth=True) -> tuple[np.ndarray, np.ndarray]:
    add_islands(material, is_smooth)
    stage.set_world((0, 0, 0))
    stage.add_camera((0, 0, 5), type="ORTHO", ortho_scale=4.2)
    scene = bpy.context.scene
    scene.render.resolution_x = scene.render.resolution_y = SIZE
    return point_pictures(tmp_path)


def test_random_per_island(tmp_path):
    cycles, ours = pictures(tmp_path, asking("NewGeometry", "Random Per Island"))
    np.testing.assert_allclose(ours, cycles, rtol=1e-6)
    assert len(np.unique(ours)) == 4  # and the sky


def test_pointiness(tmp_path):
    cycles, ours = pictures(tmp_path, asking("NewGeometry", "Pointiness"))
    np.testing.assert_allclose(ours, cycles, atol=1e-5 + 0.03 * NARROW)  # it changes by less than 0.03 over a pixel
    assert np.ptp(ours[ours > 0]) > 0.015


def shifted(material: bpy.types.Material) -> bpy.types.Material:
    """The same, 1.5 brighter, so that no component of a unit vector is lost."""
    tree = material.node_tree
    emission = next(n for n in tree.nodes if n.bl_idname == "ShaderNodeEmission")
    add = tree.nodes.new("ShaderNodeVectorMath")
    add.inputs[1].default_value = (1.5, 1.5, 1.5)
    tree.links.new(emission.inputs[0].links[0].from_socket, add.inputs[0])
    tree.links.new(add.outputs[0], emission.inputs[0])
    return material


def assert_same(difference: np.ndarray, is_smooth: bool) -> None:
    """But for pixels at edges: where shading is smooth vectors turn by up to 2 over a pixel, on flat triangles by up to
    0.1, around an axis."""
    place = (2 if is_smooth else 0.1) * NARROW
    assert np.quantile(difference, 0.97) < 1e-6 + place, np.sort(difference.ravel())[-30:]


TANGENTS = {"UV": {"direction_type": "UV_MAP"}, "by name": {"direction_type": "UV_MAP", "uv_map": "UV"}}
TANGENTS |= {axis: {"direction_type": "RADIAL", "axis": axis} for axis in "XYZ"}
TANGENTS["missing"] = {"direction_type": "UV_MAP", "uv_map": "none"}


@pytest.mark.parametrize("is_smooth", [True, False])
@pytest.mark.parametrize("name", TANGENTS)
def test_tangents(tmp_path, name, is_smooth):
    material = shifted(asking("Tangent", "Tangent", **TANGENTS[name]))
    cycles, ours = pictures(tmp_path, material, is_smooth)
    difference = np.abs(ours - cycles).max(axis=2)
    assert_same(difference, is_smooth)


@pytest.mark.parametrize("is_smooth", [True, False])
def test_normal_maps_along_smooth_tangents(tmp_path, is_smooth):
    material = shifted(asking("NormalMap", "Normal"))
    node = next(n for n in material.node_tree.nodes if n.bl_idname == "ShaderNodeNormalMap")
    node.inputs["Color"].default_value = (0.7, 0.35, 0.8, 1)
    cycles, ours = pictures(tmp_path, material, is_smooth)
    difference = np.abs(ours - cycles).max(axis=2)
    assert_same(difference, is_smooth)
