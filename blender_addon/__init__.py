"""Bentlight: a render engine whose light travels through curved spacetime. Registers the add-on's modules in order."""

import atexit

import bpy

from . import changes, checks, compatibility, cycles, engine, farm, operators, overlay, persistent, properties, ui

_MODULES = (properties, changes, checks, operators, cycles, engine, farm, persistent, ui, overlay, compatibility)
_registered: list = []  # what unregister has to undo, in order


def register() -> None:
    """Idempotent; on failure nothing stays registered."""
    if _registered:
        return
    try:
        for module in _MODULES:
            module.register()
            _registered.append(module)
    except Exception:
        unregister()
        raise
    if bpy.app.module:  # Blender 4.5 as a module waits for ever at exit while an operator is registered
        atexit.register(unregister)


def unregister() -> None:
    """Undoes `register`; idempotent. Refuses during a render: Blender crashes when its engine disappears."""
    if any(bpy.app.is_job_running(job) for job in ("RENDER", "RENDER_PREVIEW")):
        raise RuntimeError("Bentlight cannot be disabled while Blender renders; stop the render and try again")
    atexit.unregister(unregister)
    while _registered:
        _registered.pop().unregister()
