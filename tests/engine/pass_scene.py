"""A flat scene with something for every pass: surfaces of each kind, lamps, a lit world, groups, AOVs, motion."""

import bpy

from tests.engine import stage


def build() -> None:
    """Camera above a floor with a mesh and a half see-through pane; two lamps and the sky, in light groups."""
    scene = bpy.context.scene
    stage.add_camera((0, -6, 2.5), (1.2, 0, 0))
    stage.set_world((0.3, 0.5, 0.8), 0.5)
    stage.add_square(12, (0, 0, 0), _material("Floor", Roughness=0.4, Metallic=0.3), "Floor").pass_index = 3
    _add_ball("Ball", (-1.2, 0, 0.8), _material("Glass", {"Transmission Weight": 1.0}, Roughness=0.2)).pass_index = 7
    _add_ball("Knob", (1.2, 0.5, 0.7), _material("Paint", {"Base Color": (0.8, 0.2, 0.1, 1)}, Roughness=0.6))
    pane = stage.add_square(2.5, (0.3, -1.5, 1.4), _material("Pane", Alpha=0.6, Roughness=0.5), "Pane")
    pane.rotation_euler = (1.4, 0, 0.2)
    pane.parent = bpy.data.objects["Floor"]
    glow = stage.add_square(0.8, (2.2, 2, 2), stage.emission((1, 0.6, 0.2), 4.0, "Glow"), "Glow")
    glow.rotation_euler = (1.3, 0, -0.5)
    add_uv(pane)
    key = stage.add_light("AREA", (-3, -3, 5), (0.6, -0.5, 0), energy=300, size=1.5)
    fill = stage.add_light("POINT", (3, -2, 3), energy=120, shadow_soft_size=0.4, color=(0.4, 0.6, 1))
    key.visible_camera = fill.visible_camera = False
    layer = scene.view_layers[0]
    for name, owners in {"key": [key], "rest": [fill, glow], "sky": [scene.world]}.items():
        layer.lightgroups.add(name=name)
        for owner in owners:
            owner.lightgroup = name
    for index, material in enumerate(bpy.data.materials):
        material.pass_index = 10 + index


def add_uv(obj: bpy.types.Object) -> None:
    """The square's own coordinates, 0.25 to 0.75."""
    layer = obj.data.uv_layers.new(name="UVMap")
    for loop in obj.data.loops:
        x, y, _ = obj.data.vertices[loop.vertex_index].co
        layer.data[loop.index].uv = (0.5 + 0.2 * x, 0.5 + 0.2 * y)


def _material(name: str, others: dict | None = None, **inputs) -> bpy.types.Material:
    material = bpy.data.materials.new(name)
    if bpy.app.version < (5, 0, 0):
        material.use_nodes = True
    shader = next(node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    for key, value in {**inputs, **(others or {})}.items():
        shader.inputs[key].default_value = value
    return material


def _add_ball(name: str, location, material: bpy.types.Material) -> bpy.types.Object:
    bpy.ops.mesh.primitive_uv_sphere_add(radius=0.8, location=location)
    obj = bpy.context.object
    obj.name = obj.data.name = name
    obj.data.materials.append(material)
    obj.data.polygons.foreach_set("use_smooth", [True] * len(obj.data.polygons))
    return obj
