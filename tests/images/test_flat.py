"""Where there is no hole Bentlight and Cycles must agree: Z-tests of the studio of examples/flat.py.

Every picture is rendered SEEDS times by each engine with different seeds, which tells both variances; the tests fail
equal engines once in 10 000 runs each (image_statistics.py). What Cycles computes with a shortcut is switched off.
"""

import functools

import bpy
import flat
import numpy as np
import pytest
import rendering
from bpy_extras.object_utils import world_to_camera_view
from image_statistics import Comparison, compare

SEEDS = 8


def measure(scene: bpy.types.Scene, engine: str, samples: int) -> np.ndarray:
    """(SEEDS, height, width, 3) of one scene."""
    return np.stack([rendering.render(scene, engine, seed=1 + seed, samples=samples) for seed in range(SEEDS)])


def compare_engines(scene: bpy.types.Scene, samples: int) -> Comparison:
    """Cycles, which samples lights too, gets by with half as many samples."""
    return compare(measure(scene, "CYCLES", samples // 2), measure(scene, "BENTLIGHT", samples))


@pytest.mark.parametrize("light", flat.LIGHTS)
def test_light(light):
    scene = flat.build("principled", light)
    rendering.set_size(scene, 60, 36)
    comparison = compare_engines(scene, 64)
    assert comparison.precision < 0.004  # or the test would overlook too much
    assert not comparison.differs(), str(comparison)


@functools.cache
def studio() -> tuple[np.ndarray, np.ndarray, dict[str, tuple[slice, slice]]]:
    """All materials in one picture by both engines, and where in it the middle of each sphere is."""
    scene = flat.build("all", "environment")  # light from everywhere makes little noise
    width, height = 192, 108
    rendering.set_size(scene, width, height)
    bpy.context.view_layer.update()
    up = scene.camera.matrix_world.col[1].xyz
    crops = {}
    for name in flat.MATERIALS:
        ball = scene.objects[name]
        center, top = (
            world_to_camera_view(scene, scene.camera, ball.location + up * shift)
            for shift in (0, 0.7 * ball.dimensions.z / 2)
        )
        half = round((top.y - center.y) * height)
        row, column = round((1 - center.y) * height), round(center.x * width)
        crops[name] = np.s_[:, row - half : row + half, column - half : column + half]
    rows = [edge for _, rows, _ in crops.values() for edge in (rows.start, rows.stop)]
    scene.render.use_border = True  # only what the crops need, and a row more above and below; the rest stays black
    scene.render.border_min_y, scene.render.border_max_y = 1 - (max(rows) + 1) / height, 1 - (min(rows) - 1) / height
    return measure(scene, "CYCLES", 64), measure(scene, "BENTLIGHT", 128), crops


@pytest.mark.parametrize("material", flat.MATERIALS)
def test_material(material):
    cycles, bentlight, crops = studio()
    comparison = compare(cycles[crops[material]], bentlight[crops[material]], block=3)
    assert comparison.precision < 0.01
    assert not comparison.differs(), str(comparison)
