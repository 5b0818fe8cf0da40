"""Shader AOVs: what AOV Output nodes write to passes that the user names."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

from .nodes.compiler import Compiler, Scope

if TYPE_CHECKING:
    import bpy


def valid_aovs(view_layer: bpy.types.ViewLayer) -> list[tuple[str, str]]:
    """Name and type, 'COLOR' or 'VALUE', of the passes that a view layer has, in the order of the core."""
    return [(aov.name, aov.type) for aov in view_layer.aovs if aov.is_valid]


def compile_aovs(compiler: Compiler, tree: Any, aovs: Sequence[tuple[str, str]]) -> None:
    """What the AOV Output nodes of a tree, and of the groups in it, write to those passes."""
    wanted = {name: (index, kind) for index, (name, kind) in enumerate(aovs)}
    for scope, node in _outputs(tree, Scope()) if wanted else ():
        if node.aov_name in wanted:
            index, kind = wanted[node.aov_name]
            socket = node.inputs["Color" if kind == "COLOR" else "Value"]
            compiler.emit("aov", compiler.value(scope, socket), immediates=(index,))


def _outputs(tree: Any, scope: Scope) -> Iterator[tuple[Scope, Any]]:
    for node in tree.nodes:
        if node.bl_idname == "ShaderNodeOutputAOV" and not node.mute:
            yield scope, node
        elif node.bl_idname == "ShaderNodeGroup" and node.node_tree and not node.mute:
            yield from _outputs(node.node_tree, Scope(node, scope))
