"""Lamps as emissive shapes, against Cycles: seen directly, and by the light that they throw on a wall."""

import math

import bpy
import numpy as np
import pytest

from tests.engine import cycles_pictures, stage
from tests.engine.stage import blender  # noqa: F401 (a fixture)
from tests.images.image_statistics import compare

AREA, SUN = ("AREA", {"energy": 10.0}), ("SUN", {"energy": 3.0})
POINT = ("POINT", {"energy": 10.0, "use_soft_falloff": False})
LAMPS = {
    "square": (*AREA, {"size": 1.5}),
    "rectangle": (*AREA, {"shape": "RECTANGLE", "size": 2.0, "size_y": 0.7}),
    "disk": (*AREA, {"shape": "DISK", "size": 1.5}),
    "ellipse": (*AREA, {"shape": "ELLIPSE", "size": 2.0, "size_y": 0.7}),
    "not normalized": (*AREA, {"size": 1.5, "normalize": False}),
    "exposure and color": (*AREA, {"size": 1.0, "exposure": 1.5, "color": (1.0, 0.5, 0.1)}),
    "temperature": (*AREA, {"size": 1.0, "use_temperature": True, "temperature": 3000.0}),
    "point": (*POINT, {"shadow_soft_size": 0.7}),
    "point, not normalized": (*POINT, {"shadow_soft_size": 0.7, "normalize": False}),
    "sun": (*SUN, {"angle": 0.3}),
    "wide sun": (*SUN, {"angle": 2.0}),
    "sun, not normalized": (*SUN, {"angle": 0.3, "normalize": False}),
}


def lamp_before_the_camera(kind, strength, settings) -> bpy.types.Object:
    """5 away, facing the camera, scaled unevenly and turned: area lights are squeezed, spheres are not."""
    stage.add_camera()
    stage.set_world((0, 0, 0))
    lamp = stage.add_light(kind, (0.1, 0.2, -5), (math.pi - 0.4, 0.3 if kind == "AREA" else 0, 0.7))
    if kind == "SUN":
        lamp.rotation_euler = (math.pi - 0.1, 0.05, 0)
    for name, value in (strength | settings).items():
        setattr(lamp.data, name, value)
    lamp.scale = (1.2, 0.8, 2.0)
    return lamp


@pytest.mark.parametrize("name", LAMPS)
def test_lamps_look_as_in_cycles(name, tmp_path):
    lamp_before_the_camera(*LAMPS[name])
    theirs, ours = cycles_pictures.point_pictures(tmp_path)
    lit, expected = ours.max(axis=2) > 0, theirs.max(axis=2) > 0
    assert expected.sum() > 20
    # The outlines of disks and spheres are polygons: a few pixels on the rim may differ.
    assert (lit != expected).sum() <= (0 if name in {"square", "rectangle"} else 2)
    both = lit & expected
    np.testing.assert_allclose(ours[both], theirs[both], rtol=2e-5)


def test_area_lights_are_dark_from_behind_and_let_light_through(tmp_path):
    stage.add_camera()
    stage.set_world((0.2, 0.4, 0.6))
    stage.add_light("AREA", (0, 0, -5), size=3.0)
    theirs, ours = cycles_pictures.point_pictures(tmp_path)
    np.testing.assert_allclose(ours, theirs, rtol=1e-5)
    np.testing.assert_allclose(ours[24, 32], (0.2, 0.4, 0.6), rtol=1e-5)


def test_mirrored_area_lights_shine_the_same_way(tmp_path):
    lamp = lamp_before_the_camera(*LAMPS["square"])
    for scale in ((-1, 1, 1), (1, -1, 1), (1, 1, -1), (-1, -1, -1)):
        lamp.scale = scale
        theirs, ours = cycles_pictures.point_pictures(tmp_path)
        # A point on the very edge may fall on either side.
        assert ((theirs.max(axis=2) > 0) != (ours.max(axis=2) > 0)).sum() <= 1, scale
        assert (ours > 0).any() == (scale[2] > 0)


def test_ray_visibility_of_lamps(tmp_path):
    lamp = lamp_before_the_camera(*LAMPS["square"])
    lamp.visible_camera = False
    _, ours = cycles_pictures.point_pictures(tmp_path)
    assert (ours == 0).all()


@pytest.mark.parametrize(
    ("kind", "settings"),
    [
        ("AREA", {"energy": 60.0, "size": 2.0}),
        ("AREA", {"energy": 60.0, "size": 2.0, "shape": "DISK"}),
        ("POINT", {"energy": 80.0, "shadow_soft_size": 1.0, "use_soft_falloff": False}),
        ("SUN", {"energy": 2.0, "angle": 1.0}),
    ],
)
def test_lamps_light_a_wall_as_in_cycles(kind, settings, tmp_path):
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = 16, 12
    scene.bentlight.max_bounces = 0
    stage.add_camera((0, 0, 6))
    stage.set_world((0, 0, 0))
    stage.add_square(12.0)
    lamp = stage.add_light(kind, (0.5, 0.3, 2.5), (0.3, 0.1, 0), **settings)
    lamp.visible_camera = False
    theirs, ours = cycles_pictures.noisy_pictures(tmp_path, seeds=8, samples=64)
    comparison = compare(theirs, ours)
    assert not comparison.differs(), str(comparison)
