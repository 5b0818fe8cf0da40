"""Blender's own panels that make sense for Bentlight: they list the engines they show for, and we add ours."""

from __future__ import annotations

import bpy

ENGINE = "BENTLIGHT"

# Shown for Blender's base engine, but not for us: they would ask for what we do not have, or we draw our own.
_EXCLUDED = {
    "DATA_PT_light",
    "DATA_PT_spot",
    "NODE_DATA_PT_light",
    "RENDER_PT_freestyle",
    "RENDER_PT_simplify",
    "RENDER_PT_simplify_greasepencil",
    "RENDER_PT_simplify_render",
    "RENDER_PT_simplify_viewport",
    "VIEWLAYER_PT_freestyle",
    "VIEWLAYER_PT_freestyle_edge_detection",
    "VIEWLAYER_PT_freestyle_style_modules",
    "MATERIAL_PT_freestyle_line",
}

# Written for EEVEE or Cycles, and exactly what a node-based engine needs.
_BORROWED = {
    "DATA_PT_EEVEE_light",
    "DATA_PT_camera_dof",
    "DATA_PT_camera_dof_aperture",
    "EEVEE_MATERIAL_PT_context_material",
    "EEVEE_MATERIAL_PT_surface",
    "EEVEE_WORLD_PT_surface",
    "MATERIAL_PT_preview",
    "NODE_DATA_PT_EEVEE_light",
    "VIEWLAYER_PT_layer_passes",
    "VIEWLAYER_PT_layer_passes_aov",
    "VIEWLAYER_PT_layer_passes_cryptomatte",
    "VIEWLAYER_PT_layer_passes_lightgroups",
    "VIEWLAYER_PT_override",
}


def _panels() -> list[type]:
    """The panels to appear in, wherever in the class tree they are."""
    found, waiting = [], list(bpy.types.Panel.__subclasses__())
    while waiting:
        panel = waiting.pop()
        waiting.extend(panel.__subclasses__())
        engines = getattr(panel, "COMPAT_ENGINES", None)
        if not isinstance(engines, set) or panel.__name__ in _EXCLUDED:
            continue
        if "BLENDER_RENDER" in engines or panel.__name__ in _BORROWED:
            found.append(panel)
    return found


def register() -> None:
    """Shows Bentlight in Blender's panels."""
    for panel in _panels():
        panel.COMPAT_ENGINES.add(ENGINE)


def unregister() -> None:
    """Takes it out of them again."""
    for panel in _panels():
        panel.COMPAT_ENGINES.discard(ENGINE)
