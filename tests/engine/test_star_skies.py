"""Stars of a Blender world: catalogs and made-up skies, and what a render shows of them in which passes."""

import math

import bpy
import numpy as np
import pytest
from stage import add_camera, add_square, emission, render, set_world

from blender_addon.sync.star_catalog import procedural, read_catalog, temperature_k
from blender_addon.sync.thermal import blackbody_rgb

CATALOG = """# a heading and a note
ra, dec, magnitude, B-V
90.0, 0.0, -1.46, 0.0

101.3, -16.7, 2.5,
279.2, 38.8, 0.03
"""


def make_world(**settings) -> bpy.types.World:
    world = set_world((0, 0, 0))
    for name, value in settings.items():
        setattr(world.bentlight, name, value)
    return world


def look_at_y(**settings):
    """A camera at the origin that looks along +y, 90 degrees wide."""
    return add_camera(rotation=(math.pi / 2, 0, 0), angle=math.pi / 2, sensor_fit="HORIZONTAL", **settings)


def flux(pixels, width=64, height=48):
    """Irradiance (3,) of a picture of that camera that shows light in the middle only."""
    return pixels[..., :3].sum(axis=(0, 1), dtype=float) * 2 * (2 * height / width) / (width * height)


def test_a_catalog_is_read(tmp_path):
    path = tmp_path / "stars.csv"
    path.write_text(CATALOG)
    stars = read_catalog(path)
    assert np.allclose(stars.directions[0], (0, 1, 0), atol=1e-15)
    assert np.allclose(np.linalg.norm(stars.directions, axis=1), 1)
    assert list(stars.magnitudes) == [-1.46, 2.5, 0.03] and list(stars.color_indices) == [0, 0.65, 0.65]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("ra,dec,mag\n1,2,3\n1,95,3\n", "line 3: declination must lie in"),
        ("1,2,3\n\n1,2\n", "line 3: expected right ascension"),
        ("1,2,3\n4,nan,3\n", "line 2: declination is not a number: 'nan'"),
        ("1,2,3,red\n", "line 1: B-V is not a number: 'red'"),
        ("1,2,3\nx,2,3\n", "line 2: right ascension is not a number"),
        ("1,2,99\n", "line 1: magnitude must lie in"),
        ("# nothing\n", "no star"),
    ],
)
def test_a_bad_catalog_is_refused_by_its_line(tmp_path, text, message):
    path = tmp_path / "stars.csv"
    path.write_text(text)
    with pytest.raises(ValueError, match=message):
        read_catalog(path)


def test_a_made_up_sky_has_as_many_stars_of_each_magnitude_as_asked():
    stars = procedural(20000, 1, -2.0, 0.5)
    for magnitude in (-1, 2, 5):  # 10^(0.5 (m + 2)) are brighter
        assert abs((stars.magnitudes <= magnitude + 1e-9).sum() - int(10 ** (0.5 * (magnitude + 2)))) <= 1
    assert np.abs(stars.directions.mean(axis=0)).max() < 4 / np.sqrt(3 * 20000)
    assert np.allclose(np.abs(stars.directions).mean(axis=0), 0.5, atol=0.01)
    fewer, others = procedural(100, 1, -2.0, 0.5), procedural(100, 2, -2.0, 0.5)
    assert (fewer.directions == stars.directions[:100]).all() and (
        fewer.color_indices == stars.color_indices[:100]
    ).all()
    assert (others.directions != fewer.directions).all()


def test_stars_have_the_colors_of_black_bodies():
    """The sun's temperature by its color index, and chromaticities of Planck's locus (CIE 1931, at 4 digits)."""
    assert abs(temperature_k(np.array([0.65]))[0] - 5778) < 50
    rgb_from_xyz = np.array([[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]])
    kelvin, chromaticity = np.array([4000.0, 6500.0, 10000.0]), [(0.3805, 0.3768), (0.3135, 0.3237), (0.2807, 0.2884)]
    xyz = blackbody_rgb(kelvin, (5, 0)) @ np.linalg.inv(rgb_from_xyz).T
    assert np.allclose(xyz[:, 1], 1, atol=1e-3)
    assert np.allclose(xyz[:, :2] / xyz.sum(axis=1, keepdims=True), chromaticity, atol=1e-3)


def test_a_star_brings_the_light_of_its_magnitude(tmp_path):
    """One of magnitude 2.5 is a tenth of strength millionths; and the same again turned there."""
    path = tmp_path / "one.csv"
    path.write_text("90, 0, 2.5, 0.65\n")
    look_at_y()
    world = make_world(stars="CATALOG", star_catalog=str(path), star_strength=3.0)
    bpy.context.view_layer.use_pass_environment = True
    passes = render(tmp_path)
    light = flux(passes["Combined"])
    assert np.isclose(light @ np.array([0.2126, 0.7152, 0.0722]), 3e-7, rtol=1e-3)
    environment = passes["Environment" if bpy.app.version >= (5, 0, 0) else "Env"]
    assert (environment[..., :3] == passes["Combined"][..., :3]).all()
    path.write_text("0, 0, 2.5, 0.65\n")
    assert render(tmp_path)["Combined"][..., :3].max() == 0
    world.bentlight.star_rotation = (0, 0, math.pi / 2)
    assert np.allclose(flux(render(tmp_path)["Combined"]), light, rtol=1e-4)
    world.bentlight.stars = "OFF"
    assert render(tmp_path)["Combined"][..., :3].max() == 0


def one_star(tmp_path, **settings):
    """In the middle of the picture, white."""
    path = tmp_path / "one.csv"
    path.write_text("90, 0, 0, 0.65\n")
    return make_world(stars="CATALOG", star_catalog=str(path), star_strength=1e6, **settings)


def spread(pixels):
    """Standard deviations (2,) across and up of a picture's light, in pixels."""
    weights = pixels[..., 1].astype(float) / pixels[..., 1].sum(dtype=float)
    y, x = np.indices(weights.shape) + 0.5
    return np.sqrt([(weights * (axis - (weights * axis).sum()) ** 2).sum() for axis in (x, y)])


def test_a_star_out_of_focus_is_as_large_as_the_lens_says(tmp_path):
    """A disk whose radius is that of the opening, lens / (2 f), over the distance in focus; anamorphic ones are
    narrower or wider. Its light is the same."""
    camera = look_at_y()
    one_star(tmp_path)
    sharp = render(tmp_path)["Combined"]
    lens = camera.data
    lens.dof.use_dof, lens.dof.focus_distance, lens.dof.aperture_fstop = True, 0.04, 1.0
    radius = lens.lens * 1e-3 / (2 * lens.dof.aperture_fstop) / lens.dof.focus_distance / (2 / 64)
    for ratio in (1.0, 0.5, 2.0):
        lens.dof.aperture_ratio = ratio
        blurred = render(tmp_path)["Combined"]
        np.testing.assert_allclose(flux(blurred), flux(sharp), rtol=1e-5)
        expected = np.sqrt(spread(sharp) ** 2 + (radius / np.array([ratio, 1]) / 2) ** 2)
        np.testing.assert_allclose(spread(blurred), expected, rtol=0.02)
    assert radius > 5


def camera_angle(frame):
    """Of the camera below, which turns as slowly at both ends as Blender's keys say."""
    bpy.context.scene.frame_set(int(frame), subframe=frame - int(frame))
    angle = bpy.context.scene.camera.rotation_euler.z
    bpy.context.scene.frame_set(5)
    return angle


def test_stars_streak_as_the_camera_turns(tmp_path):
    """By as much as it turns while the shutter is open; all their light is there."""
    scene, camera = bpy.context.scene, look_at_y()
    one_star(tmp_path)
    still = render(tmp_path)["Combined"]
    for frame, angle in ((0, -1.0), (10, 1.0)):
        camera.rotation_euler.z = angle
        camera.keyframe_insert("rotation_euler", index=2, frame=frame)
    scene.frame_set(5)
    scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 1.0
    scene.render.motion_blur_position = "CENTER"
    scene.bentlight.samples = scene.bentlight.motion_slices = 32
    moving = render(tmp_path)["Combined"]
    np.testing.assert_allclose(flux(moving), flux(still), rtol=0.02)
    across, up = spread(moving)
    assert abs(up - spread(still)[1]) < 0.05
    turn = camera_angle(5.5) - camera_angle(4.5)
    assert across == pytest.approx(np.hypot(spread(still)[0], 32 * turn / np.sqrt(12)), rel=0.05)


def test_stars_are_seen_from_the_moment_on_in_which_the_camera_sees_any(tmp_path):
    """Also when the sky, all black, needs no more samples by then: this is the last of four moments."""
    scene, camera = bpy.context.scene, look_at_y()
    one_star(tmp_path)
    still = render(tmp_path)["Combined"]
    for frame, kind in ((0, "ORTHO"), (4.9, "PERSP"), (5, "ORTHO")):
        camera.data.type = kind
        camera.data.keyframe_insert("type", frame=frame)
    scene.frame_set(5)
    scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 1.0
    scene.render.motion_blur_position = "CENTER"
    scene.bentlight.samples, scene.bentlight.motion_slices = 64, 4
    scene.bentlight.use_adaptive_sampling, scene.bentlight.adaptive_min_samples = True, 4
    np.testing.assert_allclose(flux(render(tmp_path)["Combined"]), flux(still) / 4, rtol=1e-3)


def test_the_film_and_surfaces_hide_stars(tmp_path):
    look_at_y()
    make_world(stars="PROCEDURAL", star_count=20000)
    bpy.context.view_layer.use_pass_environment = True
    free = render(tmp_path)
    name = "Environment" if bpy.app.version >= (5, 0, 0) else "Env"
    assert (free["Combined"][..., :3] > 0).mean() > 0.5 and (free["Combined"][..., 3] == 1).all()
    bpy.context.scene.render.film_transparent = True
    passes = render(tmp_path)
    assert passes["Combined"].max() == 0 and (passes[name] == free[name]).all()
    bpy.context.scene.render.film_transparent = False
    square = add_square(40.0, (0, 5, 0), emission((0, 0, 0)))
    square.rotation_euler = (math.pi / 2, 0, 0)
    assert render(tmp_path)["Combined"][..., :3].max() == 0


def test_a_hole_moves_stars_and_the_picture_stays_the_same(tmp_path):
    """Around a hole; with one thread or two, with a time limit, and by tiles of other sizes."""
    scene = bpy.context.scene
    look_at_y()
    make_world(stars="PROCEDURAL", star_count=3000, star_strength=100.0)
    flat = render(tmp_path)["Combined"]
    bpy.ops.bentlight.black_hole_add(mass=0.5, location=(0, 8, 0))
    bent = render(tmp_path)["Combined"]
    assert np.abs(bent - flat).max() > 0.01
    scene.render.threads = 1
    scene.bentlight.samples = 300  # smaller tiles
    scene.bentlight.use_adaptive_sampling = True
    assert (render(tmp_path)["Combined"] == bent).all()
    scene.bentlight.samples, scene.bentlight.time_limit = 4, 100.0
    assert (render(tmp_path)["Combined"] == bent).all()


def test_what_cannot_be_is_said(tmp_path):
    look_at_y()
    world = make_world(stars="CATALOG")
    with pytest.raises(RuntimeError, match="no file is chosen"):
        render(tmp_path)
    world.bentlight.star_catalog = str(tmp_path / "none.csv")
    with pytest.raises(RuntimeError, match=r"none\.csv' cannot be read"):
        render(tmp_path)
    (tmp_path / "bad.csv").write_text("1,2,3\n1,2\n")
    world.bentlight.star_catalog = str(tmp_path / "bad.csv")
    with pytest.raises(RuntimeError, match="line 2"):
        render(tmp_path)
    world.bentlight.stars = "PROCEDURAL"
    bpy.context.scene.camera.data.type = "ORTHO"
    assert render(tmp_path)["Combined"][..., :3].max() == 0
