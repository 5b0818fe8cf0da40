"""Curved rays against meshes, judged by brute force (curved_oracle.py), in every spacetime."""

import functools
import tempfile
import threading

import curved_oracle
import meshes
import numpy as np
import pytest
from bentlight_native import Scene, Spacetime, trace_rays

M, A, RHO = 0.1, 0.09, 0.3
# (spacetime, what the oracle calls it, its parameters, chart radius of horizon or throat, critical impact parameter)
SPACES = {
    "isotropic": (Spacetime.schwarzschild(M), {"mass": M}, M / 2, 27**0.5 * M),
    "areal": (Spacetime.schwarzschild(M, "areal"), {"mass": M}, 2 * M, 27**0.5 * M),
    "kerr": (Spacetime.kerr(M, A), {"mass": M, "spin": A}, 0.18, 4.5 * M),
    "ellis": (Spacetime.ellis(RHO), {"throat": RHO}, RHO / 2, RHO),
}
# How the spacetime lies in the world: turned, scaled, moved. float32-exact, so that the oracle sees the same vertices.
SCALE = 2.0
WORLD = np.array([[0, -SCALE, 0, 1.5], [0, 0, -SCALE, -0.5], [SCALE, 0, 0, 3.0], [0, 0, 0, 1]])
EVERYWHERE = 4.0  # radius of the sphere that encloses it all, in the spacetime's units


@functools.cache
def library():
    return curved_oracle.build(tempfile.mkdtemp())


def to_world(points):
    return meshes.transform(WORLD, points)


def to_local(points):
    return (np.asarray(points) - WORLD[:3, 3]) @ WORLD[:3, :3] / SCALE**2


def things(rng, core):
    """An enclosing sphere; triangles about, near the photon sphere and inside it; thin and large ones."""
    vertices, triangles = meshes.joined(
        meshes.sphere(EVERYWHERE, segments=16, rings=8),
        meshes.soup(rng, 100, 0.1, 1.5),
        meshes.soup(rng, 60, 0.03, 2.5 * core),
        meshes.soup(rng, 20, 0.5, 1.5),
        meshes.sphere(0.2, (0.7, -0.3, 0.4), segments=8, rings=6),
    )
    clear = np.linalg.norm(vertices[triangles], axis=2).min(1) > 1.05 * core
    return vertices, np.ascontiguousarray(triangles[clear])


def sine_of_impact(kind, impact, radius):
    """Sine of the angle to the radial direction at which a local ray at a chart radius has this impact parameter."""
    if kind == "isotropic":
        q = M / (2 * radius)
        return impact * (1 - q) / (radius * (1 + q) ** 3)
    if kind == "ellis":
        return impact / (radius + RHO**2 / (4 * radius))
    return impact * np.sqrt(1 - 2 * M / radius) / radius  # for Kerr only about right


def rays(rng, count, kind):
    """Half anywhere, a quarter towards the hole, a quarter within 1e-1 to 1e-5 of the critical ray, winding round."""
    _, _, core, critical = SPACES[kind]
    origins = rng.uniform(-2, 2, (count, 3))
    while (inside := np.linalg.norm(origins, axis=1) < 1.2 * core).any():
        origins[inside] = rng.uniform(-2, 2, (inside.sum(), 3))
    directions = meshes.directions(rng, count)
    quarter = count // 4
    directions[:quarter] = -origins[:quarter] + rng.normal(0, 0.3, (quarter, 3))
    some = slice(quarter, 2 * quarter)
    radius = rng.uniform(1, 2, (quarter, 1))
    radial, side = meshes.directions(rng, quarter), meshes.directions(rng, quarter)
    side = np.cross(radial, side)
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    impact = critical * (1 + rng.choice([-1, 1], (quarter, 1)) * 10 ** rng.uniform(-5, -1, (quarter, 1)))
    sine = sine_of_impact(kind, impact, radius)
    origins[some], directions[some] = radius * radial, side * sine - radial * np.sqrt(1 - sine**2)
    return origins, directions / np.linalg.norm(directions, axis=1, keepdims=True)


class Case:
    """One spacetime with its scene, rays, and the true first hits."""

    def __init__(self, kind, count=10000, seed=11):
        rng = np.random.default_rng(seed)
        spacetime, parameters, core, _ = SPACES[kind]
        vertices, self.triangles = things(rng, core)
        self.vertices = to_world(vertices).astype(np.float32)
        self.origins, self.directions = rays(rng, count, kind)
        self.scene = Scene()
        self.scene.add_instance(self.scene.add_mesh(self.vertices, self.triangles), np.eye(4))
        self.scene.set_spacetime(spacetime, WORLD)
        self.scene.commit()
        self.oracle = curved_oracle.Oracle(library(), kind, to_local(self.vertices)[self.triangles], **parameters)
        self.fate, self.triangle, self.position, self.length = self.oracle.hits(self.origins, self.directions)

    def intersect(self, tolerance, **more):
        """Our answer, in the oracle's units and axes."""
        hits = self.scene.intersect(
            to_world(self.origins), self.directions @ WORLD[:3, :3].T / SCALE, SCALE * tolerance, **more
        )
        hits["position"] = to_local(hits["position"])
        hits["direction"] = hits["direction"] @ WORLD[:3, :3] / SCALE
        hits["length"] /= SCALE
        return hits

    def wrong(self, hits, allowed):
        """Rows in which we do not report what the ray, moved by no more than `allowed` (n,), meets first.

        A hit must lie on the ray. The true triangle may be passed over only where the ray is that near to one of its
        edges, or where moving it or ours by as much lets the ray miss it, as where it dips through it and out again, or
        meet ours first, as where the two cross.
        """
        met, true = hits["fate"] == 4, self.fate == 4
        off = np.linalg.norm(hits["position"] - self.position, axis=1)  # NaN where either sees no hit
        rows = np.flatnonzero((hits["fate"] != self.fate) | (hits["triangle"] != self.triangle) | (off > allowed))
        points = np.repeat(np.nan_to_num(hits["position"])[rows, None, None], 2, axis=2)
        away = met[rows] & (self.oracle.distances(self.origins[rows], self.directions[rows], points) > allowed[rows])
        passed = [true[row] and not self.may_pass(row, hits, allowed[row]) for row in rows]
        return rows[away | np.array(passed, bool) | (~met & ~true)[rows]]

    def may_pass(self, row, hits, allowed):
        """Whether what we report may come before the true hit, or the true hit not at all."""
        ray = self.origins[row], self.directions[row]
        if hits["fate"][row] == 4 and hits["length"][row] <= self.length[row]:
            return True
        if self.oracle.edge_distances(*(a[None] for a in ray), self.triangle[[row]])[0] < allowed:
            return True
        shifts = allowed * np.array([-1, -0.5, -0.25, -0.1, 0, 0.1, 0.25, 0.5, 1])
        latest = max(self.oracle.length_to(*ray, self.triangle[row], s) for s in shifts)
        if hits["fate"][row] != 4:
            return latest == np.inf
        ours = min(self.oracle.length_to(*ray, hits["triangle"][row], s) for s in shifts)
        return latest >= ours


case = functools.cache(Case)


@pytest.mark.unsanitized
@pytest.mark.parametrize("seed", [11, 112])
@pytest.mark.parametrize("kind", SPACES)
def test_brute_force_agrees(kind, seed):
    """What is hit is what the ray, moved by no more than the tolerance, meets first, and lies on the ray."""
    truth = case(kind, seed=seed)
    assert (truth.fate == 4).sum() > 0.6 * len(truth.fate) and (truth.fate != 4).sum() > 300
    for tolerance in (1e-3, 1e-4, 1e-6):
        hits = truth.intersect(tolerance)
        assert (hits["swept"] > 2 * np.pi).sum() > 20  # some wind
        # Errors of the truth itself grow like e^winding.
        allowed = tolerance + 1e-7 + 2e-10 * np.exp(hits["swept"])
        assert not len(truth.wrong(hits, allowed)), f"wrong at {tolerance}: {truth.wrong(hits, allowed)}"
        same = (hits["fate"] == truth.fate) & (hits["triangle"] == truth.triangle)
        assert (~same).mean() < 30 * tolerance + 2e-4
        error = np.linalg.norm(hits["position"] - truth.position, axis=1)
        assert np.nanpercentile(error[same & (hits["swept"] < 4)], 99) < 0.1 * tolerance + 3e-7


@pytest.mark.unsanitized
@pytest.mark.parametrize("kind", ["isotropic", "areal", "ellis"])
def test_light_goes_back_where_it_came_from(kind):
    """In a static spacetime the reversed ray from a hit passes through the origin: the hit's direction is right."""
    truth = case(kind, seed=11)
    hits = truth.intersect(1e-7, angular_tolerance=1e-10)
    clear = np.linalg.norm(hits["position"], axis=1) > 0.4  # from deep in the hole every error grows
    rows = np.flatnonzero((hits["fate"] == 4) & (hits["swept"] < 4) & clear)[:300]
    points = np.repeat(truth.origins[rows, None, None], 2, axis=2)
    inward = hits["position"][rows] * (1 - 1e-9)  # the enclosing sphere's own rounding may put it outside
    distance = truth.oracle.distances(inward, -hits["direction"][rows], points)
    assert np.percentile(distance, 99) < 1e-6


@pytest.mark.parametrize("kind", SPACES)
def test_without_geometry_rays_end_as_traced(kind):
    spacetime = SPACES[kind][0]
    origins, directions = rays(np.random.default_rng(12), 4000, kind)
    scene = Scene()
    scene.set_spacetime(spacetime)
    scene.commit()
    hits = scene.intersect(origins, directions, angular_tolerance=1e-9)
    traced = trace_rays(spacetime, origins, directions, 1e-9)
    np.testing.assert_array_equal(hits["fate"], traced["fate"])
    # a wormhole's far sky is drawn in the axes of its other mouth
    mirror = np.where(hits["fate"] == 3, -1.0, 1.0)[:, None] * [0, 1, 0] + [1, 0, 1] * np.ones((len(origins), 1))
    mirror[hits["fate"] != 3] = 1
    error = np.abs(hits["direction"] * mirror - traced["direction"]).max(1)
    assert np.all(~(error > 10 * (hits["error"] + traced["error"]) + 1e-7))
    np.testing.assert_array_equal(hits["sky"], np.where(hits["fate"] == 3, 0, -1))


@pytest.mark.parametrize("depth", [3e-2, 3e-3, 3e-4])
def test_a_plane_that_a_ray_grazes_twice_is_never_missed(depth):
    """Rays bent round the hole dip through a large plane by `depth` and come out again: all hit it on the way in."""
    impact = 1.0
    spacetime = Spacetime.schwarzschild(M)
    scene = Scene()
    scene.set_spacetime(spacetime)
    plane = np.array([[-50, -50, 0], [50, -50, 0], [0, 90, 0]], np.float32)
    mesh = scene.add_mesh(plane, np.array([[0, 1, 2]], np.uint32))
    # A ray along x above the hole is bent down, towards -z, symmetric about its highest point.
    start = np.array([[0.0, 0.0, impact]])
    peak = scene.intersect  # the plane's height is put `depth` below the highest point, seen from the start
    matrix = np.eye(4)
    matrix[2, 3] = impact - depth
    scene.add_instance(mesh, matrix)
    scene.commit()
    tolerance = depth / 10
    there = peak(start, np.array([[1.0, 0, 0]]), tolerance)
    back = peak(start, np.array([[-1.0, 0, 0]]), tolerance)
    assert there["fate"][0] == back["fate"][0] == 4
    np.testing.assert_allclose(there["position"][0] * [-1, 1, 1], back["position"][0], atol=1e-9)
    # From below, through the plane at `there`, over the top, and down again at `back`.
    rng = np.random.default_rng(13)
    turn = rng.uniform(0, 2 * np.pi, 200)
    axes = np.stack([np.cos(turn), np.sin(turn), 0 * turn], -1)
    scene.clear_instances()
    scene.commit()
    inverse = there["position"][0] * [1, 1, 0]
    below = inverse
    origins = np.stack([axes[:, 0] * below[0], axes[:, 1] * below[0], 0 * turn + impact - 1.1 * depth], -1)
    heading = np.stack([-axes[:, 0] * there["direction"][0, 0], -axes[:, 1] * there["direction"][0, 0],
                        0 * turn - there["direction"][0, 2]], -1)  # fmt: skip
    scene.add_instance(mesh, matrix)
    scene.commit()
    up = scene.intersect(origins, heading, tolerance)
    assert np.all(up["fate"] == 4)  # through the plane from below
    again = scene.intersect(up["position"], up["direction"], tolerance, sources=np.zeros((200, 2), np.int32))
    assert np.all((again["fate"] == 4) & (again["triangle"] == 0))  # and the same triangle from above, at its other end
    assert np.all(again["length"] > 0.1)
    np.testing.assert_allclose(again["position"][:, 2], impact - depth, atol=1e-7)


@pytest.mark.parametrize("kind", SPACES)
def test_rays_that_leave_a_surface_do_not_meet_it_again_at_once(kind):
    spacetime, _, _, _ = SPACES[kind]
    rng = np.random.default_rng(14)
    for scale in (1e-5, 1.0, 1e5):
        world = np.diag([scale, scale, scale, 1.0])
        vertices, triangles = meshes.sphere(0.3, (0.8, 0.1, -0.2), segments=24, rings=16)
        room, walls = meshes.sphere(3.0, segments=24, rings=12)
        scene = Scene()
        scene.add_instance(scene.add_mesh(vertices, triangles), world)
        scene.add_instance(scene.add_mesh(room, walls), world)
        scene.set_spacetime(spacetime, world)
        scene.commit()
        n = 4000
        source = np.stack([np.zeros(n), rng.integers(0, len(triangles), n)], 1).astype(np.int32)
        corners = vertices[triangles[source[:, 1]]].astype(float)
        origins = np.einsum("ij,ijk->ik", rng.dirichlet((0.5, 0.5, 0.5), n), corners) * scale
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normal /= np.linalg.norm(normal, axis=1, keepdims=True)
        directions = meshes.directions(rng, n)
        # not closer to the surface than the chart's or the hole's drag may turn the drawn direction
        outward = np.sum(directions * normal, 1)
        directions *= np.sign(outward)[:, None]
        steep = np.abs(outward) > 0.2
        hits = scene.intersect(origins, directions, 1e-4 * scale, sources=source)
        assert np.all(hits["fate"] != 0)
        back = steep & (hits["instance"] == 0)
        assert np.all(hits["length"][back] > 0.5 * scale)  # only after a way round the hole
        inside = scene.intersect(origins, -directions, 1e-4 * scale, sources=source)
        assert np.all(inside["instance"][steep] == 0)
        assert np.all(inside["length"][steep] > 1e-6 * scale)


@pytest.mark.parametrize("offset", [0, 30, 1000])
@pytest.mark.parametrize("kind", SPACES)
def test_curved_rays_that_leave_a_ball_never_meet_it_at_once_nor_leak(kind, offset):
    """However far from the origin it is. The hole is so light that rays at these slopes do not come round again."""
    spacetime = {
        "isotropic": Spacetime.schwarzschild(1e-3),
        "areal": Spacetime.schwarzschild(1e-3, "areal"),
        "kerr": Spacetime.kerr(1e-3, 9e-4),
        "ellis": Spacetime.ellis(1e-2),
    }[kind]
    rng = np.random.default_rng(16)
    vertices, triangles = meshes.sphere(segments=48, rings=32)
    matrix = np.array([[0.9, 0.5, -0.3, 0.62], [-0.2, 0.7, 0.4, -0.55], [0.1, -0.6, -0.5, 0.56], [0, 0, 0, 1]])
    matrix[:3, 3] *= offset
    hole, speck = np.eye(4), np.eye(4)
    hole[:3, 3] = matrix[:3, 3] + [3, 0.5, 0.2]
    speck[:3, 3] = -matrix[:3, 3] - 3  # keeps the scene's center at the origin
    scene = Scene()
    scene.add_instance(scene.add_mesh(vertices, triangles), matrix)
    scene.add_instance(scene.add_mesh(*meshes.box((0, 0, 0), (1e-6, 1e-6, 1e-6))), speck)
    scene.set_spacetime(spacetime, hole)
    scene.commit()
    sources, origins, outward, inward = meshes.departures(rng, matrix, vertices, triangles, 4000, 0.02)
    for tolerance in (1e-3, 1e-5):
        assert np.all(scene.intersect(origins, outward, tolerance, sources=sources)["instance"] != 0)
        inside = scene.intersect(origins, inward, tolerance, sources=sources)
        assert np.all((inside["instance"] == 0) & (inside["triangle"] != sources[:, 1]))


@pytest.mark.unsanitized
def test_ten_million_rays_stay_inside_closed_meshes():
    """Straight ones, half of them aimed at edges exactly, and curved ones that may also end in the hole."""
    rng = np.random.default_rng(15)
    room, walls = meshes.sphere(1.0, segments=64, rings=48)
    scene = Scene()
    scene.add_instance(scene.add_mesh(room, walls), np.eye(4))
    scene.commit()
    block = 1_000_000
    for turn in range(9):
        origins = rng.uniform(-0.5, 0.5, (block, 3))
        directions = meshes.directions(rng, block)
        edges = walls[rng.integers(0, len(walls), block)]
        along = rng.uniform(0, 1, (block, 1))
        on_edges = room[edges[:, 0]] * along + room[edges[:, 1]] * (1 - along)
        directions[::2] = (on_edges - origins)[::2]
        assert np.all(scene.intersect(origins, directions)["fate"] == 4), turn
    scene.set_spacetime(Spacetime.schwarzschild(0.02))
    scene.commit()
    origins = rng.uniform(-0.5, 0.5, (block, 3))
    origins[np.linalg.norm(origins, axis=1) < 0.05] = 0.3
    fate = scene.intersect(origins, meshes.directions(rng, block), 1e-3)["fate"]
    assert np.all((fate == 4) | (fate == 2))
    assert (fate == 2).sum() > 1000


@pytest.mark.parametrize("kind", SPACES)
def test_batches_threads_and_updates_do_not_matter(kind):
    truth = case(kind, 2000)
    whole = truth.intersect(1e-4)
    whole["length"] *= SCALE
    world = to_world(truth.origins), truth.directions @ WORLD[:3, :3].T / SCALE
    cuts = np.split(np.arange(2000), [1, 2, 5, 12, 300, 555, 1400])
    parts = [None] * len(cuts)

    def work(k):
        parts[k] = truth.scene.intersect(world[0][cuts[k]], world[1][cuts[k]], SCALE * 1e-4)

    threads = [threading.Thread(target=work, args=(k,)) for k in range(len(cuts))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for name in ("fate", "instance", "triangle", "barycentric", "length", "swept", "error", "sky"):
        np.testing.assert_array_equal(whole[name], np.concatenate([p[name] for p in parts]), err_msg=name)
    moved = Scene()
    mesh = moved.add_mesh(truth.vertices * np.float32(0.9), truth.triangles)
    instance = moved.add_instance(mesh, np.diag([2.0, 2, 2, 1]))
    moved.set_spacetime(Spacetime.minkowski())
    moved.commit()
    moved.update_mesh(mesh, truth.vertices)
    moved.update_instance(instance, np.eye(4))
    moved.set_spacetime(SPACES[kind][0], WORLD)
    moved.commit()
    again = moved.intersect(*world, SCALE * 1e-4)
    for name in ("fate", "triangle", "length"):
        np.testing.assert_array_equal(whole[name], again[name], err_msg=name)


def test_length_range_and_visibility_on_curved_rays():
    spacetime = Spacetime.schwarzschild(0.01)
    scene = Scene()
    box = scene.add_mesh(*meshes.box((-0.5, -0.5, -0.5), (0.5, 0.5, 0.5)))
    for x, visibility in ((2, 1), (5, 15)):
        matrix = np.eye(4)
        matrix[0, 3] = x
        scene.add_instance(box, matrix, visibility=visibility)
    scene.set_spacetime(spacetime)
    scene.commit()
    ray = np.array([[-3.0, 0.4, 0.0]]), np.array([[1.0, 0.0, 0.0]])
    near = scene.intersect(*ray, visibility=1)
    assert near["instance"][0] == 0 and abs(near["length"][0] - 4.5) < 0.1
    assert scene.intersect(*ray, visibility=2)["instance"][0] in (-1, 1)
    later = scene.intersect(*ray, length_min=near["length"][0] + 0.01)
    assert later["length"][0] > near["length"][0] + 0.01
    assert scene.intersect(*ray, length_max=near["length"][0] - 0.01)["fate"][0] == 1


def test_a_ray_from_inside_the_horizon_is_refused():
    scene = Scene()
    scene.set_spacetime(Spacetime.schwarzschild(0.1), np.diag([3.0, 3, 3, 1]))
    scene.commit()
    with pytest.raises(ValueError, match=r"ray 1: starts inside the horizon of spacetime object 0"):
        scene.intersect(np.array([[1.0, 0, 0], [0.14, 0, 0]]), np.array([[1.0, 0, 0]] * 2))
