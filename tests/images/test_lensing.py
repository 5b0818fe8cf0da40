"""What a picture of a hole shows, against closed forms and golden data: the ring, the shadow, the mouth.

Lengths in pictures are measured in SEEDS renders and compared with the exact ones by Z-tests.
"""

import csv
import math
from pathlib import Path

import bpy
import common
import einstein_ring
import materials
import numpy as np
import objects
import pytest
import rendering
from image_statistics import welch_z

GOLDEN = Path(__file__).parents[1] / "data" / "golden"
R_OBSERVER = 10.0
SEEDS = 8


def golden(name: str) -> list[dict[str, str]]:
    lines = (GOLDEN / name).read_text().splitlines()
    return list(csv.DictReader(line for line in lines if not line.startswith("#")))


@pytest.mark.parametrize("row", [r for r in golden("images.csv") if r["type"] == "einstein_ring" and r["order"] == "0"])
def test_ring_angle_is_exact(row):
    angle = einstein_ring.ring_angle(float(row["r_obs"]), float(row["r_src"]))
    assert angle == pytest.approx(float(row["psi_from_inward_rad"]), rel=1e-13)


def check(measured, exact, precision: float) -> None:
    """Equal to chance, as independent measurements (SEEDS, ...) tell it, and not by more than `precision` of it."""
    error = np.std(measured, axis=0, ddof=1) / math.sqrt(len(measured))
    assert np.max(error) < precision  # or the test would overlook too much
    z = welch_z(np.asarray(measured), np.broadcast_to(exact, np.shape(measured)))
    assert (np.abs(z) < 4.5).all(), (np.mean(measured, axis=0), exact, z)


def test_einstein_ring_has_the_radius_of_the_closed_form():
    """The disk's image is an annulus. Its brightness is the disk's own, so light counts area: both edges are measured
    by the area of light beyond and within the ring's middle. Each picture is shifted by a random part of a pixel, so
    that on average it does not matter which pixels' centers are within the ring."""
    scene = einstein_ring.build()
    width = scene.render.resolution_x
    ring = einstein_ring.ring_radius_pixels(einstein_ring.ring_angle(), width)
    distance = einstein_ring.isotropic_radius(einstein_ring.R_SOURCE)
    edge = math.hypot(distance, einstein_ring.DISK_RADIUS)
    r_edge = edge * (1 + einstein_ring.MASS / 2 / edge) ** 2
    offset = math.atan2(einstein_ring.DISK_RADIUS, distance)
    inner, outer = (
        einstein_ring.ring_radius_pixels(einstein_ring.ring_angle(r_source=r_edge, swept=math.pi + o), width)
        for o in (offset, -offset)
    )
    assert outer - inner > 2
    edges, sides = [], []
    for seed, shift in enumerate(np.random.default_rng(3).uniform(-0.5, 0.5, (SEEDS, 2)), start=1):
        scene.camera.data.shift_x, scene.camera.data.shift_y = shift / width
        coverage = rendering.render(scene, seed=seed, samples=16)[..., 0]  # the star's radiance is 1 in red
        y, x = np.mgrid[0:width, 0:width] + 0.5 - width / 2 + np.array([-shift[1], shift[0]])[:, None, None]
        radius = np.hypot(x, y)
        primary = coverage * (radius > 0.7 * ring)  # the higher images crowd at the shadow's edge
        outside, inside = (primary * (radius > ring)).sum(), (primary * (radius < ring)).sum()
        edges.append([math.sqrt(ring**2 - inside / math.pi), math.sqrt(ring**2 + outside / math.pi)])
        sides.append((primary * np.sign(x)).sum())
    check(edges, [inner, outer], precision=0.01)
    check(sides, 0, precision=0.01 * math.pi * (outer**2 - inner**2))


def shadow(spin: float, width: int = 200, field_of_view: float = 1.5) -> tuple[np.ndarray, float]:
    """The share of each pixel that is black (SEEDS, width, width), seen by an observer at r = 10 M in the equatorial
    plane, and the tangent of the angle that one pixel subtends in the middle."""
    scene = rendering.empty_space(width, width)
    bpy.ops.bentlight.black_hole_add(mass=1.0, spin=spin, location=(0, 0, 0))
    distance = math.hypot(R_OBSERVER, spin) if spin else einstein_ring.isotropic_radius(R_OBSERVER, 1.0)
    view = objects.camera((0, -distance, 0), (0, 0, 0))
    view.data.sensor_fit, view.data.angle = "HORIZONTAL", field_of_view
    pictures = [rendering.render(scene, seed=1 + seed, samples=16) for seed in range(SEEDS)]
    return 1 - np.mean(pictures, axis=-1), 2 * math.tan(field_of_view / 2) / width


def test_schwarzschild_shadow_has_its_radius():
    black, pixel = shadow(0.0)
    angle = math.asin(math.sqrt(27) / R_OBSERVER * math.sqrt(1 - 2 / R_OBSERVER))
    check(np.sqrt(black.sum(axis=(1, 2)) / math.pi), math.tan(angle) / pixel, precision=0.005)


@pytest.mark.parametrize("spin", [0.5, 0.9])
def test_kerr_shadow_is_that_of_the_golden_data(spin):
    """The axis points up and the hole's near side turns to the right (+x), so the left edge is pressed in."""
    rows = [r for r in golden("shadow_r10.csv") if float(r["a"]) == spin and float(r["theta_obs_deg"]) == 90]
    n_r, n_theta, n_phi = np.array([[float(r[c]) for c in r if c.startswith("n_")] for r in rows]).T
    black, pixel = shadow(spin)
    right, up = n_phi / -n_r / pixel, n_theta / n_r / pixel
    assert len(rows) > 8 and abs(right.max() + right.min()) > 2  # pixels: the two sides cannot be mistaken
    middle = (right.min() + right.max()) / 2
    x, y = np.concatenate([right, right]) - middle, np.concatenate([up, -up])
    radius = np.hypot(x, y)
    measured = [
        [edge_distance(one, middle, dx, dy) for dx, dy in zip(x / radius, y / radius, strict=True)] for one in black
    ]
    check(measured, radius, precision=0.05)


def edge_distance(black: np.ndarray, x0: float, dx: float, dy: float, step: float = 0.05) -> float:
    """How far the black reaches from the point x0 to the right of the picture's middle along (dx, dy), in pixels: the
    line integral of the pixels' blackness, bilinear between them, so that a blurred edge counts at its middle."""
    t = np.arange(0, black.shape[0] / 2 - 2 - max(0.0, x0 * dx), step) + step / 2
    column, row = black.shape[1] / 2 - 0.5 + x0 + t * dx, black.shape[0] / 2 - 0.5 - t * dy
    i, j = row.astype(int), column.astype(int)
    u, v = row - i, column - j
    values = (1 - u) * ((1 - v) * black[i, j] + v * black[i, j + 1])
    values += u * ((1 - v) * black[i + 1, j] + v * black[i + 1, j + 1])
    return float(values.sum() * step)


def test_a_wormhole_shows_the_far_side_upright_and_unmirrored():
    """Four colored panels far beyond mouth B are seen through mouth A in their own places."""
    scene = rendering.empty_space(64, 64)
    objects.set_world((0, 0, 0))
    colors = {(-1, 1): (1, 0, 0), (1, 1): (0, 1, 0), (-1, -1): (0, 0, 1), (1, -1): (1, 1, 0)}
    for (right, up), color in colors.items():
        corner = (min(0, 30 * right), 120, min(0, 30 * up))
        objects.quad("Panel", corner, (30, 0, 0), (0, 0, 30), materials.emission("Panel", color))
    bpy.ops.bentlight.wormhole_add(throat_radius=2.0, location=(0, 0, 0), exit_location=(0, 100, 0))
    objects.camera((0, -8, 0), (0, 0, 0), lens_mm=90)
    picture = rendering.render(scene)
    for (right, up), color in colors.items():
        seen = picture[32 - 6 * up, 32 + 6 * right]
        assert seen == pytest.approx(color, abs=1e-5), (right, up)


def test_new_scene_is_new():
    """Two examples in one process do not mix."""
    einstein_ring.build()
    assert len(common.new_scene().objects) == 0


@pytest.mark.parametrize("spin", [0.0, 0.7])
def test_a_mesh_may_reach_into_the_horizon(spin):
    """A rod through the hole shines down to the horizon and no ray that leaves it there is an error."""
    scene = rendering.empty_space(32, 32)
    scene.bentlight.max_bounces = 4
    bpy.ops.bentlight.black_hole_add(mass=1.0, spin=spin, location=(0, 0, 0))
    objects.box("Rod", (0, 0, 0), (12, 0.6, 0.6), materials.diffuse("White", (0.9, 0.9, 0.9)), turn_deg=20)
    objects.camera((0, -12, 3), (0, 0, 0), lens_mm=35)
    picture = rendering.render(scene)
    assert np.isfinite(picture).all()
    assert picture.max() <= 1 + 1e-5  # in white surroundings a surface that reflects less is darker
