"""Stars: their light is conserved wherever they lie in a pixel, and magnified as much as traced bundles and golden data
say; nothing flickers as the camera moves, and surfaces hide them."""

import numpy as np
import pytest
from bentlight_native import Cancelled, Progress, Spacetime, trace_rays
from golden import numbers, rows
from rays import unit
from scenes import IDENTITY, add, emission, look_at, new_scene, perspective, render, transparent
from test_join_lenses import OBJECTS

SCHWARZSCHILD, KERR = Spacetime.schwarzschild(1.0), Spacetime.kerr(1.0, 0.9)
EYE = np.array([0.0, -20.0, 3.0])


def sky_scene(spacetime=None, eye=EYE, half=1.5, target=(0, 0, 0)):
    """A camera that looks at a hole, and nothing else."""
    scene = new_scene()
    if spacetime is not None:
        scene.set_spacetime(spacetime, IDENTITY)
    perspective(scene, look_at(eye, target), half=half)
    return scene


def committed(scene):
    scene.commit()
    return scene


def random_stars(n, seed=0, along=None, cosine=-1.0):
    """n directions, of those whose angle to `along` has at least that cosine."""
    d = unit(np.random.default_rng(seed).normal(size=(n if along is None else 40 * n, 3)))
    return d if along is None else d[d @ unit(np.array(along, float)) > cosine][:n]


def flux(pixels, solid_angle, size):
    """Irradiance of a picture (height, width, 3) of one image, whose place has that solid angle per area."""
    return pixels.sum(axis=(0, 1), dtype=float) * solid_angle / (size[0] * size[1])


@pytest.mark.parametrize(
    ("kind", "width"), [("BLACKMAN_HARRIS", 3.0), ("GAUSSIAN", 4.5), ("BOX", 1.0), ("BLACKMAN_HARRIS", 0.02)]
)
def test_flat_light_is_conserved_wherever_a_star_lies_in_its_pixel(kind, width):
    scene, size = committed(sky_scene()), (40, 40)
    stars = random_stars(100, along=-EYE, cosine=0.9)
    images = scene.find_stars(stars, size)
    irradiance = np.random.default_rng(1).uniform(0.5, 2, (100, 3)) * 1e-6
    light = images.light(irradiance)
    assert list(images.star) == list(range(100)) and (images.swept == 0).all()
    rays = scene.camera_rays(images.place)
    assert np.abs(rays.directions - stars).max() < 1e-12
    for i in range(100):
        pixels = images.part([i]).draw(light[i : i + 1], size, (0, 0, *size), kind, width)
        assert np.allclose(flux(pixels, images.solid_angle[i], size), irradiance[i], rtol=1e-6)
        y, x = np.unravel_index(pixels[..., 0].argmax(), size)
        assert np.abs(images.place[i] * 40 - (x + 0.5, y + 0.5)).max() <= 0.5 + 1e-9, "elsewhere"


@pytest.mark.parametrize("spacetime", [None, SCHWARZSCHILD], ids=["flat", "schwarzschild"])
def test_a_star_is_as_bright_as_a_small_sun(spacetime):
    """A disk of as much light, found by chance; around a hole both of its images."""
    size, angle, seeds = (32, 32), 0.04, 8
    star = unit(np.array([0.2, 1, -0.1]))
    scene = sky_scene(spacetime, half=0.8)
    radiance = 1 / (np.pi * np.sin(angle / 2) ** 2)
    scene.set_suns([star], [(radiance, 2 * radiance, 0)], angle)
    scene.commit()
    images = bright(scene.find_stars([star], size))
    assert len(images) == (1 if spacetime is None else 2)
    pixels = images.draw(images.light([(1, 2, 0)]), size, (0, 0, *size))
    for image in range(len(images)):  # each in its half of the picture
        half = slice(16, 32) if images.place[image, 0] > 0.5 else slice(0, 16)
        pictures = [render(scene, *size, samples=160, seed=s, names=("combined",))[0] for s in range(seeds)]
        sums = np.array([picture["combined"][:, half, :3].sum((0, 1)) for picture in pictures])
        error = sums.std(axis=0, ddof=1) / np.sqrt(seeds)
        z = (sums.mean(axis=0) - pixels[:, half].sum((0, 1)))[:2] / error[:2]
        assert np.abs(z).max() < 4 and (error < 0.05 * sums.mean(axis=0))[:2].all()


def test_images_around_a_hole_are_where_golden_rays_come_from():
    """Place to 1e-7 rad; magnification sin(psi) dpsi / (sin(phi) dphi), with the golden derivative's four digits."""
    table = [row for row in rows("schwarzschild_deflection_finite.csv") if row["fate"] == "escape"]
    r, psi, phi, slope = (numbers(table, name) for name in ("r_obs", "psi_deg", "swept_azimuth", "cond_dswept_dpsi"))
    usable = (psi > 95) & (psi < 180) & (phi < 2 * np.pi) & (np.abs(np.sin(phi)) > 1e-3) & (slope > 0)
    checked = 0
    for r_i, psi_i, phi_i, slope_i in zip(r[usable], np.radians(psi[usable]), phi[usable], slope[usable], strict=True):
        scene = new_scene()
        scene.set_spacetime(Spacetime.schwarzschild(1.0, "areal"), IDENTITY)
        perspective(scene, look_at((r_i, 0, 0), (0, 0, 0)), half=30.0)
        scene.commit()
        expected = np.sin(psi_i) / np.abs(np.sin(phi_i) * slope_i)
        if expected < 1e-3:  # too faint to be listed
            continue
        images = scene.find_stars([(np.cos(phi_i), np.sin(phi_i), 0)], (64, 64))
        order = np.abs(images.swept - phi_i).argmin()
        assert abs(images.swept[order] - phi_i) < 1e-6
        d = scene.camera_rays(images.place[order : order + 1]).directions[0]
        assert abs(np.arccos(d[0]) - psi_i) < 1e-7
        if expected < 10:
            assert np.isclose(images.throughput[order, 0], expected, rtol=1e-3)
        checked += 1
    assert checked > 12


def objects_scene():
    """Two holes and the two mouths of a wormhole."""
    scene = new_scene()
    scene.set_spacetime_objects(OBJECTS)
    perspective(scene, look_at((3, -8, 3), (3, 4, 0)), half=1.0)
    return scene


def bright(images):
    """Those that are not so narrow that the steps of a bundle are too wide."""
    return images.part(images.throughput[:, 0] > 1e-2)


@pytest.mark.parametrize(
    ("scene", "tolerance"),
    [
        (sky_scene(SCHWARZSCHILD), 1e-5),
        (sky_scene(KERR), 1e-3),
        (sky_scene(Spacetime.ellis(1.0)), 1e-5),
        (objects_scene(), 1e-4),
    ],
    ids=["schwarzschild", "kerr", "ellis", "objects"],
)
def test_images_are_magnified_as_traced_bundles_are(scene, tolerance):
    """The ray back through each image comes to its star, and the solid angles of a narrow bundle have its ratio."""
    scene.commit()
    stars = random_stars(150, 3)
    images = bright(scene.find_stars(stars, (64, 64)))
    assert len(images) > 50
    rays = scene.camera_rays(images.place)
    step = 2e-5
    right = unit(np.cross(rays.directions, (0.1, 0.2, 1)))
    up = np.cross(right, rays.directions)
    ends = []
    for offset in (0 * right, right, -right, up, -up):
        hit = scene.intersect(rays.origins, unit(rays.directions + step * offset), angular_tolerance=1e-11)
        ends.append(hit["direction"])
        assert np.isin(hit["fate"], (1, 3)).all()
    off = np.linalg.norm(ends[0] - stars[images.star], axis=1)
    spread = np.linalg.norm(np.cross(ends[1] - ends[2], ends[3] - ends[4]), axis=1) / (4 * step**2)
    expected = 1 / spread
    plain = expected < 5  # not bounded
    assert plain.sum() > 40 and (off[plain] < 3e-3).all()
    assert np.median(off) < 3e-6
    assert np.allclose(images.throughput[plain, 0], expected[plain], rtol=tolerance)


def test_a_star_far_behind_a_hole_is_magnified_as_weak_lensing_has_it():
    """The total of both images is (u^2 + 2) / (u sqrt(u^2 + 4)) at u Einstein radii (Paczynski 1986), for r >> M."""
    distance, ring = 1e6, 2e-3  # theta_E^2 = 4 M / r
    scene = committed(sky_scene(SCHWARZSCHILD, (0, -distance, 0), half=0.02))
    u = np.array([0.1, 0.3, 1.0, 2.0])
    images = scene.find_stars(np.column_stack([ring * u, np.ones(4), np.zeros(4)]), (64, 64))
    total = np.bincount(images.star, images.throughput[:, 0])
    assert np.allclose(total, (u**2 + 2) / (u * np.sqrt(u**2 + 4)), rtol=5e-3)


@pytest.mark.parametrize("spacetime", [SCHWARZSCHILD, KERR], ids=["schwarzschild", "kerr"])
def test_a_star_that_passes_behind_a_hole_stays_finite_and_does_not_pop(spacetime):
    scene = committed(sky_scene(spacetime))
    behind = unit(-EYE)
    aside = unit(np.cross(behind, (0, 0, 1)))
    path = np.linspace(-0.4, 0.4, 401)[:, None] * aside + behind
    images = scene.find_stars(path, (64, 64))
    total = np.bincount(images.star, images.throughput[:, 0], minlength=len(path))
    assert np.bincount(images.star, images.throughput[:, 0] > 0.01).min() >= 2, "an image is missing"
    assert total.min() > 1 and total.max() < 202
    calm = np.abs(path @ aside) > 0.15
    assert np.abs(np.diff(total) / total[:-1])[calm[:-1]].max() < 0.03


def test_images_that_connections_miss_are_found_all_the_same():
    """Near the caustics of a fast hole: each star has two images in some view, and rays lead back to it."""
    hole, eye, size = Spacetime.kerr(1.0, 0.999), np.array([0.0, -15, 0]), (64, 64)
    steps = ((0, 1, 0), (0, -1, 0), (1, 0, 0), (-1, 0, 0), (0, 1e-9, 1), (0, 1e-9, -1))
    faces = [committed(sky_scene(hole, eye, 1.01, eye + step)) for step in steps]  # of a cube, which overlap a little
    stars = random_stars(8000, 1)
    missed = stars[faces[0].join(np.tile(eye, (len(stars), 1)), stars, sky=True)["count"] < 2]
    assert len(missed) > 3
    count = np.zeros(len(missed), int)
    for scene in faces:
        images = scene.find_stars(missed, size)
        count += np.bincount(images.star, minlength=len(missed))
        rays = scene.camera_rays(images.place)
        back = trace_rays(hole, rays.origins, rays.directions)["direction"]
        assert np.linalg.norm(back - missed[images.star], axis=1).max(initial=0) < 1e-5
    assert count.min() >= 2


def test_exactly_behind_a_hole_both_images_are_bounded():
    scene = committed(sky_scene(SCHWARZSCHILD, (0, -20, 0)))
    images = scene.find_stars([(0, 1, 0)], (64, 64))
    brightest = np.sort(images.throughput[:, 0])[::-1]
    assert np.allclose(brightest[:2], 100, rtol=1e-3) and brightest[2:].max(initial=0) < 0.2


def test_surfaces_hide_stars_or_let_them_shine_through():
    star, size = [(0, 1, 0)], (32, 32)

    def throughput(*closures, **instance):
        scene = sky_scene(eye=(0, -20, 0))
        add(scene, screen(), *closures, **instance)
        images = committed(scene).find_stars(star, size)
        return images.throughput[0] if len(images) else np.zeros(3)

    assert (throughput(emission((1, 1, 1))) == 0).all()
    assert np.allclose(throughput(transparent((0.5, 0.25, 1))), (0.5, 0.25, 1), rtol=1e-6)
    assert np.allclose(throughput(emission((1, 1, 1)), visibility=2), 1, rtol=1e-6)
    assert (throughput(transparent((1, 1, 1)), visibility=15 | 16) == 0).all(), "a holdout"
    assert np.allclose(throughput(emission((1, 1, 1)), visibility=15 | 128), 1, rtol=1e-6), "a lamp"
    scene = sky_scene(eye=(0, -20, 0))
    add(scene, screen(), transparent((0.5, 0.5, 0.5)))
    assert len(committed(scene).find_stars(star, size, transparent_bounces=0)) == 0


def screen():
    """A square across the y axis."""
    corners = [(-5, 0, -5), (5, 0, -5), (5, 0, 5), (-5, 0, 5)]
    return np.array(corners, np.float32), np.array([[0, 1, 2], [0, 2, 3]], np.uint32)


def test_a_hidden_image_leaves_the_other():
    """A screen beside the hole hides the primary image only."""
    star = unit(np.array([0.3, 1, -0.15]))
    free = committed(sky_scene(SCHWARZSCHILD)).find_stars([star], (64, 64))
    scene = sky_scene(SCHWARZSCHILD)
    vertices, triangles = screen()
    add(scene, (vertices * 0.8 + np.array([9, 0, 0], np.float32), triangles), emission((1, 1, 1)))
    left = committed(scene).find_stars([star], (64, 64))
    assert set(np.floor(free.swept / np.pi)) >= {0, 1}
    assert 0 not in np.floor(left.swept / np.pi) and 1 in np.floor(left.swept / np.pi)


@pytest.mark.parametrize("spacetime", [SCHWARZSCHILD, KERR], ids=["schwarzschild", "kerr"])
def test_an_orbit_does_not_flicker(spacetime):
    """48 frames of a slow orbit: no star's light, nor all light of a window, jumps from frame to frame."""
    size = (48, 48)
    stars = random_stars(60, 5, along=-EYE, cosine=0.6)
    single, window = [], []
    for angle in np.radians(0.1 * np.arange(48)):
        c, s = np.cos(angle), np.sin(angle)
        scene = committed(sky_scene(spacetime, np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) @ EYE, half=4.0))
        images = scene.find_stars(stars, size, margin=1.5)
        single.append(np.bincount(images.star, images.throughput[:, 0], minlength=60))
        area = images.draw(images.light(np.ones((60, 3))), size, (0, 0, *size))[..., 0]
        places = (np.indices(size)[::-1].reshape(2, -1).T + 0.5) / 48
        slopes = 4.0 * (2 * places - 1)
        solid = 64 / (1 + (slopes**2).sum(1)) ** 1.5 / (size[0] * size[1])
        window.append(area.ravel() @ solid)
    single, window = np.array(single), np.array(window)
    assert single.min() > 0.8
    assert np.abs(np.diff(single, axis=0) / single[:-1]).max() < 0.1, "a star pops"
    assert np.abs(np.diff(window) / window[:-1]).max() < 0.01
    # Without jumps, what a frame differs from the mean of its neighbors is of second order.
    assert np.abs(window[1:-1] - (window[:-2] + window[2:]) / 2).max() < 0.005 * window.mean()


def test_the_picture_does_not_depend_on_tiles_or_threads():
    scene, size = committed(sky_scene(KERR)), (33, 21)
    stars, irradiance = random_stars(3000, 7), np.random.default_rng(8).random((3000, 3))
    images, others = (scene.find_stars(stars, size, threads=threads) for threads in (1, 3))
    for name, value in vars(images).items():
        assert (value == getattr(others, name)).all(), name
    light = images.light(irradiance)
    whole = images.draw(light, size, (0, 0, *size))
    assert whole.any()
    for x, y, width, height in [(0, 0, 16, 21), (16, 3, 5, 7), (32, 20, 1, 1)]:
        tile = images.draw(light, size, (x, y, width, height))
        assert (tile == whole[y : y + height, x : x + width]).all()


def test_bad_input_is_refused():
    scene = sky_scene()
    star = [(0, 1, 0)]
    with pytest.raises(RuntimeError, match="commit"):
        scene.find_stars(star, (8, 8))
    scene.commit()
    with pytest.raises(RuntimeError, match="no camera"):
        committed(new_scene()).find_stars(star, (8, 8))
    with pytest.raises(ValueError, match="directions"):
        scene.find_stars([(0, np.nan, 0)], (8, 8))
    with pytest.raises(ValueError, match="direction 0"):
        scene.find_stars([(0, 0, 0)], (8, 8))
    with pytest.raises(ValueError, match="1 to 65536"):
        scene.find_stars(star, (0, 8))
    with pytest.raises(ValueError, match="margin"):
        scene.find_stars(star, (8, 8), margin=-1)
    with pytest.raises(ValueError, match="tolerance"):
        scene.find_stars(star, (8, 8), tolerance=np.nan)
    images = scene.find_stars(star, (8, 8))
    with pytest.raises(ValueError, match="filter_width"):
        images.draw(images.light([(1, 1, 1)]), (8, 8), (0, 0, 8, 8), filter_width=0)
    with pytest.raises(ValueError, match="filter"):
        images.draw(images.light([(1, 1, 1)]), (8, 8), (0, 0, 8, 8), filter="TENT")
    with pytest.raises(ValueError, match="light"):
        images.draw(np.full((1, 3), np.nan), (8, 8), (0, 0, 8, 8))
    assert len(scene.find_stars(np.empty((0, 3)), (8, 8))) == 0
    cancelled = Progress()
    cancelled.cancel()
    with pytest.raises(Cancelled):
        scene.find_stars(star, (8, 8), progress=cancelled)
    scene.set_camera("ORTHOGRAPHIC", look_at(EYE, (0, 0, 0)), (-1, 1, -1, 1))
    scene.commit()
    assert not scene.shows_stars()
    with pytest.raises(ValueError, match="camera"):
        scene.find_stars(star, (8, 8))


PANORAMAS = {
    "EQUIRECTANGULAR": {},
    "EQUIANGULAR_CUBEMAP_FACE": {},
    "MIRRORBALL": {},
    "FISHEYE_EQUIDISTANT": {"fisheye_fov": 5.0},
    "FISHEYE_EQUISOLID": {"fisheye_fov": 4.0, "fisheye_lens": 12, "sensor_width": 36, "sensor_height": 30},
    "FISHEYE_LENS_POLYNOMIAL": {"fisheye_fov": 4.0, "sensor_width": 36, "sensor_height": 30,
                                "fisheye_polynomial_k1": -0.09, "fisheye_polynomial_k3": -1e-4},
    "CENTRAL_CYLINDRICAL": {"central_cylindrical_range_u_min": -3, "central_cylindrical_range_u_max": 2,
                            "central_cylindrical_radius": 1.2},
}  # fmt: skip


@pytest.mark.parametrize("kind", PANORAMAS)
def test_panoramas_show_stars_where_they_look_at_them(kind):
    """At the points of the image whose rays lead there, with the solid angle that a triangle of rays spans."""
    scene = new_scene()
    scene.set_camera(kind, look_at(EYE, (3, 1, 2)), (-0.1, 0.9, 0.05, 1.1), **PANORAMAS[kind])
    scene.commit()
    points, step = np.random.default_rng(4).uniform(0.02, 0.98, (300, 2)), 1e-5
    corners = [scene.camera_rays(points + step * np.array(offset)).directions for offset in ((0, 0), (1, 0), (0, 1))]
    seen = np.isfinite(corners).all(axis=(0, 2))
    assert seen.sum() > 150
    points, (here, right, above) = points[seen], [corner[seen] for corner in corners]
    images = scene.find_stars(here, (64, 48), margin=0)
    found = np.abs(images.place - points[images.star]).max(axis=1) < 1e-6
    assert sorted(images.star[found]) == list(range(len(points)))
    assert np.abs(scene.camera_rays(images.place).directions - here[images.star]).max() < 1e-6  # all other places too
    star = images.star[found]
    area = np.linalg.norm(np.cross(right - here, above - here), axis=1)[star] / step**2
    np.testing.assert_allclose(images.solid_angle[found], area, rtol=2e-3)


def test_a_full_panorama_has_what_is_at_its_seam_on_both_sides():
    """As path tracing does, whose filter reaches beyond the edge of the picture."""
    scene = new_scene()
    scene.set_camera("EQUIRECTANGULAR", IDENTITY, (0, 1, 0, 1))
    scene.commit()
    behind = unit(np.array([[0.001, 0.2, 1], [0.3, 0.2, 1]]))  # the camera looks along -z, +x is at its right
    images = scene.find_stars(behind, (100, 50), margin=1.5)
    assert list(images.star) == [0, 0, 1]
    beside = np.arctan2(0.001, 1) / (2 * np.pi)
    np.testing.assert_allclose(sorted(images.place[:2, 0]), [-beside, 1 - beside], atol=1e-12)


@pytest.mark.parametrize("fov", [3.0, 9.0])
def test_a_fisheye_of_more_than_a_turn_shows_stars_again(fov):
    scene = new_scene()
    scene.set_camera("FISHEYE_EQUIDISTANT", IDENTITY, (0, 1, 0, 1), fisheye_fov=fov)
    scene.commit()
    images = scene.find_stars([(0.5, 0, -1)], (64, 64))
    angle = np.arctan2(0.5, 1)
    expected = [0.5 + angle / fov] + ([0.5 - (2 * np.pi - angle) / fov] if fov > 6 else [])
    expected = [x for x in expected if abs(x - 0.5) <= 0.5]
    np.testing.assert_allclose(images.place[:, 0], expected, atol=1e-9)


def test_the_middle_of_a_fisheye_shows_a_star_once():
    scene = new_scene()
    scene.set_camera("FISHEYE_EQUIDISTANT", IDENTITY, (0, 1, 0, 1), fisheye_fov=3.0)
    images = committed(scene).find_stars([(0, 0, -1)], (64, 64))
    assert len(images) == 1 and (images.place == 0.5).all()
