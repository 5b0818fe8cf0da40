"""Procedural materials of the examples for Cycles: patterns that only its own nodes draw, with bumps and gloss."""

import bpy
import materials
from materials import Color


def brick(name: str, color1: Color, color2: Color, mortar: Color, scale: float, **inputs: object) -> bpy.types.Material:
    """A wall of bricks that stand out of their mortar."""
    material = materials.principled(name, **inputs)
    tree = material.node_tree
    texture = _texture(tree, "ShaderNodeTexBrick", "UV", scale)
    for socket, color in (("Color1", color1), ("Color2", color2), ("Mortar", mortar)):
        texture.inputs[socket].default_value = (*color, 1)
    texture.inputs["Mortar Size"].default_value = 0.012
    shader = tree.nodes["Principled BSDF"]
    tree.links.new(texture.outputs["Color"], shader.inputs["Base Color"])
    _bump(tree, texture.outputs["Fac"], 0.6, invert=True)
    return material


def marble(name: str, dark: Color, light: Color, scale: float, **inputs: object) -> bpy.types.Material:
    """Veined stone: noise, bent by noise, through a ramp of colors."""
    material = materials.principled(name, **inputs)
    tree = material.node_tree
    noise = _texture(tree, "ShaderNodeTexNoise", "Object", scale)
    noise.inputs["Detail"].default_value, noise.inputs["Distortion"].default_value = 8, 2.5
    ramp = tree.nodes.new("ShaderNodeValToRGB")
    ramp.color_ramp.elements[0].position, ramp.color_ramp.elements[0].color = 0.42, (*dark, 1)
    ramp.color_ramp.elements[1].position, ramp.color_ramp.elements[1].color = 0.56, (*light, 1)
    tree.links.new(noise.outputs["Fac"], ramp.inputs["Fac"])
    tree.links.new(ramp.outputs["Color"], tree.nodes["Principled BSDF"].inputs["Base Color"])
    return material


def wet(material: bpy.types.Material, dry: float, puddle: float, scale: float) -> bpy.types.Material:
    """Lets the roughness change from place to place, from `puddle` to `dry`."""
    tree = material.node_tree
    noise = _texture(tree, "ShaderNodeTexNoise", "Object", scale)
    noise.inputs["Detail"].default_value = 5
    span = tree.nodes.new("ShaderNodeMapRange")
    for socket, value in (("From Min", 0.42), ("From Max", 0.6), ("To Min", puddle), ("To Max", dry)):
        span.inputs[socket].default_value = value
    tree.links.new(noise.outputs["Fac"], span.inputs["Value"])
    tree.links.new(span.outputs["Result"], tree.nodes["Principled BSDF"].inputs["Roughness"])
    return material


def hammered(material: bpy.types.Material, scale: float, strength: float) -> bpy.types.Material:
    """Dents all over."""
    tree = material.node_tree
    cells = _texture(tree, "ShaderNodeTexVoronoi", "Object", scale)
    cells.feature = "SMOOTH_F1"
    _bump(tree, cells.outputs["Distance"], strength, invert=False)
    return material


def starry_sky(glow: Color, horizon: Color, strength: float) -> None:
    """The world: stars where fine noise is brightest, in front of a soft nebula."""
    tree = bpy.context.scene.world.node_tree
    background = tree.nodes["Background"]
    stars = _texture(tree, "ShaderNodeTexVoronoi", "Generated", 90)
    bright = tree.nodes.new("ShaderNodeMapRange")
    for socket, value in (("From Min", 0.085), ("From Max", 0.02), ("To Min", 0), ("To Max", 5)):
        bright.inputs[socket].default_value = value
    tree.links.new(stars.outputs["Distance"], bright.inputs["Value"])
    cloud = _texture(tree, "ShaderNodeTexNoise", "Generated", 1.7)
    cloud.inputs["Detail"].default_value = 6
    ramp = tree.nodes.new("ShaderNodeValToRGB")
    ramp.color_ramp.elements[0].position, ramp.color_ramp.elements[0].color = 0.42, (*horizon, 1)
    ramp.color_ramp.elements[1].position, ramp.color_ramp.elements[1].color = 0.72, (*glow, 1)
    tree.links.new(cloud.outputs["Fac"], ramp.inputs["Fac"])
    total = tree.nodes.new("ShaderNodeVectorMath")
    tree.links.new(bright.outputs["Result"], total.inputs[0])
    tree.links.new(ramp.outputs["Color"], total.inputs[1])
    tree.links.new(total.outputs[0], background.inputs["Color"])
    background.inputs["Strength"].default_value = strength
    bpy.context.scene.world.cycles.sampling_method = "NONE"  # a map of so fine a sky takes longer than it is worth


def _texture(tree: bpy.types.NodeTree, kind: str, coordinates: str, scale: float) -> bpy.types.Node:
    texture, source = tree.nodes.new(kind), tree.nodes.new("ShaderNodeTexCoord")
    texture.inputs["Scale"].default_value = scale
    tree.links.new(source.outputs[coordinates], texture.inputs["Vector"])
    return texture


def _bump(tree: bpy.types.NodeTree, height: bpy.types.NodeSocket, strength: float, invert: bool) -> None:
    bump = tree.nodes.new("ShaderNodeBump")
    bump.inputs["Strength"].default_value, bump.invert = strength, invert
    bump.inputs["Distance"].default_value = 0.03
    tree.links.new(height, bump.inputs["Height"])
    tree.links.new(bump.outputs["Normal"], tree.nodes["Principled BSDF"].inputs["Normal"])
