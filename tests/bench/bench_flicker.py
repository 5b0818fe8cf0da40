"""Flicker of an animation: how much noise changes the photon ring from frame to frame, beside ordinary edges.

A camera orbits a Schwarzschild hole in a room whose walls, floor and boxes shine by themselves in squares of two
brightnesses: each square's border is an edge of the mesh, and noise comes from edges alone. Every frame is rendered
with two seeds, each the same for the whole animation. The difference between their changes from one frame to the next
is free of the true change; half its mean square is the variance of a change by noise. The flicker of a set of pixels
is the root of that, over the contrast of the squares.

Pixels of the ring: where photon_ring_samples could ask for 8 samples or more. Of ordinary edges: where it asks for no
more than 1, and a third seed's samples saw squares of both kinds (neither less than a tenth).
"""

from dataclasses import dataclass

import bentlight_native
import numpy as np
from orbit import Orbit

DARK, BRIGHT = 0.2, 0.8
HALF_WIDTH, SQUARES = 8.0, 8  # of the room; squares along a wall
MASS = 0.35
ORBIT = Orbit(distance=7.0, height=0.2, step=np.radians(0.5), slope=0.6)


@dataclass(frozen=True)
class Flicker:
    """Of one animation: flicker of the ring's and the edges' pixels, each with its standard error over the frames."""

    ring_samples: int
    ring: float
    edge: float
    ring_error: float
    edge_error: float
    samples: float  # a pixel, on average


def _squares(count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The square [-1, 1]^2 in the plane z = 0, as a board of count x count: vertices, triangles, colors 0 or 1."""
    line = np.linspace(-1, 1, count + 1)
    vertices = np.array([(x, y, 0) for y in line for x in line], np.float32)
    row, column = np.divmod(np.arange(count * count), count)
    corner = row * (count + 1) + column
    lower = np.stack([corner, corner + 1, corner + count + 2], axis=1)
    upper = np.stack([corner, corner + count + 2, corner + count + 1], axis=1)
    triangles = np.stack([lower, upper], axis=1).reshape(-1, 3)
    return vertices, triangles.astype(np.uint32), np.repeat((row + column) % 2, 2).astype(np.uint32)


def _glowing(brightness: float) -> bentlight_native.Program:
    builder = bentlight_native.ProgramBuilder()
    builder.emit("emission", builder.constant(1), builder.constant(brightness), builder.constant(1))
    return builder.build()


def _cube_sides(center: tuple[float, float, float], half: float) -> list[np.ndarray]:
    """world_from_square of the six sides of a cube."""
    sides = []
    for axis in range(3):
        for sign in (-1, 1):
            matrix = np.eye(4)
            matrix[:3, :3] = np.roll(np.eye(3), axis, axis=0) * half
            matrix[:3, 3] = np.asarray(center) + sign * matrix[:3, 2]
            sides.append(matrix)
    return sides


def room() -> bentlight_native.Scene:
    """The room with its hole, without a camera."""
    scene = bentlight_native.Scene()
    materials = np.array([scene.add_material(_glowing(value)) for value in (DARK, BRIGHT)], np.int32)
    cubes = [((0, 0, 0), HALF_WIDTH, SQUARES)]
    cubes += [((x, y, -6.5), 1.5, 2) for x, y in ((4, 3), (-4, -3), (-3, 4), (3, -4))]
    for center, half, squares in cubes:
        vertices, triangles, colors = _squares(squares)
        mesh = scene.add_mesh(vertices, triangles, material_slots=colors)
        for matrix in _cube_sides(center, half):
            scene.add_instance(mesh, matrix, materials=materials)
    scene.set_spacetime(bentlight_native.Spacetime.schwarzschild(MASS))
    return scene


def render(
    scene: bentlight_native.Scene, size: tuple[int, int], samples: int, seed: int, ring_samples: int
) -> np.ndarray:
    """Brightness and number of samples of each pixel, (2, height, width)."""
    width, height = size
    settings = bentlight_native.RenderSettings(
        width, height, sample_count=samples, seed=seed, photon_ring_samples=ring_samples, max_bounces=0
    )
    channels = {
        name: np.empty((height, width, components), np.float32)
        for name, components in (("combined", 4), ("sample_count", 1))
    }
    scene.render_tile(0, 0, width, height, settings, channels)
    return np.stack([channels["combined"][..., 0], channels["sample_count"][..., 0]]).astype(float)


def _kinds(scene: bentlight_native.Scene, size: tuple[int, int], samples: int) -> np.ndarray:
    """Whether pixels belong to the ring and to edges, (2, height, width)."""
    value, _ = render(scene, size, samples, 2, 1)
    multiple = render(scene, size, 1, 2, 64)[1]
    share = (value - DARK) / (BRIGHT - DARK)
    return np.stack([multiple >= 8, (multiple == 1) & (share > 0.1) & (share < 0.9)])


def measure(frames: int = 48, size: tuple[int, int] = (96, 54), samples: int = 32) -> list[Flicker]:
    """The flicker without and with up to 8 samples for one."""
    scene = room()
    difference: dict[int, list[np.ndarray]] = {1: [], 8: []}
    count, kinds = dict.fromkeys(difference, 0.0), []
    for frame in range(frames):
        ORBIT.place_camera(scene, frame, size[0] / size[1])
        kinds.append(_kinds(scene, size, samples))
        for ring_samples, list_ in difference.items():
            (a, taken), (b, _) = (render(scene, size, samples, seed, ring_samples) for seed in (0, 1))
            list_.append(a - b)
            count[ring_samples] += taken.mean() / frames
    both = np.array(kinds[1:]) & np.array(kinds[:-1])  # of the same kind in both frames
    results = []
    for ring_samples, list_ in difference.items():
        change = np.diff(list_, axis=0) ** 2 / 2 / (BRIGHT - DARK) ** 2
        variance = np.array([[step[kind].mean() for kind in pair] for step, pair in zip(change, both, strict=True)])
        mean = variance.mean(axis=0)
        error = variance.std(axis=0, ddof=1) / np.sqrt(len(variance)) / (2 * np.sqrt(mean))
        results.append(Flicker(ring_samples, *np.sqrt(mean), *error, count[ring_samples]))
    return results
