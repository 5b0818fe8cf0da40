"""Wormholes and several black holes in one Blender scene."""

import bpy
import numpy as np
import pytest

from tests.engine import stage

RED, GREEN, BLUE = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)


def add_screen(name: str, location, color, size=2.0) -> bpy.types.Object:
    """A shining square across y."""
    screen = stage.add_square(size, location, stage.emission(color, name=name), name)
    screen.rotation_euler = (np.pi / 2, 0, 0)
    return screen


@pytest.fixture
def wormhole() -> bpy.types.Object:
    """A mouth at the origin whose other end is far away; the camera looks into it along +y."""
    scene = bpy.context.scene
    stage.add_camera((0, -3, 0), (np.pi / 2, 0, 0))
    stage.set_world((0, 0, 0))
    bpy.ops.bentlight.wormhole_add(throat_radius=1.0, location=(0, 0, 0), exit_location=(100, 0, 0))
    scene.view_layers[0].bentlight.use_pass_fate = True
    return bpy.context.object


def test_what_is_behind_the_other_mouth_is_seen_upright_and_unmirrored(wormhole, tmp_path):
    """Beyond the exit, along its +y: red above, green on the right, as if the camera stood there."""
    add_screen("above", (100, 8, 4), RED, 3)
    add_screen("right", (104, 8, 0), GREEN, 3)
    picture = stage.render(tmp_path)["Combined"]
    rows, columns = np.nonzero(picture[..., 0] > 0.5)
    middle = np.hypot(rows - 23.5, columns - 31.5) < 10  # the direct image; rings of it lie further out
    assert rows[middle].size and rows[middle].mean() > 24 and abs(columns[middle].mean() - 31.5) < 1.5
    rows, columns = np.nonzero(picture[..., 1] > 0.5)
    middle = np.hypot(rows - 23.5, columns - 31.5) < 10
    assert rows[middle].size and columns[middle].mean() > 32 and abs(rows[middle].mean() - 23.5) < 1.5


def test_turning_a_mouth_turns_the_view(wormhole, tmp_path):
    """The exit turned about z by 90 degrees: its +y is the scene's -x."""
    add_screen("ahead", (100, 8, 0), RED)
    wormhole.bentlight.exit.rotation_euler = (0, 0, np.pi / 2)
    screen = add_screen("turned", (92, 0, 0), BLUE)
    screen.rotation_euler = (np.pi / 2, 0, np.pi / 2)
    picture = stage.render(tmp_path)["Combined"]
    np.testing.assert_allclose(picture[24, 32, :3], BLUE, atol=1e-6)


def test_light_comes_back_through_the_wormhole(wormhole, tmp_path):
    """A wall in front of one mouth is lit by a lamp in front of the other."""
    scene = bpy.context.scene
    wall = add_screen("wall", (0, -1.5, 0), (0, 0, 0), 40)
    wall.data.materials.clear()
    scene.camera.location = (0, -1.4, 3)
    scene.camera.rotation_euler = (0, 0, 0)
    scene.camera.location = (0, -0.9, 1.5)
    scene.camera.rotation_euler = (np.pi / 2, 0, np.pi)  # looks along -y at the wall
    scene.bentlight.samples = 256
    dark = stage.render(tmp_path)["Combined"][..., :3].mean()
    lamp = add_screen("lamp", (100, 2, 0), GREEN, 6)
    lit = stage.render(tmp_path)["Combined"][..., :3].mean(axis=(0, 1))
    assert dark == 0
    assert lit[1] > 0.01 and lit[0] == lit[2] == 0
    lamp.location = (50, 50, 0)
    assert stage.render(tmp_path)["Combined"][..., 1].mean() < 0.1 * lit[1]


def test_two_holes_each_have_a_shadow(tmp_path):
    scene = bpy.context.scene
    stage.add_camera((0, 0, 12))
    stage.set_world((0.5, 0.5, 0.5))
    for x in (-2, 2):
        bpy.ops.bentlight.black_hole_add(mass=0.15, location=(x, 0, 0))
    scene.view_layers[0].bentlight.use_pass_fate = True
    fate = stage.render(tmp_path)["Bentlight Fate"][..., 0]
    left, right = (fate[:, :32] == 2).sum(), (fate[:, 32:] == 2).sum()
    assert left > 20 and abs(left - right) <= 4
    assert set(np.unique(fate)) == {1.0, 2.0}


def test_a_sphere_of_influence_ends_the_bending(tmp_path):
    """With spheres a tenth as large, pixels away from the holes see what lies straight behind them."""
    scene = bpy.context.scene
    stage.add_camera((0, 0, 12))
    stage.set_world((0, 0, 0))
    add_screen("screen", (0, 0, -5), RED, 5.5).rotation_euler = (0, 0, 0)
    straight = stage.render(tmp_path)["Combined"]
    holes = []
    for x in (-2, 2):
        bpy.ops.bentlight.black_hole_add(mass=0.1, location=(x, 0, 0))
        holes.append(bpy.context.object)
    bent = stage.render(tmp_path)["Combined"]
    for hole in holes:
        hole.bentlight.sphere_radius = 0.2
    limited = stage.render(tmp_path)["Combined"]
    assert np.abs(bent - straight).sum() > 3 * np.abs(limited - straight).sum() > 0
    rows, columns = np.mgrid[:48, :64]
    away = np.ones((48, 64), bool)
    for x in (-2, 2):
        center = 31.5 + x / 12 / (36 / 50) * 64
        away &= np.hypot(columns - center, rows - 23.5) > 0.2 / 12 / (36 / 50) * 64 + 2
    assert np.array_equal(limited[away], straight[away])
    assert scene.render.engine == "BENTLIGHT"


def test_a_wormhole_and_a_hole_share_a_scene(wormhole, tmp_path):
    bpy.ops.bentlight.black_hole_add(mass=0.2, location=(100, 6, 0))
    fate = stage.render(tmp_path)["Bentlight Fate"][..., 0]
    assert fate[24, 32] == 2  # seen through the wormhole
    assert fate[2, 2] in {1.0, 3.0}


def test_the_chart_is_oblate_with_spin(tmp_path):
    """At spin 0 the areal horizon is drawn at 2M, the isotropic one at M/2: a square at M lies behind one of them."""
    stage.add_camera((0, 0, 6))
    stage.set_world((0, 0, 0))
    stage.add_square(0.4, (0, 0, 1), stage.emission(RED))
    bpy.ops.bentlight.black_hole_add(mass=1.0)
    settings = bpy.context.object.bentlight
    assert stage.render(tmp_path)["Combined"][..., 0].max() == 1
    settings.chart = "OBLATE"
    assert stage.render(tmp_path)["Combined"][..., 0].max() == 0
    settings.chart, settings.spin = "ISOTROPIC", 0.001
    assert stage.render(tmp_path)["Combined"][..., 0].max() == 0
