"""Scattering against Cycles: each BSDF, tilted to several angles under a sky that is different in every direction."""

import bpy
import numpy as np
import pytest
from cycles_normals import Lobe, below_normal, counted_twice, raised
from cycles_scattering import VIEW, Comparison, geometric_normal, sky
from cycles_tables import interpolate, ior_of, place_of
from value_cases import new

from tests.images.image_statistics import welch_z
from tests.native.microfacet_oracle import fresnel

COSINES = (1.0, 0.8, 0.5, 0.25)
BASE_COLOR, ROUGHNESS, IOR = (0.8, 0.4, 0.1), 0.4, 1.5  # of the Principled BSDF
SMOOTH_IOR = 1.8
GLOSSY_COLOR, GLOSSY_ROUGHNESS = (0.9, 0.6, 0.3), 0.3


def diffuse(tree, roughness):
    return new(tree, "BsdfDiffuse", {"Color": (0.8, 0.5, 0.9, 1), "Roughness": roughness})


def glossy(tree, roughness, distribution):
    inputs = {"Color": (*GLOSSY_COLOR, 1), "Roughness": roughness}
    return new(tree, "BsdfAnisotropic", inputs, distribution=distribution)


def glass(tree, roughness, distribution="GGX"):
    inputs = {"Color": (0.9, 0.6, 1, 1), "Roughness": roughness, "IOR": 1.45}
    return new(tree, "BsdfGlass", inputs, distribution=distribution)


def refraction(tree, roughness, ior=1.45):
    inputs = {"Color": (0.9, 0.6, 1, 1), "Roughness": roughness, "IOR": ior}
    return new(tree, "BsdfRefraction", inputs, distribution="GGX")


def translucent(tree):
    return new(tree, "BsdfTranslucent", {"Color": (0.8, 0.5, 0.9, 1)})


def principled(tree, distribution="MULTI_GGX", **inputs):
    inputs = {"Base Color": (*BASE_COLOR, 1), "Roughness": ROUGHNESS, "IOR": IOR} | inputs
    return new(tree, "BsdfPrincipled", inputs, distribution=distribution)


def coated(tree, distribution="MULTI_GGX", **inputs):
    inputs = {"Coat Weight": 0.8, "Coat Roughness": 0.0, "Coat IOR": 1.7, "Coat Tint": (0.9, 0.5, 0.7, 1)} | inputs
    return principled(tree, distribution, **inputs)


def metallic(tree, model, distribution="MULTI_GGX", roughness=0.5, **inputs):
    inputs = {"Roughness": roughness, "Anisotropy": 0.6, "Rotation": 0.1, "Tangent": tangent(tree)} | inputs
    return new(tree, "BsdfMetallic", inputs, fresnel_type=model, distribution=distribution)


def fuzzy(tree, roughness, **inputs):
    sheen = {"Sheen Weight": 0.9, "Sheen Roughness": roughness, "Sheen Tint": (0.7, 1, 0.4, 1)}
    return principled(tree, **sheen, **inputs)


def tangent(tree):
    """Not at right angles to any normal here."""
    return new(tree, "CombineXYZ", {0: 0.9, 1: 0.5, 2: -0.3}).outputs[0]


def tangent_axes(normal, turn):
    """Rows tangent, bitangent and normal of a surface with that tangent, turned around its normal."""
    y = np.cross(normal, (0.9, 0.5, -0.3))
    y /= np.linalg.norm(y)
    x, angle = np.cross(y, normal), 2 * np.pi * turn
    return np.array([np.cos(angle) * x + np.sin(angle) * y, np.cos(angle) * y - np.sin(angle) * x, normal])


def stretched_glossy(tree, anisotropy, rotation, distribution="GGX"):
    shader = glossy(tree, 0.5, distribution)
    shader.inputs["Anisotropy"].default_value, shader.inputs["Rotation"].default_value = anisotropy, rotation
    tree.links.new(tangent(tree), shader.inputs["Tangent"])
    return shader


def stretched(tree, anisotropic, rotation, **inputs):
    settings = {"Anisotropic": anisotropic, "Anisotropic Rotation": rotation, "Tangent": tangent(tree)}
    return principled(tree, Roughness=0.5, **settings, **inputs)


def mixed(tree):
    a, b, c = diffuse(tree, 0), glossy(tree, 0.3, "GGX"), new(tree, "BsdfTransparent", {0: (0.3, 0.9, 0.5, 1)})
    first = new(tree, "MixShader", {0: 0.3, 1: a.outputs[0], 2: b.outputs[0]})
    dim = new(tree, "MixShader", {0: 0.6, 1: first.outputs[0], 2: c.outputs[0]})
    light = new(tree, "Emission", {0: (0.2, 0.1, 0.05, 1), 1: 2.0})
    return new(tree, "AddShader", {0: dim.outputs[0], 1: light.outputs[0]})


# Others have files of their own: rough glass that makes up for multiple scattering, sheen, metal of a refractive index.
CASES = {
    "diffuse": lambda t: diffuse(t, 0),
    "oren_nayar": lambda t: diffuse(t, 0.7),
    "mirror": lambda t: glossy(t, 0, "GGX"),
    "glossy": lambda t: glossy(t, GLOSSY_ROUGHNESS, "GGX"),
    "glossy_multiple": lambda t: glossy(t, 0.7, "MULTI_GGX"),
    "glass_smooth": lambda t: glass(t, 0),
    "glass_rough": lambda t: glass(t, 0.4),
    "refraction_smooth": lambda t: refraction(t, 0),
    "refraction_rough": lambda t: refraction(t, 0.4),
    "refraction_thin": lambda t: refraction(t, 0.6, 0.8),
    "translucent": translucent,
    "plastic": principled,
    "plastic_single": lambda t: principled(t, "GGX"),
    "rough_plastic": lambda t: principled(t, Roughness=0.7, IOR=2.0),
    "roughest_plastic": lambda t: principled(t, "GGX", Roughness=1.0),
    "smooth_plastic": lambda t: principled(t, Roughness=0.0, IOR=SMOOTH_IOR),
    "tinted_plastic": lambda t: principled(
        t, **{"Specular Tint": (0.2, 0.9, 1, 1), "Specular IOR Level": 0.9, "Diffuse Roughness": 0.5}
    ),
    "metal": lambda t: principled(t, Metallic=1.0),
    "tinted_metal": lambda t: principled(t, Metallic=1.0, **{"Specular Tint": (0.3, 1, 0.7, 1)}),
    "half_metal": lambda t: principled(t, Metallic=0.5, Alpha=0.6),
    "transmission": lambda t: principled(t, "GGX", **{"Transmission Weight": 1.0}),
    "transmission_smooth": lambda t: principled(t, Roughness=0.0, **{"Transmission Weight": 0.7}),
    "coat": coated,
    "coat_rough": lambda t: coated(t, **{"Coat Roughness": 0.5}),
    "coat_roughest": lambda t: coated(t, **{"Coat Roughness": 1.0, "Coat Weight": 1.0, "Base Color": (1, 1, 1, 1)}),
    "coat_on_metal": lambda t: coated(t, **{"Metallic": 1.0, "Coat IOR": 1.2}),
    "coat_on_light": lambda t: coated(t, **{"Emission Strength": 2.0, "Emission Color": (1, 0.5, 0, 1), "Alpha": 0.7}),
    "coat_slight": lambda t: coat_of_its_own(t, "slight"),
    "coat_steep": lambda t: coat_of_its_own(t, "steep"),
    "metallic": lambda t: metallic(t, "F82", **{"Base Color": (0.9, 0.5, 0.2, 1), "Edge Tint": (0.4, 0.8, 1, 1)}),
    "metallic_smooth": lambda t: metallic(t, "F82", roughness=0.0),
    "fuzzy_plastic": lambda t: fuzzy(t, 0.6),
    "fuzzy_coat": lambda t: fuzzy(t, 0.4, **{"Coat Weight": 0.7, "Emission Strength": 1.0, "Alpha": 0.8}),
    "stretched": lambda t: stretched_glossy(t, 0.7, 0.0),
    "stretched_across": lambda t: stretched_glossy(t, -0.6, 0.15, "MULTI_GGX"),
    "stretched_metal": lambda t: stretched(t, 0.8, 0.3, Metallic=1.0),
    "stretched_plastic": lambda t: stretched(t, 1.0, 0.7, **{"Coat Weight": 0.2}),
    "emitting": lambda t: principled(t, **{"Emission Strength": 1.5, "Alpha": 0.5}),
    "mixed": mixed,
}

LEANING = {
    "diffuse": lambda t: diffuse(t, 0),
    "oren_nayar": lambda t: diffuse(t, 0.7),
    "glossy": lambda t: glossy(t, GLOSSY_ROUGHNESS, "GGX"),
    "plastic": lambda t: principled(t, "GGX"),
    "coat": lambda t: principled(t, "GGX", **{"Base Color": (0, 0, 0, 1)}),
    "metal": lambda t: principled(t, "GGX", Metallic=1.0),
    "translucent": translucent,
}
COAT = Lobe(ROUGHNESS, lambda cos_i: fresnel(cos_i, IOR)[..., None] * np.ones(3))
LOBES = {
    "glossy": Lobe(GLOSSY_ROUGHNESS, lambda cos_i: np.ones_like(cos_i)[..., None] * GLOSSY_COLOR),
    "plastic": COAT,
    "coat": COAT,
    "metal": Lobe(ROUGHNESS, lambda cos_i: BASE_COLOR + (1 - np.array(BASE_COLOR)) * (1 - cos_i[..., None]) ** 5),
}

# Normals by the color of a map in world space. The slight one is 17 to 49 degrees from the quads' own, and their mirror
# rays leave the surface. Those of the steep one, 60 to 77 degrees from them, would enter it if it were not raised.
LEANS = {"slight": (0.725, 0.6, 0.935), "steep": (0.55, 0.93, 0.75)}


def coat_of_its_own(tree, lean):
    normal = new(tree, "NormalMap", {"Color": (*LEANS[lean], 1)}, space="WORLD")
    return coated(tree, **{"Coat Normal": normal.outputs[0]})


def leaning(build, color):
    """The shader with a normal of its own, the same on all quads."""

    def build_leaning(tree):
        shader = build(tree)
        normal = new(tree, "NormalMap", {"Color": (*color, 1)}, space="WORLD")
        tree.links.new(normal.outputs[0], shader.inputs["Normal"])
        return shader

    return build_leaning


def besides_the_bsdf(name, lean, side, cosine):
    """Light (3,) that Cycles adds, for the reasons of cycles_normals.py. Seen from behind, normals point away."""
    if name not in LOBES:
        return np.zeros(3)
    geometric, own = geometric_normal(cosine), (2 * np.array(LEANS[lean]) - 1) * (-1 if side else 1)
    own /= np.linalg.norm(own)
    normal = raised(own, geometric)
    if bpy.app.version < (5, 0, 0):
        return below_normal(LOBES[name], normal, geometric)
    if name == "plastic" and own @ geometric < 0:
        return counted_twice(COAT, IOR, normal, BASE_COLOR, own, geometric)
    return np.zeros(3)


@pytest.fixture(scope="module")
def comparison(tmp_path_factory):
    return Comparison(CASES, COSINES, tmp_path_factory.mktemp("cycles") / "albedo.exr")


@pytest.fixture(scope="module")
def leaning_comparison(tmp_path_factory):
    shaders = {
        f"{lean} {name}": leaning(build, color) for lean, color in LEANS.items() for name, build in LEANING.items()
    }
    return Comparison(shaders, COSINES, tmp_path_factory.mktemp("cycles") / "leaning.exr")


def rise(mu, ior):
    """How far the reflectance has risen from that of normal incidence to 1."""
    f0 = fresnel(1.0, ior)
    return (fresnel(mu, ior) - f0) / (1 - f0)


@pytest.mark.parametrize("side", [0, 1])
def test_smooth_plastic_is_that_of_cycles_but_for_its_table(comparison, side):
    """What the mirror leaves to the diffuse lobe Cycles has from a table of its rough lobes, and we from Fresnel."""
    for cosine in COSINES:
        found, normal = comparison.scattered("smooth_plastic", side, cosine), geometric_normal(cosine)
        mirrored = fresnel(cosine, SMOOTH_IOR) * sky(2 * cosine * normal - VIEW)
        table = interpolate(lambda mu, z: rise(max(mu, 1e-4), ior_of(z)), cosine, place_of(SMOOTH_IOR))
        expected = mirrored + (found.ours - mirrored) * (1 - table) / (1 - rise(cosine, SMOOTH_IOR))
        z = welch_z(expected, found.cycles)
        assert (np.abs(z) < 4.5).all(), (cosine, z)


@pytest.mark.parametrize("side", [0, 1])
@pytest.mark.parametrize("name", [name for name in CASES if name != "smooth_plastic"])
def test_scattered_light_is_that_of_cycles(comparison, name, side):
    for cosine in COSINES:
        found = comparison.scattered(name, side, cosine)
        z = welch_z(found.ours, found.cycles)
        assert (np.abs(z) < 4.5).all(), (cosine, z)


@pytest.mark.parametrize("side", [0, 1])
@pytest.mark.parametrize("lean", LEANS)
@pytest.mark.parametrize("name", LEANING)
def test_normal_maps_scatter_as_in_cycles(leaning_comparison, name, lean, side):
    """Seen from behind, little or nothing scatters."""
    for cosine in COSINES:
        found = leaning_comparison.scattered(f"{lean} {name}", side, cosine)
        z = welch_z(found.ours + besides_the_bsdf(name, lean, side, cosine), found.cycles)
        assert (np.abs(z) < 4.5).all(), (cosine, z)
