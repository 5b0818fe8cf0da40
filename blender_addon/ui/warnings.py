"""Warnings: all of a scene's in the render properties, and each in the panel of what it is about."""

from __future__ import annotations

from collections.abc import Iterable

import bpy

from .. import checks
from ..checks import Finding
from ..compatibility import ENGINE
from .panel import tell

_MOST = 12  # warnings that are shown; the rest are counted


class _WarningPanel:
    """Shown only if there is something to tell."""

    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_label = "Warnings"

    @classmethod
    def findings(cls, context: bpy.types.Context) -> list[Finding]:
        """Those that belong here."""
        raise NotImplementedError

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.engine in {ENGINE, "CYCLES"} and bool(cls.findings(context))

    def draw_header(self, context: bpy.types.Context) -> None:
        self.layout.label(icon="ERROR")

    def draw(self, context: bpy.types.Context) -> None:
        draw_findings(self.layout, self.findings(context), context.region.width)


class BENTLIGHT_PT_warnings(_WarningPanel, bpy.types.Panel):
    """What is not as one may expect in this scene. Click to select what it is about"""

    bl_context = "render"

    @classmethod
    def findings(cls, context: bpy.types.Context) -> list[Finding]:
        return checks.of_scene(context)


class BENTLIGHT_PT_object_warnings(_WarningPanel, bpy.types.Panel):
    """What is not as one may expect about this object"""

    bl_context = "object"

    @classmethod
    def findings(cls, context: bpy.types.Context) -> list[Finding]:
        return [] if context.object is None else about(checks.of_scene(context), context.object.name)


class BENTLIGHT_PT_data_warnings(_WarningPanel, bpy.types.Panel):
    """What is not as one may expect about this camera, light or mesh"""

    bl_context = "data"

    @classmethod
    def findings(cls, context: bpy.types.Context) -> list[Finding]:
        return [] if context.object is None else about(checks.of_scene(context), context.object.name)


class BENTLIGHT_PT_material_warnings(_WarningPanel, bpy.types.Panel):
    """What Bentlight does not render of this material as its nodes say"""

    bl_context = "material"

    @classmethod
    def findings(cls, context: bpy.types.Context) -> list[Finding]:
        material = context.material
        return [] if material is None else _of("MATERIAL", material.name, checks.of_scene(context))


class BENTLIGHT_PT_world_warnings(_WarningPanel, bpy.types.Panel):
    """What Bentlight does not render of this world as its nodes say"""

    bl_context = "world"

    @classmethod
    def findings(cls, context: bpy.types.Context) -> list[Finding]:
        return [] if context.world is None else _of("WORLD", context.world.name, checks.of_scene(context))


def about(findings: Iterable[Finding], name: str) -> list[Finding]:
    """Those in which an object takes part."""
    return [found for found in findings if found.kind == "OBJECT" and name in (found.owner, *found.about)]


def _of(kind: str, name: str, findings: Iterable[Finding]) -> list[Finding]:
    return [found for found in findings if (found.kind, found.owner) == (kind, name)]


def draw_findings(layout: bpy.types.UILayout, findings: list[Finding], width: float) -> None:
    """Each with a button that leads to what it is about."""
    for found in findings[:_MOST]:
        row = layout.row()
        tell(row, found.text, width)
        if found.kind == "OBJECT":
            row.operator("bentlight.object_select", text="", icon="RESTRICT_SELECT_OFF").name = found.owner
        elif found.kind == "MATERIAL":
            button = row.operator("bentlight.material_select", text="", icon="MATERIAL")
            button.name, button.node = found.owner, found.node
    if len(findings) > _MOST:
        layout.label(text=f"+ {len(findings) - _MOST}", translate=False)


CLASSES = (
    BENTLIGHT_PT_warnings,
    BENTLIGHT_PT_object_warnings,
    BENTLIGHT_PT_data_warnings,
    BENTLIGHT_PT_material_warnings,
    BENTLIGHT_PT_world_warnings,
)
