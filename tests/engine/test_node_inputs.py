"""What materials can ask about their object and their triangle, through the whole engine, against Cycles."""

import bpy
import numpy as np

from tests.engine import stage
from tests.engine.cycles_pictures import point_pictures

COLUMNS = 4


def asking_material(kind: str, output: str) -> bpy.types.Material:
    """A material that shines with an output of a node."""
    material = stage.emission((0, 0, 0), name=f"{kind} {output}")
    material.pass_index = 3
    tree = material.node_tree
    node = tree.nodes.new(f"ShaderNode{kind}")
    emission = next(n for n in tree.nodes if n.bl_idname == "ShaderNodeEmission")
    tree.links.new(node.outputs[output], emission.inputs["Color"])
    return material


def object_row(material: bpy.types.Material, y: int) -> None:
    """Objects of one pixel each, the last by an instance of a collection, all of them different."""
    triangle = [(-0.7, -0.6, 0), (0.8, -0.55, 0), (-0.1, 0.9, 0)]
    for x in range(COLUMNS):
        name = f"{'Ångström' if x == 1 else 'Object'} {x} {y}"
        obj = stage.add_mesh(name, triangle, [(0, 1, 2)], (x + 0.5, y + 0.5, -1), material)
        obj.scale = (0.7, 0.7, 2)
        obj.color = (0.2 + 0.1 * x, 0.9, -0.3 * x, 0.25 * x)
        obj.pass_index = 5 * x + y
        if x == COLUMNS - 1:
            group = bpy.data.collections.new(f"group {y}")
            bpy.context.scene.collection.objects.unlink(obj)
            group.objects.link(obj)
            obj.location = (0.1, 0, 0)
            empty = bpy.data.objects.new(f"instancer {y}", None)
            empty.instance_type, empty.instance_collection, empty.location = "COLLECTION", group, (x + 0.4, y + 0.5, -1)
            bpy.context.scene.collection.objects.link(empty)


def test_materials_know_their_object_and_triangle_as_in_cycles(tmp_path):
    outputs = ("Location", "Color", "Alpha", "Object Index", "Material Index", "Random")
    rows = [("ObjectInfo", output) for output in outputs] + [("NewGeometry", "Parametric")]
    for y, row in enumerate(rows):
        object_row(asking_material(*row), y)
    height = len(rows)
    stage.add_camera((COLUMNS / 2, height / 2, 3), type="ORTHO", ortho_scale=max(height, COLUMNS))
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = COLUMNS, height
    cycles, ours = point_pictures(tmp_path)
    place = 0.01  # of a pixel: a parametric coordinate depends on the place of the sample
    for y, (kind, output) in enumerate(rows):
        tolerance = place if kind == "NewGeometry" else 1e-6
        np.testing.assert_allclose(ours[y], cycles[y], rtol=1e-6, atol=tolerance, err_msg=output)
    random = ours[outputs.index("Random"), :, 0]
    assert len(set(random)) == COLUMNS and ((random > 0) & (random < 1)).all()
