"""The choice of accuracy and the tolerance are one, and its error in pixels is the camera's."""

import math

import bpy
import pytest

from blender_addon import accuracy, final
from tests.engine import stage


def test_choices_set_the_tolerance_and_the_tolerance_chooses():
    settings = bpy.context.scene.bentlight
    assert settings.accuracy == "PRODUCTION"
    for name, tolerance in accuracy.TOLERANCES.items():
        settings.accuracy = name
        assert settings.tolerance == pytest.approx(tolerance, rel=1e-6)
        assert settings.accuracy == name
    settings.tolerance = 3e-5
    assert settings.accuracy == "CUSTOM"
    settings.tolerance = 1e-3
    assert settings.accuracy == "PREVIEW"


def test_custom_stays_chosen_at_any_number():
    settings = bpy.context.scene.bentlight
    settings.accuracy = "CUSTOM"
    assert settings.accuracy == "CUSTOM"
    assert settings.tolerance == pytest.approx(1e-4)
    settings.tolerance = 1e-3
    assert settings.accuracy == "CUSTOM"
    settings.accuracy = "REFERENCE"
    assert settings.tolerance == pytest.approx(1e-6)


def test_a_render_takes_the_tolerance():
    stage.add_camera()
    settings = bpy.context.scene.bentlight
    settings.accuracy = "REFERENCE"
    used = final.render_settings(bpy.context.scene, bpy.context.view_layer, False)
    assert used.tolerance == pytest.approx(1e-6)


def test_the_error_is_in_pixels_of_the_middle():
    camera = stage.add_camera(sensor_width=36.0, lens=50.0)
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = 2000, 1000
    pixel = 36 / 50 / 2000  # small: the chord between directions is the tangent, to 1e-7
    scene.bentlight.tolerance = 1e-6
    assert accuracy.scene_error_in_pixels(scene) == pytest.approx(1e-6 / pixel, rel=1e-5)
    scene.bentlight.tolerance = 1e-2
    assert accuracy.scene_error_in_pixels(scene) == pytest.approx(0.1)
    scene.render.resolution_percentage = 50
    scene.bentlight.tolerance = 1e-6
    assert accuracy.scene_error_in_pixels(scene) == pytest.approx(1e-6 / (2 * pixel), rel=1e-5)
    camera.data.type, camera.data.panorama_type = "PANO", "EQUIRECTANGULAR"
    assert accuracy.scene_error_in_pixels(scene) == pytest.approx(1e-6 / (2 * math.pi / 1000), rel=1e-4)


def test_without_an_angle_there_is_no_error():
    scene = bpy.context.scene
    assert accuracy.scene_error_in_pixels(scene) is None
    stage.add_camera(type="ORTHO")
    assert accuracy.scene_error_in_pixels(scene) is None
