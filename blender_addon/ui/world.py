"""The panels of the world's properties."""

from __future__ import annotations

import bpy

from .panel import EnginePanel


class BENTLIGHT_PT_stars(EnginePanel, bpy.types.Panel):
    """Points of light in the sky."""

    bl_label = "Stars"
    bl_context = "world"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return super().poll(context) and context.world is not None

    def draw(self, context: bpy.types.Context) -> None:
        settings = context.world.bentlight
        column = self.column()
        column.prop(settings, "stars")
        if settings.stars == "PROCEDURAL":
            for name in ("star_count", "star_seed", "star_brightest", "star_slope"):
                column.prop(settings, name)
        elif settings.stars == "CATALOG":
            column.prop(settings, "star_catalog")
        if settings.stars != "OFF":
            column.prop(settings, "star_strength")
            column.prop(settings, "star_rotation")
            self.layout.operator("bentlight.stars_reset", text="Reset to Defaults", icon="LOOP_BACK")


CLASSES = (BENTLIGHT_PT_stars,)
