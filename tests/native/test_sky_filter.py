"""Images of the sky averaged over ellipses of directions: how wide, that no light is lost, and what pictures gain."""

import numpy as np
import pytest
from bentlight_native import ProgramBuilder, RenderSettings, Scene, Spacetime
from scenes import IDENTITY, look_at, render

ROWS, COLUMNS = 64, 128
COUNT = 60_000  # directions of which a mean over the sphere is taken


def image_sky(pixels, rotation=None, srgb=False):
    """A scene whose sky is that image, turned by Euler angles."""
    scene, builder = Scene(), ProgramBuilder()
    one, image = builder.constant(1), scene.add_image(pixels, srgb)
    places = [builder.emit("coordinate", immediates=("GENERATED",))[0]]
    places += [builder.emit("coordinate_beside", one, immediates=("GENERATED", axis))[0] for axis in "XY"]
    if rotation is not None:
        numbers = [builder.constant(value) for value in (0, rotation, 1)]
        places = [builder.emit("mapping", place, *numbers, immediates=("POINT",))[0] for place in places]
    color, _ = builder.emit("environment", *places, immediates=(image, "Linear", "EQUIRECTANGULAR"))
    builder.emit("emission", one, color, one)
    scene.set_world(builder.build())
    return scene


def spot(row, column):
    """One white texel on black, and where it is: the direction, one to its east and one to its north."""
    pixels = np.zeros((ROWS, COLUMNS, 4), np.float32)
    pixels[row, column, :3] = 1
    latitude, longitude = np.pi * ((row + 0.5) / ROWS - 0.5), 2 * np.pi * (0.5 - (column + 0.5) / COLUMNS)
    place = np.array([np.cos(latitude) * np.cos(longitude), np.cos(latitude) * np.sin(longitude), np.sin(latitude)])
    east = np.array([-np.sin(longitude), np.cos(longitude), 0])
    return pixels, place, east, np.cross(place, east)


def solid_angle(rows):
    """Of one texel in each of those rows."""
    return 2 * np.pi / COLUMNS * (np.cos(np.pi * rows / ROWS) - np.cos(np.pi * (rows + 1) / ROWS))


def sphere(count=COUNT):
    """Directions even over the sphere: a Fibonacci lattice."""
    number = np.arange(count) + 0.5
    z, turn = 1 - 2 * number / count, np.pi * (1 + np.sqrt(5)) * number
    return np.column_stack([np.sqrt(1 - z * z) * np.cos(turn), np.sqrt(1 - z * z) * np.sin(turn), z])


def across(directions, first, second):
    """Standard deviations in two directions of space, as they are seen along each of the directions."""
    along = np.stack([first, second])[None]
    return along - (directions[:, None] * along).sum(-1, keepdims=True) * directions[:, None]


@pytest.mark.parametrize(("wide", "high"), [(0.05, 0.05), (0.1, 0.1), (0.2, 0.05), (0.06, 0.2)])
def test_a_point_becomes_a_spot_of_the_wanted_size(wide, high):
    """At the equator, at the image's seam and near a pole. Measured from where the point is, which lies anywhere among
    coarser texels: the mean over several."""
    directions, squares, lights = sphere(), [], []
    rng = np.random.default_rng(5)
    for row, column in [(32, 0), (31, COLUMNS - 1), (58, 20), (5, 77), *rng.integers((4, 0), (60, COLUMNS), (8, 2))]:
        pixels, place, east, north = spot(row, column)
        value = image_sky(pixels).sky(directions, across=across(directions, wide * east, high * north))[:, 0]
        x, y = (np.arctan2(directions @ axis, directions @ place) for axis in (east, north))
        squares.append([np.average(z**2, weights=value) for z in (x, y)])
        lights.append(4 * np.pi * value.mean() / solid_angle(row))
    np.testing.assert_allclose(np.sqrt(np.mean(squares, axis=0)), (wide, high), rtol=0.1)
    np.testing.assert_allclose(lights, 1, atol=0.1)  # turned aside, the two axes are shorter


@pytest.mark.parametrize("narrow", [1.0, 0.1, 1e-3])
def test_no_light_is_lost(narrow):
    """Of an image of random texels the mean over the sphere stays: no trend, and little of it lost in each. For round
    filters, and long ones as by a hole. So no ray's color has a bias before stars in random places, however it is bent;
    of stars in given places the filter moves light to where more or less of it reaches the camera."""
    directions, rng, loss = sphere(), np.random.default_rng(6), []
    side = np.cross(directions, (0.36, 0.48, 0.8))
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    for size in (0.06, 0.1, 0.17):
        vectors = size * np.stack([side, narrow * np.cross(directions, side)], axis=1)
        for _ in range(6):
            pixels = np.ones((ROWS, COLUMNS, 4), np.float32)
            pixels[..., :3] = rng.exponential(size=(ROWS, COLUMNS, 1)) ** 3
            scene = image_sky(pixels)
            loss.append(scene.sky(directions, across=vectors)[:, 0].mean() / scene.sky(directions)[:, 0].mean() - 1)
    assert np.std(loss) < 0.02
    assert abs(np.mean(loss)) < 4 * np.std(loss, ddof=1) / np.sqrt(len(loss))


def test_the_sky_may_be_turned():
    """A turned world is the same as turned directions, along which the filter lies as it did."""
    rng = np.random.default_rng(7)
    pixels = rng.random((ROWS, COLUMNS, 4), np.float32)
    directions = sphere(500)
    vectors = across(directions, (0.1, 0, 0.03), (0, 0.04, 0.2))
    turned = image_sky(pixels, (0, 0, 0.7)).sky(directions, across=vectors)
    matrix = np.array([[np.cos(0.7), -np.sin(0.7), 0], [np.sin(0.7), np.cos(0.7), 0], [0, 0, 1]])
    np.testing.assert_allclose(
        turned, image_sky(pixels).sky(directions @ matrix.T, across=vectors @ matrix.T), rtol=1e-6
    )


def test_what_is_small_beside_a_texel_is_not_averaged():
    pixels = np.random.default_rng(8).integers(0, 256, (ROWS, COLUMNS, 4), np.uint8)
    directions = sphere(500)
    for srgb in (False, True):
        scene = image_sky(pixels, srgb=srgb)
        vectors = across(directions, (0.4 * np.pi / ROWS, 0, 0), (0, 0.49 * np.pi / ROWS, 0))
        assert (scene.sky(directions, across=vectors) == scene.sky(directions)).all()


def test_bytes_are_averaged_as_light():
    """Not as the numbers of their curve: black and white squares are half as bright as white from afar."""
    pixels = np.zeros((ROWS, COLUMNS, 4), np.uint8)
    pixels[::2, ::2] = pixels[1::2, 1::2] = 255
    value = image_sky(pixels, srgb=True).sky([(1, 0.2, 0.1)], across=[[(0, 0.3, 0), (0, 0, 0.3)]])
    np.testing.assert_allclose(value, 0.5, rtol=1e-3)


@pytest.mark.parametrize("vectors", [np.full((2, 3), 1e300), [(0, 1e-300, 0), (0, 0, 50)], np.zeros((2, 3))])
def test_filters_of_any_size_are_finite(vectors):
    pixels = np.ones((3, 5, 4), np.float32)
    for direction in ((0, 0, 1), (1, 0, 0), (-1, 1e-12, 0)):
        np.testing.assert_allclose(image_sky(pixels).sky([direction], across=[vectors]), 1, rtol=1e-6)


def test_a_replaced_image_is_averaged_anew():
    scene = image_sky(np.zeros((ROWS, COLUMNS, 4), np.float32))
    scene.update_image(0, np.ones((32, 70, 4), np.float32))
    np.testing.assert_allclose(scene.sky([(1, 0, 0)], across=[[(0, 0.2, 0), (0, 0, 0.2)]]), 1, rtol=1e-6)


# ---- In pictures ----

SIZE = 32, 20
CAMERA = look_at((0, -20, 0), (0, 0, 0))


def stars(spacetime, count, half):
    """Texels a third of a pixel wide, within angles `half` of the picture's middle."""
    rng = np.random.default_rng(9)
    pixels = np.zeros((512, 1024, 4), np.float32)
    row = 256 + rng.uniform(-half, half, count) / np.pi * 512
    column = 256 + rng.uniform(-half, half, count) / np.pi * 512
    pixels[row.astype(int), column.astype(int), :3] = 1
    scene = image_sky(pixels)
    if spacetime:
        scene.set_spacetime(spacetime, IDENTITY)
    scene.set_camera("PERSPECTIVE", CAMERA, (-0.32, 0.32, -0.2, 0.2))
    scene.commit()
    return scene


def total(scene, samples, seed, sky_filter, **settings):
    combined = render(
        scene, *SIZE, samples, names=("combined",), max_bounces=0, seed=seed, sky_filter=sky_filter, **settings
    )
    return combined[0]["combined"][..., 0].astype(float).sum()


@pytest.mark.parametrize("spacetime", [None, Spacetime.schwarzschild(0.3), Spacetime.kerr(0.3, 0.25)], ids=str)
def test_pictures_keep_their_light_with_less_noise(spacetime):
    """All stars are inside of the picture, and stay there averaged: a Z-test. And the noise of n stars is no
    more than that of samples in independent places that fall on a Gaussian of their distance: 1 / sqrt(4 pi n)."""
    count = 24
    scene, samples = stars(spacetime, count, 0.12), 16
    plain = [total(scene, samples, seed, 0) for seed in range(60)]
    filtered = [total(scene, samples, seed, 1 / np.sqrt(samples)) for seed in range(60)]
    error = np.hypot(np.std(plain, ddof=1), np.std(filtered, ddof=1)) / np.sqrt(60)
    assert abs(np.mean(filtered) - np.mean(plain)) < 4 * error
    assert np.std(filtered) < np.mean(filtered) / np.sqrt(4 * np.pi * count)
    assert 1.4 * np.std(filtered) < np.std(plain)


def test_more_samples_on_the_photon_ring_are_averaged_less():
    """There a pixel's samples are closer to each other; where it takes as many as others nothing changes."""
    scene = stars(Spacetime.schwarzschild(0.3), 24, 0.12)
    names, settings = ("combined", "sample_count"), {"max_bounces": 0, "sky_filter": 0.25}
    plain, ring = (render(scene, *SIZE, 16, names=names, photon_ring_samples=n, **settings)[0] for n in (1, 8))
    alike = ring["sample_count"][..., 0] == 16
    assert 0.5 < alike.mean() < 1
    assert (plain["combined"][alike] == ring["combined"][alike]).all()


def test_bad_filters_are_refused():
    scene = stars(None, 1, 0.1)
    for bad in (-0.1, 1.5, np.nan):
        with pytest.raises(ValueError, match="sky_filter must lie in"):
            total(scene, 1, 0, bad)


def test_settings_default_to_no_filter():
    assert RenderSettings(1, 1).sky_filter == 0
