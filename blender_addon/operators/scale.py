"""The scene's size, chosen so that a black hole weighs what it should."""

import bpy
from bpy.props import FloatProperty

from .. import scale
from ..properties_scale import meters_per_unit
from ..report import told

_LENGTHS = 1e-9, 1e9  # meters a unit may have, by Blender's own limits


class BENTLIGHT_OT_unit_scale_fit(bpy.types.Operator):
    """Set the scene's Unit Scale so that the active black hole has a mass, and stays as large as it is drawn"""

    bl_idname = "bentlight.unit_scale_fit"
    bl_label = "Fit Unit Scale to Mass"
    bl_options = {"REGISTER", "UNDO"}

    suns: FloatProperty(
        name="Solar Masses",
        description="What the black hole weighs in nature, in suns, from 1e-12 to 1e20; it looks the same",
        min=1e-12,
        max=1e20,
        default=10.0,
        options={"SKIP_SAVE"},
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        obj = context.object
        return obj is not None and obj.bentlight.kind == "BLACK_HOLE" and obj.bentlight.mass > 0

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Asks for the mass."""
        self.suns = context.object.bentlight.mass_suns
        return context.window_manager.invoke_props_dialog(self)

    def execute(self, context: bpy.types.Context) -> set[str]:
        units, hole = context.scene.unit_settings, context.object
        size = hole.bentlight.mass * meters_per_unit(hole) / units.scale_length
        if not size > 0:
            self.report({"ERROR"}, told("The object has scale 0"))
            return {"CANCELLED"}
        length = self.suns * scale.METERS_PER_SUN / size
        if not _LENGTHS[0] <= length <= _LENGTHS[1]:
            text = "One unit would be {:.3g} m long, and Blender allows 1e-9 to 1e9: make the hole larger"
            self.report({"ERROR"}, told(text, length))
            return {"CANCELLED"}
        units.scale_length = length
        self.report({"INFO"}, told("One unit is {:.6g} m long now", length))
        return {"FINISHED"}


register, unregister = bpy.utils.register_classes_factory((BENTLIGHT_OT_unit_scale_fit,))
