"""Use in Cycles, and its undoing."""

from __future__ import annotations

import bpy

from ..report import RenderError, told
from . import failures, setup


class BENTLIGHT_OT_cycles_setup(bpy.types.Operator):
    """Make black holes and wormholes bend light in Cycles: adds a lens around each, and sets what that needs"""

    bl_idname = "bentlight.cycles_setup"
    bl_label = "Use in Cycles"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context: bpy.types.Context) -> set[str]:
        try:
            done, warnings = setup.setup(context.scene, context.evaluated_depsgraph_get())
        except RenderError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        failures.forget(context.scene, "lenses")
        self.report({"INFO"}, told("Ready for Cycles: {}", "; ".join(done)))
        for text in warnings:
            self.report({"WARNING"}, text)
        return {"FINISHED"}


class BENTLIGHT_OT_cycles_clear(bpy.types.Operator):
    """Take back what Use in Cycles has done: remove the lenses and restore Cycles' settings"""

    bl_idname = "bentlight.cycles_clear"
    bl_label = "Remove from Cycles"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return setup.is_set_up(context.scene)

    def execute(self, context: bpy.types.Context) -> set[str]:
        failures.forget(context.scene, "lenses")
        self.report({"INFO"}, "; ".join(setup.clear(context.scene)))
        return {"FINISHED"}


_CLASSES = (BENTLIGHT_OT_cycles_setup, BENTLIGHT_OT_cycles_clear)

register, unregister = bpy.utils.register_classes_factory(_CLASSES)
