"""Thin films against Cycles: on plastic, glass and, where Blender has that, on metal."""

import bpy
import numpy as np
import pytest
from cycles_scattering import Comparison
from test_material_albedo import glass, metallic, principled

from tests.images.image_statistics import welch_z

COSINES = (1.0, 0.8, 0.5, 0.25)
ON_METAL = bpy.app.version >= (5, 0, 0)


def film(thickness, ior=1.33):
    return {"Thin Film Thickness": thickness, "Thin Film IOR": ior}


def soap(tree, thickness, ior):
    shader = glass(tree, 0.0)
    for name, value in film(thickness, ior).items():
        shader.inputs[name].default_value = value
    return shader


# These have no noise. The observer's curves have four decimals, which leaves this.
MIRRORS, MIRRORS_ERROR = ("smooth plastic", "dense film", "on a mirror"), 2e-4

CASES = {
    "smooth plastic": lambda t: principled(t, "GGX", Roughness=0.0, **film(400.0), **{"Base Color": (0, 0, 0, 1)}),
    "dense film": lambda t: principled(t, "GGX", Roughness=0.0, **film(250.0, 2.2), **{"Base Color": (0, 0, 0, 1)}),
    "thick film": lambda t: principled(t, "GGX", Roughness=0.2, **film(1500.0, 1.8)),
    "thinnest film": lambda t: principled(t, Roughness=0.3, **film(15.0, 1.8)),
    "on nothing": lambda t: principled(t, Roughness=0.1, IOR=1.0, **film(500.0)),
    "tinted": lambda t: principled(t, Roughness=0.4, **film(300.0, 1.7), **{"Specular Tint": (0.2, 0.9, 1, 1)}),
    "on glass": lambda t: principled(t, "GGX", Roughness=0.0, **film(350.0, 1.7), **{"Transmission Weight": 1.0}),
    "on rough glass": lambda t: principled(t, "GGX", **film(350.0, 2.0), **{"Transmission Weight": 1.0}),
}
if ON_METAL:
    CASES |= {
        "soap": lambda t: soap(t, 300.0, 2.0),
        "on metal": lambda t: principled(t, "GGX", Metallic=1.0, Roughness=0.2, **film(400.0, 1.8)),
        "on tinted metal": lambda t: metallic(t, "F82", **film(300.0, 2.0), **{"Edge Tint": (0.4, 0.8, 1, 1)}),
        "on a conductor": lambda t: metallic(t, "PHYSICAL_CONDUCTOR", **film(350.0, 1.6)),
        "on a mirror": lambda t: metallic(t, "PHYSICAL_CONDUCTOR", roughness=0.0, **film(350.0, 1.6)),
    }


@pytest.fixture(scope="module")
def comparison(tmp_path_factory):
    return Comparison(CASES, COSINES, tmp_path_factory.mktemp("cycles") / "film.exr")


@pytest.mark.parametrize("side", [0, 1])
@pytest.mark.parametrize("name", CASES)
def test_films_reflect_as_in_cycles(comparison, name, side):
    for cosine in COSINES:
        found = comparison.scattered(name, side, cosine)
        if name in MIRRORS:
            np.testing.assert_allclose(found.ours.mean(axis=0), found.cycles.mean(axis=0), atol=MIRRORS_ERROR)
            continue
        z = welch_z(found.ours, found.cycles)
        assert (np.abs(z) < 4.5).all(), (cosine, z)
