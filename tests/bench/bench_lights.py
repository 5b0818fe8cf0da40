"""Noise against time: light found by chance and by connections, and flat rooms beside Cycles.

Every estimate is unbiased, so its mean squared error is its variance, told from pictures of several seeds; it falls as
1 / time. The figure of merit is the product of the two: how long a picture takes to a given error. A few pixels may
hold most of it, so that it is also told without them, and how much of it is luck. Beside Cycles differences are small:
there the pictures are more and take more samples. Where a small lamp is mirrored in glass and metal nearly all of the
error is in a few known pixels: those are rendered by themselves with many more seeds.
"""

import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from time import perf_counter
from typing import NamedTuple

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
CLOSE_SEEDS = 128
WORST = 0.01  # the share of the pixels that is left out
RESAMPLES = 300  # of the bootstrap
CONFIDENCE = 0.95


class Part(NamedTuple):
    """Pixels of a picture from its left and its top, ends not included."""

    left: int
    right: int
    top: int
    bottom: int

    def set_border(self, scene: bpy.types.Scene) -> None:
        """Lets only this part be rendered, and saved."""
        render = scene.render
        width, height = RESOLUTION
        inside = 0.01  # of a pixel: rounding goes to neither side
        render.use_border = render.use_crop_to_border = True
        render.border_min_x, render.border_max_x = (self.left + inside) / width, (self.right + inside) / width
        render.border_min_y = (height - self.bottom + inside) / height
        render.border_max_y = (height - self.top + inside) / height


# Where the lamp of 10 cm is mirrored in the flat room, by the glass sphere and by the brass one.
MIRRORED = (Part(62, 68, 37, 42), Part(67, 74, 23, 28))


@dataclass(frozen=True)
class Efficiency:
    """One way to render one room: seconds a picture; pictures of an even number of seeds, (seeds, height, width, 3);
    and those of parts of it, of other seeds, which are believed rather.
    """

    room: str
    way: str
    samples: int
    seconds: float
    pictures: np.ndarray
    close_ups: dict[Part, np.ndarray] = field(default_factory=dict)

    @cached_property
    def variance(self) -> np.ndarray:
        """Of each pixel, told from the first and the second half of the seeds, (2, height, width)."""
        return np.array([half.var(axis=0, ddof=1).mean(axis=-1) for half in np.split(self.pictures, 2)])

    @property
    def rest_squares(self) -> np.ndarray:
        """Squared deviations that add up to the variance, (seeds, pixels), 0 in close-ups."""
        squares = squared_deviations(self.pictures)
        for part in self.close_ups:
            squares[:, part.top : part.bottom, part.left : part.right] = 0
        return squares.reshape(len(squares), -1)

    @property
    def close_squares(self) -> list[np.ndarray]:
        """The same of each close-up, (seeds,)."""
        return [squared_deviations(pictures).sum(axis=(1, 2)) for pictures in self.close_ups.values()]

    @property
    def error2(self) -> float:
        """The mean squared error."""
        return (self.rest_squares.sum() + sum(each.sum() for each in self.close_squares)) / self.rest_squares.shape[1]

    @property
    def cost(self) -> float:
        """Seconds to a mean squared error of 1."""
        return self.seconds * self.error2


def squared_deviations(pictures: np.ndarray) -> np.ndarray:
    """From the mean of the seeds, so that they add up to the pixels' variances: (seeds, height, width)."""
    return ((pictures - pictures.mean(axis=0)) ** 2).mean(axis=-1) / (len(pictures) - 1)


def gain(first: Efficiency, other: Efficiency) -> float:
    """How many times lower than with the first way the mean squared error is in the same time."""
    return first.cost / other.cost


def gain_interval(first: Efficiency, other: Efficiency) -> tuple[float, float]:
    """The interval that holds the gain with the chance CONFIDENCE, by bootstrap: seeds are drawn again, for each way by
    themselves, and pixels but those of close-ups, for both together. What no seed has met it cannot know of.
    """
    random = np.random.default_rng(1)

    def weights(count: int) -> np.ndarray:
        return random.multinomial(count, np.full(count, 1 / count), size=RESAMPLES)

    pixel_weight = weights(first.rest_squares.shape[1])
    costs = []
    for way in (first, other):
        error2 = (weights(len(way.pictures)) @ way.rest_squares * pixel_weight).sum(axis=1)
        error2 += sum(weights(len(squares)) @ squares for squares in way.close_squares)
        costs.append(way.seconds * error2)
    low, high = np.quantile(costs[0] / costs[1], [(1 - CONFIDENCE) / 2, (1 + CONFIDENCE) / 2])
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


def measure(
    scene: bpy.types.Scene, room: str, ways: dict[str, int], seeds: int = SEEDS, parts: tuple[Part, ...] = ()
) -> list[Efficiency]:
    """Renders a picture a seed in every way, with as many samples as it names, by turns; then parts of it, CLOSE_SEEDS
    times.
    """
    scene.render.resolution_x, scene.render.resolution_y = RESOLUTION
    scene.render.image_settings.file_format = "OPEN_EXR"
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "picture.exr"
        pictures, seconds = take_turns(scene, ways, range(seeds), path)
        close_ups: dict[str, dict[Part, np.ndarray]] = {way: {} for way in ways}
        for part in parts:
            part.set_border(scene)
            for way, taken in take_turns(scene, ways, range(seeds, seeds + CLOSE_SEEDS), path)[0].items():
                close_ups[way][part] = taken
    made = [Efficiency(room, way, ways[way], seconds[way], pictures[way], close_ups[way]) for way in ways]
    for each in made:
        common.log.info("%s, %s: %.2f s, error %.4f", room, each.way, each.seconds, each.error2**0.5)
    return made


def take_turns(
    scene: bpy.types.Scene, ways: dict[str, int], seeds: range, path: Path
) -> tuple[dict[str, np.ndarray], dict[str, float]]:
    """Pictures of every way, (seeds, height, width, 3), and how long one takes."""
    pictures: dict[str, list[np.ndarray]] = {way: [] for way in ways}
    times: dict[str, list[float]] = {way: [] for way in ways}
    for seed in seeds:
        for way, samples in ways.items():
            choose(scene, way, samples, seed)
            begin = perf_counter()
            pictures[way].append(pixels(scene, path))
            times[way].append(perf_counter() - begin)
    return ({way: np.array(pictures[way]) for way in ways}, {way: float(np.median(times[way])) for way in ways})


def without_caustics(scene: bpy.types.Scene) -> bpy.types.Scene:
    """Diffuse surfaces see no light by way of glass and mirrors, in Cycles neither."""
    for settings in (scene.bentlight, scene.cycles):
        settings.caustics_reflective = settings.caustics_refractive = False
    return scene


def measure_all() -> list[Efficiency]:
    """Every room by chance and by connections, some bidirectionally; the flat ones by Cycles too."""
    chance, both_ends, cycles = ("SCATTERING", "BOTH"), ("SCATTERING", "BOTH", "BIDIRECTIONAL"), ("CYCLES", "BOTH")
    rooms: list[tuple[str, Callable[[], bpy.types.Scene], tuple[str, ...], int, int, tuple[Part, ...]]] = [
        ("room_schwarzschild", room_schwarzschild.build, both_ends, SAMPLES, SEEDS, ()),
        ("room_schwarzschild, lamp of 10 cm", small_lamp, both_ends, SAMPLES, SEEDS, ()),
        ("room_kerr", room_kerr.build, chance, SAMPLES, SEEDS, ()),
        ("room_wormhole", room_wormhole.build, both_ends, SAMPLES, SEEDS, ()),
        ("room_wormhole, lit from the other side", wormhole_lamp.build, both_ends, SAMPLES, SEEDS, ()),
        ("caustic_glass", caustic_glass.build, ("BOTH", "BIDIRECTIONAL"), SAMPLES, SEEDS, ()),
        ("flat room", lambda: flat(room_schwarzschild.build), cycles, 64, 16, ()),
        ("flat room, lamp of 10 cm", lambda: flat(small_lamp), cycles, 512, 8, MIRRORED),
        ("the same without caustics", lambda: without_caustics(flat(small_lamp)), cycles, 512, 6, MIRRORED),
    ]
    return [
        made
        for room, build, ways, samples, seeds, parts in rooms
        for made in measure(build(), room, dict.fromkeys(ways, samples), seeds, parts)
    ]
