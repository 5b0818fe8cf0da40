"""Disks as rendered, against geodesics of their own: where each pixel's ray crosses the disk, and what comes from
there.

Without spin light's path is u'' = 3 u^2 - u (u = M / r, over the angle swept), integrated here by Runge and Kutta.
Shifts are closed forms of the radius and of lambda, light's angular momentum about the axis over its energy.
"""

import bpy
import numpy as np
import pytest
from bentlight_native import disk_isco

from tests.engine.test_disk_scene import DISTANCE, add_hole, emission_material, look, picture

ANGLE, TILT, OUTER = 0.7, 1.4, 20.0
REACH = 0.015  # how far at most a ray of a pixel is from its middle, in pixels: half of the filter
SLIDERS = [(0.0, 0.0), (0.5, 0.3), (1.0, 1.0)]  # Doppler, gravitational
STEPS = 200  # of Runge and Kutta, to a crossing: u to 1e-9


@pytest.fixture(autouse=True)
def points():
    """Each pixel is one ray, through its middle, as exact as it gets."""
    scene = bpy.context.scene
    scene.bentlight.pixel_filter, scene.render.filter_size, scene.bentlight.tolerance = "GAUSSIAN", 0.01, 1e-6


def pixel_rays(tilt: float) -> tuple[np.ndarray, np.ndarray]:
    """The camera's place (3,) and the directions (48, 64, 3) in which it looks, as drawn."""
    x, y = np.meshgrid((np.arange(64) + 0.5) / 32 - 1, ((np.arange(48) + 0.5) / 24 - 1) * 0.75)
    local = np.stack([x * np.tan(ANGLE / 2), y * np.tan(ANGLE / 2), -np.ones_like(x)], axis=-1)
    local /= np.linalg.norm(local, axis=-1, keepdims=True)
    turn = np.array([[1, 0, 0], [0, np.cos(tilt), -np.sin(tilt)], [0, np.sin(tilt), np.cos(tilt)]])
    return turn @ (0, 0, DISTANCE), local @ turn.T


def swept(u: np.ndarray, slope: np.ndarray, angle: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """u and du/dpsi a swept angle later; rays that have fallen in or left stay what they are."""
    h = angle / STEPS
    for _ in range(STEPS):
        gone = (u > 0.5) | (u < 0)
        a1, b1 = slope, 3 * u**2 - u
        a2, b2 = slope + h / 2 * b1, 3 * (u + h / 2 * a1) ** 2 - (u + h / 2 * a1)
        a3, b3 = slope + h / 2 * b2, 3 * (u + h / 2 * a2) ** 2 - (u + h / 2 * a2)
        a4, b4 = slope + h * b3, 3 * (u + h * a3) ** 2 - (u + h * a3)
        u = np.where(gone, u, u + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4))
        slope = np.where(gone, slope, slope + h / 6 * (b1 + 2 * b2 + 2 * b3 + b4))
    return u, slope


def crossings(tilt: float) -> dict[str, np.ndarray]:
    """Where pixels' rays first meet a disk without spin: radius (0: nowhere), azimuth, order; light's lambda; and
    whether no edge of the disk is so near that the pixel's own width matters. All (48, 64)."""
    place, view = pixel_rays(tilt)
    e1 = place / DISTANCE
    k_r = view @ e1
    e2 = view - k_r[..., None] * e1
    k_t = np.linalg.norm(e2, axis=-1)
    e2 /= k_t[..., None]
    r = DISTANCE * (1 + 0.5 / DISTANCE) ** 2  # isotropic: angles are as drawn
    lapse = np.sqrt(1 - 2 / r)
    u, slope = np.full(k_r.shape, 1 / r), -lapse / r * k_r / k_t
    psi = np.arctan2(e1[2], -e2[..., 2])  # the first crossing of the equator
    found = {name: np.zeros(k_r.shape) for name in ("radius", "azimuth", "order")}
    clear, turn = np.ones(k_r.shape, bool), psi
    for order in range(3):
        u, slope = swept(u, slope, turn)
        radius, turn = 1 / np.where(u > 0, u, np.nan), np.pi
        free = found["radius"] == 0
        for edge in (6.0, OUTER):
            clear &= ~(free & (np.abs(np.nan_to_num(radius) / edge - 1) < 1e-3))
        hit = free & (radius > 6) & (radius < OUTER)
        there = np.cos(psi + order * np.pi)[..., None] * e1 + np.sin(psi + order * np.pi)[..., None] * e2
        found["radius"][hit], found["order"][hit] = radius[hit], order
        found["azimuth"][hit] = np.arctan2(there[..., 1], there[..., 0])[hit]
    momentum = np.cross(e1, -e2)[..., 2] * k_t * r / lapse  # of light that comes to the camera
    blur = REACH * sum(np.abs(slope) for slope in np.gradient(momentum))
    return found | {"lambda": momentum, "clear": clear, "blur": blur}


def factors(r: np.ndarray, momentum: np.ndarray, spin: float, lapse: float) -> tuple[np.ndarray, np.ndarray]:
    """The Doppler and the gravitational part of g from circular orbits to a camera with this lapse (BPT 1972):
    E / E_zamo = alpha / (1 - omega lambda), E_orbit / E = u^t (1 - Omega lambda)."""
    around = r**2 + spin**2 + 2 * spin**2 / r
    omega, alpha = 2 * spin / (r * around), np.sqrt((r**2 - 2 * r + spin**2) / around)
    rate = 1 / (r**1.5 + spin)
    u_t = (1 + spin / r**1.5) / np.sqrt(1 - 3 / r + 2 * spin / r**1.5)
    gravity = alpha / (1 - omega * momentum)
    return 1 / (u_t * (1 - rate * momentum)) / gravity, gravity / lapse


def told(hole, name: str, tmp_path) -> np.ndarray:
    """What the disk's material is told at each pixel, by the same rays that its colors are seen by."""
    disk = hole.bentlight.disk
    kept = disk.emission
    disk.emission, disk.material = "MATERIAL", emission_material(f"bentlight_{name}")
    found = picture(tmp_path, 1)[..., 0]
    disk.emission = kept
    return found


def test_rays_meet_the_disk_where_geodesics_do(tmp_path):
    """Radius of the direct image; and order: 1 where only the underside is seen, its image bent around the hole."""
    hole = add_hole(outer_radius=OUTER)
    look(TILT, angle=ANGLE)
    expected = crossings(TILT)
    seen = {name: told(hole, name, tmp_path) for name in ("radius", "image_order")}
    on, clear, order = expected["radius"] > 0, expected["clear"], expected["order"]
    assert clear.mean() > 0.99
    assert (on & clear & (order == 0)).sum() > 1000 and (on & clear & (order == 1)).sum() > 20
    assert np.array_equal((seen["radius"] > 0)[clear], on[clear])
    assert np.array_equal(seen["image_order"][on & clear], order[on & clear])
    error, inside = np.abs(seen["radius"] - expected["radius"]), on & (order == 0)
    for axis in (0, 1):
        for step in (-1, 1):  # where neighbors tell how fast it changes
            inside &= np.roll(on & (order == 0), step, axis)
    across = REACH * sum(np.abs(slope) for slope in np.gradient(expected["radius"]))
    assert inside.sum() > 800 and (error[inside] < 1.5 * across[inside] + 1e-5).all()


def set_ramp(disk) -> None:
    """From red to a greenish blue, linear."""
    disk.emission = "RAMP"
    ramp = disk.ramp.color_ramp
    while len(ramp.elements) > 2:
        ramp.elements.remove(ramp.elements[0])
    for element, place, color in zip(ramp.elements, (0, 1), ((1, 0.1, 0, 1), (0.2, 0.9, 0.5, 1)), strict=True):
        element.position, element.color = place, color


def ramp_color(depth: np.ndarray) -> np.ndarray:
    """`set_ramp` from the inner edge, 0, to the outer, 1."""
    return (1 - depth[..., None]) * (1, 0.1, 0) + depth[..., None] * (0.2, 0.9, 0.5)


@pytest.mark.parametrize("sliders", SLIDERS)
def test_a_ramp_seen_from_aside_is_shifted_by_g4(tmp_path, sliders):
    """Without spin, from 80 degrees off the axis: (D^doppler G^gravitational)^4 times color and strength."""
    hole = add_hole(doppler=sliders[0], gravitational=sliders[1], strength=2.0, outer_radius=OUTER)
    look(TILT, angle=ANGLE)
    set_ramp(hole.bentlight.disk)
    seen, r, geometry = picture(tmp_path, 1)[..., :3], told(hole, "radius", tmp_path), crossings(TILT)
    on = (r > 0) & geometry["clear"]
    lapse = (1 - 0.5 / DISTANCE) / (1 + 0.5 / DISTANCE)
    doppler, gravity = factors(r[on], geometry["lambda"][on], 0.0, lapse)
    assert doppler.max() > 1.3 and doppler.min() < 0.75 and gravity.min() < 0.85
    expected = 2 * (doppler ** sliders[0] * gravity ** sliders[1])[:, None] ** 4 * ramp_color((r[on] - 6) / (OUTER - 6))
    error = np.abs(seen[on] - expected).max(axis=1) / expected.max(axis=1)
    rate = r[on] ** -1.5
    of_place = 4 * sliders[0] * rate / (1 - rate * geometry["lambda"][on]) * geometry["blur"][on]
    assert (error < of_place + 1e-6).all() and np.median(of_place) < 1e-3


@pytest.mark.parametrize("sliders", SLIDERS)
def test_a_ramp_around_a_spinning_hole(tmp_path, sliders):
    """From the axis, where light has no angular momentum about it: no ray of a pixel differs, to float32."""
    spin, inner = 0.9, disk_isco(0.9)
    hole = add_hole(spin=spin, doppler=sliders[0], gravitational=sliders[1], outer_radius=OUTER)
    look(0.0, angle=1.0)
    set_ramp(hole.bentlight.disk)
    seen, r = picture(tmp_path, 1)[..., :3], told(hole, "radius", tmp_path)
    on = (r > 0) & (told(hole, "image_order", tmp_path) == 0)  # others magnify what their rays are off by
    assert on.sum() > 500 and r[on].min() < inner + 0.5
    lapse = np.sqrt((DISTANCE**2 - 2 * DISTANCE + spin**2) / (DISTANCE**2 + spin**2))  # in the oblate chart z = r
    doppler, gravity = factors(r[on], 0.0, spin, lapse)
    expected = (doppler ** sliders[0] * gravity ** sliders[1])[:, None] ** 4
    expected = expected * ramp_color((r[on] - inner) / (OUTER - inner))
    error = np.abs(seen[on] - expected).max(axis=1) / expected.max(axis=1)
    assert error.max() < 1e-6


def bilinear(pixels: np.ndarray, across: np.ndarray, up: np.ndarray) -> np.ndarray:
    """Colors of an image (height, width, 3) between its pixels' middles; it repeats across."""
    height, width = pixels.shape[:2]
    x, y = across * width - 0.5, np.clip(up * height - 0.5, 0, height - 1)
    left, low = np.floor(x).astype(int), np.minimum(np.floor(y).astype(int), height - 2)
    s, t = (x - left)[..., None], (y - low)[..., None]
    rows = [(1 - s) * pixels[low + i, left % width] + s * pixels[low + i, (left + 1) % width] for i in (0, 1)]
    return (1 - t) * rows[0] + t * rows[1]


def test_an_image_lies_around_the_hole_and_outwards(tmp_path):
    """Its left edge at azimuth 0, its bottom at the inner edge, every pixel another color; by our own geodesics."""
    hole = add_hole(emission="IMAGE", doppler=0.0, gravitational=0.0, outer_radius=OUTER)
    pixels = np.random.default_rng(3).uniform(0.2, 1, (6, 24, 3)).astype(np.float32)
    image = hole.bentlight.disk.image = bpy.data.images.new("Disk", 24, 6, float_buffer=True)
    image.pixels.foreach_set(np.concatenate([pixels, np.ones((6, 24, 1), np.float32)], axis=2).ravel())
    look(TILT, angle=ANGLE)
    seen, r, geometry = picture(tmp_path, 1)[..., :3], told(hole, "radius", tmp_path), crossings(TILT)
    on = (r > 0) & geometry["clear"] & (geometry["order"] == 0)
    turns, depth = geometry["azimuth"][on] / (2 * np.pi) % 1, (r[on] - 6) / (OUTER - 6)
    error = np.abs(seen[on] - bilinear(pixels, turns, depth)).max(axis=1)
    assert on.sum() > 1000 and np.median(error) < 3e-3
    # colors change by 0.8 at most from one of the 24 to the next, and a pixel's rays differ by what its neighbors do
    turning = np.abs(np.angle(np.exp(1j * np.diff(geometry["azimuth"], axis=1, append=0)))) / (2 * np.pi)
    assert (error < 0.8 * 24 * 3 * REACH * np.maximum(turning, np.roll(turning, 1, axis=1))[on] + 2e-3).mean() > 0.99


@pytest.mark.parametrize("sphere", [0.0, 30.0])
def test_a_hole_that_spins_the_other_way_is_the_mirror_image(tmp_path, sphere):
    """Of -spin, left for right: matter that follows the spin, dragging, and every shift."""
    hole = add_hole(spin=0.9, emission="POWER_LAW", outer_radius=OUTER, strength=1.0)
    hole.bentlight.sphere_radius = sphere
    look(TILT, angle=ANGLE)
    pictures = []
    for hole.bentlight.spin in (0.9, -0.9):
        pictures.append(picture(tmp_path, 16)[..., :3])
    there, back = pictures[0], pictures[1][:, ::-1]
    assert there[:, :32].sum() > 2 * there[:, 32:].sum()
    assert np.abs(back.sum() / there.sum() - 1) < 1e-3
    on = there.max(axis=-1) > 0.02 * there.max()
    error = np.abs(there - back).max(axis=-1)[on] / there.max(axis=-1)[on]
    assert np.quantile(error, 0.99) < 5e-3  # from pixel to pixel light may double: 0.0025 of it are a ray's deviation
