"""Light traced from lamps and from the camera: the same mean as from the camera alone, whatever bends the rays."""

import meshes
import numpy as np
import pytest
from bentlight_native import RenderSettings, Spacetime, light_image
from scenes import add, diffuse, emission, glass, glossy, look_at, material, new_scene, perspective, quad
from test_join_lenses import MOUTHS, box
from test_render_curved import placed

SIZE = 16
GRAY = diffuse((0.7, 0.7, 0.7))
BOUNCES = {"max_bounces": 3, "diffuse_bounces": 9, "glossy_bounces": 9, "transmission_bounces": 9, "roulette_start": 2}


def lamp(scene, color, half, at, **instance):
    """A square that shines on both of its sides."""
    add(scene, quad(half, half), emission(color), at=at, **instance)


def room(ball=GRAY, spacetime=None):
    """A closed room with a ball, a block and a lamp under its ceiling; a hole in its middle."""
    scene = new_scene()
    add(scene, meshes.box((-2, -2, -2), (2, 2, 2)), GRAY)
    add(scene, meshes.sphere(0.6, segments=24, rings=12), ball, at=placed(-0.8, 0.5, -1.3))
    add(scene, meshes.box((0.4, -0.6, -2), (1.1, 0.2, -0.8)), diffuse((0.2, 0.5, 0.8)))
    lamp(scene, (5, 4, 3), 0.5, placed(0.3, 0.4, 1.6))
    if spacetime is not None:
        scene.set_spacetime(spacetime, placed(0.3, 0.6, 0.1))
    perspective(scene, look_at((0, -1.9, 0.2), (0, 1.9, -0.2)))
    scene.commit()
    return scene


def picture(scene, samples, seed, size=SIZE, tiles=None, **settings):
    """(size, size, 3) by either integrator."""
    settings = RenderSettings(size, size, sample_count=samples, seed=seed, **(BOUNCES | settings))
    light, combined, taken = np.zeros((size, size, 3), np.int64), np.zeros((size, size, 4), np.float32), 0
    for x, y, w, h in tiles or [(0, 0, size, size)]:
        part = {"combined": np.zeros((h, w, 4), np.float32)}
        taken += scene.render_tile(x, y, w, h, settings, part, light=light).samples
        combined[y : y + h, x : x + w] = part["combined"]
    return combined[..., :3] + light_image(light, taken)


def pictures(scene, samples, seeds, **settings):
    return np.array([picture(scene, samples, seed, **settings) for seed in range(seeds)], float)


def assert_equal_means(a, b, error_max=0.02):
    """Z-tests of the whole picture and of its sixteenths over independent pictures (n, SIZE, SIZE, 3), which must tell
    the whole one to a relative error_max."""

    def parts(p):
        blocks = p.reshape(len(p), 4, SIZE // 4, 4, SIZE // 4, 3).mean(axis=(2, 4, 5)).reshape(len(p), -1)
        return np.concatenate([blocks, blocks.mean(axis=1, keepdims=True)], axis=1)

    a, b = parts(a), parts(b)
    error = np.sqrt(a.var(axis=0, ddof=1) / len(a) + b.var(axis=0, ddof=1) / len(b))
    assert error[-1] < error_max * a.mean(), "too noisy to tell"
    # A hole's middle gets light by the filter's outermost millionths only, which path tracing hardly ever samples.
    z = (a.mean(axis=0) - b.mean(axis=0)) / np.maximum(error, 1e-5 * a.mean())
    assert (np.abs(z) < 4.5).all(), z


BALLS = {
    "diffuse": GRAY,
    "metal": glossy((0.9, 0.9, 0.9), 0.4),
    "mirror": glossy((0.9, 0.9, 0.9), 0.0),
    "glass": glass((0.9, 0.9, 0.9), 0.0, 1.5),
    "frosted": glass((0.9, 0.9, 0.9), 0.5, 1.5),
    "flesh": ("subsurface", (0.9, 0.6, 0.3), (2.0, 1.0, 0.5), 1.0, 1.4, 0.5, 0.0, (0, 0, 0), ["RANDOM_WALK"]),
}


@pytest.mark.parametrize("ball", BALLS)
def test_flat_room(ball):
    scene = room(BALLS[ball])
    both = pictures(scene, 16, 16, integrator="BIDIRECTIONAL")
    assert_equal_means(both, pictures(scene, 64, 16))


@pytest.mark.parametrize("chart", ["isotropic", "areal"])
def test_room_around_a_hole(chart):
    """Without the ratio of frequencies on each arc light tracing is wrong here."""
    scene = room(spacetime=Spacetime.schwarzschild(0.15, chart=chart))
    both = pictures(scene, 8, 16, integrator="BIDIRECTIONAL")
    assert_equal_means(both, pictures(scene, 32, 16))


def test_a_lamp_near_the_horizon():
    """Between the lamp and the walls the square of the ratio of frequencies is about 8."""
    scene = new_scene()
    scene.set_spacetime(Spacetime.schwarzschild(0.3))
    add(scene, meshes.box((-2, -2, -2), (2, 2, 2)), GRAY)
    add(scene, meshes.sphere(0.08, segments=16, rings=8), emission((40, 32, 24)), at=placed(0.2, 0.0, 0.25))
    perspective(scene, look_at((-1.5, -1.7, 0.9), (-1.5, 1, 0.9)))
    scene.commit()
    both = pictures(scene, 8, 16, integrator="BIDIRECTIONAL")
    assert_equal_means(both, pictures(scene, 32, 16))


def rooms_of_a_wormhole():
    """The camera in one room, the lamp in another, and nothing but the wormhole between."""
    scene = new_scene()
    scene.set_spacetime_objects(MOUTHS)
    for _, at, *_ in MOUTHS:
        add(scene, box(4.0), GRAY, at=at)
    add(scene, meshes.sphere(1.0, segments=16, rings=8), emission((10, 8, 6)), at=placed(20, 2.5, 1))
    perspective(scene, look_at((0, -3.5, 1.5), (0, 3.9, 0)))
    scene.commit()
    return scene


def test_room_lit_through_a_wormhole():
    scene = rooms_of_a_wormhole()
    assert scene.bidirectional_obstacle() is None
    both = pictures(scene, 32, 16, integrator="BIDIRECTIONAL", max_bounces=2)
    assert_equal_means(both, pictures(scene, 64, 16, max_bounces=2))


def test_room_around_two_holes():
    """Each in its own sphere, with surfaces inside the spheres."""
    scene = new_scene()
    add(scene, meshes.box((-2, -2, -2), (2, 2, 2)), GRAY)
    lamp(scene, (5, 4, 3), 0.5, placed(0.3, 0.4, 1.6))
    holes = [("isotropic", placed(-0.7, 0.6, 0.1), 0.6), ("areal", placed(0.9, 0.8, 0.1), 0.7)]
    scene.set_spacetime_objects([(Spacetime.schwarzschild(0.1, chart=c), at, radius, -1) for c, at, radius in holes])
    for x, y, radius in ((-0.9, 0.2, 0.15), (0.9, 0.35, 0.2)):
        add(scene, meshes.sphere(radius, segments=16, rings=8), GRAY, at=placed(x, y, 0.1))
    perspective(scene, look_at((0, -1.9, 0.2), (0, 1.9, -0.2)))
    scene.commit()
    both = pictures(scene, 8, 16, integrator="BIDIRECTIONAL")
    assert_equal_means(both, pictures(scene, 32, 16))


WAYS = [("BIDIRECTIONAL", "BOTH"), ("PATH", "CONNECTIONS"), ("PATH", "SCATTERING")]
ROOMS = {  # and samples of each way
    "flat": (room, (16, 32, 128)),
    "hole": (lambda: room(spacetime=Spacetime.schwarzschild(0.15)), (16, 32, 128)),
    "wormhole": (rooms_of_a_wormhole, (24, 48, 256)),
}


@pytest.mark.unsanitized
@pytest.mark.parametrize("name", ROOMS)
def test_chance_alone_finds_the_same_light(name):
    """And so do connections alone."""
    build, samples = ROOMS[name]
    scene = build()
    found = [
        pictures(scene, n, 16, integrator=integrator, light_sampling=sampling, max_bounces=2)
        for (integrator, sampling), n in zip(WAYS, samples, strict=True)
    ]
    for i in range(3):
        assert_equal_means(found[i], found[i - 1], error_max=0.03)


HEIGHT = 2.0  # of the lamp below


def floor_below_a_lamp(closure, at):
    """A white floor, of which the camera sees the square |x|, |y| < 1/4, a quad, and a point lamp of intensity pi."""
    scene = new_scene()
    add(scene, quad(3, 3), diffuse((1, 1, 1)))
    add(scene, quad(2, 2), closure, at=at)
    scene.set_lamps(placed(0, 0, HEIGHT)[None], scene.add_material(material(emission((np.pi,) * 3))))
    perspective(scene, look_at((0, 0, 0.5), (0, 0, 0), up=(0, 1, 0)))
    scene.commit()
    return scene


def assert_floor(scene, irradiance):
    """That the floor has the radiance irradiance(x, y) / pi, on average."""
    x, y = np.meshgrid(*2 * [(np.arange(64) + 0.5) / 128 - 0.25])
    exact = irradiance(x, y).mean() / np.pi
    settings = {"size": 8, "filter": "BOX", "max_bounces": 1}
    values = pictures(scene, 384, 12, integrator="BIDIRECTIONAL", **settings)[..., 0].mean(axis=(1, 2))
    error = values.std(ddof=1) / np.sqrt(len(values))
    assert error < 0.01 * exact
    assert abs(values.mean() - exact) < 4.5 * error


def test_a_mirror_shows_the_floor_its_lamp():
    """A mirror at x = 1 is a second lamp at x = 2, which no path from the camera finds."""

    def lamp_above(x, y):
        return np.pi * HEIGHT / (x * x + y * y + HEIGHT**2) ** 1.5

    mirror = np.array([[0, 0, -1, 1], [0, 1, 0, 0], [1, 0, 0, 0], [0, 0, 0, 1.0]])
    scene = floor_below_a_lamp(glossy((1, 1, 1), 0.0), mirror)
    assert_floor(scene, lambda x, y: lamp_above(x, y) + lamp_above(x - 2, y))


def test_light_below_water():
    """Under a smooth surface: Snell and Fresnel, and radiance not scaled by n^2, as paths from the camera have it."""
    n, depth = 1.4, 1.0
    scene = floor_below_a_lamp(glass((1, 1, 1), 0.0, n), placed(0, 0, depth))
    assert (picture(scene, 16, 0) == 0).all()
    above = np.linspace(1e-6, 0.4, 4096)  # angles
    below = np.arcsin(np.sin(above) / n)
    a, b = np.cos(above), np.cos(below)
    reflected = (((a - n * b) / (a + n * b)) ** 2 + ((b - n * a) / (b + n * a)) ** 2) / 2
    radius = (HEIGHT - depth) * np.tan(above) + depth * np.tan(below)
    flux = np.pi * (1 - reflected) * np.sin(above) / (radius * np.gradient(radius, above))
    assert_floor(scene, lambda x, y: np.interp(np.hypot(x, y), radius, flux / n**2))


def test_tiles_threads_and_ranges_do_not_matter():
    scene = room(BALLS["frosted"])
    whole = picture(scene, 4, 0, integrator="BIDIRECTIONAL")
    tiles = [(8, 0, 8, 16), (0, 0, 8, 5), (0, 5, 8, 11)]
    np.testing.assert_array_equal(picture(scene, 4, 0, tiles=tiles, integrator="BIDIRECTIONAL"), whole)
    parts = [picture(scene, 2, 0, first_sample=first, integrator="BIDIRECTIONAL") for first in (0, 2)]
    np.testing.assert_allclose(np.mean(parts, axis=0), whole, rtol=1e-5, atol=1e-7)


def test_settings_that_do_not_fit_are_errors():
    scene = room()
    with pytest.raises(ValueError, match="light_sampling BOTH"):
        picture(scene, 1, 0, integrator="BIDIRECTIONAL", light_sampling="SCATTERING")
    settings = RenderSettings(SIZE, SIZE, integrator="BIDIRECTIONAL")
    with pytest.raises(ValueError, match="needs the array `light`"):
        scene.render_tile(0, 0, SIZE, SIZE, settings, {})
    with pytest.raises(ValueError, match="light: expected int64"):
        scene.render_tile(0, 0, SIZE, SIZE, settings, {}, light=np.zeros((SIZE, SIZE, 3), np.float32))


def test_a_spinning_hole_is_an_obstacle():
    """Then the picture is that of path tracing."""
    scene = room(spacetime=Spacetime.kerr(0.15, 0.1))
    assert scene.bidirectional_obstacle() == "a black hole spins"
    np.testing.assert_array_equal(picture(scene, 2, 0, integrator="BIDIRECTIONAL"), picture(scene, 2, 0))
    assert room(spacetime=Spacetime.schwarzschild(0.15)).bidirectional_obstacle() is None
