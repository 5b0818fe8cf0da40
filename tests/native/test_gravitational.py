"""Gravity's shift of light: every path's factor is that of its two ends, so pictures with and without it differ exactly
by closed forms (the static observer's lapse; Bardeen, Press & Teukolsky 1972 for spin), whatever happens in between."""

import meshes
import numpy as np
import pytest
from bentlight_native import Spacetime
from scenes import add, diffuse, emission, glossy, look_at, new_scene, perspective, quad
from test_bidirectional import picture
from test_render_curved import placed

MASS = 0.2
EYE = (0.3, -2.0, 0.4)
QUIET = {"samples": 8, "max_bounces": 3, "light_threshold": 0.0, "roulette_start": 9}


def lapse(place):
    """Of an observer at rest at an isotropic place."""
    x = MASS / (2 * np.linalg.norm(place))
    return (1 - x) / (1 + x)


def furnished(spacetime, sky=None):
    """Gray things around a hole, a camera that looks past it."""
    scene = new_scene(sky)
    scene.set_spacetime(spacetime)
    add(scene, meshes.sphere(0.5), diffuse((0.8, 0.7, 0.6)), at=placed(0.9, 0.6, 0.0))
    add(scene, meshes.sphere(0.4), glossy((0.9, 0.9, 0.9), 0.3), at=placed(-0.9, 0.3, -0.2))
    add(scene, quad(3, 3), diffuse((0.6, 0.6, 0.6)), at=placed(0, 0, -1.2))
    perspective(scene, look_at(EYE, (0, 0.3, 0)), half=0.7)
    return scene


def pair(scene, **settings):
    """The picture without and with the shift, (16, 16, 3) each."""
    found = []
    for amount in (0.0, 1.0):
        scene.set_gravitational(amount)
        scene.commit()
        found.append(picture(scene, seed=1, **(QUIET | settings)))
    return found


def assert_times(scene, factor, rtol=2e-5, **settings):
    before, after = pair(scene, **settings)
    assert (before > 0).mean() > 0.3
    np.testing.assert_allclose(after, factor * before, rtol=rtol, atol=1e-7)


@pytest.mark.parametrize("way", ["SCATTERING", "CONNECTIONS", "BOTH"])
def test_the_sky_is_brighter_deep_down(way):
    scene = furnished(Spacetime.schwarzschild(MASS), (0.5, 0.6, 0.7))
    scene.set_suns([(0.5, -0.6, 0.6)], [(3.0, 2.0, 1.0)], [0.2])
    assert_times(scene, lapse(EYE) ** -4, light_sampling=way)


@pytest.mark.parametrize("integrator", ["PATH", "BIDIRECTIONAL"])
def test_lamps_by_their_depth(integrator):
    """A shining square so small that it has one depth."""
    scene = furnished(Spacetime.schwarzschild(MASS))
    place = (0.2, 0.5, 0.6)
    add(scene, quad(1e-4, 1e-4), emission((4e7, 3e7, 2e7)), at=placed(*place))
    assert_times(scene, (lapse(place) / lapse(EYE)) ** 4, rtol=3e-4, integrator=integrator)


def test_around_a_spinning_hole():
    """Of the sky by camera rays alone: energy over that which the ZAMO measures, alpha (1 + v_phi n_phi)."""
    spin, scene = 0.16, new_scene((1.0, 1.0, 1.0))
    scene.set_spacetime(Spacetime.kerr(MASS, spin))
    radius = 1.1
    eye = (np.hypot(radius, spin), 0.0, 0.0)  # on the equator
    perspective(scene, look_at(eye, (3.0, 1.0, 0.2)), half=1.0)
    before, after = pair(scene, samples=1, filter="GAUSSIAN", filter_width=0.01)
    delta, around = radius**2 - 2 * MASS * radius + spin**2, radius**2 + spin**2 + 2 * MASS * spin**2 / radius
    alpha, drag = np.sqrt(delta / around), 2 * MASS * spin / (radius * around)
    u = (np.arange(16) + 0.5) / 8 - 1
    across, up = np.meshgrid(u, u)
    axes = look_at(eye, (3.0, 1.0, 0.2))[:3, :3]
    directions = np.stack([across, up, -np.ones_like(up)], axis=-1) @ axes.T
    directions /= np.linalg.norm(directions, axis=-1, keepdims=True)
    energy = alpha + drag * np.sqrt(around) * -directions[..., 1]  # the photon comes against the look direction
    seen = before[..., 0] > 0
    assert seen.mean() > 0.9 and np.ptp(energy) > 0.05
    np.testing.assert_allclose(after[..., 0][seen], energy[seen] ** -4, rtol=2e-3)


def test_stars_are_brighter_deep_down():
    scene = new_scene()
    scene.set_spacetime(Spacetime.schwarzschild(MASS))
    perspective(scene, look_at(EYE, (0, 0.3, 0)), half=0.7)
    seen = []
    for amount in (0.0, 1.0):
        scene.set_gravitational(amount)
        scene.commit()
        seen.append(scene.find_stars([(0.1, 1.0, 0.2), (-0.4, 1.0, 0.0)], (64, 64)).throughput)
    assert len(seen[0]) >= 2
    np.testing.assert_allclose(seen[1], seen[0] * lapse(EYE) ** -4, rtol=1e-9)


def test_half_the_amount_is_the_square_root():
    scene = furnished(Spacetime.schwarzschild(MASS), (1.0, 1.0, 1.0))
    before, after = pair(scene)
    scene.set_gravitational(0.5)
    scene.commit()
    half = picture(scene, seed=1, **QUIET)
    np.testing.assert_allclose(half, np.sqrt(before * after), rtol=2e-5, atol=1e-7)


@pytest.mark.parametrize("amount", [-0.1, 1.1, np.nan])
def test_bad_amounts(amount):
    with pytest.raises(ValueError, match="set_gravitational"):
        new_scene().set_gravitational(amount)
