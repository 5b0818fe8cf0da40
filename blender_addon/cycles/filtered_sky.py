"""What filtering changes in the sky as the camera sees it through a lens or by relay: images of the sky and stars,
averaged over what a ray stands for, however bending stretches it, less what the world shows point by point.

Cycles tells a world nothing of that, but osl/lens.osl and osl/relay_screen.osl know. So their materials have two copies
of the world's nodes, with images filtered and as they are, and shine as these differ; rays go on to the world, which
shows the rest and leaves all passes as they are. `_obstacle` and `_obstacle_in_nodes` tell what stands in the way.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import bpy

from ..report import RenderError, told
from ..sync.material import node_tree
from ..sync.nodes.shaders import STARS_MARK
from . import light_groups, node_copy, node_groups, shaders, sky_images, stars

SOCKETS = {"Toward": "NodeSocketVector", "Along": "NodeSocketVector", "Sky": "NodeSocketColor"}
"""The outputs of their shaders that this needs."""

_KEY = "bentlight_sky"  # fingerprint of what is filtered, and the mark of the nodes that do
_TREE = "Bentlight Sky"
_IMAGE = "ShaderNodeTexEnvironment"
_LIGHT = "ShaderNodeBackground"
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
_UNMOVED = {  # an Environment Texture's own mapping
    **{"translation": (0, 0, 0), "rotation": (0, 0, 0), "scale": (1, 1, 1)},
    **{"mapping_x": "X", "mapping_y": "Y", "mapping_z": "Z"},
}
# By places of outputs of nodes that tell places and directions: how often that of the ray they are in a world.
_DIRECTIONS = {
    "ShaderNodeTexCoord": {0: 1, 1: -1, 3: 1, 6: -1},  # Generated, Normal, Object, Reflection
    "ShaderNodeNewGeometry": {0: 1, 1: -1, 3: -1, 4: -1},  # Position, Normal, True Normal, Incoming
}


class Sky(NamedTuple):
    """What is filtered: the world's nodes; by the names of theirs, files of images, and what stars.osl is told."""

    nodes: node_copy.TreeData
    output: node_groups.Path  # of the node that shows it
    images: dict[node_groups.Path, sky_images.File]
    stars: dict[node_groups.Path, dict[str, shaders.Socket]]


def read(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> tuple[Sky | None, list[str]]:
    """The sky of a scene's world in this frame, None where nothing is to be filtered, and warnings: why images of the
    sky, and stars, that are seen are not filtered though that is asked for."""
    if not _is_asked_for(scene):
        return None, []
    shown = scene.world.evaluated_get(depsgraph)
    if (stars.find(shown.node_tree) is None) != (stars.find(scene.world.node_tree) is None):
        shown = scene.world  # they have only just come or gone
    world = node_groups.flattened(shown)
    nodes, links = world.leading_to(world.output)
    textures = [name for name in nodes if _is_image(world.sources[name])]
    star_names = {name for name in nodes if STARS_MARK in world.sources[name]}
    told_stars = {
        name: stars.told_shader(world.sources[name], pixels(scene))
        for name in star_names
        if not world.sources[name].mute
    }
    if not textures and not told_stars:
        return None, []
    reason = _obstacle(scene) or _obstacle_in_nodes(scene, world, nodes, links)
    if reason:
        return None, [told("Sky Filter does nothing in Cycles: {}", reason)]
    images, left = _files(scene, world, textures)
    if not images and not told_stars:
        return None, left
    # their code is not copied
    nodes = nodes | {
        name: node_copy.NodeData(_PLACEHOLDER, {"mute": world.sources[name].mute}, ()) for name in star_names
    }
    return Sky(node_copy.TreeData(nodes, links), world.output, images, told_stars), left


def settings(scene: bpy.types.Scene) -> tuple:
    """What decides on warnings and Blender tells of no change of."""
    world = scene.world
    if not world:
        return ()
    layers = [(layer.use_sky, layer.world_override is None) for layer in scene.view_layers]
    seen = world.cycles_visibility.camera, scene.render.film_transparent
    return scene.bentlight.sky_filter > 0, *seen, *layers


def _is_asked_for(scene: bpy.types.Scene) -> bool:
    """Whether images are to be filtered, and camera rays see the sky."""
    world = scene.world
    if not world or not node_tree(world) or not world.cycles_visibility.camera or scene.render.film_transparent:
        return False
    return scene.bentlight.sky_filter > 0 and any(layer.use_sky for layer in scene.view_layers)


def _is_image(node: bpy.types.Node) -> bool:
    return node.bl_idname == _IMAGE and node.image is not None and not node.mute


def _obstacle(scene: bpy.types.Scene) -> str:
    """Why lenses cannot add to a scene's world, by its settings; "" where they can."""
    if scene.cycles.device == "GPU":  # shaders there cannot ask whether a ray meets something
        return told("it works on the CPU alone")
    hole = light_groups.other_than_of_world(scene)
    if hole:
        return told("the disk of '{}' and world '{}' are not in one light group", hole.name, scene.world.name)
    for layer in scene.view_layers:
        if layer.world_override:
            return told("view layer '{}' has a world of its own", layer.name)
    return ""


def _obstacle_in_nodes(
    scene: bpy.types.Scene, world: node_groups.FlatTree, nodes: dict[node_copy.Name, node_copy.NodeData], links: tuple
) -> str:
    """As _obstacle, by the world's nodes, of which `nodes` and `links` are seen."""
    if any(end == world.output and place != 0 for _start, _output, end, place in links):
        return told("world '{}' has a volume", scene.world.name)
    used = {(start, output) for start, output, _end, _place in links}
    for name, data in nodes.items():
        outputs = {output for start, output in used if start == name}
        is_known = data.kind in _PLAIN | _TEXTURES | {_LIGHT, _OUTPUT} or STARS_MARK in world.sources[name]
        if not is_known and not (data.kind in _DIRECTIONS and outputs <= set(_DIRECTIONS[data.kind])):
            return told("lenses cannot show node '{}' of world '{}'", world.shown_name(name), scene.world.name)
    return ""


def _files(
    scene: bpy.types.Scene, world: node_groups.FlatTree, textures: list[node_groups.Path]
) -> tuple[dict[node_groups.Path, sky_images.File], list[str]]:
    """The files of images by the names of their nodes, and why some have none."""
    found, left = {}, []
    for name in textures:
        node, mapping = world.sources[name], world.data.nodes[name].settings["texture_mapping"]
        try:
            if node.projection != "EQUIRECTANGULAR":
                raise RenderError("image '{}' is a mirror ball", node.image.name)
            if any(mapping[part] != value for part, value in _UNMOVED.items()):
                raise RenderError("node '{}' has a Texture Mapping", world.shown_name(name))
            found[name] = sky_images.file_of(node.image, node.image_user, scene.frame_current)
        except RenderError as error:
            left.append(told("Sky Filter does nothing for an image in Cycles: {}", error))
    return found, left


def pixels(scene: bpy.types.Scene) -> float:
    """Standard deviation of the filter, as the engine's for as many samples."""
    return scene.bentlight.sky_filter / math.sqrt(scene.cycles.samples)


def seen(material: bpy.types.Material) -> bpy.types.NodeSocket:
    """What a material shows behind any disk."""
    nodes = material.node_tree.nodes
    both = next((node for node in nodes if _KEY in node and node.bl_idname == "ShaderNodeAddShader"), None)
    return both.outputs[0] if both else _script(material).outputs["BSDF"]


def update(material: bpy.types.Material, wanted: Sky | None) -> None:
    """Makes a material filter a sky; `None`: none. Changes nothing if it does already."""
    key = shaders.digest(wanted) if wanted else ""
    if material.get(_KEY, "") == key:
        return
    clear(material)
    if wanted:
        tree, script = material.node_tree, _script(material)
        group, both = tree.nodes.new("ShaderNodeGroup"), tree.nodes.new("ShaderNodeAddShader")
        group[_KEY] = both[_KEY] = ""
        group.node_tree = _group(wanted)
        group.location, both.location = (-300, -300), (-100, -100)
        node_copy.take_over(tree, script.outputs["BSDF"], both.outputs[0])
        for name in SOCKETS:
            tree.links.new(script.outputs[name], group.inputs[name])
        tree.links.new(script.outputs["BSDF"], both.inputs[0])
        tree.links.new(group.outputs[0], both.inputs[1])
        material[_KEY] = key


def clear(material: bpy.types.Material) -> None:
    """Takes the nodes of a sky out again."""
    if _KEY not in material:
        return
    node_copy.take_over(material.node_tree, seen(material), _script(material).outputs["BSDF"])
    for node in [node for node in material.node_tree.nodes if _KEY in node]:
        group = getattr(node, "node_tree", None)
        material.node_tree.nodes.remove(node)
        if group:
            bpy.data.node_groups.remove(group)
    del material[_KEY]


def _script(material: bpy.types.Material) -> bpy.types.Node:
    return next(node for node in material.node_tree.nodes if node.bl_idname == "ShaderNodeScript")


def _group(sky: Sky) -> bpy.types.NodeTree:
    """What filtering changes in the world, as a group: of a direction and of how much of it is seen."""
    tree = bpy.data.node_groups.new(_TREE, "ShaderNodeTree")
    for name, kind in SOCKETS.items():
        tree.interface.new_socket(name, in_out="INPUT", socket_type=kind)
    tree.interface.new_socket("Surface", in_out="OUTPUT", socket_type="NodeSocketShader")
    given, result = tree.nodes.new("NodeGroupInput"), tree.nodes.new("NodeGroupOutput")
    inputs = {"Filtered": ("NodeSocketShader", None), "Plain": ("NodeSocketShader", None)}
    inputs |= {"Color": ("NodeSocketColor", None), "Shown": ("NodeSocketFloat", None)}
    change = shaders.new_node(tree, "sky_change", inputs)
    tree.links.new(given.outputs["Sky"], change.inputs["Color"])
    layer = tree.nodes.new("ShaderNodeAttribute")
    layer.attribute_type, layer.attribute_name = "VIEW_LAYER", "use_sky"
    tree.links.new(layer.outputs["Fac"], change.inputs["Shown"])
    tree.links.new(change.outputs[0], result.inputs["Surface"])
    for name, direction, images in (("Filtered", "Toward", sky.images), ("Plain", "Along", {})):
        made = node_copy.build(tree, sky.nodes)
        for key, node in made.items():
            _adapt(tree, node, given.outputs[direction], images.get(key), sky.stars.get(key))
        for link in made[sky.output].inputs["Surface"].links:
            tree.links.new(link.from_socket, change.inputs[name])
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
    if node.mute:
        return
    if node.bl_idname in _DIRECTIONS:
        _direct(tree, node, toward)
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


def _direct(tree: bpy.types.NodeTree, node: bpy.types.Node, toward: bpy.types.NodeSocket) -> None:
    """Lets the direction take the place of a node that tells it."""
    for place, sign in _DIRECTIONS[node.bl_idname].items():
        if node.outputs[place].is_linked:
            scaled = tree.nodes.new("ShaderNodeVectorMath")
            scaled.operation = "SCALE"
            scaled.inputs["Scale"].default_value = sign
            tree.links.new(toward, scaled.inputs[0])
            node_copy.take_over(tree, node.outputs[place], scaled.outputs[0])
    tree.nodes.remove(node)


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
