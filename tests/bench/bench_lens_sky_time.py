"""What a lens costs Cycles where nothing but the lens and an image of the sky behind it fills the picture: processor
time a sample, which in a room is lost among all else."""

import sys
import tempfile
import time
from pathlib import Path

import bpy
import numpy as np
from bentlight_native import write_exr
from measure import side_by_side

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "examples"))
import common
import objects

RESOLUTION = (240, 135)
SAMPLES = 96
_RADIUS, _DISTANCE = 15.0, 20.0  # of the lens and of the camera, which stays outside, in masses: 97 degrees
_CASES = {  # whether there is a lens, its spin, sky filter
    "no lens": (False, 0.0, 0.0),
    "lens": (True, 0.0, 0.0),
    "lens, sky filter": (True, 0.0, 1.0),
    "lens, spin 0.9": (True, 0.9, 0.0),
    "lens, spin 0.9, sky filter": (True, 0.9, 1.0),
}


def measure(runs: int = 5) -> dict[str, float]:
    """Processor time a sample in seconds, all in Open Shading Language; without what a picture of one sample takes."""
    with tempfile.TemporaryDirectory() as folder:
        scene = build(Path(folder))
        works = {
            (name, samples): lambda case=case, samples=samples: render(scene, *case, samples)
            for name, case in _CASES.items()
            for samples in (1, SAMPLES)
        }
        times = side_by_side(works, runs, time.process_time)
    count = RESOLUTION[0] * RESOLUTION[1] * (SAMPLES - 1)
    return {name: (times[name, SAMPLES] - times[name, 1]) / count for name in _CASES}


def build(folder: Path) -> bpy.types.Scene:
    """A hole whose lens fills the picture, before a smooth image; nothing else."""
    scene = common.new_scene("CYCLES", resolution=RESOLUTION)
    waves = 0.5 + 0.4 * np.sin(np.linspace(0, 20 * np.pi, 1024)) * np.ones((512, 1))
    write_exr(folder / "sky.exr", {name: waves.astype(np.float32) for name in "RGB"}, {})
    objects.set_world_image(bpy.data.images.load(str(folder / "sky.exr")))
    bpy.ops.bentlight.black_hole_add(mass=1.0, location=(0, 0, 0))
    bpy.context.object.bentlight.lens_radius = _RADIUS
    objects.camera((0, -_DISTANCE, 1), (0, 0, 0), lens_mm=40)
    bpy.ops.bentlight.cycles_setup()
    scene.cycles.shading_system = True
    scene.render.filepath = str(folder / "sky.png")
    return scene


def render(scene: bpy.types.Scene, lens: bool, spin: float, sky_filter: float, samples: int) -> None:
    """One picture of a case."""
    hole = next(obj for obj in scene.objects if obj.bentlight.kind == "BLACK_HOLE")
    hole.hide_render, hole.bentlight.spin = not lens, spin
    scene.bentlight.sky_filter, scene.cycles.samples = sky_filter, samples
    bpy.context.view_layer.update()
    bpy.ops.render.render()
