"""A viewport without a window: what Blender gives it in Rendered shading, and waiting for its pictures."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from types import SimpleNamespace

import bpy
import numpy as np

from blender_addon.progressive import Preview
from blender_addon.sync.camera import read_camera
from blender_addon.viewport import Viewport, _Frame


class Engine:
    """What a viewport needs of Blender's engine."""

    def __init__(self) -> None:
        self.changed = threading.Condition()

    def tag_redraw(self) -> None:
        """Blender would draw the viewport."""
        with self.changed:
            self.changed.notify_all()

    def report(self, level: set[str], text: str) -> None:
        raise AssertionError(text)


class Windowless:
    """A viewport that sees just what the scene's camera does, and is told of every update of the scene."""

    def __init__(self, threads: int = 2) -> None:
        self._engine = Engine()
        self.viewport = Viewport(self._engine, threads)
        self._wish = None  # that of the last picture
        bpy.app.handlers.depsgraph_update_post.append(self._on_update)

    def close(self) -> None:
        """Ends the viewport."""
        bpy.app.handlers.depsgraph_update_post.remove(self._on_update)
        self.viewport.close()

    def _on_update(self, _scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
        self.viewport.update(self._engine, depsgraph)

    def draw(self) -> None:
        """Wishes for a picture of what is there now, as Blender's drawing does."""
        depsgraph = bpy.context.evaluated_depsgraph_get()
        camera = bpy.context.scene.camera.evaluated_get(depsgraph)
        taken = read_camera(camera, bpy.context.scene.render, np.array(camera.matrix_world), camera.data.shift_x)
        context = SimpleNamespace(space_data=_space())
        self.viewport._wish(self._engine, context, depsgraph, _Frame(0, 0, taken))

    def wait(self, is_done: Callable[[Preview], bool] = lambda _: True, seconds: float = 60.0) -> Preview:
        """The first picture since the last call that is of a newer wish, and done."""
        progressive, end = self.viewport._progressive, time.monotonic() + seconds
        with self._engine.changed:
            while (shown := progressive.preview) is None or shown.wish is self._wish or not is_done(shown):
                assert progressive.failure is None, progressive.failure
                assert self._engine.changed.wait(end - time.monotonic()), "nothing came"
        self._wish = shown.wish
        return shown


def _space() -> bpy.types.SpaceView3D:
    return next(area for screen in bpy.data.screens for area in screen.areas if area.type == "VIEW_3D").spaces[0]
