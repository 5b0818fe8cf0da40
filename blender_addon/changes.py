"""Counts changes of the open file: what was found out about a scene holds as long as the count is the same."""

from __future__ import annotations

from collections.abc import Callable

import bpy
from bpy.app.handlers import persistent

from .compatibility import ENGINE

_EVENTS = ("depsgraph_update_post", "frame_change_post", "undo_post", "redo_post", "load_post")
_count = 0
_listeners: list[Callable[[bpy.types.Depsgraph | None], None]] = []


def count() -> int:
    """Another number after each change."""
    return _count


def listen(listener: Callable[[bpy.types.Depsgraph | None], None]) -> None:
    """Calls `listener` after each change with the depsgraph whose `updates` tell what it was; None: anything."""
    _listeners.append(listener)


def ignore(listener: Callable[[bpy.types.Depsgraph | None], None]) -> None:
    """Takes that back."""
    if listener in _listeners:
        _listeners.remove(listener)


def _tell(depsgraph: bpy.types.Depsgraph | None) -> None:
    global _count
    _count += 1
    for listener in _listeners:
        listener(depsgraph)


@persistent
def _after_update(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph | None = None) -> None:
    """Looks at no updates of renders, nor of other engines: in Blender 5.0, once Python has seen those of a render,
    Cycles takes the colors of instances for white."""
    own = depsgraph is not None and depsgraph.mode == "VIEWPORT" and scene.render.engine == ENGINE
    _tell(depsgraph if own else None)


@persistent
def _after_all(*_arguments: object) -> None:
    _tell(None)


def _handler(event: str) -> Callable:
    return _after_update if event in {"depsgraph_update_post", "frame_change_post"} else _after_all


def register() -> None:
    """Begins to count."""
    for event in _EVENTS:
        getattr(bpy.app.handlers, event).append(_handler(event))


def unregister() -> None:
    """Ends it."""
    for event in _EVENTS:
        handlers = getattr(bpy.app.handlers, event)
        if _handler(event) in handlers:
            handlers.remove(_handler(event))
