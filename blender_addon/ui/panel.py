"""What Bentlight's panels have in common."""

from __future__ import annotations

import bpy

from ..compatibility import ENGINE


class EnginePanel:
    """In the Properties editor, for the Bentlight engine."""

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


def note(column: bpy.types.UILayout, text: str, icon: str = "NONE") -> None:
    """A line below a property's value; `text` is translated already."""
    split = column.split(factor=0.4)
    split.column()
    split.label(text=text, icon=icon, translate=False)
