"""Why light is not followed from lamps though the user wants it."""

from __future__ import annotations

from collections.abc import Iterator

import bpy
from bpy.app.translations import pgettext_rpt as rpt_

from .. import passes
from ..sync.scene_data import SpacetimeData
from .finding import Finding


def settings(scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer) -> tuple[str, str]:
    """The integrator, and the first pass that it may not have; "" if there is none. Blender tells of no change here."""
    if scene.bentlight.integrator != "BIDIRECTIONAL":
        return scene.bentlight.integrator, ""
    parts = passes.tell_light_apart(passes.enabled(view_layer))
    return scene.bentlight.integrator, parts[0].name if parts else ""


def obstacles(scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer, items: list[SpacetimeData]) -> Iterator[Finding]:
    """What of the scene keeps the integrator Bidirectional from it. What surfaces do is only found by a render."""
    integrator, part = settings(scene, view_layer)
    if integrator != "BIDIRECTIONAL":
        return
    text = rpt_("Bidirectional is not possible, light is followed from the camera alone: {}")
    if part:
        yield Finding(text.format(rpt_("the pass '{}' tells light apart").format(part)), "SCENE", scene.name)
    for item in items:
        if item.kind == "BLACK_HOLE" and item.mass > 0 and item.spin:
            yield Finding(text.format(rpt_("'{}' spins").format(item.name)), "OBJECT", item.name)
