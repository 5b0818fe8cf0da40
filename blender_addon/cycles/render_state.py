"""The viewport's depsgraph as a final render would see it.

Outside of a render engine's callbacks Blender offers no other depsgraph, and artists set subdivision higher, and hide
things, for renders only. So what differs is set as in renders for a while, and set back.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import bpy

# Of modifiers and of objects: the viewport's setting, and that of final renders which takes its place.
_OF_MODIFIERS = (("levels", "render_levels"), ("show_viewport", "show_render"))
_OF_OBJECTS = (("hide_viewport", "hide_render"),)


@contextmanager
def as_rendered(view_layer: bpy.types.ViewLayer) -> Iterator[bpy.types.Depsgraph]:
    """The view layer's depsgraph with modifiers and visibility of final renders, until the end of the block."""
    before = [change for obj in view_layer.objects for change in _changes(obj)]
    shown = [obj for obj in view_layer.objects if obj.hide_get(view_layer=view_layer) and not obj.hide_render]
    try:
        for owner, name, _old, new in before:
            setattr(owner, name, new)
        for obj in shown:
            obj.hide_set(False, view_layer=view_layer)
        view_layer.update()
        yield view_layer.depsgraph
    finally:
        for owner, name, old, _new in before:
            setattr(owner, name, old)
        for obj in shown:
            obj.hide_set(True, view_layer=view_layer)
        if before or shown:
            view_layer.update()


def _changes(obj: bpy.types.Object) -> Iterator[tuple[bpy.types.bpy_struct, str, object, object]]:
    """Owner, setting, its value and that of renders, for all that differ."""
    for owner, pairs in ((obj, _OF_OBJECTS), *((modifier, _OF_MODIFIERS) for modifier in obj.modifiers)):
        for name, of_renders in pairs:
            if hasattr(owner, name) and hasattr(owner, of_renders):
                old, new = getattr(owner, name), getattr(owner, of_renders)
                if old != new:
                    yield owner, name, old, new
