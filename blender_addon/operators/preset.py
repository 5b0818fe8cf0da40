"""Presets of black holes and wormholes: those that come with the extension, and the user's own."""

from pathlib import Path

import bpy
from bl_operators.presets import AddPresetBase
from bl_ui.utils import PresetPanel

FOLDER = "bentlight/spacetime"
_ROOT = str(Path(__file__).resolve().parents[1])  # holds presets/
_SETTINGS = ("kind", "mass", "spin", "chart", "throat_radius", "sphere_radius")
_DISK_SETTINGS = (
    "enable", "inner_edge", "inner_radius", "outer_radius", "emission", "temperature", "exponent", "strength",
    "opacity", "softness", "doppler", "gravitational", "pattern", "pattern_scale", "loop_frames", "loop_orbits",
)  # fmt: skip


class BENTLIGHT_MT_spacetime_presets(bpy.types.Menu):
    """Make the active object a black hole or a wormhole of a well-known kind"""

    bl_label = "Spacetime Presets"
    preset_subdir = FOLDER
    preset_operator = "script.execute_preset"
    draw = bpy.types.Menu.draw_preset


class BENTLIGHT_OT_spacetime_preset_add(AddPresetBase, bpy.types.Operator):
    """Save the settings of this black hole or wormhole under a name, or remove the preset"""

    bl_idname = "bentlight.spacetime_preset_add"
    bl_label = "Add Spacetime Preset"
    preset_menu = "BENTLIGHT_MT_spacetime_presets"
    preset_defines = ["hole = bpy.context.object.bentlight"]
    preset_values = [*(f"hole.{name}" for name in _SETTINGS), *(f"hole.disk.{name}" for name in _DISK_SETTINGS)]
    preset_subdir = FOLDER


class BENTLIGHT_PT_spacetime_presets(PresetPanel, bpy.types.Panel):
    """Well-known black holes and wormholes, and your own"""

    bl_label = "Spacetime Presets"
    preset_subdir = FOLDER
    preset_operator = "script.execute_preset"
    preset_add_operator = BENTLIGHT_OT_spacetime_preset_add.bl_idname


_CLASSES = (BENTLIGHT_MT_spacetime_presets, BENTLIGHT_OT_spacetime_preset_add, BENTLIGHT_PT_spacetime_presets)


def register() -> None:
    """Tells Blender where the presets are."""
    for cls in _CLASSES:
        bpy.utils.register_class(cls)
    bpy.utils.register_preset_path(_ROOT)


def unregister() -> None:
    """Takes that back; the user's own stay in Blender's folder for presets."""
    bpy.utils.unregister_preset_path(_ROOT)
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)
