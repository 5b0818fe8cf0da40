"""tint.osl value by value: a closure times a color, one square a pair."""

import bpy
import numpy as np
import objects
import rendering

from blender_addon.cycles import shaders

SIZE = 16


def squares(numbers: dict[str, np.ndarray]) -> bpy.types.Object:
    """SIZE x SIZE squares of side 1 from the origin on, across z; in each attribute (n, 3) each has a color."""
    x, y = (axis.ravel() for axis in np.meshgrid(np.arange(SIZE), np.arange(SIZE)))
    corners = [np.stack([x + i, y + j, 0 * x], axis=1) for i, j in ((0, 0), (1, 0), (1, 1), (0, 1))]
    mesh = bpy.data.meshes.new("Squares")
    faces = np.arange(4 * SIZE**2).reshape(-1, 4)
    mesh.from_pydata(np.stack(corners, axis=1).reshape(-1, 3).tolist(), [], faces.tolist())
    for name, colors in numbers.items():
        layer = mesh.attributes.new(name, "FLOAT_COLOR", "CORNER")
        rgba = np.concatenate([colors, np.ones((SIZE**2, 1))], axis=1)
        layer.data.foreach_set("color", np.repeat(rgba, 4, axis=0).astype(np.float32).ravel())
    return objects.place(bpy.data.objects.new("Squares", mesh))


def tinting() -> bpy.types.Material:
    """What shines in the color `behind`, seen through tint.osl in the color `tint` ("color" is the object's own)."""
    material = shaders.new_material("Tint", "tint")
    tree = material.node_tree
    node = next(node for node in tree.nodes if node.bl_idname == "ShaderNodeScript")
    shaders.fill_node(
        node, shaders.compiled("tint"), {"Behind": ("NodeSocketShader", None), "Color": ("NodeSocketColor", None)}
    )
    shine = tree.nodes.new("ShaderNodeEmission")
    for name, socket in (("behind", shine.inputs["Color"]), ("tint", node.inputs["Color"])):
        attribute = tree.nodes.new("ShaderNodeAttribute")
        attribute.attribute_name = name
        tree.links.new(attribute.outputs["Color"], socket)
    tree.links.new(shine.outputs[0], node.inputs["Behind"])
    return material


def test_a_closure_times_a_color(scene):
    random = np.random.default_rng(1)
    numbers = {"behind": random.uniform(0, 5, (SIZE**2, 3)), "tint": random.uniform(0, 2, (SIZE**2, 3))}
    numbers["tint"][:3] = np.eye(3)
    squares(numbers).data.materials.append(tinting())
    scene.cycles.shading_system = True
    camera = objects.camera((SIZE / 2, SIZE / 2, 9), (SIZE / 2, SIZE / 2, 0))
    camera.data.type, camera.data.ortho_scale = "ORTHO", SIZE
    camera.rotation_euler = (0, 0, 0)
    rendering.set_size(scene, SIZE, SIZE)
    seen = rendering.render(scene, "CYCLES", 0, 1)[::-1].reshape(-1, 3)
    np.testing.assert_allclose(seen, numbers["behind"] * numbers["tint"], rtol=4e-7)
