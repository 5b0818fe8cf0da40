"""The viewport's switches, in the popover of its overlays."""

from __future__ import annotations

import bpy


class BENTLIGHT_PT_overlay(bpy.types.Panel):
    """What is drawn of black holes and wormholes over the scene."""

    bl_label = "Black Holes and Wormholes"
    bl_space_type = "VIEW_3D"
    bl_region_type = "HEADER"
    bl_parent_id = "VIEW3D_PT_overlay"

    def draw(self, context: bpy.types.Context) -> None:
        settings = context.scene.bentlight.overlay
        layout = self.layout
        layout.active = context.space_data.overlay.show_overlays
        columns = layout.column_flow(columns=2)
        columns.prop(settings, "show_circles")
        names = columns.column()
        names.active = settings.show_circles
        names.prop(settings, "show_labels")
        rays = layout.split(factor=0.2)
        rays.label(text="Rays")
        rays.row(align=True).prop(settings, "rays", expand=True)
        count = layout.row()
        count.active = settings.rays != "OFF"
        count.prop(settings, "ray_count")


CLASSES = (BENTLIGHT_PT_overlay,)
