"""Thin films: their reflectance of one wavelength against the sum of all waves, in closed form."""

import numpy as np
import pytest
from bsdf_tools import (
    FILM_WAVELENGTH_NM,
    SCENE,
    brought,
    direction,
    draw_evenly,
    glass,
    material,
    metallic,
    principled,
    under_film,
)

IOR, FILM_IOR = 1.5, 1.33


WAYS = 3  # through the film, to and fro, that are counted


def airy(mu, thickness, film, below):
    """Reflectance of an unpolarized wave by the whole geometric series (Born and Wolf, section 7.6.1), and the most
    that those terms of its energy add which are left out: each is weaker by both amplitudes."""
    sine2 = 1 - mu**2
    in_film, in_base = np.emath.sqrt(1 - sine2 / film**2), np.emath.sqrt(1 - sine2 / below**2)
    turn = np.exp(2j * np.pi * 2 * film * thickness * in_film / FILM_WAVELENGTH_NM)
    total = rest = 0.0
    for s in (True, False):
        a, b, c = (mu, film * in_film, below * in_base) if s else (1 / mu, film / in_film, below / in_base)
        first, second = (a - b) / (a + b), (b - c) / (b + c)
        total += abs((first + second * turn) / (1 + first * second * turn)) ** 2 / 2
        top, both = abs(first) ** 2, abs(first * second)
        strength = abs((1 - top) ** 2 * abs(second) ** 2 / (1 - both**2) - (1 - top))
        rest += strength * both ** (WAYS + 1) / (1 - both)
    return total, rest


def reflected(closure, mu):
    """The part of light that a mirror reflects, by its chance and weight."""
    drawn = SCENE.draw_bsdf(material(closure), np.random.default_rng(1).random((20_000, 3)), wo=direction(mu))
    there = drawn.lobe == 4
    return there.mean() * drawn.weight[there][:, 0].mean() if there.any() else 0.0


@pytest.mark.parametrize("mu", [1.0, 0.7, 0.3])
@pytest.mark.parametrize("thickness", [20.0, 94.0, 188.0, 500.0])
@pytest.mark.parametrize("film", [FILM_IOR, 1.6])
def test_a_film_on_a_metal(film, thickness, mu):
    n, k = 0.5, 3.0
    closure = under_film(metallic(n, k, 0.0, physical=True), thickness, film)
    expected, rest = airy(mu, thickness, film, n + 1j * k)
    assert rest < 0.07
    np.testing.assert_allclose(reflected(closure, mu), expected, atol=rest + 1e-3)


@pytest.mark.parametrize("backfacing", [0.0, 1.0])
@pytest.mark.parametrize("mu", [1.0, 0.8, 0.3])
@pytest.mark.parametrize("thickness", [20.0, 94.0, 188.0, 500.0])
def test_a_film_on_glass(thickness, mu, backfacing):
    """From outside and from inside, where waves are, as in Cycles, as long as if the glass were empty and the film
    thinner than that. What is not reflected goes through."""
    outer, film, inner = (IOR, FILM_IOR, 1.0) if backfacing else (1.0, FILM_IOR, IOR)
    closure = under_film(glass(ior=IOR), thickness, FILM_IOR)
    drawn = draw_evenly(closure, wo=direction(mu), backfacing=backfacing)
    mirrored, through = brought(drawn, 4), brought(drawn, 8)
    assert mirrored + through == pytest.approx(1, abs=2 / len(drawn.lobe))
    expected, rest = 1.0, 0.0
    if outer / inner * np.sqrt(1 - mu**2) < 1:
        expected, rest = airy(mu, thickness, film / outer, inner / outer)
    assert mirrored == pytest.approx(expected, abs=rest + 1e-3)


def test_films_of_no_thickness_are_none():
    for closure in (glass(ior=IOR), principled(roughness=0.3), metallic(0.9, 0.5, 0.3)):
        wi = [direction(0.7, 1.0)]
        bare, covered = (
            SCENE.evaluate_bsdf(material(c), wi, wo=direction(0.5))[0] for c in (closure, under_film(closure, 0.0))
        )
        np.testing.assert_array_equal(bare, covered)
