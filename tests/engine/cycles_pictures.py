"""The same scene by Cycles: pixels that are points, and noisy pictures by seed."""

import bpy
import numpy as np

from tests.engine import stage

ENGINES = ("CYCLES", "BENTLIGHT")
NARROW = 0.01  # pixels: Cycles' narrowest filter


def point_pictures(tmp_path) -> tuple[np.ndarray, np.ndarray]:
    """RGB by Cycles and by Bentlight with one sample in the middle of each pixel, to half of NARROW."""
    scene = bpy.context.scene
    scene.cycles.samples = scene.bentlight.samples = 1
    scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = False
    scene.cycles.pixel_filter_type, scene.bentlight.pixel_filter = "BOX", "GAUSSIAN"
    scene.cycles.filter_width = scene.render.filter_size = NARROW
    return _pictures(tmp_path)


def noisy_pictures(tmp_path, seeds: int, samples: int, engines: tuple[str, ...] = ENGINES) -> tuple[np.ndarray, ...]:
    """RGB by each of the engines, (seeds, height, width, 3)."""
    scene = bpy.context.scene
    scene.cycles.samples = scene.bentlight.samples = samples
    scene.cycles.use_denoising = scene.cycles.use_light_tree = False
    scene.cycles.use_adaptive_sampling = scene.bentlight.use_adaptive_sampling = False
    scene.cycles.max_bounces = scene.cycles.diffuse_bounces = scene.cycles.glossy_bounces = scene.bentlight.max_bounces
    scene.cycles.sample_clamp_indirect = 0
    scene.cycles.pixel_filter_type = scene.bentlight.pixel_filter = "BOX"
    pictures = []
    for seed in range(seeds):
        scene.cycles.seed = scene.bentlight.seed = seed
        pictures.append(_pictures(tmp_path, engines))
    return tuple(np.stack(of_engine) for of_engine in zip(*pictures, strict=True))


def _pictures(tmp_path, engines: tuple[str, ...] = ENGINES) -> tuple[np.ndarray, ...]:
    found = []
    for engine in engines:
        bpy.context.scene.render.engine = engine
        found.append(stage.render(tmp_path)["Combined"][..., :3])
    return tuple(found)
