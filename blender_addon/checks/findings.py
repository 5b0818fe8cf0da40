"""All findings of a scene, remembered until it changes: panels ask for them on every redraw."""

from __future__ import annotations

from collections.abc import Hashable

import bpy
from bpy.app.translations import pgettext_rpt as rpt_

from .. import changes
from ..compatibility import ENGINE
from ..sync.objects import UNSUPPORTED_TYPES
from . import integrator, lenses, spacetimes
from .finding import Finding
from .materials import MaterialChecks

_materials = MaterialChecks()
_balls = spacetimes.Balls()
_found: dict[Hashable, list[Finding]] = {}


def of_scene(context: bpy.types.Context) -> list[Finding]:
    """What the user should know about the scene and view layer of the context, for the engine that is chosen."""
    scene, view_layer = context.scene, context.view_layer
    own = *integrator.settings(scene, view_layer), *lenses.settings(scene)
    key = changes.count(), scene.name_full, view_layer.name, context.engine, *own
    if key not in _found:
        _found.clear()
        _found[key] = _find(context)
    return _found[key]


def _find(context: bpy.types.Context) -> list[Finding]:
    scene, view_layer, depsgraph = context.scene, context.view_layer, context.evaluated_depsgraph_get()
    items = spacetimes.read(view_layer, depsgraph)
    found = spacetimes.impossible(items)
    if not found:
        found += spacetimes.near_horizons(scene, view_layer, depsgraph, items, _balls)
        if context.engine == "CYCLES":
            found += lenses.findings(scene, view_layer, depsgraph, items)
    if context.engine == "CYCLES":
        found += lenses.unmade(scene, found)
    if context.engine == ENGINE:
        found += integrator.obstacles(scene, view_layer, items)
        found += _unsupported(view_layer)
        found += _materials.findings(scene, view_layer)
    return found


def _unsupported(view_layer: bpy.types.ViewLayer) -> list[Finding]:
    """Objects of kinds that Bentlight does not render."""
    return [
        Finding(rpt_("'{}': {} cannot be rendered yet").format(obj.name, rpt_(what)), "OBJECT", obj.name)
        for obj in view_layer.objects
        if (what := UNSUPPORTED_TYPES.get(obj.type)) and not obj.hide_render
    ]


def _forget(depsgraph: bpy.types.Depsgraph | None) -> None:
    _materials.forget(depsgraph)
    _balls.forget(depsgraph)


def register() -> None:
    """Begins to watch for changes."""
    changes.listen(_forget)


def unregister() -> None:
    """Ends it, and forgets all."""
    changes.ignore(_forget)
    _forget(None)
    _found.clear()
