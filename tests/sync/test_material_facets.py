"""The distributions of microfacets besides GGX, against Cycles.

Cycles' sampling of Ashikhmin and Shirley's lobe turns facets that are seen from behind, which its formula does not
have, to the front, but then mirrors rays at them with the wrong sign: some light is added where rough surfaces are seen
at grazing angles. It is told apart here.
"""

import bpy
import numpy as np
import pytest
from cycles_scattering import VIEW, Comparison, geometric_normal, sky
from test_material_albedo import GLOSSY_COLOR, glass, glossy, metallic, stretched_glossy, tangent_axes
from value_cases import new

from tests.images.image_statistics import welch_z

COSINES = (1.0, 0.8, 0.5, 0.25)


def refraction(tree, roughness):
    inputs = {"Color": (0.9, 0.6, 1, 1), "Roughness": roughness, "IOR": 1.45}
    return new(tree, "BsdfRefraction", inputs, distribution="BECKMANN")


CASES = {
    "beckmann": lambda t: glossy(t, 0.3, "BECKMANN"),
    "rough beckmann": lambda t: glossy(t, 0.9, "BECKMANN"),
    "stretched beckmann": lambda t: stretched_glossy(t, 0.6, 0.1, "BECKMANN"),
    "beckmann metal": lambda t: metallic(t, "F82", "BECKMANN"),
    "beckmann glass": lambda t: glass(t, 0.4, "BECKMANN"),
    "beckmann refraction": lambda t: refraction(t, 0.5),
    "ashikhmin shirley": lambda t: glossy(t, 0.4, "ASHIKHMIN_SHIRLEY"),
    "rough ashikhmin shirley": lambda t: glossy(t, 0.9, "ASHIKHMIN_SHIRLEY"),
    "stretched ashikhmin shirley": lambda t: stretched_glossy(t, 0.6, 0.1, "ASHIKHMIN_SHIRLEY"),
    "ashikhmin shirley mirror": lambda t: glossy(t, 0.0, "ASHIKHMIN_SHIRLEY"),
}


if bpy.app.version >= (5, 0, 0):  # before, Fresnel's equations were approximated
    CASES["beckmann conductor"] = lambda t: metallic(t, "PHYSICAL_CONDUCTOR", "BECKMANN", Anisotropy=0.0)

# alpha along and across the tangent, and the turn of that
ASHIKHMIN_SHIRLEY = {
    "ashikhmin shirley": (0.4**2, 0.4**2, 0.0),
    "rough ashikhmin shirley": (0.9**2, 0.9**2, 0.0),
    "stretched ashikhmin shirley": (0.5**2 * 0.4, 0.5**2 / 0.4, 0.1),
}


def turned_to_the_front(name, side, cosine, count=1_000_000):
    """Samples (count, 3) of the light that facets seen from behind add in Cycles: each ray with a weight of the cosine
    to it over the larger cosine."""
    alpha_x, alpha_y, turn = ASHIKHMIN_SHIRLEY[name]
    axes = tangent_axes(geometric_normal(cosine), turn)
    x, y = 2 / alpha_x**2 - 2, 2 / alpha_y**2 - 2
    u, v = np.random.default_rng(side).random((2, count))
    phi = np.arctan2(np.sqrt(x + 1) * np.sin(2 * np.pi * u), np.sqrt(y + 1) * np.cos(2 * np.pi * u))
    z = v ** (1 / (x * np.cos(phi) ** 2 + y * np.sin(phi) ** 2 + 1))
    sine = np.sqrt(1 - z**2)
    h = np.stack([sine * np.cos(phi), sine * np.sin(phi), z], axis=1) @ axes
    behind = np.maximum(-(h @ VIEW), 0)
    wo = 2 * behind[:, None] * h - VIEW
    height = wo @ axes[2]
    seen = (behind > 0) & (height > 0)
    weight = np.where(seen, height / np.maximum(cosine, height), 0)
    return weight[:, None] * GLOSSY_COLOR * sky(wo / np.linalg.norm(wo, axis=1, keepdims=True))


@pytest.fixture(scope="module")
def comparison(tmp_path_factory):
    return Comparison(CASES, COSINES, tmp_path_factory.mktemp("cycles") / "facets.exr")


@pytest.mark.parametrize("side", [0, 1])
@pytest.mark.parametrize("name", CASES)
def test_facets_scatter_as_in_cycles(comparison, name, side):
    for cosine in COSINES:
        found = comparison.scattered(name, side, cosine)
        added = turned_to_the_front(name, side, cosine) if name in ASHIKHMIN_SHIRLEY else np.zeros((2, 3))
        z = welch_z(found.ours + added.mean(axis=0), found.cycles)
        assert (np.abs(z) < 4.5).all(), (cosine, z)
