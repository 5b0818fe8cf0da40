"""Denoising in one click: Blender's Denoise node in the compositor, guided by Bentlight's passes."""

from __future__ import annotations

import bpy
from bpy.app.translations import pgettext_rpt as rpt_

from ..compatibility import ENGINE


def find_nodes(scene: bpy.types.Scene) -> list[bpy.types.Node]:
    """The Denoise nodes that a rendered picture of this scene goes into first."""
    tree = _tree(scene)
    return [
        link.to_node
        for node in (_picture_nodes(tree, scene) if tree else ())
        for link in node.outputs["Image"].links
        if link.to_node.type == "DENOISE"
    ]


def set_up(scene: bpy.types.Scene) -> int:
    """Puts such a node behind each picture that has none, and keeps all else that is there; returns how many."""
    tree = _tree(scene) or _make_tree(scene)
    if not _picture_nodes(tree, scene):
        _show(tree, tree.nodes.new("CompositorNodeRLayers"))
    added = [node for node in _picture_nodes(tree, scene) if not _is_denoised(node)]
    for node in added:
        _denoise(tree, node, scene.view_layers.get(node.layer) or scene.view_layers[0])
    scene.render.use_compositing = True
    return len(added)


def _tree(scene: bpy.types.Scene) -> bpy.types.NodeTree | None:
    """The compositor in use."""
    if hasattr(scene, "compositing_node_group"):  # Blender 5
        return scene.compositing_node_group
    return scene.node_tree if scene.use_nodes else None


def _make_tree(scene: bpy.types.Scene) -> bpy.types.NodeTree:
    if not hasattr(scene, "compositing_node_group"):
        scene.use_nodes = True  # Blender 4 makes one that shows the picture, unless there has been one before
        return scene.node_tree
    tree = scene.compositing_node_group = bpy.data.node_groups.new("Compositing", "CompositorNodeTree")
    tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
    tree.nodes.new("NodeGroupOutput").location = 600, 0
    return tree


def _show(tree: bpy.types.NodeTree, source: bpy.types.Node) -> None:
    """Makes a picture the compositor's, unless there is another one."""
    for node in tree.nodes:
        if node.type in {"COMPOSITE", "GROUP_OUTPUT"} and len(node.inputs) > 0 and not node.inputs[0].is_linked:
            tree.links.new(source.outputs["Image"], node.inputs[0])


def _picture_nodes(tree: bpy.types.NodeTree, scene: bpy.types.Scene) -> list[bpy.types.Node]:
    return [node for node in tree.nodes if node.type == "R_LAYERS" and node.scene in {None, scene}]


def _is_denoised(node: bpy.types.Node) -> bool:
    return any(link.to_node.type == "DENOISE" for link in node.outputs["Image"].links)


def _denoise(tree: bpy.types.NodeTree, source: bpy.types.Node, layer: bpy.types.ViewLayer) -> None:
    """Gives all that a Render Layers node's picture went to what a new Denoise node makes of it."""
    layer.bentlight.use_pass_denoising = True
    layer.update_render_passes()
    targets = [link.to_socket for link in source.outputs["Image"].links]
    node = tree.nodes.new("CompositorNodeDenoise")
    node.location = source.location.x + 300, source.location.y
    for name, output in (("Image", "Image"), ("Albedo", "Denoising Albedo"), ("Normal", "Denoising Normal")):
        tree.links.new(source.outputs[output], node.inputs[name])
    for target in targets:
        tree.links.new(node.outputs["Image"], target)


class BENTLIGHT_OT_denoise_setup(bpy.types.Operator):
    """Put a Denoise node behind the picture in the compositor, and switch on the passes that guide it"""

    bl_idname = "bentlight.denoise_setup"
    bl_label = "Denoise in Compositor"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.engine == ENGINE

    def execute(self, context: bpy.types.Context) -> set[str]:
        text = rpt_("Denoise nodes added in the compositor: {}").format(set_up(context.scene))
        self.report({"INFO"}, text)
        return {"FINISHED"}


register, unregister = bpy.utils.register_classes_factory((BENTLIGHT_OT_denoise_setup,))
