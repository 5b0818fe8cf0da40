"""The shadow's edge, and that of a wormhole's mouth, by the engine, the lens and the relay camera, to 0.3 pixel.

Pixels are the parts of them that see light: summed across the edge they say where it is. The truth is a closed form
without spin, the core's rays with it.
"""

import math
from collections.abc import Callable

import agreement
import bpy
import numpy as np
import objects
import pytest

WIDTH, HEIGHT = 48, 27
PARTS = 12  # truth: rays of a pixel in each direction
SAMPLES = 16
REACH = 3  # pixels on either side of the edge that are summed
Sees = Callable[[np.ndarray], np.ndarray]  # directions (n, 3) from the camera: whether light comes from there


def lit_world(name: str, place: str) -> tuple[bpy.types.Scene, list[bpy.types.Object]]:
    """A white world; beyond a wormhole's throat it is hidden by a black box around the other mouth."""
    scene = agreement.new_scene(WIDTH, HEIGHT)
    agreement.box_samples(scene)
    scene.bentlight.relay_parts = 2  # 10 at the edge
    objects.set_world((1, 1, 1))
    holes = agreement.add_hole(name)
    if len(holes) > 1:
        black = agreement.only_shader("Black", "ShaderNodeEmission", (0, 0, 0))
        objects.box("Box", holes[1].location, (20, 20, 20), black)
    agreement.add_camera(name, agreement.PLACES[place], holes[0])
    return scene, holes


def outside_cone(name: str, place: str, toward: np.ndarray) -> Sees:
    """Closed forms. b = r sin / sqrt(1 - 2M/r) of a local angle is 3 sqrt(3) M at the edge (Synge 1966), which is more
    than a right angle from toward the center within 3 M; b = r sin is a wormhole's throat radius. Outside of the sphere
    rays are straight until they enter it."""
    distance = float(np.linalg.norm(agreement.chart_point(name, agreement.PLACES[place])))
    R = min(distance, agreement.SPHERE)
    M = agreement.MASS
    if agreement.SPINS[name] is None:
        r = R + agreement.THROAT**2 / (4 * R)
        sine = agreement.THROAT / r
    else:
        r = R * (1 + M / (2 * R)) ** 2
        sine = math.sqrt(27 * (1 - 2 * M / r)) * M / r
    angle = math.asin(sine * R / distance)
    if agreement.SPINS[name] is not None and r < 3 * M:
        angle = math.pi - angle
    return lambda ahead: ahead @ toward < math.cos(angle)


def by_core(holes: list[bpy.types.Object], start: np.ndarray) -> Sees:
    return lambda ahead: agreement.by_core(holes, start, ahead)["fate"] == agreement.ESCAPED


def coverage(scene: bpy.types.Scene, sees: Sees) -> np.ndarray:
    """The part of each pixel that sees light, (HEIGHT, WIDTH); alike where all corners around it are."""

    def rays(x, y):  # in pixels from the upper left corner
        half = math.tan(scene.camera.data.angle / 2)
        right, up, back = np.array(scene.camera.matrix_world.to_3x3().normalized()).T
        sideways, upward = (2 * x - WIDTH) / WIDTH * half, (HEIGHT - 2 * y) / WIDTH * half
        found = sideways[:, None] * right + upward[:, None] * up - back
        return found / np.linalg.norm(found, axis=1, keepdims=True)

    y, x = np.mgrid[-1 : HEIGHT + 2, -1 : WIDTH + 2].reshape(2, -1)
    corners = sees(rays(x, y)).reshape(HEIGHT + 3, WIDTH + 3).astype(float)
    around = np.lib.stride_tricks.sliding_window_view(corners, (4, 4))  # of each pixel and its neighbors
    found = around.mean(axis=(2, 3))
    edge = np.argwhere((found > 0) & (found < 1))
    parts = (np.mgrid[0:PARTS, 0:PARTS].reshape(2, -1) + 0.5) / PARTS
    y, x = (edge.T[:, :, None] + parts[:, None]).reshape(2, -1)
    found[tuple(edge.T)] = sees(rays(x, y)).reshape(len(edge), -1).mean(axis=1)
    return found


def shifts(found: np.ndarray, truth: np.ndarray) -> np.ndarray:
    """How far `found` has the edge from the true one, in pixels and toward the light, at places all along it."""
    slope = np.gradient(truth)
    moved = []
    for i, j in np.argwhere((truth > 0.2) & (truth < 0.8)):
        down, right = (component[i, j] for component in slope)
        across_rows = abs(down) > abs(right)
        place, size = (i, HEIGHT) if across_rows else (j, WIDTH)
        if REACH <= place < size - REACH:
            span = slice(place - REACH, place + REACH + 1)
            line = (span, j) if across_rows else (i, span)
            cosine = max(abs(down), abs(right)) / math.hypot(down, right)
            moved.append(cosine * np.sum(truth[line] - found[line]))
    return np.array(moved)


@pytest.mark.parametrize(("name", "place"), agreement.CASES)
def test_the_edge_is_where_it_should_be(name, place):
    scene, holes = lit_world(name, place)
    start = np.array(scene.camera.matrix_world.translation)
    toward = np.array(holes[0].matrix_world.translation) - start
    sees = by_core(holes, start)
    if not agreement.SPINS[name]:
        sees = outside_cone(name, place, toward / np.linalg.norm(toward))
    truth = coverage(scene, sees)
    for way in agreement.WAYS:
        found = agreement.pictures(scene, way, samples=SAMPLES)[0][..., 0]
        moved = shifts(found, truth)
        assert len(moved) >= 6
        assert np.abs(moved).max() < 0.3, way
        assert np.abs(moved.mean()) < 0.05, way
        assert np.abs(found - truth).max() < 0.5, way  # nor anything elsewhere: 4 sigma of a pixel's samples
