"""Joints by way of one of several finite lens spheres and through a wormhole: traced again, searched for by brute
force, and their spread against differences of traced rays; then pictures that are lit by them against chance."""

import meshes
import numpy as np
import pytest
from bentlight_native import Spacetime
from rays import angle_between, unit
from sanitized import fewer
from scenes import add, diffuse, emission, glossy, look_at, new_scene, perspective, quad, render
from test_direct_light import add_lamps, patch_radiance
from test_render_curved import placed
from test_render_light import z_score


def pose(center, axis, angle, scale=1.0):
    """A rotated and scaled placing."""
    x, y, z = unit(np.array(axis, float))
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    matrix = np.eye(4)
    matrix[:3, :3] = scale * (np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross)
    matrix[:3, 3] = center
    return matrix


CENTERS = np.array([[0, 0, 0], [6, 0.5, 0], [0, 7, 1], [6, 7, -1.0]])
RADII = np.array([2.0, 2.5, 1.8, 2.2])
CORES = np.array([0.075 * 1.3, 0.4, 0.25, 0.25])  # of horizons and throats
OBJECTS = [
    (Spacetime.schwarzschild(0.15), pose(CENTERS[0], (1, 2, 3), 0.7, 1.3), RADII[0], -1),
    (Spacetime.schwarzschild(0.2, "areal"), pose(CENTERS[1], (0, 1, 1), 0.7), RADII[1], -1),
    (Spacetime.ellis(0.5), pose(CENTERS[2], (1, 0, 1), 1.0), RADII[2], 3),
    (Spacetime.ellis(0.25), pose(CENTERS[3], (0, 0, 1), 2.0, 2.0), RADII[3], 2),
]
HIT, ESCAPED, ESCAPED_FAR = 4, 1, 3


def objects_scene():
    """Two holes and the two mouths of a wormhole, and nothing else."""
    scene = new_scene()
    scene.set_spacetime_objects(OBJECTS)
    return scene


def places_outside(rng, n):
    points = rng.uniform(-4, 11, (4 * n, 3))
    far = np.linalg.norm(points[:, None] - CENTERS, axis=2) > RADII
    return points[far.all(axis=1)][:n]


def places_inside(rng, n, lens):
    """From close to the core to close to the rim."""
    radius = CORES[lens] * (RADII[lens] / CORES[lens]) ** rng.uniform(0.02, 0.999, n)
    return CENTERS[lens] + radius[:, None] * unit(rng.normal(size=(n, 3)))


def ends(kind, n, seed=1):
    """n pairs of places: "out", "in0" .. "in3", or a place close outside or inside of a sphere, "rim0" ..."""
    rng = np.random.default_rng(seed)
    result = []
    for name in kind.split("-"):
        if name == "out":
            result.append(places_outside(rng, n))
        elif name.startswith("in"):
            result.append(places_inside(rng, n, int(name[2])))
        else:
            lens = int(name[3])
            radius = RADII[lens] * (1 + rng.choice([-1, 1], n) * 10.0 ** rng.uniform(-7, -2, n))
            result.append(CENTERS[lens] + radius[:, None] * unit(rng.normal(size=(n, 3))))
    return result


def frames(positions, normals, size):
    """world_from_mesh of quads of half-width `size` across `normals`."""
    side = unit(np.cross(normals, [0.31, 0.52, 0.8]))
    matrices = np.tile(np.eye(4), (len(positions), 1, 1))
    matrices[:, :3, :3] = size * np.stack([side, np.cross(normals, side), normals], axis=2)
    matrices[:, :3, 3] = positions
    return matrices


def listed(joints):
    """Rows and columns of all joints."""
    return np.nonzero(np.arange(16) < joints["count"][:, None])


KINDS = [
    *("out-out", "in0-out", "out-in0", "in0-in0", "in1-out", "out-in1", "in1-in1", "in2-out", "out-in2", "in2-in2"),
    *("in3-out", "out-in3", "in2-in3", "in3-in2", "rim0-out", "out-rim1", "rim2-rim3", "rim1-rim1", "rim2-rim2"),
]


def targets(scene, positions, normals, size):
    """A scene with a small quad at each position."""
    mesh = scene.add_mesh(*quad())
    for matrix in frames(positions, normals, size):
        scene.add_instance(mesh, matrix)
    scene.commit()
    return scene


@pytest.mark.parametrize("kind", KINDS)
def test_joints_traced_again(kind):
    """One of each pair's meets a small target at its end, having passed the borders and swept the angle that it
    states. The few that meet another pair's target, or their own one turn before, are traced alone, to a smaller one.
    """
    a, b = ends(kind, fewer(10000))
    bare = objects_scene()
    bare.commit()
    joints = bare.join(a, b)
    row, column = listed(joints)
    assert len(row) > 0.5 * len(a)
    rng = np.random.default_rng(3)
    row = rng.permutation(np.unique(row))[: fewer(2500)]
    column = rng.integers(0, joints["count"][row])  # one target a pair
    launch, arrival, swept, first_lens, borders, length = (
        joints[key][row, column] for key in ("launch", "arrival", "swept", "first_lens", "borders", "length")
    )
    scene = targets(objects_scene(), b[row], -arrival, 2e-4)
    hits = scene.intersect(a[row], launch, 1e-7, angular_tolerance=1e-9)
    met = (hits["fate"] == HIT) & (hits["instance"] == np.arange(len(row))) & (np.abs(hits["swept"] - swept) < 1)
    assert np.mean(met) > 0.97
    assert np.abs(hits["swept"] - swept)[met].max() < 1e-5
    assert np.linalg.norm(hits["position"] - b[row], axis=1)[met].max() < 1e-6
    assert angle_between(hits["direction"], arrival)[met].max() < 1e-5
    off = np.abs(hits["length"] / length - 1)[met]
    assert np.quantile(off, 0.99) < 1e-5 and off.max() < 1e-3, np.quantile(off, [0.5, 0.9, 0.99, 0.999, 1])
    at_rim = (np.abs(np.linalg.norm(b[row, None] - CENTERS, axis=2) - RADII) < 1e-3).any(axis=1)
    np.testing.assert_array_equal(hits["first_lens"][met & ~at_rim], first_lens[met & ~at_rim])
    np.testing.assert_array_equal(hits["borders"][met & ~at_rim], borders[met & ~at_rim])
    lone, strays = objects_scene(), np.nonzero(~met)[0][:100]
    target = lone.add_instance(lone.add_mesh(*quad()), np.eye(4))
    for i in strays:
        lone.update_instance(target, frames(b[row[i], None], -arrival[i, None], 1e-5)[0])
        lone.commit()
        hit = lone.intersect(a[row[i], None], launch[i, None], 1e-7, angular_tolerance=1e-9)
        assert np.linalg.norm(hit["position"][0] - b[row[i]]) < 1e-6
        assert hit["swept"][0] == pytest.approx(swept[i], abs=1e-5)


@pytest.mark.parametrize("far", [False, True])
def test_joints_with_the_sky_traced_again(far):
    """Out into the sky, and through a wormhole without exit into its own."""
    scene = new_scene()
    scene.set_spacetime_objects([*OBJECTS, (Spacetime.ellis(0.4), pose((3, 3, 6), (1, 1, 0), 0.4), 1.5, -1)])
    scene.commit()
    rng = np.random.default_rng(5)
    a = np.concatenate([places_outside(rng, 8000), *(places_inside(rng, 1000, lens) for lens in range(4))])
    a = a[np.linalg.norm(a - [3, 3, 6], axis=1) > 1.5]
    directions = unit(rng.normal(size=a.shape))
    joints = scene.join(a, directions, sky=True, far=far)
    row, column = listed(joints)
    assert len(row) > 0.5 * (~far + 2) * len(a)
    launch = joints["launch"][row, column]
    hits = scene.intersect(a[row], launch, 1e-7, angular_tolerance=1e-9)
    assert (hits["fate"] == (ESCAPED_FAR if far else ESCAPED)).all()
    assert (hits["sky"] == (4 if far else -1)).all()
    assert angle_between(hits["direction"], directions[row]).max() < 1e-6
    for key in ("first_lens", "borders"):
        np.testing.assert_array_equal(hits[key], joints[key][row, column])


@pytest.mark.parametrize("kind", ["out-out", "in0-out", "out-in1", "in2-out", "out-in3", "in3-in2"])
def test_pairs_in_line_stay_finite(kind):
    """The centers in line with both ends: rings, which are not listed; what is has a finite spread."""
    a, _ = ends(kind, 300)
    lens = int(kind[-1]) if kind[-1].isdigit() else 0
    center = CENTERS[lens]
    scale = np.random.default_rng(2).uniform(-1.4, 1.4, 300)[:, None]
    b = center + scale * RADII[lens] * unit(a - center)
    scene = objects_scene()
    scene.commit()
    joints = scene.join(a, b)
    row, column = listed(joints)
    assert len(row) > 50
    assert np.isfinite(joints["launch"][row, column]).all()
    assert (joints["spread"][row, column] > 0).all() and np.isfinite(joints["spread"][row, column]).all()


def stretches(lens, position):
    """Lengths that the observer at rest at `position` measures for a radial and a tangential unit of scene length; and
    the outward direction."""
    spacetime, matrix, radius, _ = OBJECTS[lens]
    away = position - CENTERS[lens]
    distance = np.linalg.norm(away)
    r, outward = distance / np.cbrt(np.linalg.det(matrix[:3, :3])), away / distance
    if distance >= radius:
        return 1.0, 1.0, outward
    if spacetime.kind == "ellis":
        return (1 + (spacetime.core_radius / r) ** 2,) * 2 + (outward,)
    if spacetime.chart == "isotropic":
        return ((1 + spacetime.core_radius / r) ** 2,) * 2 + (outward,)
    return 1 / np.sqrt(1 - spacetime.core_radius / r), 1.0, outward


def local_section(lens, position, edges, direction):
    """Area across a ray of the parallelogram of two small displacements (2, 3), for the observer at rest."""
    radial_stretch, stretch, outward = stretches(lens, position)
    radial = (edges @ outward)[:, None] * outward
    return abs(np.cross(*(radial_stretch * radial + stretch * (edges - radial))) @ direction)


def traced_spread(scene, target, start, launch, end, arrival, guess, lens=0, expected=None):
    """Area at `end`, local to who rests in lens number `lens` or outside, per solid angle at the start: by differences
    of where rays in two directions beside the launch cross a plane. NaN if not all meet it in the expected way."""
    size = min(1, np.sqrt(guess))
    scene.update_instance(target, frames(end[None], -arrival[None], 0.05 * size)[0])
    scene.commit()
    step = 5e-4 * size / np.sqrt(guess)
    x = unit(np.cross(launch, [0.2, 0.9, 0.4]))
    sides = np.array([x, np.cross(launch, x)])
    aims = unit(np.concatenate([launch + s * step * sides for s in (1, -1, 2, -2)]))
    hits = scene.intersect(np.tile(start, (8, 1)), aims, 1e-12, angular_tolerance=1e-13)
    borders, swept = expected
    if not ((hits["fate"] == HIT) & (hits["borders"] == borders) & (np.abs(hits["swept"] - swept) < 0.1)).all():
        return np.nan
    p = hits["position"].reshape(4, 2, 3)
    edges = (8 * (p[0] - p[1]) - (p[2] - p[3])) / (12 * step)
    return local_section(lens, end, edges, arrival)


@pytest.mark.parametrize(
    "kind", ["out-out", "in0-out", "out-in0", "in1-out", "out-in1", "in2-out", "out-in3", "in3-in2"]
)
def test_spread_is_that_of_traced_rays(kind):
    a, b = ends(kind, 40, seed=8)
    lens = int(kind[-1]) if kind[-1].isdigit() else 0
    scene = objects_scene()
    target = scene.add_instance(scene.add_mesh(*quad()), np.eye(4))
    scene.commit()
    joints = scene.join(a, b)
    off = []
    for i, k in zip(*listed(joints), strict=True):
        launch, arrival, spread, borders, swept = (
            joints[key][i, k] for key in ("launch", "arrival", "spread", "borders", "swept")
        )
        traced = traced_spread(scene, target, a[i], launch, b[i], arrival, spread, lens, (borders, swept))
        if np.isfinite(traced):
            off.append(abs(traced / spread - 1))
    assert len(off) > 60
    # what is left is noise of the traced rays, most of those that wind around a throat
    assert np.median(off) < 1e-6 and np.quantile(off, 0.85) < 1e-5, np.quantile(off, [0.5, 0.85, 0.95])
    assert max(off) < 1e-2


@pytest.mark.parametrize("kind", ["out-out", "in0-out", "out-in1", "in1-in1", "in2-out", "out-in3", "in2-in3"])
def test_every_image_is_listed(kind):
    """A fan of rays in the plane of both ends and a center: every bundle of three or more that meets a small ball at
    the other end, by way of one lens, has a joint in it."""
    a, b = ends(kind, 6, seed=4)
    scene = objects_scene()
    ball = scene.add_instance(scene.add_mesh(*meshes.sphere(1.0, segments=32, rings=16)), np.eye(4))
    scene.commit()
    joints = scene.join(a, b)
    first, last = (int(name[2]) if name != "out" else -1 for name in kind.split("-"))
    outside = (first < 0) + (last < 0)
    angle = np.linspace(-np.pi, np.pi, 60000)
    bundles = 0
    for i in range(len(a)):
        lens = first if first >= 0 else last if last >= 0 else i % 4
        matrix = OBJECTS[lens][1]
        axis = unit(a[i] - matrix[:3, 3])
        far_mouth = OBJECTS[lens][3] if i % 2 and kind in ("out-out", "in2-out") else -1
        if first >= 2 and last == OBJECTS[first][3]:
            far_mouth = last
        end = b[i]
        if far_mouth >= 0:  # as it is drawn on this side of the throat
            other = OBJECTS[far_mouth][1]
            end = matrix[:3, :3] @ (np.linalg.inv(other[:3, :3]) @ (b[i] - other[:3, 3]) * [1, -1, 1]) + matrix[:3, 3]
        side = unit(np.cross(np.cross(axis, end - matrix[:3, 3]), axis))
        rays = np.cos(angle)[:, None] * axis + np.sin(angle)[:, None] * side
        core = np.linalg.norm(b[i] - CENTERS[last]) - CORES[last] if last >= 0 else 1
        scene.update_instance(ball, placed(*b[i]) @ np.diag([*[min(0.05, 0.2 * core)] * 3, 1.0]))
        scene.commit()
        hits = scene.intersect(np.tile(a[i], (len(rays), 1)), rays, 1e-5, angular_tolerance=1e-6)
        single = (hits["borders"] == outside) | (hits["borders"] == outside + 1) | (hits["first_lens"] < 0)
        met = (hits["fate"] == HIT) & single
        parts = np.nonzero(np.diff(met.astype(int)))[0] + 1
        for bundle in np.split(np.arange(len(angle)), parts):
            if len(bundle) < 3 or not met[bundle[0]]:
                continue
            same = [hits[key][bundle] == hits[key][bundle[0]] for key in ("first_lens", "borders")]
            if not np.all(same):
                continue
            bundles += 1
            middle, width = rays[bundle[len(bundle) // 2]], (len(bundle) / 2 + 2) * (angle[1] - angle[0])
            own = np.arange(joints["count"][i])
            fits = [joints[key][i, own] == hits[key][bundle[0]] for key in ("first_lens", "borders")]
            near = np.linalg.norm(joints["launch"][i, own] - middle, axis=1) < width
            assert np.any(fits[0] & fits[1] & near), (i, len(bundle), hits["swept"][bundle[0]])
    assert bundles >= 6


def eight_holes():
    """On a ring around the way from one place to another."""
    angle = np.arange(8) * np.pi / 4
    centers = np.stack([2.5 * np.cos(angle), 2.5 * np.sin(angle), 0.1 * np.arange(8)], axis=1)
    scene = new_scene()
    scene.set_spacetime_objects([(Spacetime.schwarzschild(0.05), placed(*c), 0.8, -1) for c in centers])
    return scene


def test_too_many_rays_are_listed_by_chance():
    """With more joints than there is room for, the mean light of those listed is that of all."""
    scene, n = eight_holes(), 4000
    scene.commit()
    joints = scene.join(np.tile((0.2, 0.1, -6.0), (n, 1)), np.tile((-0.3, 0.2, 6.0), (n, 1)))
    assert (joints["count"] == 16).all()
    light, side = 1 / joints["spread"], joints["launch"][..., 0]
    keys = zip(joints["first_lens"].ravel(), joints["swept"].ravel().round(6), strict=True)
    each = dict(zip(keys, zip(light.ravel(), side.ravel(), strict=True), strict=True))
    assert len(each) > 20
    whole = sum(value for value, _ in each.values())
    assert (light / joints["chance"]).sum(axis=1) == pytest.approx(whole, rel=1e-9)  # one stands for both
    estimates = (light * side / joints["chance"]).sum(axis=1)
    assert estimates.std() > 0 and abs(z_score(estimates, sum(a * b for a, b in each.values()))) < 4


# ---- Pictures ----


def lit_scene(closures):
    """A floor and a ball among two holes and a wormhole, lit by a lamp overhead, glowing balls in flat space, near a
    hole and in a mouth, and a sun. Lights are hidden from the camera, whose own noise would hide theirs."""
    scene = objects_scene()
    add(scene, quad(9, 9), *closures, at=placed(3, 3.5, -2.6))
    add(scene, meshes.sphere(0.7, segments=16, rings=8), *closures, at=placed(3, 3, 0))
    lamp = np.diag([0.6, -0.6, -0.6, 1.0])
    lamp[:3, 3] = -1, 7, 5
    glow = [
        (quad(), (20, 20, 20), lamp),
        (meshes.sphere(0.3, segments=8, rings=4), (20, 10, 40), placed(6, 3.5, 2)),
        (meshes.sphere(0.15, segments=8, rings=4), (40, 80, 40), placed(1.3, 0.8, 0)),
        (meshes.sphere(0.15, segments=8, rings=4), (80, 80, 40), placed(6.5, 6, -0.6)),
    ]
    for mesh, color, at in glow:
        add(scene, mesh, emission(color), at=at, visibility=14)
    scene.set_suns([(0.3, -0.5, 1)], [(20, 18, 15)], 0.3, visibility=14)
    perspective(scene, look_at((3, -9, 8), (3, 3.5, -1)), half=0.5)
    scene.commit()
    return scene


def test_light_among_eight_holes():
    """Chance and connections agree on a floor below a ring of holes and a lamp above it."""
    scene = eight_holes()
    add(scene, quad(6, 6), diffuse((0.8, 0.8, 0.8)), at=placed(0, 0, -2))
    add(scene, meshes.sphere(0.6, segments=16, rings=8), emission((10,) * 3), at=placed(0.3, 0.2, 4), visibility=14)
    perspective(scene, look_at((0, -9, 5), (0, 0, -1)), half=0.4)
    scene.commit()
    means = {}
    for sampling, samples in [("SCATTERING", 256), ("CONNECTIONS", 32), ("BOTH", 32)]:
        settings = {"light_sampling": sampling, "max_bounces": 1, "roulette_start": 9, "names": ("combined",)}
        runs = [render(scene, 8, 8, samples, seed=s, **settings)[0]["combined"][..., 0].mean() for s in range(16)]
        means[sampling] = np.mean(runs, dtype=float), np.var(runs, ddof=1) / len(runs)
    for sampling in ("CONNECTIONS", "BOTH"):
        (a, va), (b, vb) = means["SCATTERING"], means[sampling]
        assert abs(a - b) < 4 * np.sqrt(va + vb), (sampling, means)


@pytest.mark.parametrize("closures", [diffuse((0.8, 0.5, 0.2)), glossy((0.9, 0.9, 0.9), 0.4)], ids=["diffuse", "metal"])
def test_all_ways_to_find_light_agree(closures):
    """Chance, connections and both have the same mean: a Z-test of the picture's mean over independent seeds."""
    scene = lit_scene([closures])
    means = {}
    for sampling, samples in [("SCATTERING", 256), ("CONNECTIONS", 32), ("BOTH", 32)]:
        settings = {"light_sampling": sampling, "max_bounces": 2, "roulette_start": 9, "names": ("combined",)}
        runs = [render(scene, 16, 16, samples, seed=s, **settings)[0]["combined"][..., :3].mean() for s in range(16)]
        means[sampling] = np.mean(runs, dtype=float), np.var(runs, ddof=1) / len(runs)
    for sampling in ("CONNECTIONS", "BOTH"):
        (a, va), (b, vb) = means["SCATTERING"], means[sampling]
        assert abs(a - b) < 4 * np.sqrt(va + vb), (sampling, means)


MOUTHS = [(Spacetime.ellis(0.5), placed(0, 0, 0), 1.9, 1), (Spacetime.ellis(0.5), placed(20, 0, 0), 1.9, 0)]


def box(half):
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], np.float32) * half
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return corners, np.array([t for a, b, c, d in faces for t in ((a, b, c), (a, c, d))], np.uint32)


def test_a_room_lit_from_the_other_side():
    """Two closed rooms that only a wormhole joins, the lamp in the one, the camera in the other. All three ways to find
    light have one mean, and at equal numbers of samples connections leave less than a tenth of chance's variance."""
    scene = new_scene()
    scene.set_spacetime_objects(MOUTHS)
    for _, at, _, _ in MOUTHS:
        add(scene, box(4.0), diffuse((0.7, 0.7, 0.7)), at=at)
    add(scene, meshes.sphere(0.1, segments=16, rings=8), emission((30,) * 3), at=placed(20, 2.5, 1), visibility=14)
    perspective(scene, look_at((0, -3.5, 1.5), (0, 3.9, 0)), half=0.5)
    scene.commit()
    means, noise = {}, {}
    for sampling, samples in [("SCATTERING", 1024), ("CONNECTIONS", 32), ("BOTH", 32)]:
        settings = {"light_sampling": sampling, "max_bounces": 1, "roulette_start": 9, "names": ("combined",)}
        runs = [render(scene, 8, 8, samples, seed=s, **settings)[0]["combined"][..., 0] for s in range(24)]
        whole = np.mean(runs, axis=(1, 2), dtype=float)
        means[sampling] = whole.mean(), np.var(whole, ddof=1) / len(runs)
        noise[sampling] = np.var(runs, axis=0, ddof=1).mean() * samples
    for sampling in ("CONNECTIONS", "BOTH"):
        (a, va), (b, vb) = means["SCATTERING"], means[sampling]
        assert abs(a - b) < 4 * np.sqrt(va + vb), (sampling, means)
        assert noise[sampling] < 0.1 * noise["SCATTERING"]


@pytest.mark.parametrize("place", [(18.0, 1.5, 0.7), (20.6, 0.9, 0.3)], ids=["outside", "inside"])
def test_point_lamp_on_the_other_side(place):
    """A patch that a point lamp lights through a wormhole: the sum over rays of intensity cos / spread, the spread by
    differences of traced rays."""
    place, at, up = np.array(place), np.array([0.5, -2.6, 0.4]), unit(np.array([-0.1, 1, -0.2]))
    scene = new_scene()
    scene.set_spacetime_objects(MOUTHS)
    target = scene.add_instance(scene.add_mesh(*quad()), np.eye(4))
    scene.commit()
    joints = scene.join(at[None], place[None])
    exact, radius = 0.0, np.linalg.norm(place - MOUTHS[1][1][:3, 3])
    for k in range(joints["count"][0]):
        launch, arrival, spread, borders, swept = (
            joints[key][0, k] for key in ("launch", "arrival", "spread", "borders", "swept")
        )
        if borders != 2 + (radius > 1.9):
            continue  # not through the throat: held up by the wall below
        traced = traced_spread(scene, target, at, launch, place, arrival, spread, 0, (borders, swept))
        if not np.isfinite(traced):
            assert spread > 30 * np.nanmin(joints["spread"][0])  # a faint one, whose target stands in its way before
            traced = spread
        elif radius < 1.9:  # inside all lengths are drawn shorter
            traced *= (1 + (0.25 / radius) ** 2) ** 2
        exact += 3 * max(launch @ up, 0) / traced / np.pi
    scene = new_scene()
    scene.set_spacetime_objects(MOUTHS)
    add(scene, quad(20, 20), diffuse((0, 0, 0)), at=pose((10, 0, 0), (0, 1, 0), np.pi / 2))
    add_lamps(scene, place, intensity=3.0)
    values = patch_radiance(scene, samples=256, at=at, up=up, side=unit(np.cross(up, [0, 0, 1])))
    assert exact > 0 and abs(values.mean() / exact - 1) < 5e-3 and abs(z_score(values, exact)) < 4
