"""A world's nodes without groups: what is in them stands where they were, as Cycles takes them.

From Blender 5.0 on it makes such trees itself, which also are without menus, zones and closures. Before, each socket of
a group becomes a node that only passes a value on, for there Cycles turns it into the socket's type.
"""

from __future__ import annotations

from collections import defaultdict
from typing import Any, NamedTuple

import bpy

from .node_copy import Name, NodeData, TreeData, describe

_GIVEN, _RESULT = "NodeGroupInput", "NodeGroupOutput"
_GROUPS = {"GROUP", "CUSTOM GROUP"}
_TEXTURE = "ShaderNodeTex"  # how kinds of textures begin; their first input are coordinates
# By type of socket: the node that passes it on in its first input, its settings, and its second input.
_PASSING = {
    "VALUE": ("ShaderNodeMath", {"operation": "ADD"}, 0.0),
    "INT": ("ShaderNodeMath", {"operation": "TRUNC"}, 0.0),
    "BOOLEAN": ("ShaderNodeMath", {"operation": "TRUNC"}, 0.0),
    "VECTOR": ("ShaderNodeVectorMath", {"operation": "ADD"}, (0.0, 0.0, 0.0)),
    "RGBA": ("ShaderNodeGamma", {}, 1.0),
    "SHADER": ("ShaderNodeAddShader", {}, None),
}

Path = tuple[str, ...]  # the names of the groups around a node, and its own


class Socket(NamedTuple):
    """Names the node that stands for a group's socket."""

    group: Path
    is_output: bool
    identifier: str


class FlatTree(NamedTuple):
    """Nodes and links by paths and sockets, and the nodes that they are made from; those of sockets are groups."""

    data: TreeData
    sources: dict[Name, bpy.types.Node]
    output: Path | None  # of the node whose surface Cycles shows
    inlined: Any = None  # keeps Blender's own nodes, whose names begin with numbers

    def shown_name(self, name: Name) -> str:
        """A node's or a group's name for the user, after those of the groups around."""
        if self.inlined:
            return name[0].partition("_")[2] or name[0]
        return "/".join(name.group if isinstance(name, Socket) else name)

    def leading_to(self, path: Path | None) -> TreeData:
        """Only what a node shows."""
        before = defaultdict(list)
        for link in self.data.links:
            before[link[2]].append(link[0])
        found, waiting = set(), [path]
        while waiting:
            name = waiting.pop()
            if name is not None and name not in found:
                found.add(name)
                waiting += before[name]
        nodes = {name: node for name, node in self.data.nodes.items() if name in found}
        return TreeData(nodes, tuple(link for link in self.data.links if link[2] in found))


class _Level(NamedTuple):
    """One tree. By names of groups in it, and identifiers of their sockets: what stands for those. By identifiers: what
    stands for sockets of the group that the tree itself is."""

    path: Path
    nodes: dict[str, bpy.types.Node]
    entries: dict[str, dict[str, list[Socket]]]
    exits: dict[str, dict[str, Socket]]
    given: dict[str, list[Socket]]
    wanted: dict[str, Socket]


def flattened(world: bpy.types.World) -> FlatTree:
    """All that a world shows; sockets of types that cannot be passed on become nodes of kinds that do not exist."""
    maker = getattr(bpy.types, "InlineShaderNodes", None)
    inlined = maker.from_world(world) if maker else None
    tree = inlined.node_tree if inlined else world.node_tree
    output = tree.get_output_node("CYCLES")
    flat = FlatTree(TreeData({}, ()), {}, (output.name,) if output else None, inlined)
    links = _add(flat, _Level((), dict(tree.nodes.items()), {}, {}, {}, {}), describe(tree))
    return flat._replace(data=TreeData(flat.data.nodes, tuple(_followed(flat.data.nodes, links))))


def _followed(nodes: dict[Name, NodeData], links: list[tuple]) -> list[tuple]:
    """Those that Cycles follows: a socket of a group that gets nothing leaves a texture its own coordinates."""
    origins = {end: start for start, _output, end, _place in links if isinstance(end, Socket)}

    def gets_nothing(name: Name) -> bool:
        while name in origins:
            name = origins[name]
        return isinstance(name, Socket)

    return [
        link
        for link in links
        if not (nodes[link[2]].kind.startswith(_TEXTURE) and link[3] == 0 and gets_nothing(link[0]))
    ]


def _add(flat: FlatTree, level: _Level, data: TreeData) -> list[tuple]:
    """Adds the nodes of a tree, and of groups in it; returns the links."""
    nodes, links = flat.data.nodes, []
    for name, node in level.nodes.items():
        path = (*level.path, name)
        if node.type in _GROUPS:
            links += _add_group(flat, level, node)
        elif node.bl_idname == _RESULT:
            for socket in node.inputs if node.is_active_output else ():
                if socket.identifier in level.wanted:  # what it is where nothing is linked
                    nodes[level.wanted[socket.identifier]] = _passing(socket, socket)
        elif node.bl_idname != _GIVEN and name in data.nodes:
            nodes[path], flat.sources[path] = data.nodes[name], node
    for from_node, output, to_node, place in data.links:
        for start in _starts(level, level.nodes[from_node], output):
            links += [(*start, *end) for end in _ends(level, level.nodes[to_node], place)]
    return links


def _add_group(flat: FlatTree, level: _Level, group: bpy.types.Node) -> list[tuple]:
    """Adds nodes for a group's sockets, and those in it; returns their links."""
    path = (*level.path, group.name)
    entries, exits = defaultdict(list), {}
    level.entries[group.name], level.exits[group.name] = entries, exits

    def add(socket: bpy.types.NodeSocket, default: bpy.types.NodeSocket | None) -> Socket:
        name = Socket(path, socket.is_output, socket.identifier)
        flat.data.nodes[name], flat.sources[name] = _passing(socket, default), group
        return name

    if group.mute:
        for link in group.internal_links:
            exits[link.to_socket.identifier] = add(link.to_socket, link.from_socket)
            entries[link.from_socket.identifier].append(exits[link.to_socket.identifier])
        return []
    for socket in group.inputs:
        entries[socket.identifier].append(add(socket, socket))
    for socket in group.outputs:
        exits[socket.identifier] = add(socket, None)
    if not group.node_tree:
        return []
    inside = _Level(path, dict(group.node_tree.nodes.items()), {}, {}, entries, exits)
    return _add(flat, inside, describe(group.node_tree))


def _starts(level: _Level, node: bpy.types.Node, output: int) -> list[tuple]:
    """What a link from an output starts at: nothing, or a node and the place of its output."""
    identifier = node.outputs[output].identifier
    if node.bl_idname == _GIVEN:
        return [(socket, 0) for socket in level.given.get(identifier, ())]
    if node.type in _GROUPS:
        exits = level.exits[node.name]
        return [(exits[identifier], 0)] if identifier in exits else []
    return [((*level.path, node.name), output)]


def _ends(level: _Level, node: bpy.types.Node, place: int) -> list[tuple]:
    """Where a link to an input ends: at nodes and places of their inputs."""
    identifier = node.inputs[place].identifier
    if node.bl_idname == _RESULT:
        is_shown = node.is_active_output and identifier in level.wanted
        return [(level.wanted[identifier], 0)] if is_shown else []
    if node.type in _GROUPS:
        return [(socket, 0) for socket in level.entries[node.name].get(identifier, ())]
    return [((*level.path, node.name), place)]


def _passing(socket: bpy.types.NodeSocket, default: bpy.types.NodeSocket | None) -> NodeData:
    """A node that passes on what a socket gets: if nothing, the value of `default`; None: zero."""
    if socket.type not in _PASSING:
        return NodeData(socket.bl_idname, {}, ())
    kind, settings, second = _PASSING[socket.type]
    return NodeData(kind, settings, (_value(socket.type, getattr(default, "default_value", 0.0)), second))


def _value(kind: str, value: Any) -> Any:
    """A socket's value as an input of the type `kind` takes it."""
    if kind == "SHADER":
        return None
    if kind in ("VECTOR", "RGBA"):
        parts = tuple(value) if hasattr(value, "__len__") else (value,) * 3
        return (*parts, 0.0, 0.0)[:3] if kind == "VECTOR" else (*parts, 1.0)[:4]
    return float(value) if not hasattr(value, "__len__") else float(value[0])
