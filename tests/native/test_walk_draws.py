"""Chi-square tests of a walk below a surface: channels, free paths, and directions at random and towards the surface,
by the core's own step in a medium without end; and what is paid for each step.
"""

import ctypes
from pathlib import Path

import compiled
import numpy as np
import pytest
from test_draws import uniform_z

CORE = Path(__file__).parents[2] / "native"
STEPS = 200000
EXTINCTION, ALBEDO = np.array([1.0, 2.5, 7.0]), np.array([0.9, 0.6, 0.3])
LIGHT = np.array([0.2, 0.5, 1.0])
CHANCE = LIGHT * ALBEDO / (LIGHT * ALBEDO).sum()  # of the channels
NORMAL = np.array([0.48, 0.6, 0.64])


@pytest.fixture(scope="module")
def walk(tmp_path_factory):
    """A function that takes steps from the origin: directions (n, 3), lengths (n,), the light that is left (n, 3), and
    the diffusion length."""
    include = [f"-I{CORE / folder}" for folder in ("src", "include")]
    library = compiled.load("walk_draws.c", tmp_path_factory.mktemp("walk"), *include)
    library.walk_steps.restype = ctypes.c_double

    def steps(anisotropy, direction, guided, is_first=False):
        u = np.random.default_rng(6).random((STEPS, 4))
        given = [np.ascontiguousarray(a, float) for a in (EXTINCTION, ALBEDO, LIGHT, direction, NORMAL)]
        extinction, albedo, light, along, normal = map(compiled.pointer, given)
        place, left = np.empty((STEPS, 3)), np.empty((STEPS, 3))
        numbers = ctypes.c_double(anisotropy), light, along, normal, ctypes.c_double(guided), ctypes.c_int(is_first)
        arrays = map(compiled.pointer, (u, place, left))
        diffusion = library.walk_steps(ctypes.c_size_t(STEPS), extinction, albedo, *numbers, *arrays)
        length = np.linalg.norm(place, axis=1)
        return place / length[:, None], length, left, diffusion

    return steps


def phase(g, cosine):
    """Henyey & Greenstein 1941, by solid angle."""
    return (1 - g * g) / (4 * np.pi * (1 + g * g - 2 * g * cosine) ** 1.5)


def phase_below(g, cosine):
    """Its chance of a smaller cosine."""
    if g == 0:
        return (1 + cosine) / 2
    return (1 - g * g) / (2 * g) * (1 / np.sqrt(1 + g * g - 2 * g * cosine) - 1 / (1 + g))


def ended(rates, length):
    """The chance that a free path is shorter, (n,), by the rates of the channels, (n, 3) or (3,)."""
    return (CHANCE * (1 - np.exp(-rates * length[:, None]))).sum(axis=1)


def turn_around(directions, axis):
    """The angle around an axis, over a full turn."""
    x = np.cross(axis, [0, 0, 1])
    x /= np.linalg.norm(x)
    return np.arctan2(directions @ np.cross(axis, x), directions @ x) / (2 * np.pi) % 1


def test_the_first_free_path_is_that_of_a_channel(walk):
    """Along the direction of entry, by the light that is left in each channel after a scattering."""
    along = np.array([0.6, 0, -0.8])
    direction, length, left, _ = walk(0.4, along, 0.6, is_first=True)
    np.testing.assert_allclose(direction, np.tile(along, (STEPS, 1)), atol=1e-12)
    assert abs(uniform_z(ended(EXTINCTION, length), counts=(100,))) < 4
    passed = np.exp(-EXTINCTION * length[:, None]) * EXTINCTION
    np.testing.assert_allclose(left, LIGHT * ALBEDO * passed / (passed @ CHANCE)[:, None], rtol=1e-9)


@pytest.mark.parametrize("g", [0.0, 0.6, 0.95])
def test_directions_at_random(walk, g):
    along = np.array([0.6, 0, -0.8])
    direction, length, _, _ = walk(g, along, 0.0)
    numbers = phase_below(g, direction @ along), turn_around(direction, along), ended(EXTINCTION, length)
    assert abs(uniform_z(*numbers, counts=(12, 12, 12))) < 4


@pytest.mark.parametrize("guided", [1.0, 0.5])
@pytest.mark.parametrize("g", [0.0, 0.6])
def test_directions_towards_the_surface(walk, g, guided):
    """With the density 1 / (v - c) of the cosine c to the normal, and extinction stretched by 1 - c / v, in so many
    cases; the others at random, from a walk that goes along the normal already. Light pays for the mixture of both."""
    direction, length, left, v = walk(g, NORMAL, guided)
    cosine = direction @ NORMAL
    whole = np.log((v + 1) / (v - 1))
    below = guided * np.log((v + 1) / (v - cosine)) / whole + (1 - guided) * phase_below(g, cosine)
    aimed, plain = guided / ((v - cosine) * whole * 2 * np.pi), (1 - guided) * phase(g, cosine)
    stretched = EXTINCTION * (1 - cosine / v)[:, None]
    shorter = (aimed * ended(stretched, length) + plain * ended(EXTINCTION, length)) / (aimed + plain)
    assert abs(uniform_z(below, turn_around(direction, NORMAL), shorter, counts=(12, 12, 12))) < 4
    passed, quicker = (np.exp(-rates * length[:, None]) * rates for rates in (EXTINCTION, stretched))
    pdf = plain * (passed @ CHANCE) + aimed * (quicker @ CHANCE)
    expected = LIGHT * ALBEDO * passed * phase(g, cosine)[:, None] / pdf[:, None]
    np.testing.assert_allclose(left, expected, rtol=1e-9)
