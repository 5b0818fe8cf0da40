"""The render engine: every callback that Blender makes, delegated."""

from __future__ import annotations

import bpy

from . import final, passes
from .compatibility import ENGINE


class BentlightRenderEngine(bpy.types.RenderEngine):
    """Path tracing along the geodesics of black holes and wormholes."""

    bl_idname = ENGINE
    bl_label = "Bentlight"
    bl_use_preview = True
    bl_use_shading_nodes_custom = False
    bl_use_eevee_viewport = True  # Material Preview shading
    bl_use_spherical_stereo = True

    def render(self, depsgraph: bpy.types.Depsgraph) -> None:
        """One frame of one view layer."""
        final.render(self, depsgraph)

    def update_render_passes(self, scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer) -> None:
        """What the compositor may connect to."""
        for item in passes.enabled(view_layer):
            self.register_pass(scene, view_layer, item.name, item.width, item.components, item.socket)


def register() -> None:
    """Makes the engine known to Blender."""
    bpy.utils.register_class(BentlightRenderEngine)


def unregister() -> None:
    """Takes it back."""
    bpy.utils.unregister_class(BentlightRenderEngine)
