"""Walks a node tree and writes a program; knows links, groups, reroutes and socket types, but no particular node.

Of bpy it needs the version alone. A family of nodes adds itself by the two decorators below, keyed by
`Node.bl_idname`; to add a node is one function there and one operation in the core.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import bpy
from bentlight_native import ProgramBuilder

from ...report import told
from ..attributes import AttributeKey, AttributeTable
from ..images import ImageTable

Outputs = dict[str, int]  # identifier of an output socket -> operand
NUMBERS = {"VALUE", "INT", "BOOLEAN"}  # socket types that are one number

VALUE_NODES: dict[str, Callable[[NodeView], Outputs]] = {}
SHADER_NODES: dict[str, Callable[[NodeView, int], None]] = {}


def value_node(*idnames: str) -> Callable:
    """Registers `function(node) -> Outputs`, which returns an operand for each output socket, by identifier."""

    def register(function: Callable[[NodeView], Outputs]) -> Callable:
        VALUE_NODES.update(dict.fromkeys(idnames, function))
        return function

    return register


def shader_node(*idnames: str) -> Callable:
    """Registers `function(node, weight) -> None`, which emits the node's closures times the operand `weight`."""

    def register(function: Callable[[NodeView, int], None]) -> Callable:
        SHADER_NODES.update(dict.fromkeys(idnames, function))
        return function

    return register


@dataclass(frozen=True)
class Scope:
    """Where in the nesting of groups: the group node that was entered, and the scope in which it stands."""

    group: Any = None
    outer: Scope | None = None

    @property
    def path(self) -> tuple[str, ...]:
        """Names of the groups around, from the outermost."""
        return (*self.outer.path, self.group.name) if self.outer else ()


@dataclass
class Compiler:
    """One material, world or lamp on its way to a program. `owner` names it in warnings, as in "Material 'Wall'";
    `version` is Blender's: some nodes have changed. `coordinates`: by kind, what makes those that a lamp has instead of
    the core's; `given`: the operands of attributes that the surface itself brings, by name."""

    owner: str
    images: ImageTable
    version: tuple[int, ...]
    material_index: int = 0  # the pass index of a material
    builder: ProgramBuilder = field(default_factory=ProgramBuilder)
    warnings: list[str] = field(default_factory=list)
    attributes: AttributeTable = field(default_factory=AttributeTable)
    wanted: dict[int, AttributeKey] = field(default_factory=dict)  # attributes that nodes ask for, by number
    coordinates: dict[str, Callable[[], int]] = field(default_factory=dict)
    given: dict[str, int] = field(default_factory=dict)
    _weights: dict[tuple, int] = field(default_factory=dict)  # of shader nodes that are still to be emitted
    _values: dict[tuple, Outputs] = field(default_factory=dict)
    _entered: list[tuple] = field(default_factory=list)
    side: tuple[str, int] | None = None  # axis and filter width of the step beside the point that is compiled for

    @property
    def luminance(self) -> tuple[float, float, float]:
        """Weighs the channels of a linear Rec. 709 color that becomes a number."""
        if self.version >= (5, 0):
            return 0.2126390059, 0.7151686788, 0.0721923154
        return 0.2126729, 0.7151522, 0.0721750

    def warn(self, node: Any, text: str, *values: object) -> None:
        """Adds a warning that names the owner and the node, once."""
        message = told("{}, node '{}': {}", self.owner, node.name, told(text, *values))
        if message not in self.warnings:
            self.warnings.append(message)

    def emit(self, operation: str, *operands: int, immediates: tuple = ()) -> int:
        """An instruction; its first output."""
        return (*self.builder.emit(operation, *operands, immediates=immediates), 0)[0]

    def surface(self, socket: Any, weight: int | None = None) -> None:
        """Emits what is linked to a surface input, times the operand `weight` (None: 1). Each shader node comes once,
        with the sum of the weights of all ways that lead to it, so that a program is never longer than its tree."""
        self.shade(Scope(), socket, self.builder.constant(1.0) if weight is None else weight)
        for source in shaders_behind(Scope(), socket):
            weight = self._weights.pop(source.key, None)
            function = SHADER_NODES.get(source.node.bl_idname, NodeView.unsupported)
            if weight is not None:
                function(NodeView(self, source.scope, source.node), weight)

    def shade(self, scope: Scope, socket: Any, weight: int) -> None:
        """Adds `weight` to what is linked to a shader input. A color there emits light, as in Cycles."""
        source = origin(scope, socket)
        if source.node is None or self.builder.value_of(weight) == (0.0, 0.0, 0.0):
            return
        if source.socket.type == "SHADER":
            one, others = self.builder.constant(1.0), self._weights.get(source.key)
            total = weight if others is None else self.emit("blend", one, others, weight, immediates=("ADD",))
            self._weights[source.key] = total
        else:
            color = self._value_of(source, "RGBA", (0.0, 0.0, 0.0))
            self.emit("emission", weight, color, self.builder.constant(1.0))

    def value(self, scope: Scope, socket: Any, unlinked: Callable[[], int] | None = None) -> int:
        """The operand of an input socket, converted to its type; `unlinked` replaces its own value."""
        source = origin(scope, socket)
        if source.node is not None:
            return self._value_of(source, socket.type, socket_value(socket))
        if unlinked is not None and source.socket is socket:
            return unlinked()
        return self._convert(self.builder.constant(socket_value(source.socket)), source.socket.type, socket.type)

    @contextmanager
    def beside(self, side: tuple[str, int] | None) -> Iterator[None]:
        """Within it, coordinates and attributes are those of a place beside the point, by a step along the axis "X" or
        "Y" that is an operand wide. None: of the point itself."""
        self.side, before = side, self.side
        yield
        self.side = before

    def _value_of(self, source: Origin, wanted: str, fallback: Any) -> int:
        node, name, key = source.node, source.node.bl_label, (self.side, *source.key)
        if key not in self._values:
            function = VALUE_NODES.get(node.bl_idname)
            if function is None or key in self._entered:
                self.warn(node, "'{}' is not supported yet; a constant is used instead", name)
                return self.builder.constant(fallback)
            self._entered.append(key)
            self._values[key] = function(NodeView(self, source.scope, node))
            self._entered.pop()
        operand = self._values[key].get(source.socket.identifier)
        if operand is None:
            self.warn(node, "'{}' of '{}' is not supported yet; a constant is used instead", source.socket.name, name)
            return self.builder.constant(fallback)
        return self._convert(operand, source.socket.type, wanted)

    def _convert(self, operand: int, have: str, wanted: str) -> int:
        if wanted in NUMBERS and have == "RGBA":
            return self.emit("dot", operand, self.builder.constant(self.luminance))
        if wanted in NUMBERS and have not in NUMBERS:
            return self.emit("average", operand)
        return operand


@dataclass(frozen=True)
class NodeView:
    """A node as the functions of its family see it."""

    compiler: Compiler
    scope: Scope
    node: Any

    def socket(self, identifier: str) -> Any:
        """The input socket of that identifier, or None (older and newer Blenders have more or fewer)."""
        return _by_identifier(self.node.inputs, identifier)

    def input(self, identifier: str, unlinked: Callable[[], int] | None = None) -> int:
        """The operand of an input; `unlinked` makes one if nothing is linked to it."""
        return self.compiler.value(self.scope, self.socket(identifier), unlinked)

    def normal(self, identifier: str = "Normal") -> int:
        """The operand of a normal input: the shading normal if nothing is linked."""
        return self.input(identifier, lambda: self.coordinate("SHADING_NORMAL"))

    def shade(self, identifier: str, weight: int) -> None:
        """Emits the closures linked to a shader input."""
        self.compiler.shade(self.scope, self.socket(identifier), weight)

    def is_default(self, identifier: str, value: float) -> bool:
        """Whether an input has no link and that value, or does not exist."""
        socket = self.socket(identifier)
        return socket is None or (not socket.is_linked and abs(socket.default_value - value) < 1e-6)

    def constant(self, value: Any) -> int:
        """The operand of a number or of three."""
        return self.compiler.builder.constant(value)

    def coordinate(self, kind: str) -> int:
        """One of the core's coordinates of the point, or what stands for it on a lamp."""
        instead = self.compiler.coordinates.get(kind)
        return instead() if instead else self._read("coordinate", kind)

    def attribute(self, kind: str, name: str = "") -> int:
        """An attribute of the mesh or the instance: vector, number and alpha follow each other."""
        key = AttributeKey(kind, name)
        number = self.compiler.attributes.index_of(key)
        self.compiler.wanted[number] = key
        return self._read("attribute", number)

    def _read(self, operation: str, what: str | int) -> int:
        if self.compiler.side is None:
            return self.emit(operation, immediates=(what,))
        axis, width = self.compiler.side
        return self.emit(f"{operation}_beside", width, immediates=(what, axis))

    def emit(self, operation: str, *operands: int, immediates: tuple = ()) -> int:
        """An instruction; its first output, which the others follow."""
        return self.compiler.emit(operation, *operands, immediates=immediates)

    def unsupported(self, weight: int) -> None:
        """A diffuse surface of the node's color stands for a shader that is not known."""
        self.warn("'{}' is not supported yet; a diffuse surface is used instead", self.node.bl_label)
        color = self.input("Color") if "Color" in self.node.inputs else self.constant(0.8)
        self.emit("diffuse", weight, color, self.constant(0.0), self.coordinate("SHADING_NORMAL"))

    def warn(self, text: str, *values: object) -> None:
        """A warning that names owner and node."""
        self.compiler.warn(self.node, text, *values)


@dataclass(frozen=True)
class Origin:
    """What an input takes its value from: an output of `node`, or with node None the value of `socket` itself."""

    scope: Scope
    node: Any
    socket: Any

    @property
    def key(self) -> tuple[str, ...]:
        """Tells apart the nodes of all groups."""
        return (*self.scope.path, self.node.name)


def origin(scope: Scope, socket: Any) -> Origin:
    """Follows the link of an input socket through reroutes, muted nodes and into and out of groups. What a muted node
    passes nothing on to keeps its own value; so does, from Blender 5.0 on, what a reroute does that gets nothing."""
    own = socket
    while True:
        link = next((link for link in socket.links if link.is_valid and not link.is_muted), None)
        if link is None:
            return Origin(scope, None, own)
        node, output = link.from_node, link.from_socket
        if node.bl_idname == "NodeReroute":
            socket = node.inputs[0]
            own = own if bpy.app.version >= (5, 0, 0) else socket
            continue
        if node.mute:
            inside = next((i for i in node.internal_links if i.to_socket == output), None)
            if inside is None:
                return Origin(scope, None, own)
            socket = inside.from_socket
        elif node.bl_idname == "ShaderNodeGroup" and node.node_tree:
            inner = _by_identifier(_group_outputs(node.node_tree), output.identifier)
            if inner is None:
                return Origin(scope, None, output)
            scope, socket = Scope(node, scope), inner
        elif node.bl_idname == "NodeGroupInput" and scope.outer:
            socket, scope = _by_identifier(scope.group.inputs, output.identifier), scope.outer
        else:
            return Origin(scope, node, output)
        own = socket


def shaders_behind(scope: Scope, socket: Any) -> list[Origin]:
    """The shader nodes that a shader input leads to, each before those that it leads to itself."""
    found, seen = [], set()
    stack = [(origin(scope, socket), False)]
    while stack:
        source, is_finished = stack.pop()
        if is_finished:
            found.append(source)
        elif source.node is not None and source.socket.type == "SHADER" and source.key not in seen:
            seen.add(source.key)
            stack.append((source, True))
            inputs = [socket for socket in source.node.inputs if socket.type == "SHADER"]
            stack.extend((origin(source.scope, socket), False) for socket in inputs)
    return found[::-1]


def socket_value(socket: Any) -> Any:
    """A socket's own value: a number, or three. Sockets without one (shaders) are 0."""
    value = getattr(socket, "default_value", 0.0)
    return tuple(value)[:3] if hasattr(value, "__len__") else float(value)


def _by_identifier(sockets: Any, identifier: str) -> Any:
    return next((socket for socket in sockets if socket.identifier == identifier), None)


def _group_outputs(tree: Any) -> Any:
    ends = [node for node in tree.nodes if node.bl_idname == "NodeGroupOutput"]
    active = [node for node in ends if node.is_active_output] or ends
    return active[0].inputs if active else ()
