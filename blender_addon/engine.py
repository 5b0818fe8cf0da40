"""The render engine: every callback that Blender makes, delegated."""

from __future__ import annotations

import weakref

import bpy

from . import final, passes, viewport
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

    def view_update(self, context: bpy.types.Context, depsgraph: bpy.types.Depsgraph) -> None:
        """The scene of a viewport in Rendered shading has changed, or the viewport has just begun."""
        self._viewport_of(depsgraph).update(self, depsgraph)

    def view_draw(self, context: bpy.types.Context, depsgraph: bpy.types.Depsgraph) -> None:
        """Draws such a viewport."""
        self._viewport_of(depsgraph).draw(self, context, depsgraph)

    def _viewport_of(self, depsgraph: bpy.types.Depsgraph) -> viewport.Viewport:
        """Made when it is first needed: Blender calls __init__ twice, and for final renders too."""
        if getattr(self, "viewport", None) is None:
            self.viewport = viewport.Viewport(self, depsgraph.scene_eval.render.threads)
            weakref.finalize(self, self.viewport.close)  # __del__ may come when Blender's side of self is gone already
        return self.viewport


def register() -> None:
    """Makes the engine known to Blender."""
    bpy.utils.register_class(BentlightRenderEngine)


def unregister() -> None:
    """Takes it back."""
    bpy.utils.unregister_class(BentlightRenderEngine)
