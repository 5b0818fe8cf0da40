"""A procedural sky of stars for the examples: points of many brightnesses and colors."""

import bpy


def set_starry_world(strength: float = 1.0) -> None:
    """Gives the scene a world of stars."""
    world = bpy.context.scene.world
    tree = world.node_tree
    if tree is None:
        world.use_nodes = True
        tree = world.node_tree
    tree.nodes.clear()
    new, link = tree.nodes.new, tree.links.new
    place = new("ShaderNodeTexCoord").outputs["Generated"]
    total = None
    for scale, size, brightness in ((40.0, 0.045, 60.0), (120.0, 0.08, 6.0)):
        color = _layer(tree, place, scale, size, brightness)
        if total is not None:
            both = new("ShaderNodeVectorMath")
            both.operation = "ADD"
            link(total, both.inputs[0])
            link(color, both.inputs[1])
            color = both.outputs[0]
        total = color
    background, output = new("ShaderNodeBackground"), new("ShaderNodeOutputWorld")
    background.inputs["Strength"].default_value = strength
    link(total, background.inputs["Color"])
    link(background.outputs["Background"], output.inputs["Surface"])


def _layer(
    tree: bpy.types.NodeTree, place: bpy.types.NodeSocket, scale: float, size: float, brightness: float
) -> bpy.types.NodeSocket:
    """Stars at the centers of cells: round, soft, few of them bright, from orange to blue."""
    new, link = tree.nodes.new, tree.links.new
    cells = new("ShaderNodeTexVoronoi")
    cells.inputs["Scale"].default_value = scale
    link(place, cells.inputs["Vector"])
    near = new("ShaderNodeMapRange")
    near.interpolation_type = "SMOOTHSTEP"
    near.inputs["From Min"].default_value, near.inputs["From Max"].default_value = size, 0.0
    link(cells.outputs["Distance"], near.inputs["Value"])
    chance = new("ShaderNodeSeparateColor")
    link(cells.outputs["Color"], chance.inputs["Color"])
    faint = new("ShaderNodeMath")
    faint.operation = "POWER"
    link(chance.outputs["Red"], faint.inputs[0])
    faint.inputs[1].default_value = 8.0
    light = new("ShaderNodeMath")
    light.operation = "MULTIPLY"
    link(near.outputs["Result"], light.inputs[0])
    link(faint.outputs["Value"], light.inputs[1])
    warmth = new("ShaderNodeMapRange")
    warmth.inputs["To Min"].default_value, warmth.inputs["To Max"].default_value = 3500.0, 12000.0
    link(chance.outputs["Green"], warmth.inputs["Value"])
    glow = new("ShaderNodeBlackbody")
    link(warmth.outputs["Result"], glow.inputs["Temperature"])
    scaled = new("ShaderNodeVectorMath")
    scaled.operation = "SCALE"
    link(glow.outputs["Color"], scaled.inputs[0])
    link(light.outputs["Value"], scaled.inputs["Scale"])
    bright = new("ShaderNodeVectorMath")
    bright.operation = "SCALE"
    bright.inputs["Scale"].default_value = brightness
    link(scaled.outputs[0], bright.inputs[0])
    return bright.outputs[0]
