"""Simplify, drawn by Blender's own panels, which cannot be shown below ours: theirs would be the topmost of the tab."""

from __future__ import annotations

import bpy
from bl_ui import properties_render

from .panel import EnginePanel


class BENTLIGHT_PT_simplify(EnginePanel, bpy.types.Panel):
    """Coarser meshes and fewer particles."""

    bl_label = "Simplify"
    bl_context = "render"
    bl_options = {"DEFAULT_CLOSED"}

    draw_header = properties_render.RENDER_PT_simplify.draw_header
    draw = properties_render.RENDER_PT_simplify.draw


class BENTLIGHT_PT_simplify_viewport(EnginePanel, bpy.types.Panel):
    """How coarse things are in the viewport."""

    bl_label = "Viewport"
    bl_context = "render"
    bl_parent_id = "BENTLIGHT_PT_simplify"

    draw = properties_render.RENDER_PT_simplify_viewport.draw


class BENTLIGHT_PT_simplify_render(EnginePanel, bpy.types.Panel):
    """How coarse things are in renders."""

    bl_label = "Render"
    bl_context = "render"
    bl_parent_id = "BENTLIGHT_PT_simplify"

    draw = properties_render.RENDER_PT_simplify_render.draw


CLASSES = (BENTLIGHT_PT_simplify, BENTLIGHT_PT_simplify_viewport, BENTLIGHT_PT_simplify_render)
