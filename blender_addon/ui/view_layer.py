"""The panels of the view layer's properties: which passes there are."""

from __future__ import annotations

import bpy

from .panel import EnginePanel


class BENTLIGHT_PT_passes(EnginePanel, bpy.types.Panel):
    """What else than the picture a view layer delivers."""

    bl_label = "Data"
    bl_context = "view_layer"
    bl_parent_id = "VIEWLAYER_PT_layer_passes"

    def draw(self, context: bpy.types.Context) -> None:
        layer = context.view_layer
        is_blurred = context.scene.render.use_motion_blur and layer.use_motion_blur
        for group in (
            (
                (layer, "use_pass_combined", "Combined"),
                (layer, "use_pass_z", "Depth"),
                (layer, "use_pass_mist", "Mist"),
                (layer, "use_pass_position", "Position"),
                (layer, "use_pass_normal", "Normal"),
                (layer, "use_pass_vector", "Vector"),
                (layer, "use_pass_uv", "UV"),
                (layer.bentlight, "use_pass_denoising", "Denoising Data"),
            ),
            (
                (layer, "use_pass_object_index", "Object Index"),
                (layer, "use_pass_material_index", "Material Index"),
            ),
            ((layer.bentlight, "use_pass_sample_count", "Sample Count"),),
        ):
            column = self.column()
            for owner, name, text in group:
                row = column.row()
                row.active = name != "use_pass_vector" or not is_blurred
                row.prop(owner, name, text=text)
        self.layout.prop(layer, "pass_alpha_threshold")


class BENTLIGHT_PT_passes_light(EnginePanel, bpy.types.Panel):
    """Light by what scatters it towards the camera."""

    bl_label = "Light"
    bl_context = "view_layer"
    bl_parent_id = "VIEWLAYER_PT_layer_passes"

    def draw(self, context: bpy.types.Context) -> None:
        layer = context.view_layer
        for kind in ("Diffuse", "Glossy", "Transmission"):
            column = self.column()
            column = column.column(heading=kind, align=True)
            for part in ("Direct", "Indirect", "Color"):
                column.prop(layer, f"use_pass_{kind.lower()}_{part.lower()}", text=part)
        column = self.column().column(heading="Other", align=True)
        column.prop(layer, "use_pass_emit", text="Emission")
        column.prop(layer, "use_pass_environment", text="Environment")
        column.prop(layer, "use_pass_ambient_occlusion", text="Ambient Occlusion")


class BENTLIGHT_PT_passes_spacetime(EnginePanel, bpy.types.Panel):
    """What only curved light has."""

    bl_label = "Spacetime"
    bl_context = "view_layer"
    bl_parent_id = "VIEWLAYER_PT_layer_passes"

    def draw(self, context: bpy.types.Context) -> None:
        column = self.column()
        for name in ("deflection", "frequency_shift", "image_order", "winding", "disk", "fate", "error"):
            column.prop(context.view_layer.bentlight, f"use_pass_{name}")


CLASSES = (
    BENTLIGHT_PT_passes,
    BENTLIGHT_PT_passes_light,
    BENTLIGHT_PT_passes_spacetime,
)
