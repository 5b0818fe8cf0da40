"""Rough glass that makes up for multiple scattering, against Cycles, from outside and from inside.

Both divide the light of single scattering by an albedo from a table. From inside Cycles' table counts refractions that
end on the wrong side of the surface too, which its sampling drops, so that Cycles loses up to a tenth of the light at
grazing angles. That is told apart here by quadrature: what Cycles should show is what we should show times the ratio
of the true albedo to that of Cycles' table.
"""

import numpy as np
import pytest
from cycles_scattering import Comparison
from value_cases import new

from tests.native.microfacet_oracle import glass_energy

COSINES = (0.95, 0.6, 0.35, 0.25)
ENTRIES = 16  # of Cycles' table along each axis (intern/cycles/app/cycles_precompute.cpp)


def glass(tree, roughness, ior):
    inputs = {"Color": (1, 1, 1, 1), "Roughness": roughness, "IOR": ior}
    return new(tree, "BsdfGlass", inputs, distribution="MULTI_GGX")


def principled(tree, roughness, ior):
    inputs = {"Base Color": (1, 1, 1, 1), "Roughness": roughness, "IOR": ior, "Transmission Weight": 1.0}
    return new(tree, "BsdfPrincipled", inputs, distribution="MULTI_GGX")


CASES = {
    f"{shader.__name__} of roughness {roughness} and IOR {ior}": (shader, roughness, ior)
    for shader in (glass, principled)
    for roughness in (0.5, 0.75, 1.0)
    for ior in (1.1, 1.45, 2.0)
}


@pytest.fixture(scope="module")
def comparison(tmp_path_factory):
    shaders = {
        name: lambda tree, shader=shader, roughness=roughness, ior=ior: shader(tree, roughness, ior)
        for name, (shader, roughness, ior) in CASES.items()
    }
    return Comparison(shaders, COSINES, tmp_path_factory.mktemp("cycles") / "glass.exr")


def cycles_albedo(roughness, mu, ior, side):
    """From a table as Cycles makes it: even in roughness, mu and z with z^2 = (ior - 1) / (ior + 1), linear between."""
    places = np.array([roughness, mu, np.sqrt((ior - 1) / (ior + 1))]) * (ENTRIES - 1)
    corner = np.minimum(places.astype(int), ENTRIES - 2)
    fraction = places - corner
    z2 = ((corner[2] + np.arange(2)) / (ENTRIES - 1)) ** 2
    etas = ((1 + z2) / (1 - z2)) ** (-1 if side else 1)
    total = 0.0
    for r, m in np.ndindex(2, 2):
        weight = np.prod(np.where([r, m], fraction[:2], 1 - fraction[:2]))
        energies = glass_energy((corner[0] + r) / (ENTRIES - 1), (corner[1] + m) / (ENTRIES - 1), etas)
        total += weight * np.dot([1 - fraction[2], fraction[2]], [min(e.albedo + e.wrong_side, 1) for e in energies])
    return total


@pytest.mark.parametrize("side", [0, 1])
@pytest.mark.parametrize("name", CASES)
def test_light_of_rough_glass_is_that_of_cycles_but_for_its_table(comparison, name, side):
    _, roughness, ior = CASES[name]
    for cosine in COSINES:
        (exact,) = glass_energy(roughness, cosine, [1 / ior if side else ior])
        found = comparison.scattered(name, side, cosine)
        ratio = exact.albedo / cycles_albedo(roughness, cosine, ior, side)
        error = np.sqrt(found.cycles_variance + ratio**2 * found.ours_variance)
        z = (found.ours * ratio - found.cycles) / error
        assert (np.abs(z) < 4.5).all(), (cosine, ratio, z)
