"""What the viewport's Rendered shading shows of the world's stars: those of a final render, and changes at once."""

import bpy
import numpy as np
import pytest

from tests.engine.stage import add_camera, render, set_world
from tests.engine.windowless import Windowless


@pytest.fixture
def viewport():
    shown = Windowless()
    yield shown
    shown.close()


def picture(viewport):
    """The last picture of what is there now: (height, width, 3)."""
    bpy.context.view_layer.update()
    viewport.draw()
    return viewport.wait(lambda preview: preview.samples == 4).pixels[..., :3]


def test_the_viewport_shows_the_stars_of_a_render(viewport, tmp_path):
    """Around a hole; they go as the world says."""
    scene = bpy.context.scene
    add_camera((0, 0, 6))
    world = set_world((0, 0, 0))
    world.bentlight.stars, world.bentlight.star_count, world.bentlight.star_strength = "PROCEDURAL", 3000, 100.0
    bpy.ops.bentlight.black_hole_add(mass=0.3, location=(0, 0, 0))
    scene.bentlight.preview_samples = scene.bentlight.samples = 4
    final = render(tmp_path)["Combined"][..., :3]
    shown = picture(viewport)
    np.testing.assert_allclose(shown, final, rtol=1e-5, atol=1e-9)
    assert (final > 0).mean() > 0.2
    world.bentlight.star_strength = 50.0
    np.testing.assert_allclose(picture(viewport), final / 2, rtol=1e-5, atol=1e-9)
    world.bentlight.stars = "OFF"
    assert picture(viewport).max() == 0
