"""Noise against time: light found by chance and by connections, and flat rooms beside Cycles.

Every estimate is unbiased, so its mean squared error is its variance, told from pictures of several seeds; it falls as
1 / time. The figure of merit is the product of the two: how long a picture takes to a given error. A few pixels may
hold most of it, so that it is also told without them.
"""

import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

import bpy
import numpy as np
import OpenEXR

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "examples"))
import caustic_glass
import common
import objects
import room_kerr
import room_schwarzschild
import room_wormhole
import wormhole_lamp

RESOLUTION = (96, 54)
SEEDS = 8
SAMPLES = 32
WORST = 0.01  # the share of the pixels that is left out


@dataclass(frozen=True)
class Efficiency:
    """One way to render one room: seconds a picture, and the variance of each pixel, told from the first and the second
    half of the seeds, (2, height, width).
    """

    room: str
    way: str
    samples: int
    seconds: float
    variance: np.ndarray

    @property
    def error2(self) -> float:
        """The mean squared error."""
        return float(self.variance.mean())

    @property
    def cost(self) -> float:
        """Seconds to a mean squared error of 1."""
        return self.seconds * self.error2


def gain(first: Efficiency, other: Efficiency) -> float:
    """How many times lower than with the first way the mean squared error is in the same time."""
    return first.cost / other.cost


def gain_without_worst(first: Efficiency, other: Efficiency) -> float:
    """The same without the pixels that are worst in either way. Those that some seeds name are judged by the others:
    a picture's own worst pixels are where chance has struck, and without those it would look better than it is.
    """
    costs = np.zeros(2)
    for judges, judged in ((0, 1), (1, 0)):
        rank = sum(way.variance[judges] / max(way.variance[judges].mean(), 1e-300) for way in (first, other))
        kept = np.argsort(rank, axis=None)[: round(rank.size * (1 - WORST))]
        costs += [way.seconds * way.variance[judged].ravel()[kept].sum() for way in (first, other)]
    return float(costs[0] / costs[1])


def small_lamp() -> bpy.types.Scene:
    """The room with a hole, lit by one lamp of 10 cm."""
    scene = room_schwarzschild.build()
    for name in ("Ceiling lamp", "Window"):
        bpy.data.objects.remove(bpy.data.objects[name])
    objects.area_light("Small lamp", (1.2, -1.0, 3.4), (0, 0, 1), (0.1, 0.1), 230)
    return scene


def flat(build: Callable[[], bpy.types.Scene]) -> bpy.types.Scene:
    """The same without its hole."""
    scene = build()
    for obj in scene.objects:
        obj.bentlight.kind = "NONE"
    return scene


def pixels(scene: bpy.types.Scene, path: Path) -> np.ndarray:
    """One picture, linear RGB."""
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    channels = OpenEXR.File(str(path), separate_channels=True).channels()
    planes = [channels[next(n for n in channels if n.endswith(f".{c}") or n == c)].pixels for c in "RGB"]
    return np.stack(planes, axis=-1).astype(float)


def measure(scene: bpy.types.Scene, room: str, way: str, samples: int) -> Efficiency:
    """Renders SEEDS pictures as `way` says: 'CYCLES', 'BIDIRECTIONAL' or one of Bentlight's kinds of light sampling."""
    scene.render.engine = "CYCLES" if way == "CYCLES" else "BENTLIGHT"
    scene.bentlight.integrator = "BIDIRECTIONAL" if way == "BIDIRECTIONAL" else "PATH"
    if way in ("BOTH", "SCATTERING", "CONNECTIONS"):
        scene.bentlight.light_sampling = way
    scene.bentlight.samples = scene.cycles.samples = samples
    for limit in ("max_bounces", "diffuse_bounces", "glossy_bounces", "transmission_bounces"):
        setattr(scene.cycles, limit, scene.bentlight.max_bounces)
    scene.cycles.blur_glossy = scene.cycles.sample_clamp_indirect = 0  # Cycles' own biases, which cut noise
    scene.render.resolution_x, scene.render.resolution_y = RESOLUTION
    scene.render.image_settings.file_format = "OPEN_EXR"
    pictures, times = [], []
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(SEEDS):
            scene.bentlight.seed = scene.cycles.seed = seed
            begin = perf_counter()
            pictures.append(pixels(scene, Path(folder) / "picture.exr"))
            times.append(perf_counter() - begin)
    halves = np.split(np.array(pictures), 2)
    variance = np.array([half.var(axis=0, ddof=1).mean(axis=-1) for half in halves])
    made = Efficiency(room, way, samples, float(np.median(times)), variance)
    common.log.info("%s, %s: %.2f s, error %.4f", room, way, made.seconds, made.error2**0.5)
    return made


def measure_all() -> list[Efficiency]:
    """Every room by chance and by connections, some bidirectionally; the flat ones by Cycles too."""
    rooms: list[tuple[str, Callable[[], bpy.types.Scene], tuple[str, ...]]] = [
        ("room_schwarzschild", room_schwarzschild.build, ("SCATTERING", "BOTH", "BIDIRECTIONAL")),
        ("room_schwarzschild, lamp of 10 cm", small_lamp, ("SCATTERING", "BOTH", "BIDIRECTIONAL")),
        ("room_kerr", room_kerr.build, ("SCATTERING", "BOTH")),
        ("room_wormhole", room_wormhole.build, ("SCATTERING", "BOTH")),
        ("room_wormhole, lit from the other side", wormhole_lamp.build, ("SCATTERING", "BOTH", "BIDIRECTIONAL")),
        ("caustic_glass", caustic_glass.build, ("BOTH", "BIDIRECTIONAL")),
        ("flat room", lambda: flat(room_schwarzschild.build), ("CYCLES", "BOTH")),
        ("flat room, lamp of 10 cm", lambda: flat(small_lamp), ("CYCLES", "BOTH")),
    ]
    return [measure(scene, room, way, SAMPLES) for room, build, ways in rooms for scene in [build()] for way in ways]
