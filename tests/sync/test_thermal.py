"""Thermal light for disks: the color of known blackbodies, the table against Planck's law, and its ends."""

import numpy as np
import pytest
from bentlight_native import ProgramBuilder, Scene

from blender_addon.sync import thermal
from blender_addon.sync.cie_1931 import RGB_FROM_XYZ, RGB_FROM_XYZ_5

VERSIONS = {(4, 5, 0): RGB_FROM_XYZ, (5, 0, 0): RGB_FROM_XYZ_5}


def test_illuminant_a():
    """CIE 15: the standard lamp, a blackbody of 2855.5 K, has x = 0.44758, y = 0.40745."""
    xyz = thermal.blackbody_xyz(np.array([2855.5]))[0]
    assert xyz[:2] / xyz.sum() == pytest.approx([0.44758, 0.40745], abs=2e-4)


def test_brightness_grows_as_planck_says():
    """At the middle of the visible a hotter body is brighter by about exp(c2 / lambda (1/T1 - 1/T2)); at 10 million
    kelvin light is proportional to the temperature."""
    ratio = np.log(thermal.luminance(3100.0) / thermal.luminance(3000.0))
    wavelength = 1.4388e-2 * (1 / 3000 - 1 / 3100) / ratio
    assert 560e-9 < wavelength < 610e-9
    assert thermal.luminance(2e7) / thermal.luminance(1e7) == pytest.approx(2, rel=2e-3)


def core_light(kelvin, version):
    """RGB from the core's operation, as the table makes it."""
    builder = ProgramBuilder()
    table = builder.table(thermal.blackbody_table(version))
    ends = (builder.constant(thermal.LOWEST_K), builder.constant(thermal.HIGHEST_K))
    light = builder.emit("blackbody_light", builder.constant(kelvin), *ends, immediates=table)[0]
    builder.emit("emission", builder.constant(1.0), light, builder.constant(1 / thermal.luminance(5000.0)))
    scene = Scene()
    material = scene.add_material(builder.build())
    return scene.shade(material, position=(0, 0, 0), wo=(0, 0, 1))["emission"][0]


@pytest.mark.parametrize("version", VERSIONS)
def test_the_core_interpolates_to_a_thousandth(version):
    for kelvin in np.random.default_rng(1).uniform(np.log(2000), np.log(1e6), 40):
        xyz = thermal.blackbody_xyz(np.exp([kelvin]))[0] / thermal.luminance(5000.0)
        assert core_light(np.exp(kelvin), version) == pytest.approx(VERSIONS[version] @ xyz, rel=1e-3)


@pytest.mark.parametrize("version", VERSIONS)
def test_cold_colors_keep_their_luminance(version):
    """Below 1900 K the color is out of gamut: no channel is negative, and the brightness is right."""
    light = core_light(1200.0, version)
    assert (light >= 0).all() and light[2] == 0
    luminance = np.linalg.inv(VERSIONS[version])[1]
    assert light @ luminance == pytest.approx(thermal.luminance(1200.0) / thermal.luminance(5000.0), rel=1e-3)


def test_ends_of_the_table():
    hottest = core_light(1e7, (5, 0, 0))
    assert core_light(2.5e7, (5, 0, 0)) == pytest.approx(2.5 * hottest, rel=1e-9)
    for kelvin in (299.0, 0.0, -5.0):
        assert (core_light(kelvin, (5, 0, 0)) == 0).all()


def test_both_sides_know_the_same_constant():
    """The table stores what the header takes off again."""
    header = (thermal.__file__.rsplit("blender_addon", 1)[0]) + "native/src/scene/disk.h"
    with open(header) as file:
        line = next(line for line in file if line.startswith("#define DISK_WIEN_KELVIN"))
    assert float(line.split()[2]) == thermal._WIEN_K
