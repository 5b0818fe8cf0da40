"""What the viewport's Rendered shading shows of the world's stars: those of a final render, and changes at once."""

import time
from types import SimpleNamespace

import bpy
import numpy as np
import pytest

from blender_addon.sync.camera import read_camera
from blender_addon.viewport import Viewport, _Frame
from tests.engine.stage import add_camera, render, set_world


class Engine:
    """What a viewport needs of Blender's engine."""

    def tag_redraw(self):
        pass

    def report(self, level, text):
        raise AssertionError(text)


@pytest.fixture
def viewport():
    engine = Engine()
    shown = Viewport(engine, 2)
    yield shown, engine
    shown.close()


def picture(viewport, engine):
    """The last picture of what is there now: (height, width, 3)."""
    space = next(area for screen in bpy.data.screens for area in screen.areas if area.type == "VIEW_3D").spaces[0]
    depsgraph = bpy.context.evaluated_depsgraph_get()
    camera = bpy.context.scene.camera.evaluated_get(depsgraph)
    taken = read_camera(camera, bpy.context.scene.render, np.array(camera.matrix_world), camera.data.shift_x)
    viewport.update(engine, depsgraph)
    viewport._wish(engine, SimpleNamespace(space_data=space), depsgraph, _Frame(0, 0, taken))
    end = time.monotonic() + 60
    while time.monotonic() < end:
        preview = viewport._progressive.preview
        assert viewport._progressive.failure is None
        if preview is not None and preview.wish is not picture.last and preview.samples == 4:
            picture.last = preview.wish
            return preview.pixels[..., :3]
        time.sleep(0.01)
    raise AssertionError("nothing came")


picture.last = None


def test_the_viewport_shows_the_stars_of_a_render(viewport, tmp_path):
    """Around a hole; they go as the world says."""
    scene = bpy.context.scene
    add_camera((0, 0, 6))
    world = set_world((0, 0, 0))
    world.bentlight.stars, world.bentlight.star_count, world.bentlight.star_strength = "PROCEDURAL", 3000, 100.0
    bpy.ops.bentlight.black_hole_add(mass=0.3, location=(0, 0, 0))
    scene.bentlight.preview_samples = scene.bentlight.samples = 4
    final = render(tmp_path)["Combined"][..., :3]
    shown = picture(*viewport)
    np.testing.assert_allclose(shown, final, rtol=1e-5, atol=1e-9)
    assert (final > 0).mean() > 0.2
    world.bentlight.star_strength = 50.0
    np.testing.assert_allclose(picture(*viewport), final / 2, rtol=1e-5, atol=1e-9)
    world.bentlight.stars = "OFF"
    assert picture(*viewport).max() == 0
