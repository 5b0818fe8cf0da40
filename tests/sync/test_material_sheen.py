"""The Sheen BSDF against Cycles, up to the noise of the tables that both have of it.

Under a normal map Cycles 4.5 softens the terminator of velvet as that of diffuse surfaces; we and Cycles 5.0 do not.
"""

import bpy
import numpy as np
import pytest
from cycles_normals import STEPS, around
from cycles_scattering import VIEW, Comparison, geometric_normal, sky
from test_material_albedo import LEANS, leaning
from value_cases import new

from tests.images.image_statistics import welch_z
from tests.native.bsdf_tools import SCENE, direction, material
from tests.native.bsdf_tools import sheen as sheen_lobe

COSINES = (1.0, 0.8, 0.5, 0.25)
COLOR = (0.8, 0.5, 0.9)
VELVET_ROUGHNESS = 0.6  # with normal maps
NODES = 31  # steps of both tables, along roughness and cosine; linear between them
THEIR_SAMPLES = 2_000_000  # of each entry of Cycles' table: Zeltner et al., precompute_brdf_values_sheen_volume.py
OUR_SAMPLES, OUR_REFLECTED = 3_000_000, 700_000  # of ours: tools/fit_sheen.c; whichever comes first


def sheen(tree, roughness, distribution="MICROFIBER"):
    return new(tree, "BsdfSheen", {"Color": (*COLOR, 1), "Roughness": roughness}, distribution=distribution)


FIBERS = {f"fibers of roughness {r}": r for r in (0.3, 0.5, 0.83, 1.0)}
CASES = {name: lambda t, r=r: sheen(t, r) for name, r in FIBERS.items()} | {
    "velvet": lambda t: sheen(t, 0.7, "ASHIKHMIN"),
    "fine velvet": lambda t: sheen(t, 0.3, "ASHIKHMIN"),
}
LEANING = {}  # name -> color of the normal map
for _lean, _color in LEANS.items():
    LEANING[f"velvet with a {_lean} normal"] = _color
    CASES[f"velvet with a {_lean} normal"] = leaning(lambda t: sheen(t, VELVET_ROUGHNESS, "ASHIKHMIN"), _color)
    FIBERS[f"fibers with a {_lean} normal"] = 0.9
    CASES[f"fibers with a {_lean} normal"] = leaning(lambda t: sheen(t, 0.9), _color)


@pytest.fixture(scope="module")
def comparison(tmp_path_factory):
    return Comparison(CASES, COSINES, tmp_path_factory.mktemp("cycles") / "sheen.exr")


def table_variance(roughness, mu):
    """Relative variance of the reflected part, between the entries of the two tables: each entry is a mean of chances.
    Ours are independent; Cycles' come from the same random numbers, so that their errors add up."""
    total, ours, their_deviation = 0.0, 0.0, 0.0
    for row, part_of_row in split(roughness):
        for column, part_of_column in split(mu):
            r, cosine, part = max(row / NODES, 0.01), max(column / NODES, 0.01), part_of_row * part_of_column
            (albedo,) = SCENE.shade(material(sheen_lobe(roughness=r)), wo=direction(cosine))["albedo"][:, 0]
            depth = np.sqrt(1 - cosine**2 + (r**2 * cosine) ** 2) / cosine
            met = 1 - np.exp(-depth)  # our paths all meet a fiber, with this weight
            chance = albedo / met
            total += part * albedo
            ours += part**2 * albedo * met * (1 - chance) / min(OUR_SAMPLES, OUR_REFLECTED / chance)
            their_deviation += part * np.sqrt(albedo * (1 - albedo) / THEIR_SAMPLES)
    return (ours + their_deviation**2) / total**2


def split(x):
    """The two entries around x in [0, 1], and their parts."""
    low = min(int(x * NODES), NODES - 1)
    return (low, 1 - (x * NODES - low)), (low + 1, x * NODES - low)


def mean_and_variance(samples):
    return samples.mean(axis=0), samples.var(axis=0, ddof=1) / len(samples)


@pytest.mark.parametrize("side", [0, 1])
@pytest.mark.parametrize("name", FIBERS)
def test_fibers_scatter_as_in_cycles_but_for_the_noise_of_the_tables(comparison, name, side):
    for cosine in COSINES:
        found = comparison.scattered(name, side, cosine)
        (ours, our_variance), (cycles, cycles_variance) = map(mean_and_variance, (found.ours, found.cycles))
        noise = cycles**2 * table_variance(FIBERS[name], cosine) if "normal" not in name else 0
        z = (ours - cycles) / np.sqrt(our_variance + cycles_variance + noise + 1e-300)
        assert (np.abs(z) < 4.5).all(), (cosine, z)


def softened_velvet(color, cosine):
    """Light (3,) that Cycles 4.5 takes from velvet whose normal is that of a map, by quadrature: Ashikhmin, Premoze,
    Shirley (2000); Conty et al., "A Microfacet-Based Shadowing Function to Solve the Bump Terminator Problem"."""
    geometric, normal = geometric_normal(cosine), 2 * np.array(color) - 1
    normal /= np.linalg.norm(normal)
    cos_o = (np.arange(STEPS) + 0.5) / STEPS
    wi = around(normal, cos_o)
    half = (wi + VIEW) / np.linalg.norm(wi + VIEW, axis=-1, keepdims=True)
    cos_h, cos_i, cos_v, lit = half @ normal, half @ VIEW, normal @ VIEW, wi @ geometric
    upright, sin2 = VELVET_ROUGHNESS**-2, 1 - cos_h**2
    density = upright * np.exp(-upright * cos_h**2 / sin2) / (np.pi * sin2**2)
    grooves = np.minimum(1, 2 * cos_h / cos_i * np.minimum(cos_o[:, None], cos_v))
    value = density * grooves / (4 * cos_v) * (lit > 0)
    tilt2 = (geometric @ normal) ** 2
    slope2 = np.clip(0.125 * (1 - tilt2) / tilt2, 0, 1) * (1 - lit**2) / lit**2
    taken = value * (1 - 2 / (1 + np.sqrt(1 + slope2)))
    return np.array(COLOR) * np.einsum("ij,ijk->k", taken, sky(wi)) * 2 * np.pi / STEPS**2


@pytest.mark.parametrize("side", [0, 1])
@pytest.mark.parametrize("name", [name for name in CASES if name not in FIBERS])
def test_velvet_scatters_as_in_cycles(comparison, name, side):
    """With a normal map, nothing is scattered from behind."""
    for cosine in COSINES:
        found, softened = comparison.scattered(name, side, cosine), 0.0
        if name in LEANING and not side and bpy.app.version < (5, 0, 0):
            softened = softened_velvet(LEANING[name], cosine)
        z = welch_z(found.ours - softened, found.cycles)
        assert (np.abs(z) < 4.5).all(), (cosine, z)
