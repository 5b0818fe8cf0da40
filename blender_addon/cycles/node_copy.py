"""A node tree as plain data that can be compared, and nodes made from it: Blender copies no tree of a material."""

from __future__ import annotations

from typing import Any, NamedTuple

import bpy

_OF_ALL_NODES = {prop.identifier for prop in bpy.types.Node.bl_rna.properties} - {"mute"}  # for the eye alone


class NodeData(NamedTuple):
    """One node: its settings, and its inputs by index, None where they have no value."""

    kind: str
    settings: dict[str, Any]
    inputs: tuple[Any, ...]


Name = str | tuple  # as in its tree, or of node_groups


class TreeData(NamedTuple):
    """Nodes by name, and links (from, output, to, input), sockets by index."""

    nodes: dict[Name, NodeData]
    links: tuple[tuple[Name, int, Name, int], ...]


def describe(tree: bpy.types.NodeTree) -> TreeData:
    """All that a tree shows; frames are for the eye alone."""
    nodes = {node.name: _describe_node(node) for node in tree.nodes if node.bl_idname != "NodeFrame"}
    links = [
        (link.from_node.name, _index(link.from_node.outputs, link.from_socket), link.to_node.name, place)
        for link in tree.links
        if (place := _index(link.to_node.inputs, link.to_socket)) is not None and link.is_valid and not link.is_muted
    ]
    return TreeData(nodes, tuple(links))


def _index(sockets: Any, wanted: bpy.types.NodeSocket) -> int | None:
    return next((i for i, socket in enumerate(sockets) if socket == wanted), None)


def _describe_node(node: bpy.types.Node) -> NodeData:
    inputs = tuple(_plain(getattr(socket, "default_value", None)) for socket in node.inputs)
    return NodeData(node.bl_idname, _settings(node), inputs)


def _settings(owner: bpy.types.bpy_struct) -> dict[str, Any]:
    """Settings of a node, or of what it holds: ramps, curves, users of images."""
    found = {}
    for prop in owner.bl_rna.properties:
        name = prop.identifier
        if name in _OF_ALL_NODES or prop.type == "COLLECTION":
            continue
        value = getattr(owner, name)
        if prop.type == "POINTER" and not isinstance(value, bpy.types.ID) and value is not None:
            if prop.is_readonly:
                found[name] = _settings(value)
        elif not prop.is_readonly:
            found[name] = _plain(value)
    if isinstance(owner, bpy.types.ColorRamp):
        found["elements"] = [(element.position, tuple(element.color)) for element in owner.elements]
    if isinstance(owner, bpy.types.CurveMapping):
        found["curves"] = [[(tuple(p.location), p.handle_type) for p in curve.points] for curve in owner.curves]
    return found


def _plain(value: Any) -> Any:
    if isinstance(value, bpy.types.ID):
        return value.original
    return tuple(value) if hasattr(value, "__len__") and not isinstance(value, (str, set)) else value


def build(tree: bpy.types.NodeTree, data: TreeData) -> dict[Name, bpy.types.Node]:
    """Makes the nodes and links in a tree; returns them by the names they have in `data`."""
    made = {name: _build_node(tree, name, node) for name, node in data.nodes.items()}
    for from_node, output, to_node, place in data.links:
        tree.links.new(made[from_node].outputs[output], made[to_node].inputs[place])
    return made


def _build_node(tree: bpy.types.NodeTree, name: Name, data: NodeData) -> bpy.types.Node:
    node = tree.nodes.new(data.kind)
    if isinstance(name, str):
        node.name = name
    _set(node, data.settings)
    for socket, value in zip(node.inputs, data.inputs, strict=False):
        if value is not None:
            socket.default_value = value
    return node


def _set(owner: bpy.types.bpy_struct, settings: dict[str, Any]) -> None:
    for name, value in settings.items():
        if name == "elements":
            _set_elements(owner.elements, value)
        elif name == "curves":
            _set_curves(owner, value)
        elif isinstance(value, dict):
            _set(getattr(owner, name), value)
        elif value != _plain(getattr(owner, name)):
            setattr(owner, name, value)


def _set_elements(elements: bpy.types.ColorRampElements, wanted: list) -> None:
    while len(elements) > 1:
        elements.remove(elements[-1])
    for i, (position, color) in enumerate(wanted):
        element = elements[0] if i == 0 else elements.new(position)
        element.position, element.color = position, color


def _set_curves(mapping: bpy.types.CurveMapping, wanted: list) -> None:
    for curve, points in zip(mapping.curves, wanted, strict=True):
        while len(curve.points) > 2:  # it must keep two
            curve.points.remove(curve.points[1])
        while len(curve.points) < len(points):
            curve.points.new(0.5, 0.5)
        for point, (location, handle) in zip(curve.points, points, strict=True):
            point.location, point.handle_type = location, handle
    mapping.update()


def take_over(tree: bpy.types.NodeTree, old: bpy.types.NodeSocket, new: bpy.types.NodeSocket) -> None:
    """What one output led to, another does."""
    for target in [link.to_socket for link in old.links]:
        tree.links.new(new, target)


def hand_over(tree: bpy.types.NodeTree, old: bpy.types.NodeSocket, new: bpy.types.NodeSocket) -> None:
    """What one input got, another gets."""
    new.default_value = old.default_value
    if old.is_linked:
        tree.links.new(old.links[0].from_socket, new)
