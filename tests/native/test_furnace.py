"""The white furnace: what a closure of no color reflects, in all, of light that comes from everywhere.

Closures that make up for multiple scattering lose and win nothing; those that scatter once lose what the formulas of
microfacet_oracle.py say. Every closure that the core knows is in the table, or the first test fails.
"""

import functools
import math

import numpy as np
import pytest
from bsdf_tools import (
    SCENE,
    diffuse,
    direction,
    glass,
    glossy,
    material,
    metallic,
    principled,
    refraction,
    sheen,
    subsurface,
    translucent,
    transparent,
    under_film,
)
from closure_table import ROUGH, SHARP, choices_of, closure_choices
from microfacet_oracle import facets, glass_energy, layer_energy, smith_lambda

IOR = 1.5
ERFC = np.vectorize(math.erfc)


def all_of_it(roughness, mu, eta):
    return 1.0


def mirrored_once(roughness, mu, eta):
    return layer_energy(roughness, mu, 1e9)[0]


def glass_once(roughness, mu, eta):
    return glass_energy(roughness, mu, [eta])[0].albedo


def refracted_once(roughness, mu, eta):
    cos_h, cos_i, weight, masking = facets(roughness, mu)
    cos_t2 = 1 - (1 - cos_i**2) / eta**2
    depth = mu / eta + (np.sqrt(np.maximum(cos_t2, 0)) - cos_i / eta) * cos_h
    passes = (cos_t2 > 0) & (depth > 0)
    return weight @ np.where(passes, 1 / (masking + smith_lambda(np.maximum(depth, 1e-12), roughness**2)), 0)


@functools.cache
def beckmann_once(roughness, mu, eta):
    """Over slopes of the facets, which are normal variables: what is seen, mirrored upwards, and seen from there."""
    alpha, steps = roughness**2, 400
    slopes = (np.arange(steps) + 0.5) / steps * 9 - 4.5
    x, y = np.meshgrid(alpha * slopes, alpha * slopes)
    weight = np.exp(-(x**2 + y**2) / alpha**2) * (9 / steps) ** 2 / np.pi
    length = np.sqrt(1 + x**2 + y**2)
    cos_i = (mu - x * np.sqrt(1 - mu**2)) / length  # the facet's normal is (-x, -y, 1) / length
    height = 2 * cos_i / length - mu
    seen = (cos_i > 0) & (height > 0)
    tan2 = np.array([1 / np.maximum(c, 1e-12) ** 2 - 1 for c in (np.full_like(height, mu), height)])
    a = 1 / np.sqrt(np.maximum(alpha**2 * tan2, 1e-30))
    lambdas = np.exp(-(np.minimum(a, 25) ** 2)) / (2 * a * np.sqrt(np.pi)) - ERFC(np.minimum(a, 25)) / 2
    return (weight * seen * cos_i * length / mu / (1 + lambdas.sum(axis=0)))[seen].sum()


def at_most_all(roughness, mu, eta):
    """Models that have no closed form here."""
    return None


# closure by roughness, what it reflects, and by how much that may be off: the errors of microfacet_energy.h
FURNACE = {
    "diffuse": (lambda r: diffuse(roughness=r), all_of_it, 1e-3),
    "translucent": (lambda r: translucent(), all_of_it, 1e-9),
    "transparent": (lambda r: transparent(), all_of_it, 1e-9),
    "glossy": (lambda r: glossy(roughness=r), all_of_it, 0.004),
    "glossy, once": (lambda r: glossy(roughness=r, distribution="GGX"), mirrored_once, 1e-3),
    "metal": (lambda r: metallic(roughness=r), all_of_it, 0.004),
    "metal, once": (lambda r: metallic(roughness=r, distribution="GGX"), mirrored_once, 1e-3),
    "conductor": (lambda r: metallic(1.0, 1e6, r, physical=True), all_of_it, 0.004),
    "conductor, once": (lambda r: metallic(1.0, 1e6, r, physical=True, distribution="GGX"), mirrored_once, 1e-3),
    "glass": (lambda r: glass(roughness=r), all_of_it, 0.01),
    "glass, once": (lambda r: glass(roughness=r, distribution="GGX"), glass_once, 1e-3),
    "refraction": (lambda r: refraction(roughness=r, ior=IOR), refracted_once, 1e-3),
    "fibers": (lambda r: sheen(roughness=r), at_most_all, 0),
    "velvet": (lambda r: sheen(roughness=r, distribution="ASHIKHMIN"), at_most_all, 0),
    "flesh": (lambda r: subsurface(alpha=0.0), all_of_it, 1e-9),
    "skin": (lambda r: subsurface(method="RANDOM_WALK_SKIN"), all_of_it, 1e-9),
    "principled metal": (lambda r: principled(metallic=1.0, base_color=1.0, roughness=r), all_of_it, 0.004),
    "principled metal, once": (
        lambda r: principled("GGX", metallic=1.0, base_color=1.0, roughness=r),
        mirrored_once,
        1e-3,
    ),
    "principled glass": (lambda r: principled(transmission=1.0, base_color=1.0, roughness=r), all_of_it, 0.01),
    "principled glass, once": (
        lambda r: principled("GGX", transmission=1.0, base_color=1.0, roughness=r),
        glass_once,
        1e-3,
    ),
    "glass under a film": (lambda r: under_film(glass(roughness=r, distribution="GGX"), 400.0), at_most_all, 0),
    "metal under a film": (lambda r: under_film(metallic(0.9, 0.7, roughness=r), 400.0), at_most_all, 0.004),
    "beckmann": (lambda r: glossy(roughness=r, distribution="BECKMANN"), beckmann_once, 1e-3),
    "beckmann metal": (lambda r: metallic(roughness=r, distribution="BECKMANN"), beckmann_once, 1e-3),
    "beckmann conductor": (
        lambda r: metallic(1.0, 1e6, r, physical=True, distribution="BECKMANN"),
        beckmann_once,
        1e-3,
    ),
    "beckmann glass, once": (lambda r: glass(roughness=r, distribution="BECKMANN"), at_most_all, 0),
    "beckmann refraction, once": (lambda r: refraction(roughness=r, distribution="BECKMANN"), at_most_all, 0),
    "ashikhmin": (lambda r: glossy(roughness=r, distribution="ASHIKHMIN_SHIRLEY"), at_most_all, 0),
    "fuzzy": (lambda r: principled(base_color=1.0, sheen_weight=1.0, sheen_roughness=r), at_most_all, 0.007),
    "coated": (lambda r: principled(base_color=1.0, coat_weight=1.0, coat_roughness=r), at_most_all, 0.007),
    "flesh below": (lambda r: principled(base_color=1.0, subsurface_weight=1.0, roughness=r), at_most_all, 0.007),
    "skin below": (
        lambda r: principled(base_color=1.0, subsurface_weight=1.0, roughness=r, method="RANDOM_WALK_SKIN"),
        at_most_all,
        0.007,
    ),
}


def test_every_closure_is_tested():
    assert choices_of(*(build(0.5) for build, _, _ in FURNACE.values())) == closure_choices()
    drawn = choices_of(*(closure for closures in ROUGH.values() for closure in closures))
    assert {choice for choice in closure_choices() if choice[0] not in SHARP} == drawn


@pytest.mark.parametrize("backfacing", [0.0, 1.0])
@pytest.mark.parametrize("mu", [0.2, 0.5, 1.0])
@pytest.mark.parametrize("roughness", [0.0, 0.1, 0.3, 0.6, 1.0])
@pytest.mark.parametrize("name", FURNACE)
def test_white_furnace(name, roughness, mu, backfacing):
    build, expected, table_error = FURNACE[name]
    weight = SCENE.draw_bsdf(
        material(build(roughness)),
        np.random.default_rng(3).random((20_000, 3)),
        wo=direction(mu),
        backfacing=backfacing,
    ).weight
    error = 4.5 * weight.std(axis=0) / np.sqrt(len(weight)) + table_error + 1e-9
    wanted = expected(max(roughness, 0.01), mu, 1 / IOR if backfacing else IOR)
    if wanted is None:
        assert (weight.mean(axis=0) < 1 + error).all()
    else:
        assert (np.abs(weight.mean(axis=0) - wanted) < error).all(), (weight.mean(axis=0), wanted)


@pytest.mark.parametrize("roughness", [0.1, 0.3, 0.6, 1.0])
@pytest.mark.parametrize("backfacing", [0.0, 1.0])
@pytest.mark.parametrize("name", ["glossy", "glass", "principled metal", "principled glass"])
def test_white_furnace_at_grazing_angles(name, roughness, backfacing):
    """Where the tables are off more."""
    closure, u = FURNACE[name][0](roughness), np.random.default_rng(3).random((40_000, 3))
    weight = SCENE.draw_bsdf(material(closure), u, wo=direction(0.05), backfacing=backfacing).weight[:, 0]
    assert abs(weight.mean() - 1) < 4 * weight.std() / np.sqrt(len(weight)) + (0.04 if "glass" in name else 0.004)


@pytest.mark.parametrize("mu", [0.02, 0.3, 0.9])
@pytest.mark.parametrize("roughness", [0.05, 0.4, 1.0])
def test_no_sample_of_single_scattering_gains_energy(roughness, mu):
    once = [build(roughness) for name, (build, _, _) in FURNACE.items() if "once" in name]
    stretched = glossy(roughness=roughness, distribution="GGX", anisotropy=0.8)
    plain = principled("GGX", base_color=1.0, metallic=1.0, roughness=roughness, anisotropy=0.7)
    for closure in (
        *once,
        refraction(roughness=roughness),
        translucent(),
        sheen(roughness=roughness),
        stretched,
        plain,
    ):
        index = material(closure)
        for backfacing in (0.0, 1.0):
            u = np.random.default_rng(4).random((20_000, 3))
            weight = SCENE.draw_bsdf(index, u, wo=direction(mu), backfacing=backfacing).weight
            assert (weight <= 1 + 1e-9).all(), closure
