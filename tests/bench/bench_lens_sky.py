"""Flicker of an image of the sky behind a lens of Cycles, or seen by the relay camera, with and without the filter for
it: bench_sky.py's orbit and its figures, in pictures by Cycles."""

import sys
import tempfile
from pathlib import Path

import bpy
import numpy as np
from bench_sky import MASS, ORBIT, SkyFlicker, flicker, starry_image
from bentlight_native import write_exr

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "examples"))
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "images"))
import common
import objects
import rendering

_RADIUS = 15.0  # of the lens: the camera stays outside


def measure(
    frames: int = 48,
    size: tuple[int, int] = (96, 56),
    samples: int = 16,
    stars: int = 3000,
    filters: tuple[float, ...] = (0.0, 1.0),
    relay: bool = False,
) -> list[SkyFlicker]:
    """The flicker for each width of the filter."""
    with tempfile.TemporaryDirectory() as folder:
        scene = _scene(Path(folder), size, stars)
        camera = scene.camera
        if relay:
            bpy.ops.bentlight.relay_setup(bake=False)
        return [_measure(scene, camera, frames, samples, sky_filter) for sky_filter in filters]


def _scene(folder: Path, size: tuple[int, int], stars: int) -> bpy.types.Scene:
    scene = common.new_scene("CYCLES", resolution=size)
    pixels = starry_image(stars)[::-1]
    write_exr(folder / "sky.exr", {name: pixels[..., i] for i, name in enumerate("RGB")}, {})
    objects.set_world_image(bpy.data.images.load(str(folder / "sky.exr")))
    bpy.ops.bentlight.black_hole_add(mass=MASS, location=(0, 0, 0))
    bpy.context.object.bentlight.lens_radius = _RADIUS
    objects.camera((0, -20, 1), (0, 0, 0), lens_mm=18 * size[1] / (ORBIT.slope * size[0]))
    bpy.ops.bentlight.cycles_setup()
    return scene


def _measure(
    scene: bpy.types.Scene, camera: bpy.types.Object, frames: int, samples: int, sky_filter: float
) -> SkyFlicker:
    scene.bentlight.sky_filter = sky_filter
    pictures = []
    for frame in range(frames):
        turn = ORBIT.step * frame
        place = ORBIT.distance * np.array((np.sin(turn), -np.cos(turn), ORBIT.height))
        camera.location = place
        objects.look_at(camera, (0, 0, 0))
        pictures.append(
            [rendering.render(scene, "CYCLES", seed, samples)[..., 0] for seed in (frame + 1, frames + frame + 1)]
        )
    return flicker(sky_filter, np.array(pictures))
