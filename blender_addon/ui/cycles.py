"""The panels that Bentlight adds to Cycles' render properties and to its cameras."""

from __future__ import annotations

import bpy
from bpy.app.translations import pgettext_iface as iface_

from ..cycles import relay, setup
from .panel import tell


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
            column.use_property_split, column.use_property_decorate = True, False
            column.prop(context.scene.bentlight, "sky_filter")
            tell(column, iface_("Lamps do not shine through lenses"), context.region.width, icon="INFO")


class BENTLIGHT_PT_relay(bpy.types.Panel):
    """The relay camera of a scene that Cycles renders."""

    bl_label = "Bentlight Relay"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "data"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.engine == "CYCLES" and context.camera is not None

    def draw(self, context: bpy.types.Context) -> None:
        column = self.layout.column()
        column.use_property_split, column.use_property_decorate = True, False
        source = relay.source_of(context.scene.camera)
        if source is not None:
            text = iface_("Curved rays of '{}'").format(source.name)
            tell(column, text, context.region.width, icon="INFO")
            column.prop(context.scene.bentlight, "relay_parts")
            slices = column.row()
            slices.active = context.scene.render.use_motion_blur
            slices.prop(context.scene.bentlight, "relay_slices")
            column.prop(context.scene.bentlight, "sky_filter")
            column.prop(context.scene.bentlight, "gravitational")
            column.operator("bentlight.relay_clear")
        else:
            column.operator("bentlight.relay_setup")


CLASSES = (BENTLIGHT_PT_cycles, BENTLIGHT_PT_relay)
