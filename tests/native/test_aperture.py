"""The lens: places on it, rays through it, its picture of a point, and the same picture by light from the lamp."""

import numpy as np
import pytest
from bentlight_native import Aperture, RenderSettings, Scene, Spacetime
from bsdf_tools import chi_square_z
from scenes import add, diffuse, emission, look_at, new_scene, perspective, quad, render
from test_bidirectional import assert_equal_means, pictures, placed, room

IDENTITY = np.eye(4)
FOCUS = 3.0


def camera(aperture, at=IDENTITY, half=0.5):
    scene = Scene()
    scene.set_camera("PERSPECTIVE", at, (-half, half, -half, half), aperture=aperture)
    return scene


def places(blades, count=100000, **lens):
    numbers = np.random.default_rng(5).random((count, 2))
    rays = camera(Aperture(2.0, FOCUS, blades, **lens)).camera_rays(np.full((count, 2), 0.5), numbers)
    return rays.origins[:, :2] / 2.0


def test_places_on_a_disk_are_even():
    x, y = places(0).T
    radius, angle = x**2 + y**2, (np.arctan2(y, x) / (2 * np.pi)) % 1
    assert radius.max() <= 1
    counts = np.histogram2d(radius, angle, bins=(12, 16), range=((0, 1), (0, 1)))[0].ravel()
    assert abs(chi_square_z(counts, np.full(counts.size, counts.sum() / counts.size))) < 4


@pytest.mark.parametrize("blades", [3, 5, 16, 64])
def test_places_on_a_polygon_are_even(blades):
    """By side, along it, and outwards, in triangles with their tips in the middle. Nothing is beyond."""
    x, y = (places(blades, rotation=0.7, ratio=2.0) * (2.0, 1.0)).T
    sector = np.pi * 2 / blades
    turn = (np.arctan2(y, x) - 0.7 + sector / 2) / sector
    side = np.floor(turn)
    within = (turn - side - 0.5) * sector  # radians from the middle of the side
    outward = np.hypot(x, y) * np.cos(within) / np.cos(sector / 2)
    along = np.tan(within) / np.tan(sector / 2)
    assert outward.max() <= 1 + 1e-12
    cells = (side % blades, 4 * (along + 1) / 2, 6 * np.minimum(outward, 1 - 1e-12) ** 2)
    counts = np.histogramdd(np.stack(cells, axis=1), bins=(blades, 4, 6), range=((0, blades), (0, 4), (0, 6)))[
        0
    ].ravel()
    assert abs(chi_square_z(counts, np.full(counts.size, counts.sum() / counts.size))) < 4


VIEWPLANES = {"PERSPECTIVE": (-0.5, 0.6, -0.4, 0.5), "ORTHOGRAPHIC": (-2, 3, -1, 1), "EQUIRECTANGULAR": (0, 1, 0, 1)}


def test_rays_of_one_point_meet_in_focus():
    pose = look_at((1.0, -2.0, 0.5), (0.2, 0.3, 0.1))
    rng = np.random.default_rng(2)
    for kind, plane in VIEWPLANES.items():
        scene = Scene()
        scene.set_camera(kind, pose, plane, 0.1, 9.0, aperture=Aperture(0.7, FOCUS, 5, 0.2, 1.5))
        points, lens = rng.random((200, 2)), rng.random((200, 2))
        through, middle = scene.camera_rays(points, lens), scene.camera_rays(points)
        depth = np.full(200, FOCUS) if kind == "EQUIRECTANGULAR" else FOCUS / (-middle.directions @ pose[:3, 2])
        focus = middle.origins + depth[:, None] * middle.directions
        way = focus - through.origins
        assert np.abs(way / np.linalg.norm(way, axis=1, keepdims=True) - through.directions).max() < 1e-14
        if kind != "EQUIRECTANGULAR":
            assert np.abs((through.origins - middle.origins) @ pose[:3, 2]).max() < 1e-14, "the lens is flat"
            assert np.abs(through.length_max * (-through.directions @ pose[:3, 2]) - 9).max() < 1e-12


def test_the_disk_of_a_small_emitter_is_that_of_a_thin_lens():
    """A point at depth d is seen as a disk of the slopes radius |1 / d - 1 / focus|, evenly bright."""
    radius, depth, half, size, edge = 0.2, 1.2, 0.25, 32, 0.04
    scene = new_scene()
    add(scene, quad(edge / 2, edge / 2), emission((1, 1, 1)), at=placed(0.05, 0.02, -depth))
    scene.set_camera("PERSPECTIVE", IDENTITY, (-half, half, -half, half), aperture=Aperture(radius, FOCUS))
    scene.commit()
    image = render(scene, size, size, 4096, names=("combined",), filter="BOX")[0]["combined"][..., 0].astype(float)
    y, x = (np.indices((size, size)) + 0.5) / size * 2 * half - half
    total, disk = image.sum(), radius * abs(1 / depth - 1 / FOCUS)
    x, y = x - 0.05 / depth, y - 0.02 / depth
    # All its light: solid angle of the emitter over that of a pixel, which the lens leaves as it is.
    assert total == pytest.approx((edge / depth) ** 2 / (2 * half / size) ** 2, rel=0.02)
    assert (image * x).sum() / total == pytest.approx(0, abs=0.003)
    assert (image * y).sum() / total == pytest.approx(0, abs=0.003)
    own = ((2 * half / size) ** 2 + (edge / depth) ** 2) / 6  # of a pixel and of the emitter
    spread = (image * (x**2 + y**2)).sum() / total - own
    assert spread == pytest.approx(disk**2 / 2, rel=0.02)
    assert image[np.hypot(x, y) > disk + 2 * half / size + edge / depth].max() == 0


@pytest.mark.parametrize("spacetime", [None, Spacetime.schwarzschild(0.15)], ids=["flat", "hole"])
def test_light_from_lamps_comes_through_the_lens(spacetime):
    scene = room(spacetime=spacetime)
    perspective(scene, look_at((0, -1.9, 0.2), (0, 1.9, -0.2)), aperture=Aperture(0.4, 1.0, 5, 0.3, 1.5))
    scene.commit()
    ours = pictures(scene, 16, 6, integrator="BIDIRECTIONAL")
    theirs = pictures(scene, 48, 6)
    assert_equal_means(theirs, ours, 0.03)
    pinhole = pictures(room(spacetime=spacetime), 24, 6)
    with pytest.raises(AssertionError):
        assert_equal_means(pinhole, ours)


def test_depth_is_along_the_axis_through_every_place():
    scene = new_scene()
    add(scene, quad(9, 9), diffuse((0.5, 0.5, 0.5)), at=placed(0, 0, -2.5))
    perspective(scene, aperture=Aperture(0.5, FOCUS))
    scene.commit()
    depth = render(scene, 8, 8, 1, names=("depth",))[0]["depth"]
    np.testing.assert_allclose(depth, 2.5, rtol=1e-6)


BAD = {"radius": -1.0, "focal_distance": 0.0, "blades": 65, "ratio": 0.0, "rotation": np.nan}


@pytest.mark.parametrize("name", BAD)
def test_bad_lenses_are_refused(name):
    with pytest.raises(ValueError, match=name):
        camera(Aperture(0.1, FOCUS)._replace(**{name: BAD[name]}))


@pytest.mark.parametrize("blades", [65, 2**31, 2**32 - 1, -1])
def test_no_lens_has_more_blades_than_make_a_disk(blades):
    """Stars out of focus take cells by the blade: so many would never end."""
    with pytest.raises(ValueError, match=rf"aperture_blades must be at most 64, got {blades % 2**32}"):
        camera(Aperture(0.1, FOCUS, blades))
    camera(Aperture(0.0, FOCUS, blades))  # a pinhole has none


def test_a_closed_lens_is_a_pinhole():
    """To the last bit."""
    settings = RenderSettings(8, 8, sample_count=2)
    found = []
    for aperture in (None, Aperture(0.0, FOCUS)):
        scene = room()
        perspective(scene, look_at((0, -1.9, 0.2), (0, 1.9, -0.2)), aperture=aperture)
        scene.commit()
        channels = {"combined": np.zeros((8, 8, 4), np.float32)}
        scene.render_tile(0, 0, 8, 8, settings, channels)
        found.append(channels["combined"])
    np.testing.assert_array_equal(*found)
