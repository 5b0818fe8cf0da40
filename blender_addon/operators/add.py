"""Add > Black Hole and Add > Wormhole, and what a wormhole lacks."""

import bpy
from bpy.props import FloatProperty, FloatVectorProperty

from .. import checks
from ..properties_object import MASS

_APART = 10  # throat radii between the mouths of a new wormhole


def _add_empty(context: bpy.types.Context, name: str, location: tuple[float, float, float]) -> bpy.types.Object:
    obj = bpy.data.objects.new(name, None)
    obj.empty_display_type = "SPHERE"
    obj.location = location
    context.collection.objects.link(obj)
    return obj


def _select_only(context: bpy.types.Context, objects: list[bpy.types.Object]) -> None:
    """Selects the objects and makes the first one active; objects in hidden collections cannot be."""
    context.view_layer.update()  # so that it knows the new objects
    for obj in context.view_layer.objects:
        obj.select_set(False)
    for obj in objects:
        if obj.name in context.view_layer.objects:
            obj.select_set(True)
            context.view_layer.objects.active = objects[0]


class _AddOperator:
    bl_options = {"REGISTER", "UNDO"}

    location: FloatVectorProperty(name="Location", description="Where the new object is", subtype="TRANSLATION")

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.mode == "OBJECT"

    def place(self, context: bpy.types.Context) -> tuple[float, float, float]:
        """The 3D cursor, unless the caller said where."""
        if not self.properties.is_property_set("location"):
            self.location = context.scene.cursor.location
        return self.location

    def warn(self, context: bpy.types.Context) -> None:
        """Of what keeps the new object from being seen: there may well be something at the 3D cursor."""
        for found in checks.of_scene(context):
            if context.object is not None and context.object.name in found.about:
                self.report({"WARNING"}, found.text)


class BENTLIGHT_OT_black_hole_add(_AddOperator, bpy.types.Operator):
    """Add a black hole: light bends around it, and what comes too close is lost"""

    bl_idname = "bentlight.black_hole_add"
    bl_label = "Black Hole"

    mass: FloatProperty(
        name="Mass",
        description="As a length in scene units, 0 and more: seen from afar the shadow has a radius of 5.2 masses",
        min=0.0,
        default=MASS,
        subtype="DISTANCE",
    )
    spin: FloatProperty(
        name="Spin",
        description=(
            "As a fraction of the most a black hole can have, from -0.9999 to 0.9999: makes the shadow lopsided"
        ),
        min=-0.9999,
        max=0.9999,
    )

    def execute(self, context: bpy.types.Context) -> set[str]:
        obj = _add_empty(context, "Black Hole", self.place(context))
        obj.bentlight.mass = self.mass
        obj.bentlight.spin = self.spin
        obj.bentlight.kind = "BLACK_HOLE"
        _select_only(context, [obj])
        self.warn(context)
        return {"FINISHED"}


class BENTLIGHT_OT_wormhole_add(_AddOperator, bpy.types.Operator):
    """Add the two mouths of a wormhole: what goes into one comes out of the other"""

    bl_idname = "bentlight.wormhole_add"
    bl_label = "Wormhole"

    throat_radius: FloatProperty(
        name="Throat Radius",
        description="As a length in scene units, 1e-6 and more: seen from afar a ball of twice this size",
        min=1e-6,
        default=1.0,
        subtype="DISTANCE",
    )
    exit_location: FloatVectorProperty(
        name="Exit",
        description="Where the other mouth is, which is seen in this one; ten throat radii along X if not given",
        subtype="TRANSLATION",
    )

    def execute(self, context: bpy.types.Context) -> set[str]:
        entrance = self.place(context)
        if not self.properties.is_property_set("exit_location"):
            self.exit_location = (entrance[0] + _APART * self.throat_radius, *entrance[1:])
        mouths = [_add_empty(context, "Wormhole", place) for place in (entrance, self.exit_location)]
        for mouth in mouths:
            mouth.bentlight.throat_radius = self.throat_radius
            mouth.bentlight.kind = "WORMHOLE"
        mouths[0].bentlight.exit = mouths[1]
        _select_only(context, mouths)
        self.warn(context)
        return {"FINISHED"}


class BENTLIGHT_OT_exit_add(bpy.types.Operator):
    """Add the other mouth of the active wormhole, ten throat radii away: what goes into one comes out of the other"""

    bl_idname = "bentlight.exit_add"
    bl_label = "Add Wormhole Exit"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        obj = context.object
        return obj is not None and obj.bentlight.kind == "WORMHOLE" and obj.bentlight.exit is None

    def execute(self, context: bpy.types.Context) -> set[str]:
        entrance = context.object
        mouth = _add_empty(context, entrance.name, entrance.matrix_world.translation)
        mouth.scale = (entrance.matrix_world.col[0].to_3d().length,) * 3
        mouth.location.x += _APART * entrance.bentlight.throat_radius * mouth.scale.x
        mouth.bentlight.throat_radius = entrance.bentlight.throat_radius
        mouth.bentlight.kind = "WORMHOLE"
        entrance.bentlight.exit = mouth
        return {"FINISHED"}


_CLASSES = (BENTLIGHT_OT_black_hole_add, BENTLIGHT_OT_wormhole_add, BENTLIGHT_OT_exit_add)

register, unregister = bpy.utils.register_classes_factory(_CLASSES)
