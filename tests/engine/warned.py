"""A hole to be warned of, and what the warnings say."""

import bpy

from blender_addon import checks


def add_hole() -> bpy.types.Object:
    """Its horizon has a radius of 1 as drawn."""
    bpy.ops.bentlight.black_hole_add(mass=2.0, location=(0, 0, 0))
    bpy.context.object.name = "Hole"
    return bpy.context.object


def texts() -> list[str]:
    """All warnings of the scene."""
    bpy.context.view_layer.update()
    return [found.text for found in checks.of_scene(bpy.context)]
