"""Noise against time: light found by chance and by connections, and flat rooms beside Cycles.

Every estimate is unbiased, so its mean squared error is its variance, told from pictures of several seeds; it falls as
1 / time. The figure of merit is the product of the two: how long a picture takes to a given error. A few pixels may
hold most of it, so that it is also told without them, and how much of it is luck. Beside Cycles differences are small:
there the pictures are more and take more samples, most where a small lamp is seen in glass and metal.
"""

import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
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
RESAMPLES = 300  # of the bootstrap
CONFIDENCE = 0.95


@dataclass(frozen=True)
class Efficiency:
    """One way to render one room: seconds a picture, and the pictures of an even number of seeds,
    (seeds, height, width, 3).
    """

    room: str
    way: str
    samples: int
    seconds: float
    pictures: np.ndarray

    @cached_property
    def variance(self) -> np.ndarray:
        """Of each pixel, told from the first and the second half of the seeds, (2, height, width)."""
        return np.array([half.var(axis=0, ddof=1).mean(axis=-1) for half in np.split(self.pictures, 2)])

    @property
    def error2(self) -> float:
        """The mean squared error."""
        return float(self.pictures.var(axis=0, ddof=1).mean())

    @property
    def cost(self) -> float:
        """Seconds to a mean squared error of 1."""
        return self.seconds * self.error2


def gain(first: Efficiency, other: Efficiency) -> float:
    """How many times lower than with the first way the mean squared error is in the same time."""
    return first.cost / other.cost


def gain_interval(first: Efficiency, other: Efficiency) -> tuple[float, float]:
    """The interval that holds the gain with the chance CONFIDENCE, by bootstrap: seeds are drawn again, for each way by
    themselves, and pixels, for both together. What no seed has met it cannot know of.
    """
    random = np.random.default_rng(1)
    costs = []
    for way in (first, other):
        seeds = len(way.pictures)
        squares = ((way.pictures - way.pictures.mean(axis=0)) ** 2).mean(axis=-1).reshape(seeds, -1)
        seed_weight = random.multinomial(seeds, np.full(seeds, 1 / seeds), size=RESAMPLES)
        costs.append(way.seconds / (seeds - 1) * seed_weight @ squares)
    pixels = costs[0].shape[1]
    pixel_weight = random.multinomial(pixels, np.full(pixels, 1 / pixels), size=RESAMPLES)
    ratios = (costs[0] * pixel_weight).sum(axis=1) / (costs[1] * pixel_weight).sum(axis=1)
    low, high = np.quantile(ratios, [(1 - CONFIDENCE) / 2, (1 + CONFIDENCE) / 2])
    return float(low), float(high)


def gain_without_worst(first: Efficiency, other: Efficiency) -> float:
    """The same as gain without the pixels that are worst in either way. Those that some seeds name are judged by the
    others: a picture's own worst pixels are where chance has struck, and without those it would look better than it is.
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


def choose(scene: bpy.types.Scene, way: str, samples: int, seed: int) -> None:
    """Sets the scene up for one way: 'CYCLES', 'BIDIRECTIONAL' or one of Bentlight's kinds of light sampling."""
    scene.render.engine = "CYCLES" if way == "CYCLES" else "BENTLIGHT"
    scene.bentlight.integrator = "BIDIRECTIONAL" if way == "BIDIRECTIONAL" else "PATH"
    if way in ("BOTH", "SCATTERING", "CONNECTIONS"):
        scene.bentlight.light_sampling = way
    scene.bentlight.samples = scene.cycles.samples = samples
    scene.bentlight.seed = scene.cycles.seed = seed
    for limit in ("max_bounces", "diffuse_bounces", "glossy_bounces", "transmission_bounces"):
        setattr(scene.cycles, limit, scene.bentlight.max_bounces)
    scene.cycles.blur_glossy = scene.cycles.sample_clamp_indirect = 0  # Cycles' own biases, which cut noise


def measure(scene: bpy.types.Scene, room: str, ways: dict[str, int], seeds: int = SEEDS) -> list[Efficiency]:
    """Renders a picture a seed in every way, with as many samples as it names, by turns."""
    scene.render.resolution_x, scene.render.resolution_y = RESOLUTION
    scene.render.image_settings.file_format = "OPEN_EXR"
    pictures: dict[str, list[np.ndarray]] = {way: [] for way in ways}
    times: dict[str, list[float]] = {way: [] for way in ways}
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(seeds):
            for way, samples in ways.items():
                choose(scene, way, samples, seed)
                begin = perf_counter()
                pictures[way].append(pixels(scene, Path(folder) / "picture.exr"))
                times[way].append(perf_counter() - begin)
    made = [Efficiency(room, way, ways[way], float(np.median(times[way])), np.array(pictures[way])) for way in ways]
    for each in made:
        common.log.info("%s, %s: %.2f s, error %.4f", room, each.way, each.seconds, each.error2**0.5)
    return made


def without_caustics(scene: bpy.types.Scene) -> bpy.types.Scene:
    """Diffuse surfaces see no light by way of glass and mirrors, in Cycles neither."""
    for settings in (scene.bentlight, scene.cycles):
        settings.caustics_reflective = settings.caustics_refractive = False
    return scene


def measure_all() -> list[Efficiency]:
    """Every room by chance and by connections, some bidirectionally; the flat ones by Cycles too."""
    chance, both_ends, cycles = ("SCATTERING", "BOTH"), ("SCATTERING", "BOTH", "BIDIRECTIONAL"), ("CYCLES", "BOTH")
    rooms: list[tuple[str, Callable[[], bpy.types.Scene], tuple[str, ...], int, int]] = [
        ("room_schwarzschild", room_schwarzschild.build, both_ends, SAMPLES, SEEDS),
        ("room_schwarzschild, lamp of 10 cm", small_lamp, both_ends, SAMPLES, SEEDS),
        ("room_kerr", room_kerr.build, chance, SAMPLES, SEEDS),
        ("room_wormhole", room_wormhole.build, chance, SAMPLES, SEEDS),
        ("room_wormhole, lit from the other side", wormhole_lamp.build, both_ends, SAMPLES, SEEDS),
        ("caustic_glass", caustic_glass.build, ("BOTH", "BIDIRECTIONAL"), SAMPLES, SEEDS),
        ("flat room", lambda: flat(room_schwarzschild.build), cycles, 64, 16),
        ("flat room, lamp of 10 cm", lambda: flat(small_lamp), cycles, 256, 16),
        ("the same without caustics", lambda: without_caustics(flat(small_lamp)), cycles, 128, 16),
    ]
    return [
        made
        for room, build, ways, samples, seeds in rooms
        for made in measure(build(), room, dict.fromkeys(ways, samples), seeds)
    ]
