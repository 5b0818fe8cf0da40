"""The panels of the render properties."""

from __future__ import annotations

import bpy
from bpy.app.translations import pgettext_iface as iface_

from .. import accuracy
from ..operators import denoise
from ..report import RenderError
from .panel import EnginePanel, note


class BENTLIGHT_PT_sampling(EnginePanel, bpy.types.Panel):
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
        column.prop(settings, "photon_ring_samples", text="Photon Ring")
        column.prop(settings, "sky_filter")
        column.prop(settings, "time_limit")
        _draw_accuracy(column, context.scene)
        lights = column.row()
        lights.active = settings.integrator == "PATH"
        lights.prop(settings, "light_sampling")
        column.prop(settings, "portal_sampling")
        column.prop(settings, "light_threshold")
        column.prop(settings, "sampling_pattern")
        self.layout.prop(settings, "seed")
        _draw_denoising(self.layout, context.scene)
        self.layout.operator("bentlight.render_reset", text="Reset to Defaults", icon="LOOP_BACK")


def _draw_denoising(layout: bpy.types.UILayout, scene: bpy.types.Scene) -> None:
    """A button that sets it up, and then its switch."""
    nodes = denoise.find_nodes(scene)
    for node in nodes[:1]:
        layout.prop(node, "mute", text="Denoise", invert_checkbox=True)
    if not nodes:
        layout.operator("bentlight.denoise_setup", icon="SHADERFX")


def _draw_accuracy(column: bpy.types.UILayout, scene: bpy.types.Scene) -> None:
    """The choice, its number if it is the user's own, and what it means in the picture."""
    column.prop(scene.bentlight, "accuracy")
    if scene.bentlight.accuracy == "CUSTOM":
        column.prop(scene.bentlight, "tolerance")
    try:
        pixels = accuracy.scene_error_in_pixels(scene)
    except RenderError:
        return  # the camera's own panels tell
    if pixels is not None:
        note(column, iface_("Within {:.2g} pixels").format(pixels))


class BENTLIGHT_PT_viewport(EnginePanel, bpy.types.Panel):
    """What Rendered shading shows in the 3D viewport."""

    bl_label = "Viewport"
    bl_parent_id = "BENTLIGHT_PT_sampling"
    bl_context = "render"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        column = self.column()
        column.prop(context.scene.bentlight, "preview_samples", text="Samples")
        column.prop(context.scene.render, "preview_pixel_size")


class BENTLIGHT_PT_light_paths(EnginePanel, bpy.types.Panel):
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


class BENTLIGHT_PT_film(EnginePanel, bpy.types.Panel):
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


class BENTLIGHT_PT_performance(EnginePanel, bpy.types.Panel):
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
        column.prop(render, "use_persistent_data")


CLASSES = (
    BENTLIGHT_PT_sampling,
    BENTLIGHT_PT_viewport,
    BENTLIGHT_PT_light_paths,
    BENTLIGHT_PT_film,
    BENTLIGHT_PT_performance,
)
