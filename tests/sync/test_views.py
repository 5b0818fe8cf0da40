"""What viewports see: the camera of a region, from Blender's own matrices, against the camera that renders."""

import bpy
import numpy as np
import pytest

from blender_addon.sync.camera import View, camera_frame, framed, read_camera, read_free_view
from tests.engine import stage
from tests.engine.stage import blender  # noqa: F401 (a fixture)

LENSES = {
    "plain": {},
    "shifted": {"shift_x": 0.2, "shift_y": -0.1},
    "long": {"lens": 135.0, "sensor_fit": "VERTICAL"},
    "orthographic": {"type": "ORTHO", "ortho_scale": 3.0},
}


def camera_and_view(width=200, height=120, **lens):
    """A camera, and a region that is just its picture, as Blender draws it."""
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = width, height
    scene.render.resolution_percentage = 100
    camera = stage.add_camera((1, 2, 3), (0.3, 0.2, 0.1), **lens)
    depsgraph = bpy.context.evaluated_depsgraph_get()
    window = np.array(camera.calc_matrix_camera(depsgraph, x=width, y=height), np.float64)
    view = View((width, height), np.linalg.inv(np.array(camera.matrix_world)), window, (0.1, 100.0))
    return camera, view, read_camera(camera, scene.render, np.array(camera.matrix_world), camera.data.shift_x)


@pytest.mark.parametrize("lens", LENSES)
def test_a_region_that_is_the_picture_sees_it(lens):
    """To float32, in which Blender has its matrices."""
    _, view, wanted = camera_and_view(**LENSES[lens])
    seen = read_free_view(view)
    assert seen.kind == wanted.kind
    assert seen.window == pytest.approx(wanted.window, abs=2e-6)
    np.testing.assert_allclose(seen.world_from_camera, wanted.world_from_camera, atol=1e-6)


@pytest.mark.parametrize("lens", LENSES)
def test_the_frame_is_all_of_that_region(lens):
    camera, view, _ = camera_and_view(**LENSES[lens])
    assert camera_frame(camera, bpy.context.scene, view) == pytest.approx((0, 1, 0, 1), abs=1e-5)


@pytest.mark.parametrize("lens", LENSES)
def test_a_zoomed_and_moved_camera_view(lens):
    """The frame is a part of the region: what the region sees by its matrix is what the camera sees, widened."""
    camera, view, taken = camera_and_view(**LENSES[lens])
    zoom = np.diag([0.5, 0.4, 1, 1])
    zoom[:2, 3] = 0.25, -0.1  # offset on the screen
    view = view._replace(window_matrix=zoom @ view.window_matrix)
    left, right, bottom, top = camera_frame(camera, bpy.context.scene, view)
    assert (right - left, top - bottom) == pytest.approx((0.5, 0.4), abs=1e-5)
    part = (
        -left / (right - left),
        (1 - left) / (right - left),
        -bottom / (top - bottom),
        (1 - bottom) / (top - bottom),
    )
    assert framed(taken, view.size, part).window == pytest.approx(read_free_view(view).window, abs=1e-5)


def test_a_panorama_is_framed_in_its_own_coordinates():
    _, _, taken = camera_and_view(type="PANO", panorama_type="EQUIRECTANGULAR")
    seen = framed(taken, (50, 50), (-0.5, 1.5, 0.25, 0.75))
    assert seen.kind == "EQUIRECTANGULAR"
    assert seen.window == pytest.approx((-0.5, 1.5, 0.25, 0.75))
    assert (seen.width, seen.height) == (50, 50)
