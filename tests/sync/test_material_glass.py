"""Rough glass that makes up for multiple scattering, against Cycles, from outside and from inside.

Both divide the light of single scattering by an albedo from a table. From inside Cycles' table counts refractions that
end on the wrong side of the surface too, which its sampling drops, so that Cycles loses up to a tenth of the light at
grazing angles. That is told apart here by quadrature: what Cycles should show is what we should show times the ratio
of the true albedo to that of Cycles' table.
"""

import functools
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import pytest
from cycles_scattering import Comparison
from cycles_tables import interpolate, ior_of, place_of
from value_cases import new

from tests.images.image_statistics import welch_z
from tests.native.microfacet_oracle import glass_energy

COSINES = (0.95, 0.6, 0.35, 0.25)
WHITE, TINT = (1.0, 1.0, 1.0), (0.81, 0.36, 1.0)


class Case(NamedTuple):
    """A kind of glass; `bounced` is the color that each bounce between its facets is multiplied by."""

    build: Callable
    roughness: float
    ior: float
    color: tuple
    bounced: np.ndarray


def glass(tree, case):
    inputs = {"Color": (*case.color, 1), "Roughness": case.roughness, "IOR": case.ior}
    return new(tree, "BsdfGlass", inputs, distribution="MULTI_GGX")


def principled(tree, case):
    inputs = {"Base Color": (*case.color, 1), "Roughness": case.roughness, "IOR": case.ior, "Transmission Weight": 1.0}
    return new(tree, "BsdfPrincipled", inputs, distribution="MULTI_GGX")


CASES = {
    f"{build.__name__} of roughness {roughness} and IOR {ior}": Case(build, roughness, ior, WHITE, np.array(WHITE))
    for build in (glass, principled)
    for roughness in (0.5, 0.75, 1.0)
    for ior in (1.1, 1.45, 2.0)
}
CASES["tinted glass"] = Case(glass, 0.4, 1.45, TINT, np.array(TINT))
CASES["tinted principled"] = Case(principled, 0.6, 1.45, TINT, np.sqrt(TINT))  # by each of the two surfaces


@pytest.fixture(scope="module")
def comparison(tmp_path_factory):
    shaders = {name: lambda tree, case=case: case.build(tree, case) for name, case in CASES.items()}
    return Comparison(shaders, COSINES, tmp_path_factory.mktemp("cycles") / "glass.exr")


@functools.cache
def energy(roughness, mu, eta):
    return glass_energy(roughness, mu, [eta])[0]


def table_albedo(roughness, mu, eta):
    """As Cycles counts it."""
    found = energy(roughness, mu, eta)
    return min(found.albedo + found.wrong_side, 1)


def average(albedo, roughness, eta):
    """Cosine-weighted mean of an albedo over mu: 2 mu dmu = 4 t^3 dt for mu = t^2."""
    t, weights = np.polynomial.legendre.leggauss(16)
    t, weights = (t + 1) / 2, weights / 2
    return sum(4 * x**3 * w * albedo(roughness, max(x**2, 0.01), eta) for x, w in zip(t, weights, strict=True))


def compensation(albedo, mean, bounced):
    """What single scattering is multiplied by: Kulla and Conty, as in closure.c."""
    several = bounced * mean / (1 - bounced * (1 - mean))
    return 1 + (1 - albedo) / albedo * several


def cycles_over_ours(case, cosine, side):
    """Ratio (3,) of the light of both."""
    z, eta = place_of(case.ior), 1 / case.ior if side else case.ior
    theirs = interpolate(lambda r, mu, z: table_albedo(r, mu, ior_of(z, side)), case.roughness, cosine, z)
    ours = energy(case.roughness, cosine, eta).albedo
    if case.color == WHITE:  # whatever the means
        return ours / theirs * case.bounced
    their_mean = interpolate(lambda r, z: average(table_albedo, r, ior_of(z, side)), case.roughness, z)
    our_mean = average(lambda *place: energy(*place).albedo, case.roughness, eta)
    return compensation(theirs, their_mean, case.bounced) / compensation(ours, our_mean, case.bounced)


@pytest.mark.parametrize("side", [0, 1])
@pytest.mark.parametrize("name", CASES)
def test_light_of_rough_glass_is_that_of_cycles_but_for_its_table(comparison, name, side):
    for cosine in COSINES:
        ratio = cycles_over_ours(CASES[name], cosine, side)
        found = comparison.scattered(name, side, cosine)
        z = welch_z(found.ours * ratio, found.cycles)
        assert (np.abs(z) < 4.5).all(), (cosine, ratio, z)
