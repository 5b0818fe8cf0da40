"""An accretion disk's own material in a lens: the lens' shader tells where a ray crosses the disk, and a copy of the
material's nodes for each crossing says what is seen there.

A lens has no surface where the disk is: what a material scatters is lost there, what it emits and what it lets pass are
seen. Transparent shaders show what is behind that crossing.
"""

from __future__ import annotations

from typing import Any

import bpy

from ..sync.disk_program import MATERIAL_ATTRIBUTES
from ..sync.material import node_tree
from . import filtered_sky, node_copy, shaders

_CROSSINGS = 4  # as in disk_light.h
_KEY = "bentlight_disk"  # fingerprint of what a lens shows, and the mark of the nodes that show it
_LIGHT = {"ShaderNodeEmission", "ShaderNodeMixShader", "ShaderNodeAddShader", "ShaderNodeGroup", "NodeReroute"}
_REPLACED = {"ShaderNodeBsdfTransparent", "ShaderNodeBsdfPrincipled"}
_OUTPUTS = {
    "Place": ("cover", "bentlight_radius", "bentlight_azimuth"),
    "Shift": ("bentlight_frequency_ratio", "bentlight_doppler", "bentlight_gravitational"),
    "More": ("bentlight_image_order", "bentlight_pattern", ""),
}
SOCKETS = {f"{name}{i}": "NodeSocketVector" for i in range(1, _CROSSINGS + 1) for name in _OUTPUTS}
"""The outputs of the lens shader that this needs."""


def update(lens: bpy.types.Material, wanted: bpy.types.Material | None) -> None:
    """Makes the material of a lens show a disk's; `None`: none. Changes nothing if it does already."""
    data = node_copy.describe(node_tree(wanted)) if wanted else None
    key = shaders.digest(data) if data else ""
    if lens.get(_KEY, "") == key:
        return
    clear(lens)
    nodes = lens.node_tree.nodes
    seen = filtered_sky.seen(lens)
    if data:
        group = _group(lens.name, data, node_tree(wanted).get_output_node("CYCLES"))
        for crossing in range(_CROSSINGS, 0, -1):
            seen = _layer(lens.node_tree, group, crossing, seen)
        lens[_KEY] = key
    output = next(node for node in nodes if node.bl_idname == "ShaderNodeOutputMaterial")
    lens.node_tree.links.new(seen, output.inputs["Surface"])


def clear(lens: bpy.types.Material) -> None:
    """Takes the nodes of a disk out again."""
    nodes = lens.node_tree.nodes
    added = [node for node in nodes if _KEY in node]
    groups = {node.node_tree for node in added if node.bl_idname == "ShaderNodeGroup"}
    for node in added:
        nodes.remove(node)
    for group in groups:
        if group:
            bpy.data.node_groups.remove(group)
    if _KEY in lens:
        del lens[_KEY]


def scattering_nodes(material: bpy.types.Material) -> list[str]:
    """Labels of the nodes whose light is lost in a lens."""
    return [node.name for node in node_tree(material).nodes if _is_lost(node)]


def _is_lost(node: bpy.types.Node) -> bool:
    is_shader = any(socket.type == "SHADER" and socket.enabled for socket in node.outputs)
    return is_shader and node.bl_idname not in _LIGHT | _REPLACED


def _layer(
    tree: bpy.types.NodeTree, group: bpy.types.NodeTree, crossing: int, behind: bpy.types.NodeSocket
) -> bpy.types.NodeSocket:
    """Adds what is seen at one crossing in front of what is behind it."""
    script = next(node for node in tree.nodes if node.bl_idname == "ShaderNodeScript")
    layer = tree.nodes.new("ShaderNodeGroup")
    layer.node_tree, layer[_KEY] = group, ""
    tree.links.new(behind, layer.inputs["behind"])
    for name, parts in _OUTPUTS.items():
        separate = tree.nodes.new("ShaderNodeSeparateXYZ")
        separate[_KEY] = ""
        tree.links.new(script.outputs[f"{name}{crossing}"], separate.inputs[0])
        for output, part in zip(separate.outputs, parts, strict=True):
            if part:
                tree.links.new(output, layer.inputs[part])
    return layer.outputs["Surface"]


def _group(name: str, data: node_copy.TreeData, output: Any) -> bpy.types.NodeTree:
    """The material as a group: of what is behind a crossing and what is known of it, what is seen."""
    tree = bpy.data.node_groups.new(name, "ShaderNodeTree")
    for socket in ("cover", *MATERIAL_ATTRIBUTES):
        tree.interface.new_socket(socket, in_out="INPUT", socket_type="NodeSocketFloat")
    tree.interface.new_socket("behind", in_out="INPUT", socket_type="NodeSocketShader")
    tree.interface.new_socket("Surface", in_out="OUTPUT", socket_type="NodeSocketShader")
    given, result = tree.nodes.new("NodeGroupInput"), tree.nodes.new("NodeGroupOutput")
    made = node_copy.build(tree, data)
    mix = tree.nodes.new("ShaderNodeMixShader")
    tree.links.new(given.outputs["cover"], mix.inputs["Fac"])
    tree.links.new(given.outputs["behind"], mix.inputs[1])
    tree.links.new(mix.outputs[0], result.inputs["Surface"])
    if output and made[output.name].inputs["Surface"].is_linked:
        tree.links.new(made[output.name].inputs["Surface"].links[0].from_socket, mix.inputs[2])
    for node in made.values():
        _adapt(tree, node, given)
    return tree


def _adapt(tree: bpy.types.NodeTree, node: bpy.types.Node, given: bpy.types.Node) -> None:
    """Replaces a node that in a lens knows nothing, or is something else there."""
    if node.bl_idname == "ShaderNodeAttribute":
        if node.attribute_name in MATERIAL_ATTRIBUTES:
            one = tree.nodes.new("ShaderNodeValue")
            one.outputs[0].default_value = 1.0
            for output in node.outputs:
                known = one.outputs[0] if output.name == "Alpha" else given.outputs[node.attribute_name]
                node_copy.take_over(tree, output, known)
            tree.nodes.remove(node)
    elif node.bl_idname == "ShaderNodeBsdfTransparent":
        inputs = {"Behind": ("NodeSocketShader", None), "Color": ("NodeSocketColor", None)}
        tint = shaders.new_node(tree, "tint", inputs)
        tree.links.new(given.outputs["behind"], tint.inputs["Behind"])
        node_copy.hand_over(tree, node.inputs["Color"], tint.inputs["Color"])
        node_copy.take_over(tree, node.outputs[0], tint.outputs["BSDF"])
        tree.nodes.remove(node)
    elif node.bl_idname == "ShaderNodeBsdfPrincipled":
        emission, mix = tree.nodes.new("ShaderNodeEmission"), tree.nodes.new("ShaderNodeMixShader")
        node_copy.hand_over(tree, node.inputs["Emission Color"], emission.inputs["Color"])
        node_copy.hand_over(tree, node.inputs["Emission Strength"], emission.inputs["Strength"])
        node_copy.hand_over(tree, node.inputs["Alpha"], mix.inputs["Fac"])
        tree.links.new(given.outputs["behind"], mix.inputs[1])
        tree.links.new(emission.outputs[0], mix.inputs[2])
        node_copy.take_over(tree, node.outputs[0], mix.outputs[0])
        tree.nodes.remove(node)
    elif node.bl_idname == "ShaderNodeOutputMaterial" or _is_lost(node):
        tree.nodes.remove(node)
