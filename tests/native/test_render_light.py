"""Light transport in flat space against closed forms: exactly where the estimate has no variance, else by a Z-test."""

import meshes
import numpy as np
import pytest
from scenes import (
    add,
    diffuse,
    emission,
    glass,
    glossy,
    look_at,
    material,
    new_scene,
    perspective,
    quad,
    render,
    transparent,
)

GRAY = (0.5, 0.5, 0.5)
BY_CHANCE = {"light_sampling": "SCATTERING"}  # where each path's light is exact, but not how lights are drawn


def z_score(estimates, exact):
    """Deviation of independent estimates' mean from `exact`, in its standard errors."""
    estimates = np.asarray(estimates, float).ravel()
    return (estimates.mean() - exact) / (estimates.std(ddof=1) / np.sqrt(estimates.size))


def point_radiance(scene, samples, seeds, **settings):
    """Red radiance along a hair-thin camera's view: one independent estimate for each seed."""
    return [
        float(render(scene, 1, 1, samples, names=("combined",), seed=s, **settings)[0]["combined"][0, 0, 0])
        for s in range(seeds)
    ]


def inside_sphere(*closures):
    scene = new_scene()
    add(scene, meshes.sphere(), *closures)
    perspective(scene, look_at((0.3, 0.2, 0.1), (0, 0, 0)))
    return scene


def test_furnace_is_exact():
    """Albedo 1/2, emission 1/2, closed: every path gives 1/2 + 1/4 + ... = 1, without variance."""
    scene = inside_sphere(diffuse(GRAY), emission(GRAY))
    scene.commit()
    channels, _ = render(scene, samples=4, max_bounces=60, diffuse_bounces=60, roulette_start=60, **BY_CHANCE)
    assert (channels["combined"] == 1).all()
    assert (channels["emission"] == 0.5).all()


def test_furnace_of_many_lobes():
    """The same with the albedo cut into 300 lobes."""
    scene = inside_sphere(*[diffuse(np.divide(GRAY, 300))] * 300, emission(GRAY))
    scene.commit()
    channels, _ = render(scene, 4, 4, samples=2, max_bounces=60, diffuse_bounces=60, roulette_start=60, **BY_CHANCE)
    np.testing.assert_allclose(channels["combined"][..., :3], 1, rtol=1e-6)


def test_furnace_with_roulette():
    scene = inside_sphere(diffuse((0.8, 0.8, 0.8)), emission((0.2, 0.2, 0.2)))
    scene.commit()
    channels, _ = render(scene, 32, 32, 64, max_bounces=200, diffuse_bounces=200, roulette_start=2)
    values = channels["combined"][..., 0]
    assert values.std() > 0
    assert abs(z_score(values, 1)) < 4


@pytest.mark.parametrize("bounces", [0, 1, 3])
@pytest.mark.parametrize("limit", ["max_bounces", "diffuse_bounces"])
def test_bounces_are_counted_as_cycles_does(bounces, limit):
    """n bounces: emission of n + 2 surfaces; a path may scatter n + 1 times and then only gathers."""
    scene = inside_sphere(diffuse(GRAY), emission(GRAY))
    scene.commit()
    limits = {"max_bounces": 100, "diffuse_bounces": 100, "roulette_start": 100, limit: bounces}
    channels, _ = render(scene, samples=2, **limits, **BY_CHANCE)
    assert (channels["combined"][..., :3] == 1 - 0.5 ** (bounces + 2)).all()
    for sampling in ("CONNECTIONS", "BOTH"):
        values = render(scene, 32, 32, 16, names=("combined",), light_sampling=sampling, **limits)[0]["combined"][
            ..., 0
        ]
        assert abs(z_score(values, 1 - 0.5 ** (bounces + 2))) < 4, sampling


def test_clamp_direct():
    """Light seen directly or scattered once is cut, the rest is not: min(2^-k, 0.3) for k = 1, 2, then 2^-k."""
    scene = inside_sphere(diffuse(GRAY), emission(GRAY))
    scene.commit()
    channels, _ = render(scene, samples=2, max_bounces=3, clamp_direct=0.3, roulette_start=9, **BY_CHANCE)
    assert channels["combined"][..., 0] == pytest.approx(0.3 + 0.25 + 2**-3 + 2**-4 + 2**-5, rel=1e-6)


def test_clamp_indirect():
    """Contributions after the second scattering are cut: 1/2 + 1/4 + 3 times min(2^-k, 0.05), k = 3, 4, 5."""
    scene = inside_sphere(diffuse(GRAY), emission(GRAY))
    scene.commit()
    channels, _ = render(scene, samples=2, max_bounces=3, clamp_indirect=0.05, roulette_start=9, **BY_CHANCE)
    assert channels["combined"][..., 0] == pytest.approx(0.75 + 0.05 + 0.05 + 2**-5, rel=1e-6)


def test_convex_object_under_an_even_sky():
    """A convex diffuse body of albedo 0.8 under a sky of 1 is 0.8 all over."""
    scene = new_scene((1, 1, 1))
    add(scene, meshes.box((-1, -1, -1), (1, 1, 1)), diffuse((0.8, 0.4, 0.2)))
    perspective(scene, look_at((3, 2, 1.5), (0, 0, 0)), half=0.15)
    scene.commit()
    channels, _ = render(scene, samples=4)
    assert channels["combined"][..., :3] == pytest.approx(np.full((16, 16, 3), (0.8, 0.4, 0.2)), rel=1e-6)


def test_glass_under_an_even_sky_keeps_its_light():
    """A smooth dielectric neither adds nor takes light in the mean; its fainter way is drawn more often than it takes
    light. Total reflection holds some paths for thousands of bounces.
    """
    scene = new_scene((1, 1, 1))
    add(scene, meshes.sphere(segments=64, rings=32), glass((1, 1, 1), 0.0, 1.5))
    perspective(scene, look_at((4, 0, 0), (0, 0, 0)), half=0.2)
    scene.commit()
    many = dict.fromkeys(("max_bounces", "glossy_bounces", "transmission_bounces", "roulette_start"), 15000)
    means = [render(scene, samples=16, seed=seed, **many)[0]["combined"][..., 0].mean() for seed in range(16)]
    error = np.std(means, ddof=1) / np.sqrt(len(means))
    assert error < 1e-3
    assert abs(np.mean(means) - 1) < 5 * error


def test_integrating_sphere():
    """Ulbricht's sphere: with emission L_e on the fraction f of a diffuse sphere's wall, of albedo rho all over, the
    wall that does not emit has radiance rho f L_e / (1 - rho). Multiple scattering between unequal parts."""
    scene, rho = new_scene(), 0.6
    vertices, triangles = meshes.sphere(segments=128, rings=64)
    corners = vertices[triangles].astype(float)
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    bright = corners[:, :, 2].mean(1) < -0.5
    wall, lamp = diffuse((rho,) * 3), emission((1, 1, 1), 3.0)
    materials = [scene.add_material(material(wall)), scene.add_material(material(wall, lamp))]
    mesh = scene.add_mesh(vertices, triangles, material_slots=bright.astype(np.uint32))
    scene.add_instance(mesh, np.eye(4), materials=np.array(materials, np.int32))
    perspective(scene, look_at((0, 0, 0), (0, 0.2, 1)), half=0.3)
    scene.commit()
    channels, _ = render(scene, 16, 16, 256, max_bounces=50, diffuse_bounces=50, roulette_start=5)
    expected = rho * (area[bright].sum() / area.sum()) * 3.0 / (1 - rho)
    assert abs(z_score(channels["combined"][..., 0], expected)) < 4


@pytest.mark.parametrize("tilt", [0.0, 0.9])
@pytest.mark.parametrize("angle", [0.2, 0.8])
def test_sun_irradiance(angle, tilt):
    """A plane that sees the whole disk: E = pi sin^2(angle / 2) cos(tilt) L, and its radiance albedo E / pi."""
    scene = new_scene()
    scene.set_suns([(np.sin(tilt), 0, np.cos(tilt))], [(7, 5, 3)], angle)
    add(scene, quad(), diffuse(GRAY))
    perspective(scene, look_at((0, -1, 2), (0, 0, 0)), half=1e-3)
    scene.commit()
    exact = 0.5 * np.sin(angle / 2) ** 2 * np.cos(tilt) * 7
    assert abs(z_score(point_radiance(scene, 4096, 100), exact)) < 4


def test_sun_disk_seen_by_the_camera():
    """Its solid angle, its edge, and rays that must not see it."""
    scene, angle = new_scene((0, 0, 0.25)), 0.3
    at = look_at((0, 0, 0), (0, 1, 0))
    perspective(scene, at, half=np.tan(angle))
    for visibility, seen in [(15, 1), (14, 0)]:
        scene.set_suns([(0, 5, 0)], [(2, 0, 0)], angle, visibility)
        scene.commit()
        channels, _ = render(scene, 64, 64, 64, filter="BOX")
        red, blue = channels["environment"][..., 0], channels["combined"][..., 2]
        covered = red.mean() / 2  # of the square of half width tan(angle), by a circle of radius tan(angle / 2)
        circle = np.pi * np.tan(angle / 2) ** 2 / (2 * np.tan(angle)) ** 2
        assert covered == pytest.approx(seen * circle, abs=seen * 3e-4)
        assert (blue == 0.25).all()


def rectangle_factor(a, b, h):
    """Configuration factor from a point under the center of a parallel rectangle of half sides a, b at height h
    (Howell, catalog of radiation configuration factors, B-4): four times the factor under a corner."""
    x, y = a / h, b / h
    corner = x / np.hypot(1, x) * np.arctan(y / np.hypot(1, x)) + y / np.hypot(1, y) * np.arctan(x / np.hypot(1, y))
    return 4 * corner / (2 * np.pi)


@pytest.mark.parametrize("a, b, h", [(0.5, 0.3, 1.0), (2.0, 1.0, 0.5)])
def test_area_light_irradiance(a, b, h):
    """Under a one-sided light: radiance albedo F L. The light hangs face down; turned over it gives nothing."""
    for flip, seen in [(-1, 1), (1, 0)]:
        scene = new_scene()
        add(scene, quad(4, 4), diffuse(GRAY))
        light = np.diag([1.0, flip, flip, 1.0])
        light[2, 3] = h
        add(scene, quad(a, b), emission((1, 1, 1), 6.0), at=light, one_sided=True)
        perspective(scene, look_at((0, -3.0, 0.4 * h), (0, 0, 0)), half=1e-4)
        scene.commit()
        values = point_radiance(scene, 1024, 100 if seen else 1, max_bounces=0)
        if seen:
            assert abs(z_score(values, 0.5 * rectangle_factor(a, b, h) * 6)) < 4
        else:
            assert values == [0]


def test_camera_sees_through_the_back_of_a_one_sided_surface():
    scene = new_scene((0, 0, 1))
    add(scene, quad(), emission((1, 0, 0)), one_sided=True)
    for z, color in [(2.0, (1, 0, 0, 1)), (-2.0, (0, 0, 1, 1))]:
        perspective(scene, look_at((0.1, 0, z), (0, 0, 0), up=(0, 1, 0)), half=0.2)
        scene.commit()
        channels, _ = render(scene, samples=1)
        assert (channels["combined"] == color).all()
        assert (channels["fate"] == (4 if z > 0 else 1)).all()


def test_transparent_surfaces_multiply_and_are_counted_apart():
    scene = new_scene((1, 1, 1))
    for i in range(5):
        at = np.eye(4)
        at[2, 3] = i
        add(scene, quad(9, 9), transparent((0.5, 0.5, 0.5)), at=at)
    perspective(scene, look_at((0, 0, 9), (0, 0, 0), up=(0, 1, 0)), half=0.2)
    scene.commit()
    channels, _ = render(scene, samples=1, max_bounces=0, transparent_bounces=5)
    assert (channels["combined"] == (2**-5, 2**-5, 2**-5, 1)).all()
    channels, _ = render(scene, samples=1, max_bounces=0, transparent_bounces=4)
    assert (channels["combined"] == (0, 0, 0, 1)).all()
    channels, _ = render(scene, samples=1, transparent_bounces=5, film_transparent=True)
    assert (channels["combined"] == (0, 0, 0, 1 - 2**-5)).all()
    assert (channels["environment"] == 2**-5).all()


def test_film_transparent():
    """The sky is cut out of what the camera sees, and still lights the scene."""
    scene = new_scene((1, 1, 1))
    add(scene, meshes.box((-1, -1, -1), (1, 1, 1)), diffuse(GRAY))
    perspective(scene, look_at((6, 0, 0), (0, 0, 0)), half=0.4)
    scene.commit()
    channels, _ = render(scene, 32, 32, 16, film_transparent=True)
    combined, alpha = channels["combined"], channels["combined"][..., 3]
    assert (combined[0, 0] == 0).all() and (combined[16, 16] == (0.5, 0.5, 0.5, 1)).all()
    assert combined[..., 0] == pytest.approx(0.5 * alpha)  # premultiplied at the edges too
    assert ((alpha > 0) & (alpha < 1)).any()


@pytest.mark.parametrize("kind, bit", [("camera", 1), ("diffuse", 2), ("glossy", 4), ("transmission", 8)])
def test_visibility_by_kind_of_ray(kind, bit):
    """A lamp that lacks one bit is invisible to that kind of ray, and to no other."""
    first = {
        "diffuse": diffuse((1, 1, 1)),
        "glossy": glossy((1, 1, 1), 0.0),
        "transmission": glass((1, 1, 1), 0.0, 1.0),
    }
    for mask, seen in [(15 - bit, False), (bit, True)]:
        scene = new_scene()
        add(scene, meshes.sphere(5), emission((1, 1, 1)), visibility=mask)
        if kind != "camera":
            add(scene, quad(), first[kind], visibility=1)
        perspective(scene, look_at((0, -1, 1), (0, 0, 0)), half=0.1)
        scene.commit()
        channels, _ = render(scene, samples=4, max_bounces=0, **BY_CHANCE)
        assert channels["combined"][..., 0] == pytest.approx(1.0 if seen else 0.0, abs=1e-12), (kind, mask)
        values = render(scene, 32, 32, 16, names=("combined",), max_bounces=0)[0]["combined"][..., 0]
        assert abs(z_score(values, 1)) < 4 if seen and kind == "diffuse" else (values == seen).all(), (kind, mask)


def test_pixel_filter_is_what_a_straight_edge_shows():
    """Beyond an edge at distance x from its center a pixel sees 1 - (the filter's integral up to x). Samples are
    stratified in x, so the mean of 4096 is off by less than two strata."""
    scene = new_scene()
    add(scene, quad(10, 10), emission((1, 1, 1)), at=[[1, 0, 0, 10], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1.0]])
    at = look_at((0, 0, 5), (0, 0, 0), up=(0, 1, 0))
    t = np.linspace(-1, 1, 20001)[:-1] + 5e-5
    for kind, width, density in [
        ("BOX", 1.0, np.ones_like(t)),
        ("GAUSSIAN", 2.5, np.exp(-18 * t**2)),
        (
            "BLACKMAN_HARRIS",
            1.5,
            0.35875 + 0.48829 * np.cos(np.pi * t) + 0.14128 * np.cos(2 * np.pi * t) + 0.01168 * np.cos(3 * np.pi * t),
        ),
    ]:
        for x in (-0.4, -0.1, 0.0, 0.25):
            scene.set_camera("ORTHOGRAPHIC", at, (-0.5 - x, 0.5 - x, -0.5, 0.5))  # one pixel, one unit wide
            scene.commit()
            channels, _ = render(scene, 1, 1, 4096, filter=kind, filter_width=width)
            expected = density[t * width / 2 > x].sum() / density.sum()
            assert abs(channels["combined"][0, 0, 0] - expected) < 2 / 4096 + 1e-4, (kind, x)
