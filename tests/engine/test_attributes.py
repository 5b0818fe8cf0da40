"""Attributes of meshes and objects by name, through the whole engine, against Cycles."""

import bpy
import numpy as np
import pytest

from tests.engine import stage
from tests.engine.cycles_pictures import NARROW, point_pictures

TYPES = {  # Blender's data types that Cycles knows -> (components, field)
    "FLOAT": (1, "value"),
    "INT": (1, "value"),
    "INT8": (1, "value"),
    "BOOLEAN": (1, "value"),
    "FLOAT2": (2, "vector"),
    "FLOAT_VECTOR": (3, "vector"),
    "FLOAT_COLOR": (4, "color"),
    "BYTE_COLOR": (4, "color"),
    "QUATERNION": (4, "value"),
}
DOMAINS = ("POINT", "CORNER", "FACE", "EDGE")
COLUMNS = 4


def asking(kind: str, output: str, **settings) -> bpy.types.Material:
    """A material that shines with an output of a node."""
    material = stage.emission((0, 0, 0), name=f"{kind} {output}")
    tree = material.node_tree
    node = tree.nodes.new(f"ShaderNode{kind}")
    for name, value in settings.items():
        setattr(node, name, value)
    emission = next(n for n in tree.nodes if n.bl_idname == "ShaderNodeEmission")
    tree.links.new(node.outputs[output], emission.inputs["Color"])
    return material


def fill(attribute, rng) -> None:
    """Random values, whole where they must be."""
    width, field = TYPES[attribute.data_type]
    values = rng.uniform(0.05, 0.95, len(attribute.data) * width)
    if attribute.data_type in ("INT", "INT8"):
        values = np.floor(values * 100)
    if attribute.data_type == "BOOLEAN":
        values = values > 0.5
    dtype = {"BOOLEAN": bool, "INT": np.int32, "INT8": np.int8}.get(attribute.data_type, np.float32)
    attribute.data.foreach_set(field, values.astype(dtype))


def grid(rows: list[bpy.types.Material]) -> bpy.types.Object:
    """One mesh of a quad a pixel, each row with its own material."""
    height = len(rows)
    row, column = np.divmod(np.arange(height * COLUMNS), COLUMNS)
    corner = np.array([[-0.1, -0.1, 0], [1, 0, 0], [1, 1, 0.3], [0, 1, 0]])
    vertices = (np.stack([column, row, 0 * row], 1)[:, None] + corner).reshape(-1, 3)
    quads = stage.add_mesh("quads", vertices, np.arange(len(vertices)).reshape(-1, 4))
    for material in rows:
        quads.data.materials.append(material)
    quads.data.polygons.foreach_set("material_index", row.astype(np.int32))
    stage.add_camera((COLUMNS / 2, height / 2, 3), type="ORTHO", ortho_scale=max(height, COLUMNS))
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = COLUMNS, height
    stage.set_world((0, 0, 0))
    return quads


def compare(rows, tmp_path, slope: float = 1.0) -> np.ndarray:
    """Asserts that the rows are as in Cycles, but for `slope`, the most that values change over a pixel, times how far
    samples lie apart. Returns ours."""
    cycles, ours = point_pictures(tmp_path)
    for y, material in enumerate(rows):
        tolerance = 1e-6 + 1e-6 * np.abs(cycles[y]) + slope * NARROW
        assert (np.abs(ours[y] - cycles[y]) <= tolerance).all(), (material.name, ours[y], cycles[y])
    return ours


@pytest.mark.parametrize("data_type", TYPES)
def test_attributes_of_meshes(tmp_path, data_type):
    names = [*DOMAINS, "missing"]
    outputs = ("Color", "Vector", "Fac", "Alpha")
    rows = [asking("Attribute", output, attribute_name=name) for name in names for output in outputs]
    rng = np.random.default_rng(1)
    quads = grid(rows)
    for domain in DOMAINS:
        if domain == "EDGE" and data_type in ("BYTE_COLOR", "QUATERNION"):
            continue  # Blender has a mean of its own for these; who puts them on edges is not known
        fill(quads.data.attributes.new(domain, data_type, domain), rng)
    ours = compare(rows, tmp_path, 50 if data_type.startswith("INT") else 1)
    for i in range(3):
        assert np.ptp(ours[4 * i]) > 0.1


@pytest.mark.parametrize("data_type", ["BYTE_COLOR", "FLOAT_COLOR"])
def test_color_attributes(tmp_path, data_type):
    names = ("", "POINT", "CORNER", "missing")
    rows = [asking("VertexColor", output, layer_name=name) for name in names for output in ("Color", "Alpha")]
    quads = grid(rows)
    for domain in ("POINT", "CORNER"):
        fill(quads.data.attributes.new(domain, data_type, domain), np.random.default_rng(2))
    quads.data.color_attributes.render_color_index = 1
    compare(rows, tmp_path)


def test_uv_maps_by_name(tmp_path):
    names = ("", "First", "Second", "missing")
    rows = [asking("UVMap", "UV", uv_map=name) for name in names]
    rows += [asking("Attribute", output, attribute_name="Second") for output in ("Color", "Fac")]
    quads = grid(rows)
    rng = np.random.default_rng(3)
    for name in ("First", "Second"):
        layer = quads.data.uv_layers.new(name=name)
        layer.uv.foreach_set("vector", rng.uniform(0, 1, 2 * len(quads.data.loops)).astype(np.float32))
    quads.data.uv_layers["First"].active_render = True
    compare(rows, tmp_path)


def test_vertex_groups_and_positions(tmp_path):
    rows = [asking("Attribute", "Fac", attribute_name=name) for name in ("group", "position")]
    rows += [asking("Attribute", "Color", attribute_name="position")] * 2
    quads = grid(rows)
    group = quads.vertex_groups.new(name="group")
    for i, weight in enumerate(np.random.default_rng(4).random(len(quads.data.vertices))):
        if i % 3:
            group.add([i], weight, "REPLACE")
    compare(rows, tmp_path, slope=2)


def test_properties_of_objects_instancers_and_the_view_layer(tmp_path):
    wanted = [
        ("OBJECT", name) for name in ("number", "whole", "pair", "color4", "scale", "pass_index", "of data", "missing")
    ]
    wanted += [("INSTANCER", name) for name in ("number", "of parent")]
    wanted += [("VIEW_LAYER", name) for name in ("of layer", "frame_current", "missing")]
    rows = [
        asking("Attribute", output, attribute_type=kind, attribute_name=name)
        for kind, name in wanted
        for output in ("Color", "Fac", "Alpha")
    ]
    quads = grid(rows)
    quads["number"], quads["whole"], quads["pair"], quads["color4"] = 0.7, 3, [0.2, 0.9], [0.1, 0.2, 0.6, 0.5]
    quads.pass_index, quads.data["of data"] = 4, 0.3
    bpy.context.view_layer["of layer"] = [0.3, 0.6, 0.1]
    scene = bpy.context.scene
    scene.frame_set(7)
    group = bpy.data.collections.new("group")
    scene.collection.objects.unlink(quads)
    group.objects.link(quads)
    empty = bpy.data.objects.new("instancer", None)
    empty.instance_type, empty.instance_collection = "COLLECTION", group
    empty["number"], empty["of parent"] = 0.25, 0.45
    scene.collection.objects.link(empty)
    compare(rows, tmp_path, slope=0)
