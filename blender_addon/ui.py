"""Bentlight's own panels."""

from __future__ import annotations

import bentlight_native
import bpy

from .compatibility import ENGINE
from .cycles import radius, setup
from .report import RenderError
from .sync import left_out, spacetime


class _Panel:
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.engine == ENGINE

    def column(self) -> bpy.types.UILayout:
        """Labels left, values right, as in Blender's own panels."""
        self.layout.use_property_split = True
        self.layout.use_property_decorate = False
        return self.layout.column()


class BENTLIGHT_PT_sampling(_Panel, bpy.types.Panel):
    """How many rays, and how exact."""

    bl_label = "Sampling"
    bl_context = "render"

    def draw(self, context: bpy.types.Context) -> None:
        settings = context.scene.bentlight
        column = self.column()
        column.prop(settings, "integrator")
        noise = column.row(heading="Noise Threshold")
        noise.prop(settings, "use_adaptive_sampling", text="")
        threshold = noise.row()
        threshold.active = settings.use_adaptive_sampling
        threshold.prop(settings, "adaptive_threshold", text="")
        column.prop(settings, "samples", text="Max Samples" if settings.use_adaptive_sampling else "Samples")
        least = column.row()
        least.active = settings.use_adaptive_sampling
        least.prop(settings, "adaptive_min_samples")
        column.prop(settings, "photon_ring_samples")
        column.prop(settings, "sky_filter")
        column.prop(settings, "time_limit")
        column.prop(settings, "tolerance")
        lights = column.row()
        lights.active = settings.integrator == "PATH"
        lights.prop(settings, "light_sampling")
        column.prop(settings, "portal_sampling")
        column.prop(settings, "light_threshold")
        column.prop(settings, "sampling_pattern")
        self.layout.prop(settings, "seed")


class BENTLIGHT_PT_light_paths(_Panel, bpy.types.Panel):
    """How long light is followed."""

    bl_label = "Light Paths"
    bl_context = "render"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        settings = context.scene.bentlight
        column = self.column()
        column.prop(settings, "max_bounces")
        column.prop(settings, "transparent_bounces")
        clamp = self.column()
        clamp.prop(settings, "clamp_direct")
        clamp.prop(settings, "clamp_indirect")
        caustics = self.column()
        caustics.prop(settings, "blur_glossy")
        caustics.prop(settings, "caustics_reflective")
        caustics.prop(settings, "caustics_refractive")
        self.column().prop(settings, "gravitational")


class BENTLIGHT_PT_film(_Panel, bpy.types.Panel):
    """From light to pixels."""

    bl_label = "Film"
    bl_context = "render"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        render = context.scene.render
        column = self.column()
        column.prop(context.scene.bentlight, "pixel_filter")
        width = column.row()
        width.active = context.scene.bentlight.pixel_filter != "BOX"
        width.prop(render, "filter_size", text="Filter Width")
        self.layout.prop(render, "film_transparent", text="Transparent")


class BENTLIGHT_PT_performance(_Panel, bpy.types.Panel):
    """How many processors."""

    bl_label = "Performance"
    bl_context = "render"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        render = context.scene.render
        column = self.column()
        column.prop(render, "threads_mode")
        threads = column.row()
        threads.enabled = render.threads_mode == "FIXED"
        threads.prop(render, "threads")


class BENTLIGHT_PT_passes(_Panel, bpy.types.Panel):
    """What else than the picture a view layer delivers."""

    bl_label = "Data"
    bl_context = "view_layer"
    bl_parent_id = "VIEWLAYER_PT_layer_passes"

    def draw(self, context: bpy.types.Context) -> None:
        layer = context.view_layer
        column = self.column()
        for name, text in (
            ("use_pass_combined", "Combined"),
            ("use_pass_z", "Depth"),
            ("use_pass_position", "Position"),
            ("use_pass_normal", "Normal"),
            ("use_pass_emit", "Emission"),
            ("use_pass_environment", "Environment"),
        ):
            column.prop(layer, name, text=text)
        column.prop(layer.bentlight, "use_pass_denoising")


class BENTLIGHT_PT_passes_spacetime(_Panel, bpy.types.Panel):
    """What only curved light has."""

    bl_label = "Spacetime"
    bl_context = "view_layer"
    bl_parent_id = "VIEWLAYER_PT_layer_passes"

    def draw(self, context: bpy.types.Context) -> None:
        column = self.column()
        for name in ("use_pass_error", "use_pass_winding", "use_pass_fate"):
            column.prop(context.view_layer.bentlight, name)


class BENTLIGHT_PT_stars(_Panel, bpy.types.Panel):
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


class BENTLIGHT_PT_ray_visibility(_Panel, bpy.types.Panel):
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


class BENTLIGHT_PT_spacetime(_Panel, bpy.types.Panel):
    """What an object does to light around it."""

    bl_label = "Spacetime"
    bl_context = "object"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.engine in {ENGINE, "CYCLES"} and context.object is not None

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
            column.prop(settings, "exit")
        if settings.kind != "NONE":
            column.prop(settings, "sphere_radius")
            if context.engine == "CYCLES":
                column.prop(settings, "lens_radius")
            self._draw_influence(context)

    def _draw_influence(self, context: bpy.types.Context) -> None:
        """The sphere in use and what it costs; or why this cannot be rendered."""
        column = self.layout.column()
        try:
            text = describe_influence(context.object, context.view_layer, context.engine == "CYCLES")
        except RenderError as error:
            column.alert = True
            column.label(text=str(error), icon="ERROR")
        else:
            for line, icon in zip(text.split("; "), ("INFO", "BLANK1"), strict=False):  # panels are narrow
                column.label(text=line, icon=icon)


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


class BENTLIGHT_PT_disk(_Panel, bpy.types.Panel):
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
            column.label(text=f"{bentlight_native.disk_isco(spin):.3f} masses", icon="BLANK1")
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


def describe_influence(obj: bpy.types.Object, view_layer: bpy.types.ViewLayer, lenses: bool = False) -> str:
    """How far an object bends light, and the bending that this leaves out; with `lenses`, in Cycles.

    Raises RenderError as a render would.
    """
    items = [
        _read(other, lenses) for other in view_layer.objects if other.bentlight.kind != "NONE" and not other.hide_render
    ]
    spacetime.check(items)
    for item, used in zip(items, spacetime.influence_radii(items), strict=True):
        if item.name == obj.name:
            if used == float("inf"):
                return "Not set up for Cycles" if lenses else "Bends light everywhere, exactly"
            missing = left_out.missing_bending(item, used)
            most = f"up to {missing:.2g} rad" if missing < float("inf") else "rays that would fall in"
            return f"Bends light within {used:.4g}; leaves out {most}"
    return "Not rendered"


def _read(obj: bpy.types.Object, lenses: bool) -> spacetime.SpacetimeData:
    item = spacetime.read_spacetime(obj, obj.matrix_world)
    return radius.with_lens_radius(item, obj) if lenses else item


_CLASSES = (
    BENTLIGHT_PT_sampling,
    BENTLIGHT_PT_light_paths,
    BENTLIGHT_PT_film,
    BENTLIGHT_PT_performance,
    BENTLIGHT_PT_passes,
    BENTLIGHT_PT_passes_spacetime,
    BENTLIGHT_PT_stars,
    BENTLIGHT_PT_ray_visibility,
    BENTLIGHT_PT_spacetime,
    BENTLIGHT_PT_cycles,
    BENTLIGHT_PT_disk,
)

register, unregister = bpy.utils.register_classes_factory(_CLASSES)
