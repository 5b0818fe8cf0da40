"""Flicker of stars in Cycles, through a lens or by the relay camera, with and without Sky Filter, beside the engine's:
bench_sky.py's orbit and its figures, with as many stars in place of texels.

The engine's picture has no noise, and tells where single stars are and what their light is. Two seeds of one frame show
what noise alone changes from one frame to the next: a star pops where one seed has twice the light of the other.
"""

import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np
from bench_sky import MASS, ORBIT, SkyFlicker, flicker

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "examples"))
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "images"))
import common
import objects
import rendering

_RADIUS = 15.0  # of the lens: the camera stays outside
_HALF = 2  # pixels beside its brightest one in which a star's light is


@dataclass(frozen=True)
class StarFlicker:
    """Of one animation. sky: of all light and of 4 x 4 pixels. light: of all frames, over the engine's, with its
    standard error; a lens bends within its sphere alone, so that it shows other stars at the picture's edge. star: the
    change of a single image by noise, over its light (root mean square). pops: which part of images have twice the
    light in one seed's picture that they have in the other's."""

    samples: int
    sky: SkyFlicker
    light: float
    light_error: float
    star: float
    pops: float
    images: int  # that were looked at


def measure(
    frames: int = 48,
    size: tuple[int, int] = (96, 56),
    settings: tuple[tuple[int, float], ...] = ((16, 0.0), (16, 1.0), (64, 1.0)),
    stars: int = 3000,
    relay: bool = False,
) -> list[StarFlicker]:
    """The flicker for each number of samples and width of the filter."""
    with tempfile.TemporaryDirectory() as folder:
        scene = _scene(Path(folder), size, stars)
        camera = scene.camera
        truth = np.array([_frame(scene, camera, frame, "BENTLIGHT", 0, 1) for frame in range(frames)])
        if relay:
            bpy.ops.bentlight.relay_setup(bake=False)
        return [_measure(scene, camera, truth, *each) for each in settings]


def _scene(folder: Path, size: tuple[int, int], stars: int) -> bpy.types.Scene:
    scene = common.new_scene("CYCLES", resolution=size)
    world = scene.world.bentlight
    world.stars, world.star_catalog, world.star_strength = "CATALOG", str(folder / "stars.csv"), 1e6
    rng = np.random.default_rng(1)
    declination = np.degrees(np.arcsin(rng.uniform(-1, 1, stars)))
    where = zip(rng.uniform(0, 360, stars), declination, strict=True)
    (folder / "stars.csv").write_text("".join(f"{a},{d},0\n" for a, d in where))
    bpy.ops.bentlight.black_hole_add(mass=MASS, location=(0, 0, 0))
    bpy.context.object.bentlight.sphere_radius = bpy.context.object.bentlight.lens_radius = _RADIUS
    objects.camera((0, -20, 1), (0, 0, 0), lens_mm=18 * size[1] / (ORBIT.slope * size[0]))
    bpy.ops.bentlight.cycles_setup()
    return scene


def _frame(
    scene: bpy.types.Scene, camera: bpy.types.Object, frame: int, engine: str, seed: int, samples: int
) -> np.ndarray:
    turn = ORBIT.step * frame
    camera.location = ORBIT.distance * np.array((np.sin(turn), -np.cos(turn), ORBIT.height))
    objects.look_at(camera, (0, 0, 0))
    return rendering.render(scene, engine, seed, samples)[..., 0]


def _measure(
    scene: bpy.types.Scene, camera: bpy.types.Object, truth: np.ndarray, samples: int, sky_filter: float
) -> StarFlicker:
    scene.bentlight.sky_filter = sky_filter
    frames = len(truth)
    pictures = np.array(
        [[_frame(scene, camera, i, "CYCLES", seed, samples) for seed in (i + 1, frames + i + 1)] for i in range(frames)]
    )
    each = np.array([pair for i in range(frames) for pair in _images(truth[i], pictures[i])])
    light = pictures.sum((2, 3)) / truth.sum((1, 2))[:, None]
    change, mean = each[:, 1] - each[:, 2], each[:, 0]
    return StarFlicker(
        samples,
        flicker(sky_filter, pictures),
        light.mean(),
        light.std(ddof=1) / np.sqrt(light.size),
        np.sqrt((change**2 / 2 / mean**2).mean()),
        (each[:, 1:].max(1) > 2 * each[:, 1:].min(1)).mean(),
        len(each),
    )


def _images(truth: np.ndarray, pictures: np.ndarray) -> list[tuple[float, ...]]:
    """Light of single images, with nothing bright beside them: the engine's, and that of both seeds."""
    found, side = [], 2 * _HALF + 1
    around = np.lib.stride_tricks.sliding_window_view(truth, (side + 4, side + 4))
    for y, x in np.argwhere(truth[_HALF + 2 : -_HALF - 2, _HALF + 2 : -_HALF - 2] == around.max((2, 3))):
        inner = slice(y + 2, y + 2 + side), slice(x + 2, x + 2 + side)
        light = truth[inner].sum()
        if light > 0.9 * around[y, x].sum() > 0:
            found.append((light, *(picture[inner].sum() for picture in pictures)))
    return found
