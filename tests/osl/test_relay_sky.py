"""Images of the sky as the relay camera filters them: footprints against the picture's own differences, noise and light
against pictures without the filter, and what is left as it is."""

import bpy
import objects
import pytest
import rendering
import skies
from test_lens_pictures import SPACES, add_spacetime

from blender_addon.cycles import relay, screen

SIZE = (96, 56)


@pytest.fixture(autouse=True)
def no_maps_left():
    yield
    relay.forget_all()


def hole_before(scene, image, kind="isotropic", far=1):
    """A hole before a sky, seen by a relay camera in small pictures."""
    skies.show(scene, image)
    objects.camera((0.3 * far, -8 * far, 1.3 * far), (0, 0, 0), lens_mm=60 * far)
    add_spacetime(kind)
    rendering.set_size(scene, *SIZE)
    scene.render.engine = "CYCLES"
    assert bpy.ops.bentlight.relay_setup(bake=False) == {"FINISHED"}


def picture(scene, sky_filter, seed=0, samples=16):
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = "BOX", 1.0
    scene.bentlight.sky_filter = sky_filter
    return rendering.render(scene, "CYCLES", seed, samples)


def material(scene):
    return screen.find(scene.camera).data.materials[0]


@pytest.mark.parametrize("kind", SPACES)
def test_footprints_are_the_differences_of_neighboring_pixels(kind, scene, tmp_path):
    hole_before(scene, skies.sky_file(tmp_path, skies.points()), kind, far=5)
    rendering.set_size(scene, 288, 168)
    scene.bentlight.sky_filter, scene.cycles.samples, scene.bentlight.relay_parts = 0.125, 1, 5
    rendering.render(scene, "CYCLES", 0, 1)
    squares, toward = (skies.measured(scene, tmp_path, material(scene), what) for what in skies.KINDS)
    skies.check_footprints(squares, toward, 0.125)


@pytest.mark.parametrize("kind", ["isotropic", "kerr"])
def test_points_make_less_noise_and_as_much_light(kind, scene, tmp_path):
    hole_before(scene, skies.sky_file(tmp_path, skies.points()), kind)
    skies.check_less_noise(scene, picture, SIZE)
