"""The tables of the light that is lost between microfacets, against quadrature (microfacet_oracle.py)."""

import numpy as np
import pytest
from bsdf_tools import SCENE, direction, glass, glossy, material, principled
from microfacet_oracle import glass_energy, layer_energy

IORS = (1.001, 1.01, 1.03, 1.06, 1.1, 1.15, 1.2, 1.33, 1.5, 2.0, 3.0, 5.0)
ROUGHNESSES = (0.08, 0.23, 0.43, 0.61, 0.77, 0.97)
GLASS_BOUND = {0.0: (0.004, 0.04), 1.0: (0.01, 0.04)}  # of microfacet_energy.h, by backfacing: mu > 0.08, and below
LOW_IOR_INSIDE = 0.1


def table_albedo(lobe, **settings):
    """The albedo that a lobe's compensation assumes: white light makes up for what is missing by division by it."""
    point = {"wo": direction(settings.pop("mu")), "backfacing": settings.pop("backfacing", 0.0)}
    single, multiple = (
        SCENE.evaluate_bsdf(material(lobe(distribution=kind, **settings)), [(0.1, 0.2, 0.97)], **point)[0][0, 0]
        for kind in ("GGX", "MULTI_GGX")
    )
    return single / multiple


@pytest.mark.parametrize("mu", [0.02, 0.05, 0.1, 0.17, 0.29, 0.5, 0.75, 0.97])
@pytest.mark.parametrize("roughness", ROUGHNESSES)
def test_glass(roughness, mu):
    for backfacing, (wide, grazing) in GLASS_BOUND.items():
        etas = [1 / ior if backfacing else ior for ior in IORS]
        for ior, exact in zip(IORS, glass_energy(roughness, mu, etas), strict=True):
            table = table_albedo(glass, roughness=roughness, ior=ior, mu=mu, backfacing=backfacing)
            bound = wide if mu > 0.08 else LOW_IOR_INSIDE if backfacing and ior <= 1.01 else grazing
            assert table == pytest.approx(exact.albedo, rel=bound), (ior, backfacing)


@pytest.mark.parametrize("mu", [0.02, 0.1, 0.29, 0.6, 0.97])
@pytest.mark.parametrize("roughness", ROUGHNESSES)
def test_reflection(roughness, mu):
    (exact,) = glass_energy(roughness, mu, (1e9,))  # reflects everything
    table = table_albedo(glossy, roughness=roughness, mu=mu)
    assert table == pytest.approx(exact.albedo, rel=0.002 if mu > 0.08 else 0.04)


@pytest.mark.parametrize("mu", [0.02, 0.05, 0.1, 0.17, 0.29, 0.5, 0.75, 0.97])
@pytest.mark.parametrize("roughness", ROUGHNESSES)
def test_what_a_layer_leaves_to_those_below(roughness, mu):
    """The diffuse lobe of plastic is what a white base adds to a black one."""
    for ior in IORS:
        white, black = (
            SCENE.evaluate_bsdf(
                material(principled(distribution="GGX", base_color=color, roughness=roughness, ior=ior)),
                [direction(0.9)],
                wo=direction(mu),
            )[0][0, 0]
            for color in (1.0, 0.0)
        )
        left = (white - black) * np.pi / 0.9
        _, taken = layer_energy(roughness, mu, ior)
        assert 1 - left == pytest.approx(taken, abs=0.007 if mu > 0.08 else 0.02), ior


def test_glass_of_any_ior_is_white_on_average():
    """Sampled from both sides at random roughness, IOR from 1.001 to 4 and direction: no energy is lost or won."""
    rng = np.random.default_rng(5)
    means = []
    for k in range(300):
        closure = glass(roughness=rng.uniform(0.2, 1), ior=1 + 10 ** rng.uniform(-3, 0.5))
        point = {"wo": direction(np.sqrt(rng.uniform(0.01, 1))), "backfacing": float(k % 2)}
        means.append(SCENE.draw_bsdf(material(closure), rng.random((2000, 3)), **point).weight[:, 0].mean())
    assert np.mean(means) == pytest.approx(1, abs=4 * np.std(means) / np.sqrt(len(means)) + 0.001)
