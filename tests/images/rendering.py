"""Renders small pictures as arrays, and says where in them a direction or an object is seen."""

import tempfile
from pathlib import Path

import bpy
import common
import numpy as np
import OpenEXR


def render(scene: bpy.types.Scene, engine: str = "BENTLIGHT", seed: int = 0, samples: int | None = None) -> np.ndarray:
    """The Combined pass, linear, as (height, width, 3) float64, first row at the top."""
    scene.render.engine = engine
    scene.bentlight.seed = scene.cycles.seed = seed
    if samples:
        scene.bentlight.samples = scene.cycles.samples = samples
    with tempfile.TemporaryDirectory() as folder:
        path = common.render(scene, Path(folder) / "picture.exr")
        channels = OpenEXR.File(str(path), separate_channels=True).channels()
        planes = [channels[next(n for n in channels if n.endswith(f"Combined.{c}"))].pixels for c in "RGB"]
    return np.stack(planes, axis=-1).astype(float)


def set_size(scene: bpy.types.Scene, width: int, height: int) -> None:
    """Sets the picture's size in pixels."""
    scene.render.resolution_x, scene.render.resolution_y = width, height


def empty_space(width: int, height: int, samples: int = 16) -> bpy.types.Scene:
    """A scene of nothing but a white world, quick to render: black pixels have fallen into something."""
    scene = common.new_scene(samples=samples, resolution=(width, height))
    scene.bentlight.max_bounces = 0
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (1, 1, 1, 1)
    return scene
