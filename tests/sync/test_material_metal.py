"""Metal of a refractive index and an extinction coefficient, against Cycles.

Cycles 5.0 has Fresnel's equations, as we do; Cycles 4.5 an approximation of them for large indices, which is told apart
here where it can be: in a mirror. Large indices make no difference.
"""

import bpy
import numpy as np
import pytest
from cycles_scattering import VIEW, Comparison, geometric_normal, sky
from test_material_albedo import metallic

from tests.images.image_statistics import welch_z

COSINES = (1.0, 0.8, 0.5, 0.25)
IOR, EXTINCTION = np.array((0.2, 1.1, 3.0)), np.array((3.9, 2.4, 0.5))
HAS_FRESNEL = bpy.app.version >= (5, 0, 0)


def conductor(tree, distribution="MULTI_GGX", scale=1, **inputs):
    colors = {"IOR": tuple(scale * IOR), "Extinction": tuple(scale * EXTINCTION)}
    return metallic(tree, "PHYSICAL_CONDUCTOR", distribution, **colors, **inputs)


MIRROR = {"mirror": lambda t: conductor(t, roughness=0.0)}
ROUGH = {
    "stretched": lambda t: conductor(t, roughness=0.5),
    "single": lambda t: conductor(t, "GGX", roughness=0.4),
    "rough": lambda t: conductor(t, roughness=0.8, Anisotropy=0.0),
    "default": lambda t: metallic(t, "PHYSICAL_CONDUCTOR"),
}
LARGE = {
    "large": lambda t: conductor(t, scale=8, roughness=0.5),
    "large single": lambda t: conductor(t, "GGX", scale=8, roughness=0.4),
}


@pytest.fixture(scope="module")
def comparison(tmp_path_factory):
    return Comparison(MIRROR | ROUGH | LARGE, COSINES, tmp_path_factory.mktemp("cycles") / "metal.exr")


def fresnel(mu):
    """Reflectance (3,) by the amplitudes of both polarizations."""
    index = IOR + 1j * EXTINCTION
    inside = np.sqrt(1 - (1 - mu**2) / index**2)
    s = (mu - index * inside) / (mu + index * inside)
    p = (index * mu - inside) / (index * mu + inside)
    return (abs(s) ** 2 + abs(p) ** 2) / 2


def approximation(mu):
    """Reflectance (3,) where the index is so large that light inside goes straight down: Cycles 4.5."""
    squares, twice = IOR**2 + EXTINCTION**2, 2 * IOR * mu
    p = (squares * mu**2 - twice + 1) / (squares * mu**2 + twice + 1)
    s = (squares - twice + mu**2) / (squares + twice + mu**2)
    return (p + s) / 2


@pytest.mark.parametrize("side", [0, 1])
def test_mirror(comparison, side):
    """Ours by Fresnel's equations, Cycles' by its own."""
    for cosine in COSINES:
        found = comparison.scattered("mirror", side, cosine)
        seen = sky(2 * cosine * geometric_normal(cosine) - VIEW)
        np.testing.assert_allclose(found.ours.mean(axis=0), fresnel(cosine) * seen, rtol=1e-5)
        expected = (fresnel if HAS_FRESNEL else approximation)(cosine) * seen
        np.testing.assert_allclose(found.cycles.mean(axis=0), expected, rtol=1e-5)


@pytest.mark.parametrize("side", [0, 1])
@pytest.mark.parametrize("name", LARGE | (ROUGH if HAS_FRESNEL else {}))
def test_rough_metal(comparison, name, side):
    for cosine in COSINES:
        found = comparison.scattered(name, side, cosine)
        z = welch_z(found.ours, found.cycles)
        assert (np.abs(z) < 4.5).all(), (cosine, z)
