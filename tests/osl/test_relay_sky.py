"""Images of the sky as the relay camera filters them: footprints against the picture's own differences, noise and light
against pictures without the filter, and what is left as it is."""

import bpy
import numpy as np
import objects
import pytest
import rendering
import skies
from test_lens_pictures import SPACES, add_spacetime

from blender_addon.cycles import relay, screen
from tests.engine import stage
from tests.osl import test_relay_motion as motion

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


@pytest.mark.parametrize("how", ["moving", "out of focus", "behind a disk"])
def test_smooth_skies_look_the_same(how, scene, tmp_path):
    """With all that goes by way of the screen, or makes neighbors in the maps look from other places."""
    hole_before(scene, skies.sky_file(tmp_path, skies.smooth()), "kerr")
    hole = next(obj for obj in bpy.data.objects if obj.bentlight.kind != "NONE")
    camera = scene.camera.bentlight.relay_source
    if how == "moving":
        scene.render.use_motion_blur = True
        motion.move(camera, (0.3, 0.0, 0.1))
    elif how == "out of focus":
        camera.data.dof.use_dof, camera.data.dof.focus_distance, camera.data.dof.aperture_fstop = True, 2.0, 0.4
    else:
        hole.bentlight.disk.enable, hole.bentlight.disk.opacity = True, 0.5
    skies.add_wall()
    skies.check_same(scene, picture)


def test_points_that_move_make_less_noise(scene, tmp_path):
    """The filter works in each moment."""
    hole_before(scene, skies.sky_file(tmp_path, skies.points()))
    scene.render.use_motion_blur = True
    motion.move(scene.camera.bentlight.relay_source, (0.2, 0.0, 0.05))
    noise = [np.stack([picture(scene, f, seed)[..., 0] for seed in range(3)]).var(0, ddof=1).mean() for f in (0, 1)]
    assert noise[1] < noise[0] / 4


@pytest.mark.parametrize("gravitational", [0.0, 0.5])
def test_passes_are_those_of_what_lies_behind(gravitational, scene, tmp_path):
    """Whether light is dimmed or not."""
    hole_before(scene, skies.sky_file(tmp_path, skies.smooth()), "kerr")
    scene.bentlight.gravitational = gravitational
    skies.add_wall()
    skies.add_lamp()

    def passes(sky_filter):
        picture(scene, sky_filter, samples=1)
        return stage.render(tmp_path)

    skies.check_passes(scene, passes, 2e-5)  # the camera's place is rounded anew where there is a screen


def test_the_screen_comes_and_goes(scene, tmp_path):
    """With Open Shading Language, which it needs; nothing is left behind."""
    hole_before(scene, skies.sky_file(tmp_path, skies.points(10, 64)))
    depsgraph = bpy.context.evaluated_depsgraph_get()
    scene.cycles.samples = 16
    assert not scene.cycles.shading_system
    for sky_filter, film_transparent in ((1.0, False), (0.0, False), (1.0, False), (1.0, True)):
        scene.bentlight.sky_filter, scene.render.film_transparent = sky_filter, film_transparent
        relay.update(scene, depsgraph)
        filtered = sky_filter > 0 and not film_transparent
        assert (screen.find(scene.camera) is not None) == filtered == bool(bpy.data.node_groups)
        assert scene.camera.data.cycles_custom["SkyFilter"] == (0.25 if filtered else 0)
    scene.render.film_transparent = False
    relay.update(scene, depsgraph)
    assert scene.cycles.shading_system and len(bpy.data.node_groups) == 1
    assert bpy.ops.bentlight.relay_clear() == {"FINISHED"}
    assert not scene.cycles.shading_system and not bpy.data.node_groups
    assert not [obj for obj in bpy.data.objects if obj.bentlight.made_for_cycles == "SCREEN"]
