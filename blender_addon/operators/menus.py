"""Bentlight's entries in Blender's menus; what is in a menu is found by the menu search (F3) too."""

import bpy

from ..compatibility import ENGINE
from .add import BENTLIGHT_OT_black_hole_add, BENTLIGHT_OT_exit_add, BENTLIGHT_OT_wormhole_add
from .preset import BENTLIGHT_MT_spacetime_presets


class BENTLIGHT_MT_spacetime(bpy.types.Menu):
    """What can be done with a black hole or a wormhole"""

    bl_label = "Spacetime"

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        layout.menu(BENTLIGHT_MT_spacetime_presets.__name__)
        layout.operator("bentlight.spacetime_reset", icon="LOOP_BACK")
        layout.separator()
        layout.operator("bentlight.unit_scale_fit", icon="SNAP_INCREMENT")
        layout.operator(BENTLIGHT_OT_exit_add.bl_idname, icon="LINKED")


def _draw_add(self: bpy.types.Menu, context: bpy.types.Context) -> None:
    layout = self.layout
    layout.separator()
    layout.operator(BENTLIGHT_OT_black_hole_add.bl_idname, icon="SHADING_SOLID")
    layout.operator(BENTLIGHT_OT_wormhole_add.bl_idname, icon="SHADING_WIRE")


def _draw_object(self: bpy.types.Menu, context: bpy.types.Context) -> None:
    self.layout.separator()
    self.layout.menu(BENTLIGHT_MT_spacetime.__name__, icon="SHADING_SOLID")


def _draw_render(self: bpy.types.Menu, context: bpy.types.Context) -> None:
    layout = self.layout
    layout.separator()
    if context.engine == "CYCLES":
        layout.operator("bentlight.cycles_setup", text="Use Black Holes in Cycles", icon="SHADING_SOLID")
        layout.operator("bentlight.cycles_clear")
        layout.operator("bentlight.relay_setup", icon="CAMERA_DATA")
        layout.operator("bentlight.relay_clear")
    elif context.engine == ENGINE:
        layout.operator("bentlight.denoise_setup", icon="SHADERFX")
    layout.operator("bentlight.render_reset", icon="LOOP_BACK")
    layout.operator("bentlight.stars_reset")


_ENTRIES = (("VIEW3D_MT_add", _draw_add), ("VIEW3D_MT_object", _draw_object), ("TOPBAR_MT_render", _draw_render))


def register() -> None:
    """Adds the entries."""
    bpy.utils.register_class(BENTLIGHT_MT_spacetime)
    for menu, draw in _ENTRIES:
        getattr(bpy.types, menu).append(draw)


def unregister() -> None:
    """Removes them."""
    for menu, draw in _ENTRIES:
        getattr(bpy.types, menu).remove(draw)
    bpy.utils.unregister_class(BENTLIGHT_MT_spacetime)
