"""The panels of the object's properties: what it does to light, its disk, and which rays see it."""

from __future__ import annotations

import bentlight_native
import bpy
from bpy.app.translations import pgettext_iface as iface_

from ..compatibility import ENGINE
from ..operators.preset import BENTLIGHT_PT_spacetime_presets
from ..report import RenderError
from ..sync.spacetime import core_radius, read_spacetime
from .influence import describe_influence
from .panel import EnginePanel, note, tell


class BENTLIGHT_PT_ray_visibility(EnginePanel, bpy.types.Panel):
    """Which rays see an object."""

    bl_label = "Ray Visibility"
    bl_context = "object"
    bl_parent_id = "OBJECT_PT_visibility"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return super().poll(context) and context.object.type != "CAMERA"

    def draw(self, context: bpy.types.Context) -> None:
        column = self.column()
        for name, text in (
            ("visible_camera", "Camera"),
            ("visible_diffuse", "Diffuse"),
            ("visible_glossy", "Glossy"),
            ("visible_transmission", "Transmission"),
            ("visible_shadow", "Shadow"),
        ):
            column.prop(context.object, name, text=text)
        column.prop(context.object, "is_holdout")


class BENTLIGHT_PT_spacetime(EnginePanel, bpy.types.Panel):
    """What an object does to light around it."""

    bl_label = "Spacetime"
    bl_context = "object"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.engine in {ENGINE, "CYCLES"} and context.object is not None

    def draw_header_preset(self, context: bpy.types.Context) -> None:
        BENTLIGHT_PT_spacetime_presets.draw_panel_header(self.layout)

    def draw(self, context: bpy.types.Context) -> None:
        settings = context.object.bentlight
        column = self.column()
        column.prop(settings, "kind")
        if settings.kind == "BLACK_HOLE":
            column.prop(settings, "mass")
            column.prop(settings, "spin")
            chart = column.column()
            chart.enabled = settings.spin == 0
            chart.prop(settings, "chart")
            if settings.spin and settings.chart == "ISOTROPIC":
                column.label(text="With spin, the oblate chart is used", icon="INFO")
        elif settings.kind == "WORMHOLE":
            column.prop(settings, "throat_radius")
            exit_row = column.row(align=True)
            exit_row.prop(settings, "exit")
            if settings.exit is None:
                exit_row.operator("bentlight.exit_add", text="", icon="ADD")
        if settings.kind != "NONE":
            self.layout.operator("bentlight.spacetime_reset", text="Reset to Defaults", icon="LOOP_BACK")


class BENTLIGHT_PT_influence(EnginePanel, bpy.types.Panel):
    """How far an object bends light."""

    bl_label = "Sphere of Influence"
    bl_context = "object"
    bl_parent_id = "BENTLIGHT_PT_spacetime"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return BENTLIGHT_PT_spacetime.poll(context) and context.object.bentlight.kind != "NONE"

    def draw(self, context: bpy.types.Context) -> None:
        settings = context.object.bentlight
        column = self.column()
        column.prop(settings, "sphere_radius", text="Radius")
        if context.engine == "CYCLES":
            column.prop(settings, "lens_radius")
            row = column.row()
            row.active = settings.lens_radius > 0
            row.prop(settings, "lens_soft_edge")
        self._draw_use(context)

    def _draw_use(self, context: bpy.types.Context) -> None:
        """The sphere in use and what it costs; or why this cannot be rendered."""
        column, width = self.layout.column(), context.region.width
        try:
            text = describe_influence(context.object, context.view_layer, context.engine == "CYCLES")
        except RenderError as error:
            column.alert = True
            tell(column, str(error), width, icon="ERROR")
        else:
            for part, icon in zip(text.split("; "), ("INFO", "BLANK1"), strict=False):
                tell(column, part, width, icon)


class BENTLIGHT_PT_scale(EnginePanel, bpy.types.Panel):
    """What a black hole weighs in nature, and how large the scene is then."""

    bl_label = "Scale"
    bl_context = "object"
    bl_parent_id = "BENTLIGHT_PT_spacetime"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return BENTLIGHT_PT_spacetime.poll(context) and context.object.bentlight.kind == "BLACK_HOLE"

    def draw(self, context: bpy.types.Context) -> None:
        settings = context.object.bentlight
        column = self.column()
        column.prop(context.scene.unit_settings, "scale_length")
        for name in ("mass_suns", "mass_kilograms", "horizon_kilometers"):
            column.prop(settings, name)
        item = read_spacetime(context.object, context.object.matrix_world)
        text = iface_("Drawn with radius {:.4g}").format(core_radius(item) * item.scale)
        note(column, text)
        column.operator("bentlight.unit_scale_fit", icon="SNAP_INCREMENT")


class BENTLIGHT_PT_disk(EnginePanel, bpy.types.Panel):
    """What glows around a black hole."""

    bl_label = "Accretion Disk"
    bl_context = "object"
    bl_parent_id = "BENTLIGHT_PT_spacetime"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return super().poll(context) and context.object is not None and context.object.bentlight.kind == "BLACK_HOLE"

    def draw_header(self, context: bpy.types.Context) -> None:
        self.layout.prop(context.object.bentlight.disk, "enable", text="")

    def draw(self, context: bpy.types.Context) -> None:
        disk = context.object.bentlight.disk
        column = self.column()
        column.active = disk.enable
        column.prop(disk, "inner_edge")
        if disk.inner_edge == "CUSTOM":
            column.prop(disk, "inner_radius")
        else:
            spin = context.object.bentlight.spin
            note(column, iface_("{:.3f} masses").format(bentlight_native.disk_isco(spin)))
        column.prop(disk, "outer_radius")
        column.prop(disk, "softness")
        column.separator()
        column.prop(disk, "emission")
        self._draw_emission(column, disk)
        if disk.emission == "MATERIAL":
            return
        column.prop(disk, "strength")
        column.prop(disk, "opacity")
        column.separator()
        column.prop(disk, "doppler")
        column.prop(disk, "gravitational")
        column.separator()
        column.prop(disk, "pattern")
        for name in ("pattern_scale", "loop_frames", "loop_orbits"):
            column.prop(disk, name)

    def _draw_emission(self, column: bpy.types.UILayout, disk: bpy.types.PropertyGroup) -> None:
        """What each kind of emission is chosen by."""
        if disk.emission in {"PAGE_THORNE", "POWER_LAW"}:
            column.prop(disk, "temperature")
        if disk.emission == "POWER_LAW":
            column.prop(disk, "exponent")
        elif disk.emission == "RAMP":
            column.template_ID(disk, "ramp", new="texture.new")
            if disk.ramp is not None:
                column.prop(disk.ramp, "use_color_ramp")
                column.template_color_ramp(disk.ramp, "color_ramp")
        elif disk.emission == "IMAGE":
            column.template_ID(disk, "image", new="image.new", open="image.open")
        elif disk.emission == "MATERIAL":
            column.template_ID(disk, "material", new="material.new")
            for name in ("doppler", "gravitational", "pattern_scale", "loop_frames", "loop_orbits"):
                column.prop(disk, name)


CLASSES = (
    BENTLIGHT_PT_ray_visibility,
    BENTLIGHT_PT_spacetime,
    BENTLIGHT_PT_influence,
    BENTLIGHT_PT_scale,
    BENTLIGHT_PT_disk,
)
