"""What a lens shows of the sky to the camera: a copy of the world's nodes, whose images and stars are averaged over
what a camera ray stands for, however bending stretches it.

Cycles tells a world nothing of that, so rays that leave a lens for the sky end in its material (osl/lens.osl), which
knows. Only where that changes nothing else: for worlds with images of the sky or stars, made of nodes that ask for no
more than a direction, seen by the camera in all view layers, without an Environment pass, a light group, a volume or
a transparent film; and on CPUs, for shaders of graphics cards cannot ask whether a ray meets something.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import bpy

from ..sync.material import node_tree
from ..sync.nodes.shaders import STARS_MARK
from . import node_copy, shaders, sky_images, stars

SOCKETS = {"Toward": "NodeSocketVector", "Sky": "NodeSocketColor"}
"""The outputs of the lens shader that this needs."""

_KEY = "bentlight_sky"  # fingerprint of what a lens shows, and the mark of the nodes that show it
_TREE = "Bentlight Sky"
_IMAGE = "ShaderNodeTexEnvironment"
_COORDINATE, _LIGHT = "ShaderNodeTexCoord", "ShaderNodeBackground"
_OUTPUT, _PLACEHOLDER = "ShaderNodeOutputWorld", "ShaderNodeEmission"
# Those that know no more than what is linked to them, and those that, where nothing is, know the direction.
_PLAIN = {
    "NodeReroute",
    "ShaderNodeAddShader",
    "ShaderNodeBlackbody",
    "ShaderNodeBrightContrast",
    "ShaderNodeClamp",
    "ShaderNodeCombineColor",
    "ShaderNodeCombineXYZ",
    "ShaderNodeEmission",
    "ShaderNodeFloatCurve",
    "ShaderNodeGamma",
    "ShaderNodeHueSaturation",
    "ShaderNodeInvert",
    "ShaderNodeLightPath",
    "ShaderNodeMapRange",
    "ShaderNodeMapping",
    "ShaderNodeMath",
    "ShaderNodeMix",
    "ShaderNodeMixRGB",
    "ShaderNodeMixShader",
    "ShaderNodeRGB",
    "ShaderNodeRGBCurve",
    "ShaderNodeRGBToBW",
    "ShaderNodeSeparateColor",
    "ShaderNodeSeparateXYZ",
    "ShaderNodeValToRGB",
    "ShaderNodeValue",
    "ShaderNodeVectorCurve",
    "ShaderNodeVectorMath",
    "ShaderNodeVectorRotate",
    "ShaderNodeWavelength",
}
_TEXTURES = {
    "ShaderNodeTexBrick",
    "ShaderNodeTexChecker",
    "ShaderNodeTexEnvironment",
    "ShaderNodeTexGabor",
    "ShaderNodeTexGradient",
    "ShaderNodeTexMagic",
    "ShaderNodeTexNoise",
    "ShaderNodeTexSky",
    "ShaderNodeTexVoronoi",
    "ShaderNodeTexWave",
    "ShaderNodeTexWhiteNoise",
}


class Sky(NamedTuple):
    """What a lens shows: the world's nodes; by the names of theirs, files of images, and what stars.osl is told."""

    nodes: node_copy.TreeData
    output: str  # name of the node that shows it
    images: dict[str, sky_images.File]
    stars: dict[str, dict[str, shaders.Socket]]


def read(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> Sky | None:
    """The sky of a scene's world in this frame; None where the world itself is to be seen, its images as they are."""
    if not _may_be_copied(scene):
        return None
    star_node = stars.find(scene.world.node_tree)
    tree = node_tree(scene.world.evaluated_get(depsgraph))
    if star_node and star_node.name not in tree.nodes:  # they have only just been added
        tree = scene.world.node_tree
    output = tree.get_output_node("CYCLES")
    if not output or output.inputs["Volume"].is_linked:
        return None
    others = [node for node in tree.nodes if STARS_MARK not in node and node.bl_idname != "NodeFrame"]
    if not all(_is_known(node) for node in others):
        return None
    found = {node.name: sky_images.file_of(node.image) for node in others if _is_filtered(node)}
    images = {name: file for name, file in found.items() if file}
    if not images and not star_node:
        return None
    told = {star_node.name: stars.told_shader(star_node, pixels(scene))} if star_node else {}
    nodes, links = node_copy.describe(tree)
    nodes |= {name: node_copy.NodeData(_PLACEHOLDER, {}, ()) for name in told}  # code is not copied
    return Sky(node_copy.TreeData(nodes, links), output.name, images, told)


def _may_be_copied(scene: bpy.types.Scene) -> bool:
    """Whether a scene's settings let lenses shine instead of its world."""
    world = scene.world
    if not world or not node_tree(world) or world.lightgroup or not world.cycles_visibility.camera:
        return False
    if scene.cycles.device == "GPU" or scene.bentlight.sky_filter == 0 or scene.render.film_transparent:
        return False
    return not any(
        not layer.use_sky or layer.use_pass_environment or getattr(layer, "world_override", None)
        for layer in scene.view_layers
    )


def _is_known(node: bpy.types.Node) -> bool:
    """Whether a node shows in a material what it shows in a world, once it is told the direction."""
    if node.bl_idname == _COORDINATE:
        return not any(output.is_linked for output in node.outputs if output.name != "Generated")
    return node.bl_idname in _PLAIN | _TEXTURES | {_LIGHT, _OUTPUT}


def _is_filtered(node: bpy.types.Node) -> bool:
    return node.bl_idname == _IMAGE and node.projection == "EQUIRECTANGULAR" and node.image is not None


def pixels(scene: bpy.types.Scene) -> float:
    """Standard deviation of the filter, as the engine's for as many samples."""
    return scene.bentlight.sky_filter / math.sqrt(scene.cycles.samples)


def seen(lens: bpy.types.Material) -> bpy.types.NodeSocket:
    """What a lens shows behind any disk."""
    nodes = lens.node_tree.nodes
    both = next((node for node in nodes if _KEY in node and node.bl_idname == "ShaderNodeAddShader"), None)
    return both.outputs[0] if both else _script(lens).outputs["BSDF"]


def update(lens: bpy.types.Material, wanted: Sky | None) -> None:
    """Makes the material of a lens show a sky; `None`: the world itself. Changes nothing if it does already."""
    key = shaders.digest(wanted) if wanted else ""
    if lens.get(_KEY, "") == key:
        return
    clear(lens)
    if wanted:
        tree, script = lens.node_tree, _script(lens)
        group, both = tree.nodes.new("ShaderNodeGroup"), tree.nodes.new("ShaderNodeAddShader")
        group[_KEY] = both[_KEY] = ""
        group.node_tree = _group(wanted)
        group.location, both.location = (-300, -300), (-100, -100)
        node_copy.take_over(tree, script.outputs["BSDF"], both.outputs[0])
        for name in SOCKETS:
            tree.links.new(script.outputs[name], group.inputs[name])
        tree.links.new(script.outputs["BSDF"], both.inputs[0])
        tree.links.new(group.outputs[0], both.inputs[1])
        lens[_KEY] = key


def clear(lens: bpy.types.Material) -> None:
    """Takes the nodes of a sky out again."""
    if _KEY not in lens:
        return
    node_copy.take_over(lens.node_tree, seen(lens), _script(lens).outputs["BSDF"])
    for node in [node for node in lens.node_tree.nodes if _KEY in node]:
        group = getattr(node, "node_tree", None)
        lens.node_tree.nodes.remove(node)
        if group:
            bpy.data.node_groups.remove(group)
    del lens[_KEY]


def _script(lens: bpy.types.Material) -> bpy.types.Node:
    return next(node for node in lens.node_tree.nodes if node.bl_idname == "ShaderNodeScript")


def _group(sky: Sky) -> bpy.types.NodeTree:
    """The world as a group: of a direction and of how much of it is seen, what is seen there."""
    tree = bpy.data.node_groups.new(_TREE, "ShaderNodeTree")
    for name, kind in SOCKETS.items():
        tree.interface.new_socket(name, in_out="INPUT", socket_type=kind)
    tree.interface.new_socket("Surface", in_out="OUTPUT", socket_type="NodeSocketShader")
    given, result = tree.nodes.new("NodeGroupInput"), tree.nodes.new("NodeGroupOutput")
    part = shaders.new_node(tree, "tint", {"Behind": ("NodeSocketShader", None), "Color": ("NodeSocketColor", None)})
    tree.links.new(given.outputs["Sky"], part.inputs["Color"])
    tree.links.new(part.outputs[0], result.inputs["Surface"])
    made = node_copy.build(tree, sky.nodes)
    for name, node in made.items():
        _adapt(tree, node, given.outputs["Toward"], sky.images.get(name), sky.stars.get(name))
    output = made[sky.output]
    for link in output.inputs["Surface"].links:
        tree.links.new(link.from_socket, part.inputs["Behind"])
    for node in [node for node in tree.nodes if node.bl_idname == _OUTPUT]:
        tree.nodes.remove(node)
    return tree


def _adapt(
    tree: bpy.types.NodeTree,
    node: bpy.types.Node,
    toward: bpy.types.NodeSocket,
    image: sky_images.File | None,
    star_inputs: dict[str, shaders.Socket] | None,
) -> None:
    """Tells a node the direction that in a world it knows, and replaces those that are something else in a material."""
    if node.bl_idname == _COORDINATE:
        node_copy.take_over(tree, node.outputs["Generated"], toward)
    elif star_inputs:
        shown = shaders.new_node(tree, "stars", {**star_inputs, "Toward": ("NodeSocketVector", None)})
        tree.links.new(toward, shown.inputs["Toward"])
        node_copy.take_over(tree, node.outputs[0], shown.outputs["BSDF"])
        tree.nodes.remove(node)
    elif node.bl_idname == _LIGHT:
        emission = tree.nodes.new("ShaderNodeEmission")
        for name in ("Color", "Strength"):
            node_copy.hand_over(tree, node.inputs[name], emission.inputs[name])
        node_copy.take_over(tree, node.outputs[0], emission.outputs[0])
        tree.nodes.remove(node)
    elif node.bl_idname in _TEXTURES:
        vector = node.inputs.get("Vector")
        if vector and not vector.is_linked:
            tree.links.new(toward, vector)
        if image:
            _filter(tree, node, image)


def _filter(tree: bpy.types.NodeTree, node: bpy.types.Node, image: sky_images.File) -> None:
    """Puts osl/sky_image.osl behind an Environment Texture."""
    inputs = {
        "Vector": ("NodeSocketVector", None),
        "Near": ("NodeSocketColor", None),
        "Image": ("NodeSocketString", str(image.path)),
        "Height": ("NodeSocketInt", image.height),
    }
    filtered = shaders.new_node(tree, "sky_image", inputs, {"Color": "NodeSocketColor"})
    node_copy.take_over(tree, node.outputs["Color"], filtered.outputs["Color"])
    tree.links.new(node.inputs["Vector"].links[0].from_socket, filtered.inputs["Vector"])
    tree.links.new(node.outputs["Color"], filtered.inputs["Near"])
