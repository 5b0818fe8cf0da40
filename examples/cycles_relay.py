"""Cycles shades along curved camera rays: a lacquered monkey in orbit around a black hole, at four times its mass.

The lacquer is made of nodes that only Cycles has to know. Bentlight traces the camera's rays around the hole to the
surfaces that they meet (the relay camera), and Cycles renders from there on; what surfaces scatter is bent by the lens
around the hole. So the monkey is seen twice: in front, and drawn out along the other side of the hole, from behind.
"""

import math

import bpy
import common
import nodes
import objects

MASS = 0.5
ORBIT = 4 * MASS
_GOLD, _TEAL = (0.9, 0.55, 0.15, 1.0), (0.01, 0.16, 0.2, 1.0)


def lacquer() -> bpy.types.Material:
    """Cells of gold in teal under clear coat, all by Cycles' own nodes."""
    material = bpy.data.materials.new("Lacquer")
    if bpy.app.version < (5, 0, 0):
        material.use_nodes = True
    new, links = material.node_tree.nodes.new, material.node_tree.links
    shader = material.node_tree.nodes["Principled BSDF"]
    cells, ramp, bump = (new(f"ShaderNode{kind}") for kind in ("TexVoronoi", "ValToRGB", "Bump"))
    place = new("ShaderNodeTexCoord")
    cells.feature = "DISTANCE_TO_EDGE"
    cells.inputs["Scale"].default_value = 5.0
    ramp.color_ramp.elements[0].position, ramp.color_ramp.elements[0].color = 0.04, _GOLD
    ramp.color_ramp.elements[1].position, ramp.color_ramp.elements[1].color = 0.09, _TEAL
    bump.inputs["Strength"].default_value = 0.35
    links.new(place.outputs["Object"], cells.inputs["Vector"])
    links.new(cells.outputs["Distance"], ramp.inputs["Fac"])
    links.new(cells.outputs["Distance"], bump.inputs["Height"])
    links.new(ramp.outputs["Color"], shader.inputs["Base Color"])
    links.new(bump.outputs["Normal"], shader.inputs["Normal"])
    shader.inputs["Roughness"].default_value = 0.3
    shader.inputs["Metallic"].default_value = 0.4
    shader.inputs["Coat Weight"].default_value = 1.0
    return material


def build(angle_deg: float = 235.0) -> bpy.types.Scene:
    """Makes the scene in the current file, the monkey at this angle of its orbit, and returns it ready for Cycles."""
    scene = common.new_scene("CYCLES", samples=96)
    nodes.starry_sky((0.10, 0.06, 0.13), (0.01, 0.03, 0.07), 1.0)
    bpy.ops.bentlight.black_hole_add(mass=MASS, location=(0, 0, 0))
    angle = math.radians(angle_deg)
    center = (ORBIT * math.sin(angle), ORBIT * math.cos(angle), 0.25)
    objects.suzanne(center, 1.2, 35.0, lacquer())
    objects.area_light("Key", (-5.0, -7.0, 5.0), center, (2.5, 2.5), 1200, (1.0, 0.9, 0.78))
    objects.area_light("Rim", (3.0, 5.0, 2.5), center, (2.0, 3.0), 900, (0.5, 0.7, 1.0))
    objects.camera((0.0, -15.0, 1.6), (0.0, 0.0, 0.0), 32)
    bpy.ops.bentlight.cycles_setup()
    bpy.ops.bentlight.relay_setup(bake=False)
    return scene


if __name__ == "__main__":
    common.main(build, "cycles_relay.png", "CYCLES")
