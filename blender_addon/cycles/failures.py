"""Why lenses or the relay camera are not as they should be, for as long as it lasts: handlers cannot report it."""

from __future__ import annotations

import logging

import bpy

log = logging.getLogger(__name__)

_failures: dict[int, dict[str, str]] = {}  # by scene: what failed, and its text


def remember(scene: bpy.types.Scene, what: str, text: str) -> None:
    """`what`, such as "lenses", could not be made as the scene asks for; text: translated, and said in the log once."""
    known = _failures.setdefault(scene.session_uid, {})
    if known.get(what) != text:
        log.warning("%s", text)
    known[what] = text


def forget(scene: bpy.types.Scene, what: str) -> None:
    """`what` is as it should be again, or is gone."""
    known = _failures.get(scene.session_uid, {})
    known.pop(what, None)


def of_scene(scene: bpy.types.Scene) -> tuple[str, ...]:
    """Texts of what has failed and still does."""
    return tuple(_failures.get(scene.session_uid, {}).values())


def forget_all() -> None:
    """Another file, or the end."""
    _failures.clear()
