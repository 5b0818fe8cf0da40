"""Settings as they are when they are new."""

import bpy


def reset(settings: bpy.types.bpy_struct, kept: frozenset[str] = frozenset()) -> None:
    """All of a property group, and of those in it, but what users do not see and what is `kept`."""
    for item in settings.bl_rna.properties:
        name = item.identifier
        if name in {"rna_type", "name", *kept} or item.is_hidden:
            continue
        if item.type == "POINTER" and isinstance(getattr(settings, name), bpy.types.PropertyGroup):
            reset(getattr(settings, name))
        elif item.type == "POINTER" or item.is_animatable:  # else it only shows another setting
            settings.property_unset(name)


class BENTLIGHT_OT_spacetime_reset(bpy.types.Operator):
    """Give this black hole or wormhole its first settings back: all but what it is, and where a wormhole leads"""

    bl_idname = "bentlight.spacetime_reset"
    bl_label = "Reset Spacetime to Defaults"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.object is not None and context.object.bentlight.kind != "NONE"

    def execute(self, context: bpy.types.Context) -> set[str]:
        settings = context.object.bentlight
        # A lens has its radius from Use in Cycles.
        reset(settings, frozenset({"kind", "exit", "relay_source", "lens_radius"}))
        for mouth in filter(None, (settings.exit, context.object)):  # both need the same, and their empties the size
            mouth.bentlight.throat_radius = settings.throat_radius
        return {"FINISHED"}


class BENTLIGHT_OT_render_reset(bpy.types.Operator):
    """Give all of Bentlight's own render properties of this scene their first settings back"""

    bl_idname = "bentlight.render_reset"
    bl_label = "Reset Bentlight Rendering to Defaults"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context: bpy.types.Context) -> set[str]:
        reset(context.scene.bentlight, frozenset({"overlay"}))
        context.scene.bentlight.property_unset("accuracy_is_custom")
        return {"FINISHED"}


class BENTLIGHT_OT_stars_reset(bpy.types.Operator):
    """Give the stars of this world their first settings back: off"""

    bl_idname = "bentlight.stars_reset"
    bl_label = "Reset Stars to Defaults"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.scene.world is not None

    def execute(self, context: bpy.types.Context) -> set[str]:
        reset(context.scene.world.bentlight)
        return {"FINISHED"}


_CLASSES = (BENTLIGHT_OT_spacetime_reset, BENTLIGHT_OT_render_reset, BENTLIGHT_OT_stars_reset)

register, unregister = bpy.utils.register_classes_factory(_CLASSES)
