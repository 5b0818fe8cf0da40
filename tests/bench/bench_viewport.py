"""The room of make render in Rendered shading: how soon a move of the camera is seen, by the viewport's own classes."""

import statistics
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "examples"))
import common
import room_schwarzschild

from tests.engine.windowless import Windowless

RESOLUTION = (960, 540)


@dataclass(frozen=True)
class ViewportTimes:
    """Seconds; after the last change until there is a picture."""

    begun: float  # the viewport is new: all of the scene is read
    moved: float  # the first one of a camera that has moved, median
    full: float  # in full resolution, a sample a pixel, median


def timed(viewport: Windowless, is_done: Callable[[object], bool] = lambda _: True) -> float:
    """Seconds until a picture of what is there now is there."""
    start = time.perf_counter()
    bpy.context.view_layer.update()
    viewport.draw()
    viewport.wait(is_done, seconds=600)
    return time.perf_counter() - start


def measure(runs: int = 5) -> ViewportTimes:
    """A new viewport, and then a camera that moves on and on."""
    scene = room_schwarzschild.build()
    scene.render.resolution_x, scene.render.resolution_y = RESOLUTION
    scene.bentlight.preview_samples = 1
    common.log.info("viewport: %d x %d", *RESOLUTION)
    viewport, moved, full = Windowless(scene.render.threads), [], []
    begun = timed(viewport)
    try:
        for _ in range(runs):
            for times, is_done in ((moved, lambda _: True), (full, lambda picture: picture.samples > 0)):
                scene.camera.location.x += 0.01
                times.append(timed(viewport, is_done))
    finally:
        viewport.close()
    return ViewportTimes(begun, statistics.median(moved), statistics.median(full))
