"""Bump against Cycles through the whole engine: quads tilted at random, half of them seen from behind, that shine with
their normal.

One sample in the middle of each pixel; Cycles reckons heights, whose differences are a hundredth of them, in float32.
"""

import bpy
import mathutils
import numpy as np
import pytest

from tests.engine import stage
from tests.engine.cycles_pictures import point_pictures

COLUMNS = 6


def new(tree, kind: str, inputs=(), **settings):
    """A node with settings; `inputs`: socket -> value or output socket."""
    node = tree.nodes.new(f"ShaderNode{kind}")
    for name, value in settings.items():
        setattr(node, name, value)
    for key, value in dict(inputs).items():
        if isinstance(value, bpy.types.NodeSocket):
            tree.links.new(value, node.inputs[key])
        else:
            node.inputs[key].default_value = value
    return node


def plane(tree, vector):
    """A height that rises evenly."""
    return new(tree, "VectorMath", {0: vector, 1: (0.31, -0.17, 0.23)}, operation="DOT_PRODUCT").outputs["Value"]


def wave(tree, vector):
    """A height that curves."""
    return new(tree, "Math", {0: plane(tree, vector)}, operation="SINE").outputs[0]


def coordinate(name: str):
    return lambda tree: new(tree, "TexCoord").outputs[name]


def uv_map(tree):
    return new(tree, "UVMap", uv_map="Second").outputs[0]


def position(tree):
    return new(tree, "NewGeometry").outputs["Position"]


def attribute(tree):
    return new(tree, "Attribute", attribute_name="height").outputs["Vector"]


def bump(vector, height=plane, strength=1.0, distance=1.0, **settings):
    def build(tree):
        inputs = {"Height": height(tree, vector(tree)), "Strength": strength, "Distance": distance}
        return new(tree, "Bump", inputs, **settings)

    return build


def bump_of_bump(tree):
    outer = bump(coordinate("Object"), strength=0.6)(tree)
    tree.links.new(bump(coordinate("UV"))(tree).outputs[0], outer.inputs["Normal"])
    return outer


def flat_height(tree):
    return new(tree, "Bump", {"Height": 0.7})


CASES = {
    **{name: bump(coordinate(name)) for name in ("UV", "Generated", "Object", "Normal")},
    **{place.__name__: bump(place) for place in (uv_map, position, attribute)},
    **{f"strength {value}": bump(position, strength=value) for value in (0.0, 0.3, 2.0)},
    **{f"distance {value}": bump(position, distance=value) for value in (0.0, 0.1, 4.0, -1.0)},
    "inverted": bump(position, invert=True),
    "wave": bump(position, height=wave),
    "bump of bump": bump_of_bump,
    "nothing linked": flat_height,
}


def normal_material(name: str) -> bpy.types.Material:
    """Shines with the normal, moved to where no component is negative."""
    material = stage.emission((0, 0, 0), name=name)
    tree = material.node_tree
    shifted = new(tree, "VectorMath", {0: CASES[name](tree).outputs[0], 1: (1.5, 1.5, 1.5)}, operation="ADD")
    emission = next(n for n in tree.nodes if n.bl_idname == "ShaderNodeEmission")
    tree.links.new(shifted.outputs[0], emission.inputs["Color"])
    return material


def build_quads() -> None:
    """A quad a pixel, each row with the material of a case, in an object that is turned and stretched."""
    rng = np.random.default_rng(5)
    count = len(CASES) * COLUMNS
    row, column = np.divmod(np.arange(count), COLUMNS)
    square = np.array([[-0.55, -0.5], [0.6, -0.5], [0.5, 0.5], [-0.5, 0.5]])
    height = square @ rng.uniform(-1.2, 1.2, (count, 2, 1))
    corners = np.stack([column + 0.5, row + 0.5, 0 * row], axis=1)[:, None] + np.concatenate(
        [np.broadcast_to(square, (count, 4, 2)), height], axis=2
    )
    matrix = mathutils.Matrix.LocRotScale((0.1, -0.2, 0.3), mathutils.Euler((0.4, -0.7, 1.9)), (0.5, 1.5, 0.8))
    inverse = np.array(matrix.inverted())
    vertices = corners.reshape(-1, 3) @ inverse[:3, :3].T + inverse[:3, 3]
    faces = np.arange(4 * count).reshape(-1, 4)
    faces[1::2] = faces[1::2, ::-1]
    quads = stage.add_mesh("quads", vertices, faces)
    quads.matrix_world = matrix
    for name in CASES:
        quads.data.materials.append(normal_material(name))
    quads.data.polygons.foreach_set("material_index", row.astype(np.int32))
    for name in ("First", "Second"):
        layer = quads.data.uv_layers.new(name=name)
        layer.uv.foreach_set("vector", rng.uniform(0, 2, 8 * count).astype(np.float32))
    values = quads.data.attributes.new("height", "FLOAT_VECTOR", "CORNER")
    values.data.foreach_set("vector", rng.uniform(0, 1, 12 * count).astype(np.float32))


@pytest.fixture(scope="module")
def pictures(tmp_path_factory):
    """Filled by the first test: the stage is set anew for each."""
    return {}


@pytest.mark.parametrize("name", CASES)
def test_normals_are_those_of_cycles(pictures, tmp_path, name):
    if not pictures:
        build_quads()
        stage.set_world((0, 0, 0))
        height = len(CASES)
        stage.add_camera((COLUMNS / 2, height / 2, 5), type="ORTHO", ortho_scale=max(height, COLUMNS))
        scene = bpy.context.scene
        scene.render.resolution_x, scene.render.resolution_y = COLUMNS, height
        cycles, ours = point_pictures(tmp_path)
        pictures.update({case: (cycles[y], ours[y]) for y, case in enumerate(CASES)})
    cycles, ours = pictures[name]
    np.testing.assert_allclose(np.linalg.norm(ours - 1.5, axis=1), 1, atol=1e-5)
    place = (
        1e-3 if name == "wave" else 0
    )  # its slope changes by about 0.1 over a pixel, in whose middle samples are to 0.01
    np.testing.assert_allclose(ours, cycles, atol=1e-5 + place)
