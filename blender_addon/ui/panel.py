"""What Bentlight's panels have in common."""

from __future__ import annotations

import blf
import bpy

from ..compatibility import ENGINE

_MARGIN, _ICON = 40, 26  # pixels, at scale 1, that a panel keeps free beside its rows; that an icon or button takes


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


def tell(layout: bpy.types.UILayout, text: str, width: float, icon: str = "NONE") -> None:
    """A text, translated already, on as many lines as it takes in a region of `width` pixels: Blender's labels do not
    wrap."""
    column = layout.column(align=True)
    column.scale_y = 0.8
    for number, line in enumerate(wrap(text, width - (_MARGIN + _ICON) * _scale())):
        shown = icon if number == 0 or icon == "NONE" else "BLANK1"
        column.label(text=line, icon=shown, translate=False)


def wrap(text: str, width: float) -> list[str]:
    """Cuts a text between words into lines of at most `width` pixels, as long as a single word is no longer."""
    lines = [""]
    for word in text.split():
        longer = f"{lines[-1]} {word}".strip()
        if lines[-1] and text_width(longer) > width:
            lines.append(word)
        else:
            lines[-1] = longer
    return lines


def text_width(text: str) -> float:
    """Pixels that a label takes, in Blender's font for widgets."""
    blf.size(0, bpy.context.preferences.ui_styles[0].widget.points * _scale())
    return blf.dimensions(0, text)[0]


def _scale() -> float:
    return bpy.context.preferences.system.ui_scale or 1.0  # 0 without a window
