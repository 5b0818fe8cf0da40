"""Keeps lenses as their holes are: when a file is opened, when anything changes, in every frame, before a render."""

from __future__ import annotations

import logging

import bpy
from bpy.app.handlers import persistent

from ..report import RenderError, told
from . import disk, failures, setup, sky_images, tables

log = logging.getLogger(__name__)


_at_work = False  # adding lenses is itself a change


def _refresh(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph, complete: bool = True) -> None:
    """Lenses as their holes are; `complete`: also for holes that are new, none for those that are gone."""
    global _at_work
    if _at_work:
        return
    _at_work = True
    try:
        if not complete or setup.is_complete(scene, depsgraph):
            setup.update(scene, depsgraph)
        else:
            for text in setup.complete(scene, depsgraph):
                log.warning(text)
        failures.forget(scene, "lenses")
    except RenderError as error:
        failures.remember(scene, "lenses", told("Lenses for Cycles: {}", error))
    finally:
        _at_work = False


@persistent
def _on_change(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph | None = None) -> None:
    if setup.is_set_up(scene) and depsgraph is not None:
        _refresh(scene, depsgraph)


@persistent
def _on_frame(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph | None = None) -> None:
    """While an animation renders objects must not come and go."""
    if setup.is_set_up(scene) and depsgraph is not None:
        _refresh(scene, depsgraph, complete=False)


@persistent
def _on_load(_path: str) -> None:
    """Another machine wrote the file, or another version of the shaders: paths and code are made anew."""
    failures.forget_all()
    waiting = [scene for scene in bpy.data.scenes if setup.is_set_up(scene)]
    if waiting:
        tables.check()
    for scene in waiting:
        for view_layer in scene.view_layers[:1]:
            _refresh(scene, view_layer.depsgraph or bpy.context.evaluated_depsgraph_get())


@persistent
def _before_render(scene: bpy.types.Scene, *_unused: object) -> None:
    if setup.is_set_up(scene) and scene.render.engine == "CYCLES":
        disk.forget_images()
        sky_images.forget()
        _refresh(scene, scene.view_layers[0].depsgraph or bpy.context.evaluated_depsgraph_get())


def _handlers() -> list[tuple[list, object]]:
    events = bpy.app.handlers
    return [
        (events.load_post, _on_load),
        (events.depsgraph_update_post, _on_change),
        (events.frame_change_post, _on_frame),
        (events.render_init, _before_render),
    ]


def register() -> None:
    """Starts to listen."""
    for event, handler in _handlers():
        event.append(handler)


def unregister() -> None:
    """Stops."""
    for event, handler in _handlers():
        if handler in event:
            event.remove(handler)
    failures.forget_all()
