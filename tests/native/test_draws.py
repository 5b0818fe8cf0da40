"""Chi-square tests of what is drawn for the camera, suns, light subpaths, directions through mouths of wormholes, of
which connections are listed, and of Russian roulette.

Others: the sampler (test_sampler.py), lobes (test_bsdf.py, test_subsurface.py), walks below surfaces
(test_walk_draws.py), the choice of lights, places on them and directions of the sky (test_direct_light.py).
"""

import meshes
import numpy as np
import pytest
from bentlight_native import Spacetime
from bsdf_tools import Grid, chi_square_z, direction, glossy, material
from bsdf_tools import diffuse as white
from bsdf_tools import glass as rough_glass
from scenes import add, diffuse, emission, glass, look_at, new_scene, perspective, quad, render
from test_direct_light import add_lamps, patch_radiance, placed
from test_join_lenses import box
from test_portal import glowing_room, open_mouth

DRAWS = 100000


def cells(*coordinates, counts):
    """How many points lie in each cell of the unit cube cut into equal parts."""
    index = [np.clip((c * n).astype(int), 0, n - 1) for c, n in zip(coordinates, counts, strict=True)]
    return np.bincount(np.ravel_multi_index(index, counts), minlength=np.prod(counts))


def uniform_z(*coordinates, counts):
    """The deviate of points that should be even in the unit cube."""
    observed = cells(*coordinates, counts=counts)
    return chi_square_z(observed, np.full(observed.size, observed.sum() / observed.size))


# Densities by |offset| / half width, 0 to 1: Harris 1978 for the four-term window.
FILTERS = {
    "BOX": lambda t: np.ones_like(t),
    "GAUSSIAN": lambda t: np.exp(-18 * t**2),
    "BLACKMAN_HARRIS": lambda t: (
        0.35875 + 0.48829 * np.cos(np.pi * t) + 0.14128 * np.cos(2 * np.pi * t) + 0.01168 * np.cos(3 * np.pi * t)
    ),
}


@pytest.mark.parametrize(("kind", "width"), [("BOX", 1.0), ("GAUSSIAN", 3.0), ("BLACKMAN_HARRIS", 2.2)])
@pytest.mark.parametrize("pattern", ["BLUE_NOISE", "CLASSIC"])
def test_places_in_the_pixel_filter(kind, width, pattern):
    """Where the first camera rays of 96 x 96 pixels and two seeds meet a wall, in pixels, by the cumulative
    distribution of the filter: even over the unit square. In the blue-noise pattern they are evener than that."""
    size = 96
    scene = new_scene()
    add(scene, quad(3, 3), emission((1, 1, 1)))
    perspective(scene, look_at((0, 0, 2), (0, 0, 0), up=(0, 1, 0)), half=0.5)
    scene.commit()
    fine = (np.arange(4096) + 0.5) / 4096
    half = np.cumsum(FILTERS[kind](fine))
    numbers = []
    for seed in (0, 1):
        settings = {"filter": kind, "filter_width": width, "sampling_pattern": pattern, "seed": seed}
        position = render(scene, size, size, 1, names=("position",), **settings)[0]["position"].astype(float)
        center = np.arange(size) + 0.5
        for axis, middle in ((0, center[None, :]), (1, center[:, None])):
            offset = (position[..., axis] / 2 + 0.5) * size - middle  # the image is 2 units wide at distance 2
            share = np.interp(np.abs(offset) / (width / 2), fine, half / half[-1])
            assert np.abs(offset).max() <= width / 2 * (1 + 1e-4)
            numbers.append(0.5 + np.sign(offset).ravel() * share.ravel() / 2)
    x, y = np.concatenate(numbers[::2]), np.concatenate(numbers[1::2])
    z = uniform_z(x, y, counts=(12, 12))
    assert z < 4 and (pattern == "BLUE_NOISE" or z > -4)


@pytest.mark.parametrize("angle", [0.01, 0.5, 3.0, np.pi])
def test_directions_towards_a_sun(angle):
    """Even over its disk: 1 - cosine to its middle, which grows like the solid angle (Archimedes), and the turn."""
    scene, rng = new_scene(), np.random.default_rng(3)
    axis = np.array([0.3, -0.5, 0.81])
    axis /= np.linalg.norm(axis)
    scene.set_suns([axis], [(1, 1, 1)], angle)
    scene.commit()
    u = rng.random((DRAWS, 4))
    which, direction, _ = scene.draw_lights(np.zeros((DRAWS, 3)), np.zeros((DRAWS, 3)), u)
    assert (which[:, 0] == 2).all()
    chord2 = ((direction - axis) ** 2).sum(axis=1)  # 2 (1 - cosine)
    share = chord2 / (4 * np.sin(angle / 4) ** 2)
    x = np.cross(axis, (1, 0, 0))
    x /= np.linalg.norm(x)
    turn = np.arctan2(direction @ np.cross(axis, x), direction @ x) / (2 * np.pi) % 1
    assert share.max() < 1 + 1e-9
    assert abs(uniform_z(share, turn, counts=(16, 16))) < 4


def subpath_scene():
    """A ball that shines all around, a square that shines to one side, and a lamp without size."""
    scene = new_scene()
    add(scene, meshes.sphere(0.5, segments=8, rings=4), emission((1, 1, 1)), at=placed(2, 0, 0))
    tilted = np.array([[0.6, 0, 0.8, 0], [0, 2, 0, 0], [-0.8, 0, 0.6, 1], [0, 0, 0, 1.0]])
    add(scene, quad(), emission((3, 3, 3)), at=tilted, one_sided=1)
    add_lamps(scene, (-1, 0, 0), intensity=2.0)
    scene.commit()
    return scene, tilted


def test_starts_of_light_subpaths():
    """Triangles and the lamp by their chances, which sum up to 1 and go like the flux of triangles; places on the
    square even over its area; directions by the cosine to its normal, on its front alone; of the lamp all alike."""
    scene, tilted = subpath_scene()
    u = np.random.default_rng(4).random((DRAWS, 6))
    which, place, direction, probability = scene.draw_light_starts(u)
    rows, first, number = np.unique(which, axis=0, return_index=True, return_inverse=True)
    chance = probability[first, 0]
    assert chance.sum() == pytest.approx(1)
    assert abs(chi_square_z(np.bincount(number.ravel()), DRAWS * chance)) < 4
    square = (which[:, 0] == 0) & (which[:, 1] == 1)
    share = chance[(rows[:, 0] == 0) & (rows[:, 1] == 1)].sum()
    ball = chance[(rows[:, 0] == 0) & (rows[:, 1] == 0)].sum()
    vertices, triangles = meshes.sphere(0.5, segments=8, rings=4)
    a, b, c = (vertices[triangles[:, k]].astype(float) for k in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2
    assert share / ball == pytest.approx(3 * 8 / (2 * area), rel=1e-3)  # 2 x 4 square on one side; the ball on both
    x, y = ((place[square] - tilted[:3, 3]) @ tilted[:3, k] / (tilted[:3, k] @ tilted[:3, k]) for k in (0, 1))
    assert abs(uniform_z(x / 2 + 0.5, y / 2 + 0.5, counts=(16, 16))) < 4
    normal, along = tilted[:3, 2], tilted[:3, 0]
    cosine = direction[square] @ normal
    across = direction[square] @ along, direction[square] @ np.cross(normal, along)
    assert cosine.min() > 0 and probability[square, 1] == pytest.approx(cosine / np.pi, abs=1e-9)
    assert abs(uniform_z(cosine**2, np.arctan2(*across) / (2 * np.pi) + 0.5, counts=(16, 16))) < 4
    lamp = which[:, 0] == 1
    around = np.arctan2(direction[lamp, 1], direction[lamp, 0]) / (2 * np.pi) + 0.5
    assert probability[lamp, 1] == pytest.approx(1 / (4 * np.pi))
    assert abs(uniform_z(direction[lamp, 2] / 2 + 0.5, around, counts=(16, 16))) < 4


def test_directions_aimed_at_glass():
    """Half of a lamp's subpaths set out towards glass. Their densities say so: of 1 / density each of 16 x 16 equal
    parts of the sphere has the same sum."""
    scene = new_scene()
    add_lamps(scene, (0, 0, 0))
    add(scene, meshes.sphere(0.5, segments=24, rings=12), glass((1, 1, 1), 0.0, 1.5), at=placed(1.5, 0.4, 0.3))
    scene.commit()
    u = np.random.default_rng(8).random((DRAWS, 6))
    _, _, direction, probability = scene.draw_light_starts(u)
    density = probability[:, 1]
    towards = direction @ (1.5, 0.4, 0.3) / np.linalg.norm((1.5, 0.4, 0.3)) > np.cos(np.arcsin(0.5 / 1.58))
    assert abs(towards.mean() - 0.5) < 0.05 and density.min() > 0
    row = np.floor((direction[:, 2] + 1) * 8 * (1 - 1e-12))
    column = np.floor((np.arctan2(direction[:, 1], direction[:, 0]) / np.pi + 1) * 8 * (1 - 1e-12))
    sums, squares = (np.bincount((16 * row + column).astype(int), density**-k, 256) for k in (1, 2))
    z = (sums - DRAWS * 4 * np.pi / 256) / np.sqrt(squares - sums**2 / DRAWS)
    assert abs(z).max() < 5 and abs((z**2).mean() - 1) < 5 * np.sqrt(2 / 256)


def test_scenes_without_starts_are_errors():
    scene = new_scene((1, 1, 1))
    scene.commit()
    with pytest.raises(ValueError, match="no light starts anywhere"):
        scene.draw_light_starts(np.zeros((1, 6)))


# ---- Mouths of wormholes ----


def bright_room(closures):
    """A lone wormhole in a room that shines brighter than what is beyond."""
    scene = new_scene()
    scene.set_spacetime(Spacetime.ellis(0.5))
    add(scene, box(4.0), emission((5, 5, 5)))
    return scene


# Where a surface looks at mouths, and the room: at one mouth of a pair from outside its sphere and from within, at a
# lone one, and through it from beyond.
LOOKS = {
    "outside": (glowing_room, (-1, -2.5, 1.2)),
    "in its sphere": (glowing_room, (0.4, -1.0, 0.3)),
    "bent": (open_mouth, (1.1, 0.4, -1.5)),
    "beyond": (bright_room, (0.06, -0.1, 0.16)),
}
SURFACES = {
    "diffuse": (white(0.8),),
    "metal": (glossy(0.9, 0.7, distribution="GGX"),),
    "glass": (white(0.4), rough_glass(0.4, 0.8, 1.3, distribution="GGX")),
}


@pytest.mark.parametrize("surface", SURFACES)
@pytest.mark.parametrize("look", LOOKS)
def test_directions_through_mouths(look, surface):
    """Directions of the mixture of lobes and mouths by its density, which integrates to 1 with what is absorbed; and
    the weight that goes with a direction is the value over that density."""
    build, place = LOOKS[look]
    scene = build([])
    index = material(*SURFACES[surface], scene=scene)
    scene.commit()
    towards_center = -np.sign(place[2]) if look != "beyond" else 1.0
    normal = (0.0, 0.0, towards_center)
    point = {"position": place, "normal": normal, "geometric_normal": normal, "wo": direction(0.8, 0.5) * normal[2]}
    grid = Grid(rows=16, columns=16, fine=40)
    directions = grid.directions()
    value, pdf = scene.evaluate_bsdf(index, directions.reshape(-1, 3), portals=True, **point)
    lobes = scene.evaluate_bsdf(index, directions.reshape(-1, 3), **point)[1]
    mouths = 1 - np.min(pdf[lobes > 0] / lobes[lobes > 0])  # how often a mouth is drawn
    assert 0.01 < mouths < 0.76
    integral, absorbed = pdf.mean() * 4 * np.pi, 1 - lobes.mean() * 4 * np.pi
    assert integral == pytest.approx(mouths + (1 - mouths) * (1 - absorbed), abs=2e-3)
    drawn = scene.draw_bsdf(index, np.random.default_rng(9).random((DRAWS, 3)), portals=True, **point)
    kept = drawn.lobe != 0
    again, density = scene.evaluate_bsdf(index, drawn.wi[kept], portals=True, **point)
    np.testing.assert_allclose(drawn.pdf[kept], density, rtol=1e-12)
    np.testing.assert_allclose(drawn.weight[kept], again / density[:, None], rtol=1e-9, atol=1e-12)
    shines = (value > 0).any(axis=1)
    chance = np.where(shines, pdf, 0).reshape(directions.shape[:3]).mean(axis=2).ravel() * grid.cell
    observed = np.append(grid.count(drawn.wi[kept]), (~kept).sum())
    expected = np.append(chance, max(1 - chance.sum(), 0)) * DRAWS
    assert chi_square_z(observed, expected) < 4


# ---- Connections ----


@pytest.mark.parametrize("sky", [False, True])
@pytest.mark.parametrize(("a", "b"), [((2.5, 0, 0), (-1, 2.5, 1)), ((1, 0, 0), (-1, 2.5, 1))])
def test_images_are_listed_by_their_chances(a, b, sky):
    """One, two, or all: as often as the listed images say; what is left of the number that decides is even again."""
    scene = new_scene()
    scene.set_spacetime(Spacetime.schwarzschild(0.3))
    scene.commit()
    end = np.array(b) / np.linalg.norm(b) if sky else b
    full = scene.join([a], [end], sky=sky)
    chance, images = full["image_chance"][0], full["count"][0]
    assert images > 2 and chance[0] == 1 > chance[1] > chance[2] > 0
    u = np.random.default_rng(10).random(DRAWS)
    joints = scene.join(np.tile(a, (DRAWS, 1)), np.tile(end, (DRAWS, 1)), sky=sky, u=u)
    count, rest = joints["count"], joints["rest"]
    assert set(count) == {1, 2, images}
    level = np.searchsorted([1, 2, images], count)
    observed = cells(level / 3, rest, counts=(3, 20))
    share = np.array([1 - chance[1], chance[1] - chance[2], chance[2]])
    assert abs(chi_square_z(observed, DRAWS * np.repeat(share / 20, 20))) < 4


def test_ways_are_tried_by_their_chances():
    """Of the ways between two places on both sides of a hole's sphere, straight and bent, all combinations come as
    often as the product of the chances given, and the number that decides is even again."""
    scene = new_scene()
    scene.set_spacetime_objects([(Spacetime.schwarzschild(0.15), placed(0, 0, 0), 1.0, -1)])
    scene.commit()
    chances = np.array([0.3, 0.7, 0.5])  # straight, by way of the hole, through it: there is no such way
    a, b = (-3, 1.2, 0), (3, 1.1, 0)  # the straight way passes by outside
    full = scene.join([a], [b])
    assert set(full["way"][0, : full["count"][0]]) == {0, 1}
    u = np.random.default_rng(14).random(DRAWS)
    joints = scene.join(np.tile(a, (DRAWS, 1)), np.tile(b, (DRAWS, 1)), u=u, way_chances=np.tile(chances, (DRAWS, 1)))
    present = [(joints["way"] == way).any(axis=1) for way in (0, 1)]
    # around the hole there is but the second image, which is listed by a chance of its own
    second = full["image_chance"][0][full["way"][0] == 1]
    share = [chances[0], chances[1] * second.max()]
    assert all(np.all(joints["chance"][joints["way"] == way] == chances[way]) for way in (0, 1))
    observed = cells(present[0] / 2, present[1] / 2, joints["rest"], counts=(2, 2, 10))
    expected = np.outer([1 - share[0], share[0]], [1 - share[1], share[1]]).ravel()
    assert abs(chi_square_z(observed, DRAWS * np.repeat(expected / 10, 10))) < 4


# ---- Russian roulette ----


def rays_of_samples(scene, count, **settings):
    """How many rays each of `count` samples of a picture of one pixel takes."""
    numbers = (render(scene, 1, 1, 1, names=("combined",), seed=s, **settings)[1].rays for s in range(count))
    return np.fromiter(numbers, int, count)


@pytest.mark.parametrize(("albedo", "start"), [(0.5, 0), (0.8, 2), (0.2, 1)])
def test_paths_end_by_their_throughput(albedo, start):
    """Inside a gray ball that does not shine: from bounce `start` on a path of throughput b goes on with the chance
    sqrt(b / 0.33), and what goes on stands for all: b becomes sqrt(0.33 b). Each survivor of a scattering is one more
    ray."""
    scene = new_scene()
    add(scene, meshes.sphere(), diffuse((albedo,) * 3))
    perspective(scene, look_at((0.3, 0.2, 0.1), (0, 0, 0)))
    scene.commit()
    n, throughput, alive, ends = 4000, 1.0, 1.0, []
    for bounce in range(1, 60):
        throughput *= albedo
        chance = min(np.sqrt(throughput / 0.33), 1) if bounce >= start else 1
        ends.append(alive * (1 - chance))
        throughput, alive = throughput / chance, alive * chance
    limits = {"max_bounces": 99, "diffuse_bounces": 99, "roulette_start": start, "light_sampling": "SCATTERING"}
    observed = np.bincount(rays_of_samples(scene, n, **limits), minlength=61)[1:60]
    assert observed.sum() == n and abs(chi_square_z(observed, np.multiply(n, ends))) < 4


def test_faint_shadows_are_traced_by_their_light():
    """Of light L less than the threshold t, in L / t of the samples; then it stands for all."""
    scene = new_scene()
    add_lamps(scene, (0, 0, 2), intensity=3.0)
    values = patch_radiance(scene)
    light = 3 / 4 / np.pi
    assert values == pytest.approx(light, rel=1e-5)
    n, threshold = 4000, 0.8
    shadows = rays_of_samples(scene, n, max_bounces=0, light_threshold=threshold) - 2  # the path's rays go to the sky
    chance = light / threshold
    assert set(shadows) == {0, 1} and abs(shadows.sum() - n * chance) < 4 * np.sqrt(n * chance * (1 - chance))
