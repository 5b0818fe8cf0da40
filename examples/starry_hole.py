"""A hole before a galaxy and thirty thousand stars: what is behind it becomes arcs of twins around its ring.

Stars are points, which path tracing would find by chance only; a picture of few samples shows them without noise.
"""

import math

import bpy
import common
import objects

POLE = (0.45, 0.25, 0.86)  # of the galaxy


def build() -> bpy.types.Scene:
    """Makes the scene in the current file and returns it."""
    scene = common.new_scene(samples=32)
    scene.bentlight.max_bounces = 0
    scene.render.filter_size = 1.8
    scene.view_settings.view_transform, scene.view_settings.look = "AgX", "AgX - Medium High Contrast"
    bpy.ops.bentlight.black_hole_add(mass=1.0, spin=0.0, location=(0, 0, 0))
    set_galaxy(scene.world)
    stars = scene.world.bentlight
    stars.stars = "PROCEDURAL"
    stars.star_count, stars.star_seed, stars.star_brightest, stars.star_slope = 30_000, 11, 0.0, 0.55
    stars.star_strength = 450.0
    view = objects.camera((0, -30, 4), (0, 0, 0))
    view.data.sensor_fit, view.data.angle = "HORIZONTAL", math.radians(68)
    view.data.clip_end = 1000.0
    return scene


def set_galaxy(world: bpy.types.World) -> None:
    """A dim band across the sky, of clouds that dust cuts through."""
    tree = world.node_tree
    new, link = tree.nodes.new, tree.links.new
    place = new("ShaderNodeTexCoord").outputs["Generated"]
    height = new("ShaderNodeVectorMath")
    height.operation, height.inputs[1].default_value = "DOT_PRODUCT", POLE
    link(place, height.inputs[0])
    noise = new("ShaderNodeTexNoise")
    noise.inputs["Scale"].default_value, noise.inputs["Detail"].default_value = 4.5, 10.0
    noise.inputs["Roughness"].default_value = 0.62
    link(place, noise.inputs["Vector"])
    ragged = new("ShaderNodeMath")  # the height above the band's plane, with clouds and gaps
    ragged.operation = "ABSOLUTE"
    moved = new("ShaderNodeMath")
    moved.operation, moved.inputs[1].default_value, moved.inputs[2].default_value = "MULTIPLY_ADD", 0.9, -0.45
    link(noise.outputs[0], moved.inputs[0])
    sum_ = new("ShaderNodeMath")
    link(height.outputs["Value"], sum_.inputs[0])
    link(moved.outputs[0], sum_.inputs[1])
    link(sum_.outputs[0], ragged.inputs[0])
    ramp = new("ShaderNodeValToRGB")
    elements = ramp.color_ramp.elements
    ramp.color_ramp.interpolation = "EASE"
    elements[0].color = (0.06, 0.04, 0.032, 1)
    elements[1].position, elements[1].color = 0.5, (0.0, 0.0, 0.001, 1)
    elements.new(0.045).color = (0.5, 0.4, 0.32, 1)
    elements.new(0.1).color = (0.2, 0.16, 0.145, 1)
    elements.new(0.2).color = (0.05, 0.055, 0.085, 1)
    link(ragged.outputs[0], ramp.inputs[0])
    clouds = new("ShaderNodeTexNoise")  # of stars too faint to be seen one by one
    clouds.inputs["Scale"].default_value, clouds.inputs["Detail"].default_value = 9.0, 12.0
    clouds.inputs["Roughness"].default_value = 0.7
    link(place, clouds.inputs["Vector"])
    density = new("ShaderNodeMapRange")
    density.inputs["From Min"].default_value, density.inputs["From Max"].default_value = 0.38, 0.78
    density.inputs["To Min"].default_value, density.inputs["To Max"].default_value = 0.01, 0.5
    link(clouds.outputs[0], density.inputs["Value"])
    background = next(node for node in tree.nodes if node.type == "BACKGROUND")
    link(density.outputs["Result"], background.inputs["Strength"])
    link(ramp.outputs["Color"], background.inputs["Color"])


if __name__ == "__main__":
    common.main(build, "starry_hole.png")
