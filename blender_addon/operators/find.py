"""From a warning to what it is about."""

import bpy
from bpy.props import StringProperty

from ..report import told


class BENTLIGHT_OT_object_select(bpy.types.Operator):
    """Select the object that this is about, and nothing else"""

    bl_idname = "bentlight.object_select"
    bl_label = "Select Object"
    bl_options = {"REGISTER", "UNDO", "INTERNAL"}

    name: StringProperty(name="Object", description="Which object")

    def execute(self, context: bpy.types.Context) -> set[str]:
        obj = context.view_layer.objects.get(self.name)
        if obj is None:
            self.report({"WARNING"}, told("'{}' is not in this view layer", self.name))
            return {"CANCELLED"}
        select_only(context, obj)
        return {"FINISHED"}


class BENTLIGHT_OT_material_select(bpy.types.Operator):
    """Show the material that this is about: selects an object that has it, and the material's slot"""

    bl_idname = "bentlight.material_select"
    bl_label = "Select Material"
    bl_options = {"REGISTER", "UNDO", "INTERNAL"}

    name: StringProperty(name="Material", description="Which material")
    node: StringProperty(name="Node", description="Which of its nodes is selected, if any")

    def execute(self, context: bpy.types.Context) -> set[str]:
        material = bpy.data.materials.get(self.name)
        if material is None:
            self.report({"WARNING"}, told("There is no material '{}'", self.name))
            return {"CANCELLED"}
        for obj in context.view_layer.objects:
            slot = next((i for i, slot in enumerate(obj.material_slots) if slot.material == material), None)
            if slot is not None:
                obj.active_material_index = slot
                select_only(context, obj)
                break
        node = material.node_tree.nodes.get(self.node) if material.node_tree else None
        if node is not None:
            for other in material.node_tree.nodes:
                other.select = False
            node.select = True
            material.node_tree.nodes.active = node
        return {"FINISHED"}


def select_only(context: bpy.types.Context, obj: bpy.types.Object) -> None:
    """Makes an object of the view layer the active one."""
    if context.mode != "OBJECT" and bpy.ops.object.mode_set.poll():
        bpy.ops.object.mode_set(mode="OBJECT")
    for other in context.view_layer.objects:
        other.select_set(other == obj)
    context.view_layer.objects.active = obj


_CLASSES = (BENTLIGHT_OT_object_select, BENTLIGHT_OT_material_select)

register, unregister = bpy.utils.register_classes_factory(_CLASSES)
