"""Stars out of focus: figures of the lens of the size that the thin lens' formula gives, with exactly the star's light,
as nearby as holes let them seem, and hidden where the rest of the picture is."""

from dataclasses import replace

import numpy as np
import pytest
from bentlight_native import Aperture, Cancelled, Progress, Spacetime
from rays import unit
from scenes import IDENTITY, add, emission, look_at, new_scene, quad, transparent
from test_direct_light import placed

EYE, FOCUS, SIZE, HALF = np.array([0.0, -20.0, 3.0]), 20.0, (48, 48), 0.004
PIXEL = 2 * HALF / SIZE[0]


def sky_scene(aperture, spacetime=None, target=(0, 0, 0), **camera):
    scene = new_scene()
    if spacetime is not None:
        scene.set_spacetime(spacetime, IDENTITY)
    kind = camera.pop("kind", "PERSPECTIVE")
    window = camera.pop("window", (-HALF, HALF, -HALF, HALF))
    scene.set_camera(kind, look_at(EYE, target), window, aperture=aperture, **camera)
    return scene


def committed(scene):
    scene.commit()
    return scene


def drawn(images, light=(1, 2, 0.5), size=SIZE, tile=None, **filters):
    return images.draw(images.light([light]), size, tile or (0, 0, *size), **filters)


def moments(pixels):
    """Mean place and covariance, in pixels, of a picture's light."""
    weights = pixels[..., 0].astype(float).ravel() / pixels[..., 0].sum(dtype=float)
    at = np.indices(pixels.shape[:2])[::-1].reshape(2, -1) + 0.5
    mean = at @ weights
    return mean, (at - mean[:, None]) * weights @ (at - mean[:, None]).T


LENSES = {
    "disk": Aperture(0.02, FOCUS),
    "small": Aperture(0.0004, FOCUS),
    "wide": Aperture(0.02, FOCUS, ratio=0.6),
    "triangle": Aperture(0.02, FOCUS, 3, 0.3),
    "hexagon": Aperture(0.02, FOCUS, 6, 0.1, 1.7),
}


@pytest.mark.parametrize("name", LENSES)
@pytest.mark.parametrize("filters", [("BLACKMAN_HARRIS", 3.0), ("BOX", 1.0), ("BLACKMAN_HARRIS", 0.02)], ids=str)
def test_light_is_conserved_and_spread_as_the_lens_is(name, filters):
    """In pixels a lens of radius r shows r / focus over a pixel's slope. Along any axis the variance of a disk of
    radius R is R^2 / 4, of a regular n-gon of circumradius R R^2 (2 + cos(2 pi / n)) / 12; the pixel filter adds its
    own."""
    lens = LENSES[name]
    scene = committed(sky_scene(lens))
    for star in unit(-EYE + [[0, 0, 0], [0.0146, 0.004, -0.0063]]):
        images = scene.find_stars([star], SIZE)
        pixels = drawn(images, filter=filters[0], filter_width=filters[1])
        np.testing.assert_allclose(flux(pixels, images), (1, 2, 0.5), rtol=1e-6)
        mean, covariance = moments(pixels)
        sharp = moments(
            drawn(committed(sky_scene(None)).find_stars([star], SIZE), filter=filters[0], filter_width=filters[1])
        )
        radius = lens.radius / FOCUS / PIXEL
        part = 0.25 if lens.blades < 3 else (2 + np.cos(2 * np.pi / lens.blades)) / 12
        expected = radius**2 * part / np.array([lens.ratio**2, 1])
        allowed = 0.06 if filters[1] > 1 else 0.5  # a pixel shows what is around its center alone
        np.testing.assert_allclose(mean, images.place[0] * SIZE, atol=allowed)
        np.testing.assert_allclose(np.diag(covariance) - np.diag(sharp[1]), expected, rtol=0.02, atol=allowed)
        edge = radius / min(lens.ratio, 1) + filters[1] / 2 + 1
        y, x = np.nonzero(pixels[..., 0])
        assert np.abs(np.stack([x, y]) + 0.5 - mean[:, None]).max() < edge


def test_an_even_disk():
    """The middle of a large disk is flat, and its edge where the formula has it."""
    scene = committed(sky_scene(Aperture(0.06, FOCUS)))
    size = (96, 96)
    radius = 0.06 / FOCUS / (2 * HALF / 96)
    images = scene.find_stars([unit(-EYE)], size)
    pixels = drawn(images, size=size)[..., 0]
    y, x = np.indices(pixels.shape) + 0.5 - 48
    within = np.hypot(x, y) < radius - 3
    mean = pixels.sum(dtype=float) / (np.pi * radius**2)
    assert (pixels[within] / mean).std() < 0.02 and abs(pixels[within].mean() / mean - 1) < 0.003
    assert (pixels[np.hypot(x, y) > radius + 2.2] == 0).all()
    half = np.sqrt((pixels > mean / 2).sum() / np.pi)
    assert abs(half - radius) < 0.1


SCENES = {
    "flat": (None, LENSES["hexagon"]),
    "schwarzschild": (Spacetime.schwarzschild(1.0), LENSES["triangle"]),
    "kerr": (Spacetime.kerr(1.0, 0.9), LENSES["wide"]),
    "ellis": (Spacetime.ellis(1.0), LENSES["disk"]),
}


def pinhole_pictures(scene, pose, lens, star, count=400):
    """What an ideal pinhole at each of `count` places on the lens sees of a star, moved as thin lenses do: places on
    the lens, and for each the images as (places in the whole picture, throughput)."""
    scene.set_camera("PERSPECTIVE", pose, (-HALF, HALF, -HALF, HALF), aperture=lens)
    scene.commit()
    numbers = (np.arange(count)[:, None] * (0.7548776662, 0.5698402910) + 0.5) % 1
    on_lens = (scene.camera_rays(np.full((count, 2), 0.5), numbers).origins - pose[:3, 3]) @ pose[:3, :2]
    seen = []
    for x, y in on_lens:
        eye = pose.copy()
        eye[:3, 3] += pose[:3, :2] @ (x, y)
        window = (-HALF - x / FOCUS, HALF - x / FOCUS, -HALF - y / FOCUS, HALF - y / FOCUS)
        scene.set_camera("PERSPECTIVE", eye, window)
        scene.commit()
        images = scene.find_stars([star], SIZE, margin=60)
        seen.append((images.place, images.throughput))
    scene.set_camera("PERSPECTIVE", pose, (-HALF, HALF, -HALF, HALF), aperture=lens)
    scene.commit()
    return on_lens, seen


@pytest.mark.parametrize("name", SCENES)
def test_each_place_on_the_lens_sees_a_star_where_a_pinhole_there_does(name):
    """All bright images move over the picture as parallax says: what is missing, of second order, is less than a
    hundredth of that. Near holes images are not where those at infinity are."""
    spacetime, lens = SCENES[name]
    star = unit(np.array([0.2, 1, -0.1]))
    images = committed(sky_scene(None, spacetime, window=(-0.7, 0.7, -0.7, 0.7))).find_stars([star], SIZE)
    images = images.part(images.throughput[:, 0] > 0.01)
    scene = sky_scene(None, spacetime, window=(-0.7, 0.7, -0.7, 0.7))
    looks = committed(scene).camera_rays(images.place).directions
    at_infinity = SIZE[0] / (2 * HALF * FOCUS)
    curved = 0
    for look in looks:
        scene = sky_scene(lens, spacetime, EYE + look)
        pose = look_at(EYE, EYE + look)
        on_lens, seen = pinhole_pictures(scene, pose, lens, star, 60)
        mine = scene.find_stars([star], SIZE)
        mine = mine.part([np.abs(mine.place - 0.5).sum(axis=1).argmin()])
        expected = mine.place[0] + on_lens @ mine.parallax[0].T
        true = np.array([p[np.abs(p - e).sum(axis=1).argmin()] for (p, _), e in zip(seen, expected, strict=True)])
        shift = np.abs(true - mine.place[0]).max() * SIZE[0]
        off = np.abs(true - expected).max() * SIZE[0]
        curved = max(curved, np.abs(mine.parallax[0] * SIZE[0] - at_infinity * np.eye(2)).max() / at_infinity)
        assert shift > 2 and off < 0.01 * shift
    assert curved < 1e-6 if spacetime is None else curved > 0.3


@pytest.mark.parametrize("focus", [1.0, 1e3, 1e6, 1e9])
def test_what_is_sharp_moves_figures_alike(focus):
    """A lens in focus at infinity shows a star around a hole as large as what is as near as that is; another focus adds
    to the parallax of all images alike."""
    star, parallax = unit(np.array([0.2, 1, -0.1])), []
    for each in (FOCUS, focus):
        scene = sky_scene(Aperture(0.02, each), SCENES["schwarzschild"][0], window=(-0.7, 0.7, -0.7, 0.7))
        images = committed(scene).find_stars([star], SIZE)
        parallax.append(images.parallax - np.eye(2) / (1.4 * each))
    assert len(images) > 1 and len(parallax[0]) == len(parallax[1])
    assert (np.abs(parallax[0]).max(axis=(1, 2)) > 0.3 / (1.4 * FOCUS)).all()
    np.testing.assert_allclose(parallax[1], parallax[0], rtol=1e-3, atol=1e-4 / FOCUS)


def test_stars_beside_the_picture_reach_into_it_by_a_hole():
    """A lens in focus far behind a hole blurs an image by it as if nearby, by pixels: its edge is only one away."""
    star = unit(np.array([0.2, 1, -0.1]))
    wide = committed(sky_scene(None, SCENES["schwarzschild"][0], window=(-0.7, 0.7, -0.7, 0.7)))
    images = wide.find_stars([star], SIZE)
    place = images.place[images.throughput[:, 0].argmax()] * 1.4 - 0.7
    left = place[0] + 0.0002
    scene = sky_scene(
        Aperture(0.02, 1e5),
        SCENES["schwarzschild"][0],
        window=(left, left + 2 * HALF, place[1] - HALF, place[1] + HALF),
    )
    images = committed(scene).find_stars([star], SIZE, margin=0.5)
    assert len(images) == 1 and -0.1 < images.place[0, 0] < 0
    assert flux(drawn(images), images)[0] > 0.05 * images.light([(1, 1, 1)])[0, 0] * images.solid_angle[0]


@pytest.mark.parametrize("radius", 10.0 ** np.arange(-19, -13))
def test_figures_as_small_as_rounding_keep_their_light(radius):
    """Through a lens that is all but closed."""
    scene = committed(sky_scene(Aperture(radius, FOCUS)))
    for star in unit(-EYE + [[0, 0, 0], [0.0146, 0.004, -0.0063]]):
        images = scene.find_stars([star], SIZE)
        np.testing.assert_allclose(flux(drawn(images), images), (1, 2, 0.5), rtol=1e-6)


@pytest.mark.parametrize("hides", [False, True], ids=["free", "hidden"])
def test_a_star_is_drawn_as_many_pinholes_see_it(hides):
    """Around a hole, and behind panes not far from the lens of which one hides what is there and one dims it: to half a
    cell of the lens at the edge between."""
    spacetime, lens = SCENES["schwarzschild"]
    star = unit(np.array([0.2, 1, -0.1]))
    wide = committed(sky_scene(None, spacetime, window=(-0.7, 0.7, -0.7, 0.7)))
    images = wide.find_stars([star], SIZE)
    look = wide.camera_rays(images.place[images.throughput[:, 0].argmax()][None]).directions[0]
    scene, pose = sky_scene(lens, spacetime, EYE + look), look_at(EYE, EYE + look)
    if hides:
        for side, closure in ((0.01, emission((0, 0, 0))), (-0.01, transparent((0.5, 0.25, 1)))):
            at = look_at(EYE + look, EYE) @ placed(side, 0, 0)
            add(scene, quad(0.0099, 0.5), closure, at=at)
    _, seen = pinhole_pictures(scene, pose, lens, star, 400)
    images = scene.find_stars([star], SIZE)
    ours = drawn(images, (1, 1, 1))
    sharp = committed(sky_scene(None, spacetime, EYE + look)).find_stars([star], SIZE)
    theirs = np.zeros_like(ours, dtype=float)
    for places, throughput in seen:
        many = sharp.part([0] * len(places))
        light = throughput / sharp.solid_angle[0] / len(seen)
        theirs += type(sharp)(
            many.star,
            places,
            throughput,
            *[getattr(many, n) for n in ("solid_angle", "swept", "parallax", "seen", "lens")],
        ).draw(light, SIZE, (0, 0, *SIZE))
    blocks, everything = (
        [p.reshape(12, 4, 12, 4, 3).sum(axis=(1, 3), dtype=float) for p in (ours, theirs)],
        theirs.sum(),
    )
    edge = 0.5 / images.seen.shape[1] if hides else 0.01
    np.testing.assert_allclose(*(block.sum(axis=(0, 1)) for block in blocks), rtol=2 * edge)
    assert np.abs(blocks[0] - blocks[1]).sum() < (0.05 + 2 * edge) * everything


def test_a_hidden_middle_hides_nothing_else():
    """Through the lens' middle nothing is seen; around it all is, and a lens behind a wall sees nothing."""
    lens, star = Aperture(0.5, FOCUS), unit(-EYE)
    scene, at = sky_scene(lens, window=(-0.2, 0.2, -0.2, 0.2)), look_at(EYE + 0.1 * star, EYE)
    add(scene, quad(0.1, 0.1), emission((0, 0, 0)), at=at)
    (throughput,) = committed(scene).find_stars([star], SIZE).throughput[:, 0]
    assert abs(throughput - (1 - 0.04 / (np.pi * 0.25))) < 0.03
    add(scene, quad(2, 2), emission((0, 0, 0)), at=at)
    assert len(committed(scene).find_stars([star], SIZE)) == 0


def test_stars_beside_the_picture_reach_into_it():
    """A star half a blur's radius beyond the edge: the segment of a circle that lies within."""
    scene = committed(sky_scene(Aperture(0.02, FOCUS)))
    x, radius = HALF + 3 * PIXEL, 6
    pose = look_at(EYE, (0, 0, 0))
    images = scene.find_stars([pose[:3, :3] @ (x, 0, -1)], SIZE, margin=1.5)
    share = drawn(images)[..., 0].sum(dtype=float) / (images.light([(1, 1, 1)])[0, 0] * SIZE[0] * SIZE[1])
    depth = 3 / radius
    assert share == pytest.approx((np.arccos(depth) - depth * np.sqrt(1 - depth**2)) / np.pi, rel=0.02)


PANORAMAS = {
    "EQUIRECTANGULAR": {"longitude_min": -0.02, "longitude_max": 0.02, "latitude_min": -0.02, "latitude_max": 0.02},
    "FISHEYE_EQUIDISTANT": {"fisheye_fov": 0.04},
    "FISHEYE_EQUISOLID": {"fisheye_fov": 0.06, "fisheye_lens": 1000, "sensor_width": 40, "sensor_height": 40},
}


@pytest.mark.parametrize("kind", PANORAMAS)
def test_panoramas_of_small_angles_blur_as_a_lens_does(kind):
    scene = new_scene()
    scene.set_camera(
        kind, look_at(EYE, (0, 0, 0)), (0, 1, 0, 1), aperture=Aperture(0.1, FOCUS, ratio=2.0), **PANORAMAS[kind]
    )
    images = committed(scene).find_stars([unit(-EYE)], SIZE)
    pixels = drawn(images)
    np.testing.assert_allclose(flux(pixels, images), (1, 2, 0.5), rtol=1e-6)
    radius = 0.1 / FOCUS / (0.04 / SIZE[0])
    covariance = moments(pixels)[1]
    across = sorted(np.linalg.eigvalsh(covariance))
    np.testing.assert_allclose(across, np.array([radius / 2, radius]) ** 2 / 4 + 0.25, rtol=0.1)


def flux(pixels, images):
    """Irradiance (3,) of a picture of one image."""
    return pixels.sum(axis=(0, 1), dtype=float) * images.solid_angle[0] / (SIZE[0] * SIZE[1])


def test_the_picture_does_not_depend_on_tiles_or_threads():
    scene = committed(sky_scene(LENSES["triangle"], Spacetime.schwarzschild(1.0), window=(-0.7, 0.7, -0.7, 0.7)))
    stars = unit(np.random.default_rng(7).normal(size=(3000, 3)))
    one, three = (scene.find_stars(stars, SIZE, threads=threads) for threads in (1, 3))
    for name, value in vars(one).items():
        assert (value == getattr(three, name)).all(), name
    light = one.light(np.random.default_rng(8).random((3000, 3)))
    whole = one.draw(light, SIZE, (0, 0, *SIZE))
    for x, y, width, height in [(0, 0, 16, 21), (16, 3, 5, 7), (47, 40, 1, 8)]:
        tile = one.draw(light, SIZE, (x, y, width, height))
        assert tile.any() and (tile == whole[y : y + height, x : x + width]).all()


def test_bad_lenses_are_refused():
    """By the methods that the numpy-facing ones stand on."""
    places, parallax, corners = np.full((1, 2), 0.5), np.zeros((1, 2, 2)), np.empty((9, 9, 2))
    seen, point, nothing = np.empty((1, 8, 8, 3), np.float32), np.empty((1, 1, 2)), np.empty((1, 0, 0, 3), np.float32)
    lens = sky_scene(Aperture(1e-6, FOCUS))
    with pytest.raises(RuntimeError, match="commit"):
        lens._trace_star_cells(places, parallax, (*SIZE, 0, 1e-4, 8), corners, seen, None)
    lens.commit()
    wrong = {"1 to 65536": (0, 8, 0, 1e-4, 8), "tolerance": (8, 8, 0, 0, 8), "margin": (8, 8, -1, 1e-4, 8)}
    for message, view in wrong.items():
        with pytest.raises(ValueError, match=message):
            lens._trace_star_cells(places, parallax, view, corners, seen, None)
    with pytest.raises(ValueError, match="cells"):
        committed(sky_scene(None))._trace_star_cells(places, parallax, (*SIZE, 0, 1e-4, 8), point, nothing, None)
    with pytest.raises(RuntimeError, match="no camera"):
        committed(new_scene())._trace_star_cells(places, parallax, (*SIZE, 0, 1e-4, 8), point, nothing, None)
    images = lens.find_stars([unit(-EYE)], SIZE)
    for shape in ((0, 9, 2), (9, 0, 2), (1, 9, 2)):
        with pytest.raises(ValueError, match="corners"):
            drawn(replace(images, lens=np.empty(shape)))


def test_a_cancel_is_obeyed():
    cancelled = Progress()
    cancelled.cancel()
    with pytest.raises(Cancelled):
        committed(sky_scene(LENSES["disk"])).find_stars([unit(-EYE)], SIZE, progress=cancelled)
