"""The panels of motion blur: the shutter, in the render properties, and what stands still, in those of objects."""

from __future__ import annotations

import bpy

from .panel import EnginePanel


class BENTLIGHT_PT_motion_blur(EnginePanel, bpy.types.Panel):
    """When the shutter is open, and in how many moments."""

    bl_label = "Motion Blur"
    bl_context = "render"
    bl_options = {"DEFAULT_CLOSED"}

    def draw_header(self, context: bpy.types.Context) -> None:
        self.layout.prop(context.scene.render, "use_motion_blur", text="")

    def draw(self, context: bpy.types.Context) -> None:
        render = context.scene.render
        column = self.column()
        column.active = render.use_motion_blur
        column.prop(render, "motion_blur_position", text="Position")
        column.prop(render, "motion_blur_shutter")
        column.prop(context.scene.bentlight, "motion_slices")


class BENTLIGHT_PT_motion_blur_curve(EnginePanel, bpy.types.Panel):
    """How far the shutter is open."""

    bl_label = "Shutter Curve"
    bl_context = "render"
    bl_parent_id = "BENTLIGHT_PT_motion_blur"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        column = self.column()
        column.active = context.scene.render.use_motion_blur
        column.template_curve_mapping(context.scene.render, "motion_blur_shutter_curve")


class BENTLIGHT_PT_object_motion_blur(EnginePanel, bpy.types.Panel):
    """Whether an object moves while the shutter is open: by Cycles' own switches."""

    bl_label = "Motion Blur"
    bl_context = "object"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return super().poll(context) and hasattr(context.object, "cycles")  # unless its add-on is switched off

    def draw_header(self, context: bpy.types.Context) -> None:
        self.layout.active = context.scene.render.use_motion_blur
        self.layout.prop(context.object.cycles, "use_motion_blur", text="")

    def draw(self, context: bpy.types.Context) -> None:
        settings = context.object.cycles
        column = self.column()
        column.active = context.scene.render.use_motion_blur and settings.use_motion_blur
        if context.object.type != "CAMERA":
            column.prop(settings, "use_deform_motion", text="Deformation")


CLASSES = (BENTLIGHT_PT_motion_blur, BENTLIGHT_PT_motion_blur_curve, BENTLIGHT_PT_object_motion_blur)
