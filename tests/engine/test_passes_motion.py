"""Passes while things move: means over the moments of the shutter, or what the first of them sees, pixel by pixel."""

import bpy
import numpy as np
import pytest

from blender_addon.passes import PASSES
from blender_addon.sync.cryptomatte import name_as_float
from blender_addon.sync.shutter import Shutter
from blender_addon.sync.slices import slices
from tests.engine import stage
from tests.engine.stage import blender  # noqa: F401 (a fixture)

NAMES = {item.channel: item.name for item in PASSES}
SLICES, SAMPLES, SEED = 8, 32, 3
GLOW, WALL = np.array([3.0, 0.5, 0.25]), np.array([0.1, 0.2, 0.4])
SLOPE = np.sin(0.5), np.cos(0.5)  # of the square, which is turned about x
SPEED, HEIGHT, HALF, BEHIND = 1.6, 4.0, 0.35, -1.0  # per frame; of the camera; of the square's side; the wall's z


@pytest.fixture
def scene(blender) -> bpy.types.Scene:  # noqa: F811
    """A shining square, tilted, that goes by before a wall, the shutter open for half a frame around frame 5."""
    scene = bpy.context.scene
    stage.add_camera((0, 0, HEIGHT))
    stage.add_square(30, (0, 0, BEHIND), stage.emission(WALL, name="Wall"), "Wall").pass_index = 3
    square = stage.add_square(2 * HALF, (0, 0, 0), stage.emission(GLOW), "Square")
    square.rotation_euler, square.pass_index = (0.5, 0, 0), 7
    for frame in (0, 10):
        square.location.x = SPEED * (frame - 5)
        square.keyframe_insert("location", frame=frame)
    stage.make_even(square)
    scene.frame_set(5)
    scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 0.5
    settings = scene.bentlight
    settings.samples, settings.motion_slices, settings.seed = SAMPLES, SLICES, SEED
    settings.pixel_filter, settings.use_adaptive_sampling = "GAUSSIAN", False
    scene.render.filter_size = 0.01
    return scene


def square_seen_at(time: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """By rays through the centers of pixels, (48, 64): whether the square is met, its depth, and whether that is sure
    as its edge is more than a fiftieth of a pixel away."""
    x, y = np.meshgrid((np.arange(64) + 0.5 - 32) * 36 / 50 / 64, (np.arange(48) + 0.5 - 24) * 36 / 50 / 64)
    depth = HEIGHT * SLOPE[1] / (SLOPE[1] + y * SLOPE[0])  # -y sin + z cos = 0 where z = HEIGHT - depth
    across, along = depth * x - SPEED * (time - 5), depth * y / SLOPE[1]
    beyond = np.maximum(np.abs(across), np.abs(along)) - HALF
    return beyond < 0, depth, np.abs(beyond) > HEIGHT * 36 / 50 / 64 / 50


def moments(scene: bpy.types.Scene) -> list[float]:
    """Frames of the slices, all of as many samples, in the order in which they are taken."""
    every = slices(SAMPLES, SLICES, SEED)
    assert {part.count for part in every} == {SAMPLES // SLICES}
    return [Shutter(scene).frame_of_light(part.light) for part in every]


def coverage(passes: dict[str, np.ndarray], name: str) -> np.ndarray:
    """(48, 64): how much of each pixel an object is, by Cryptomatte."""
    pairs = np.concatenate([passes[f"CryptoObject{i:02}"] for i in range(3)], axis=-1).reshape(48, 64, 6, 2)
    return (pairs[..., 1] * (pairs[..., 0] == np.float32(name_as_float(name)))).sum(axis=-1)


def test_passes_are_of_the_moments_of_the_shutter(scene, tmp_path):
    """Light, normals, mist and mattes are means; depth, places and indices are of the first moment, in the middle."""
    layer = scene.view_layers[0]
    for channel in ("depth", "normal", "position", "emission", "object_index", "mist"):
        setattr(layer, next(item.toggle for item in PASSES if item.channel == channel), True)
    layer.use_pass_cryptomatte_object = True
    scene.world = bpy.data.worlds.new("World")
    scene.world.mist_settings.start, scene.world.mist_settings.depth = 2.0, 10.0
    scene.world.mist_settings.falloff = "LINEAR"
    times = moments(scene)
    passes = stage.render(tmp_path)
    seen = [square_seen_at(time) for time in times]
    sure = np.logical_and.reduce([item[2] for item in seen])
    part = np.mean([item[0] for item in seen], axis=0)
    assert sure.mean() > 0.9 and set(np.unique(part[sure])) >= set(np.arange(SLICES // 2) / SLICES)
    color = part[..., None] * GLOW + (1 - part[..., None]) * WALL
    np.testing.assert_allclose(passes["Combined"][sure][:, :3], color[sure], rtol=1e-5)
    np.testing.assert_allclose(passes[NAMES["emission"]][sure], color[sure], rtol=1e-5)
    normal = part[..., None] * (0, -SLOPE[0], SLOPE[1]) + (1 - part[..., None]) * (0, 0, 1)
    np.testing.assert_allclose(passes["Normal"][sure], normal[sure], atol=1e-5)
    np.testing.assert_allclose(coverage(passes, "Square")[sure], part[sure], atol=1e-6)
    np.testing.assert_allclose(coverage(passes, "Square") + coverage(passes, "Wall"), 1, atol=1e-6)
    first, depth, _ = seen[0]
    assert abs(times[0] - 5) < 0.5 / SLICES
    depth = np.where(first, depth, HEIGHT - BEHIND)
    np.testing.assert_allclose(passes["Depth"][sure][:, 0], depth[sure], rtol=1e-4)
    np.testing.assert_allclose(passes["Position"][sure][:, 2], HEIGHT - depth[sure], atol=4e-4)
    np.testing.assert_array_equal(passes[NAMES["object_index"]][sure][:, 0], np.where(first, 7, 3)[sure])
    slope = np.stack(np.meshgrid(*[(np.arange(n) + 0.5 - n / 2) * 36 / 50 / 64 for n in (64, 48)]))
    way = np.sqrt(1 + (slope**2).sum(axis=0)) * [np.where(met, depth, HEIGHT - BEHIND) for met, depth, _ in seen]
    np.testing.assert_allclose(passes["Mist"][sure][:, 0], ((way - 2) / 10).mean(axis=0)[sure], atol=1e-4)
