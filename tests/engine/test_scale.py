"""Masses of nature: CODATA's and the IAU's numbers, and every way from one unit to another and back."""

import math

import bpy
import pytest

from blender_addon import scale

# IAU 2015 Resolution B3 and the SI: 1.3271244e20 m^3/s^2 / (299792458 m/s)^2. NASA's Sun fact sheet: 1.9885e30 kg.
METERS_PER_SUN = 1476.625
EARTH_KG, EARTH_RADIUS_M = 5.9722e24, 4.435e-3  # CODATA's G, and the gravitational radius of the Earth


@pytest.fixture
def hole():
    bpy.ops.bentlight.black_hole_add(mass=1.0, location=(0, 0, 0))
    return bpy.context.object


def test_constants():
    assert pytest.approx(METERS_PER_SUN, rel=3e-8) == scale.METERS_PER_SUN
    assert pytest.approx(1.98841e30, rel=3e-6) == scale.KILOGRAMS_PER_SUN
    earth = EARTH_KG * scale.GRAVITATIONAL_CONSTANT / scale.SPEED_OF_LIGHT**2
    assert earth == pytest.approx(EARTH_RADIUS_M, rel=1e-4)


def test_suns_give_the_mass_and_the_mass_suns(hole):
    settings = hole.bentlight
    settings.mass_suns = 1.0
    assert settings.mass == pytest.approx(METERS_PER_SUN, rel=1e-6)
    assert settings.horizon_kilometers == pytest.approx(2.95325, rel=1e-6)
    assert hole.empty_display_size == pytest.approx(METERS_PER_SUN / 2, rel=1e-6)
    settings.mass = 10 * METERS_PER_SUN
    assert settings.mass_suns == pytest.approx(10, rel=1e-6)


def test_kilograms_both_ways(hole):
    settings = hole.bentlight
    for text in ("1.98841e30", "1.98841e30 kg", "1,98841e30 KG", "1 sun"):
        settings.mass = 7.0
        settings.mass_kilograms = text
        assert settings.mass == pytest.approx(METERS_PER_SUN, rel=4e-6), text
    assert settings.mass_kilograms == "1.98841e+30 kg"
    settings.mass_kilograms = settings.mass_kilograms
    assert settings.mass == pytest.approx(METERS_PER_SUN, rel=4e-6)


@pytest.mark.parametrize("text", ["", "heavy", "nan", "inf", "-1", "2 pounds", "1 2 kg", "kg"])
def test_what_is_no_mass_changes_nothing(hole, text, capfd):
    hole.bentlight.mass_kilograms = text
    assert hole.bentlight.mass == 1.0
    assert "ValueError" in capfd.readouterr().err
    with pytest.raises(ValueError):
        scale.parse_suns(text)


@pytest.mark.parametrize("spin", [0.0, 0.9, -0.9])
def test_the_horizon_both_ways(hole, spin):
    settings = hole.bentlight
    settings.spin = spin
    settings.horizon_kilometers = 100.0
    r_plus = 1 + math.sqrt(1 - spin**2)
    assert settings.mass == pytest.approx(100e3 / r_plus, rel=1e-6)
    assert settings.horizon_kilometers == pytest.approx(100, rel=1e-6)


def test_the_size_of_a_unit_and_the_object_s_scale_count(hole):
    bpy.context.scene.unit_settings.scale_length = 1000.0
    hole.scale = (2, 2, 2)
    bpy.context.view_layer.update()
    hole.bentlight.mass_suns = 4.3e6
    assert hole.bentlight.mass == pytest.approx(4.3e6 * METERS_PER_SUN / 2000, rel=1e-6)


def test_the_unit_can_be_fitted_instead(hole):
    hole.scale = (3, 3, 3)
    bpy.context.view_layer.update()
    bpy.ops.bentlight.unit_scale_fit(suns=10)
    assert bpy.context.scene.unit_settings.scale_length == pytest.approx(10 * METERS_PER_SUN / 3, rel=1e-6)
    assert hole.bentlight.mass == 1.0
    assert hole.bentlight.mass_suns == pytest.approx(10, rel=1e-6)


def test_a_unit_that_blender_cannot_have_is_refused(hole):
    with pytest.raises(RuntimeError, match="make the hole larger"):
        bpy.ops.bentlight.unit_scale_fit(suns=1e15)
    assert bpy.context.scene.unit_settings.scale_length == 1.0


def test_a_hole_of_scale_0_keeps_its_mass(hole):
    hole.scale = (0, 0, 0)
    bpy.context.view_layer.update()
    hole.bentlight.mass_suns = 5
    assert hole.bentlight.mass == 1.0
    with pytest.raises(RuntimeError, match="scale 0"):
        bpy.ops.bentlight.unit_scale_fit(suns=1)


def test_the_mass_alone_is_stored(hole):
    hole.bentlight.mass_suns = 2.0
    hole.bentlight.mass_kilograms = "3e30"
    hole.bentlight.horizon_kilometers = 4.0
    assert set(hole.bentlight.keys()) & {"mass", "mass_suns", "mass_kilograms", "horizon_kilometers"} == {"mass"}
