"""The panel that Bentlight adds to Cycles' render properties."""

from __future__ import annotations

import bpy

from ..cycles import setup


class BENTLIGHT_PT_cycles(bpy.types.Panel):
    """Lenses for Cycles."""

    bl_label = "Bentlight"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "render"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.engine == "CYCLES" and any(obj.bentlight.kind != "NONE" for obj in context.scene.objects)

    def draw(self, context: bpy.types.Context) -> None:
        column = self.layout.column()
        ready = setup.is_set_up(context.scene)
        column.operator("bentlight.cycles_setup", text="Update Lenses" if ready else "Use in Cycles")
        if ready:
            column.operator("bentlight.cycles_clear")
            column.label(text="Lamps do not shine through lenses", icon="INFO")


CLASSES = (BENTLIGHT_PT_cycles,)
