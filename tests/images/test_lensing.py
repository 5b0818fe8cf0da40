"""What a picture of a hole shows, against closed forms and golden data: the ring, the shadow, the mouth."""

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

GOLDEN = Path(__file__).parents[1] / "data" / "golden"
R_OBSERVER = 10.0


def golden(name: str) -> list[dict[str, str]]:
    lines = (GOLDEN / name).read_text().splitlines()
    return list(csv.DictReader(line for line in lines if not line.startswith("#")))


@pytest.mark.parametrize("row", [r for r in golden("images.csv") if r["type"] == "einstein_ring" and r["order"] == "0"])
def test_ring_angle_is_exact(row):
    angle = einstein_ring.ring_angle(float(row["r_obs"]), float(row["r_src"]))
    assert angle == pytest.approx(float(row["psi_from_inward_rad"]), rel=1e-13)


def test_einstein_ring_has_the_radius_of_the_closed_form():
    """The disk's image is an annulus. Its brightness is the disk's own, so light counts area: both edges are measured
    by the area of light beyond and within the ring's middle, and so is the ring itself."""
    scene = einstein_ring.build()
    width = scene.render.resolution_x
    picture = rendering.render(scene)[..., 1]
    coverage = picture / picture.max()
    y, x = np.mgrid[0:width, 0:width] + 0.5 - width / 2
    radius = np.hypot(x, y)
    assert (coverage * (x > 0)).sum() == pytest.approx((coverage * (x < 0)).sum(), rel=0.01)

    ring = einstein_ring.ring_radius_pixels(einstein_ring.ring_angle(), width)
    distance = einstein_ring.isotropic_radius(einstein_ring.R_SOURCE)
    edge = math.hypot(distance, einstein_ring.DISK_RADIUS)
    r_edge = edge * (1 + einstein_ring.MASS / 2 / edge) ** 2
    offset = math.atan2(einstein_ring.DISK_RADIUS, distance)
    inner, outer = (
        einstein_ring.ring_radius_pixels(einstein_ring.ring_angle(r_source=r_edge, swept=math.pi + o), width)
        for o in (offset, -offset)
    )
    primary = radius > 0.7 * ring  # the higher images crowd at the shadow's edge
    assert outer - inner > 2
    assert math.sqrt(ring**2 + (coverage * (radius > ring)).sum() / math.pi) == pytest.approx(outer, abs=0.2)
    assert math.sqrt(ring**2 - (coverage * primary * (radius < ring)).sum() / math.pi) == pytest.approx(inner, abs=0.2)
    middle = (coverage * primary * radius).sum() / (coverage * primary).sum()
    expected = 2 / 3 * (outer**3 - inner**3) / (outer**2 - inner**2)
    assert middle == pytest.approx(expected, abs=0.1)


def shadow(spin: float, width: int = 200, field_of_view: float = 1.5) -> tuple[np.ndarray, float]:
    """The share of each pixel that is black, seen by an observer at r = 10 M in the equatorial plane, and the
    tangent of the angle that one pixel subtends in the middle."""
    scene = rendering.empty_space(width, width, samples=64)
    bpy.ops.bentlight.black_hole_add(mass=1.0, spin=spin, location=(0, 0, 0))
    distance = math.hypot(R_OBSERVER, spin) if spin else einstein_ring.isotropic_radius(R_OBSERVER, 1.0)
    view = objects.camera((0, -distance, 0), (0, 0, 0))
    view.data.sensor_fit, view.data.angle = "HORIZONTAL", field_of_view
    return 1 - rendering.render(scene).mean(axis=-1), 2 * math.tan(field_of_view / 2) / width


def test_schwarzschild_shadow_has_its_radius():
    black, pixel = shadow(0.0)
    angle = math.asin(math.sqrt(27) / R_OBSERVER * math.sqrt(1 - 2 / R_OBSERVER))
    assert math.sqrt(black.sum() / math.pi) == pytest.approx(math.tan(angle) / pixel, abs=0.1)


@pytest.mark.parametrize("spin", [0.5, 0.9])
def test_kerr_shadow_is_that_of_the_golden_data(spin):
    """The axis points up and the hole's near side turns to the right (+x), so the left edge is pressed in."""
    rows = [r for r in golden("shadow_r10.csv") if float(r["a"]) == spin and float(r["theta_obs_deg"]) == 90]
    n_r, n_theta, n_phi = np.array([[float(r[c]) for c in r if c.startswith("n_")] for r in rows]).T
    black, pixel = shadow(spin)
    right, up = n_phi / -n_r / pixel, n_theta / n_r / pixel
    assert len(rows) > 8 and abs(right.max() + right.min()) > 2  # pixels: the two sides cannot be mistaken
    middle = (right.min() + right.max()) / 2
    for x, y in zip(np.concatenate([right, right]), np.concatenate([up, -up]), strict=True):
        radius = math.hypot(x - middle, y)
        measured = edge_distance(black, middle, (x - middle) / radius, y / radius)
        assert measured == pytest.approx(radius, abs=0.2), (x, y)


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
