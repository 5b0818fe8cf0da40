"""Persistent Data: scenes that are kept from one frame to the next, and edited where something has changed.

Blender keeps the engine of a scene's renders, and with it what is kept here, until a file is loaded, another engine is
chosen or Persistent Data is switched off.
"""

from __future__ import annotations

from typing import Any

import bentlight_native
import bpy
from bpy.app.handlers import persistent

from .sync.memory import Memory
from .sync.scene_data import SceneData

_undos = 0  # Blender does not tell its engines what an undo has changed


class KeptScenes:
    """Of one engine: for each view layer and view the native scene of the last frame, and what it shows."""

    def __init__(self) -> None:
        self._scenes: dict[tuple[str, str], tuple[bentlight_native.Scene, SceneData]] = {}
        self._memory = Memory()
        self._remembered: tuple[str, int] | None = None  # the layer, and the number of undos, that the memory is of

    def memory(self, layer: str, updates: Any) -> Memory:
        """What need not be read again of a view layer. updates: all of its depsgraph since the last call. Layers share
        one depsgraph, so that nothing is remembered where there are several."""
        if self._remembered == (layer, _undos):
            self._memory.forget(updates)
        else:
            self._memory = Memory()
        self._remembered = layer, _undos
        return self._memory

    def take(self, layer: str, view: str) -> tuple[bentlight_native.Scene | None, SceneData | None]:
        """A view's native scene, to be edited, and what it shows. It is gone unless it is kept again."""
        return self._scenes.pop((layer, view), (None, None))

    def keep(self, layer: str, view: str, native: bentlight_native.Scene | None, data: SceneData | None) -> None:
        """Keeps a committed scene, if there is one, for the next frame."""
        if native is not None and data is not None:
            self._scenes[layer, view] = native, data


def kept_by(engine: bpy.types.RenderEngine, scene: bpy.types.Scene) -> KeptScenes:
    """What an engine has kept; nothing unless the user wants Persistent Data."""
    kept = getattr(engine, "kept_scenes", None)
    if not scene.render.use_persistent_data or engine.is_preview:
        engine.kept_scenes = None
        return KeptScenes()
    if kept is None:
        kept = engine.kept_scenes = KeptScenes()
    return kept


@persistent
def _count_undo(*_unused: object) -> None:
    global _undos
    _undos += 1


_HANDLERS = ("undo_post", "redo_post", "load_post")


def register() -> None:
    """Listens for undo."""
    for name in _HANDLERS:
        getattr(bpy.app.handlers, name).append(_count_undo)


def unregister() -> None:
    """Takes the handlers back."""
    for name in _HANDLERS:
        getattr(bpy.app.handlers, name).remove(_count_undo)
