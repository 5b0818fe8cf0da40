"""Straight rays through the public interface: Embree's own answers, instances, edits, surfaces that rays leave."""

import threading

import meshes
import numpy as np
import pytest
from bentlight_native import Progress, Scene, Spacetime, embree_version, load_embree
from bentlight_native.embree import embree_candidates

EYE = np.eye(4)


def embree_path():
    load_embree()
    origin = embree_version()[1]
    return origin if not origin.startswith("already") else embree_candidates()[0]


def scene_of(*parts):
    """A committed flat scene of (vertices, triangles, matrix) parts."""
    scene = Scene()
    for vertices, triangles, matrix in parts:
        scene.add_instance(scene.add_mesh(vertices, triangles), matrix)
    scene.commit()
    return scene


def random_affine(rng):
    """Rotation, non-uniform scale, shear, translation; mirrored half of the time."""
    matrix = np.eye(4)
    while np.allclose(matrix, np.eye(4)) or np.linalg.cond(matrix[:3, :3]) > 6:
        matrix[:3, :3] = rng.normal(0, 0.7, (3, 3))
    matrix[:3, 3] = rng.uniform(-2, 2, 3)
    return matrix


@pytest.mark.parametrize("kind", ["sphere", "soup"])
def test_identical_to_embree_called_directly(kind):
    rng = np.random.default_rng(1)
    mesh = meshes.sphere(segments=96, rings=64) if kind == "sphere" else meshes.soup(rng, 20000, 0.03)
    origins, directions = rng.uniform(-2, 2, (20000, 3)), meshes.directions(rng, 20000)
    direct = meshes.DirectEmbree(embree_path(), *mesh)
    triangle, distance, barycentric = direct.intersect(origins, directions)
    direct.close()
    hits = scene_of((*mesh, EYE)).intersect(origins, directions)
    np.testing.assert_array_equal(hits["triangle"], triangle)
    found = triangle >= 0
    assert 2000 < found.sum() < 20000
    np.testing.assert_array_equal(hits["fate"], np.where(found, 4, 1))
    # Embree's float32 distance is off by its rounding over the cosine of incidence; ours lies on the true ray.
    v = mesh[0][mesh[1][triangle[found]]].astype(float)
    normal = np.cross(v[:, 1] - v[:, 0], v[:, 2] - v[:, 0])
    cosine = np.abs(np.sum(normal * directions[found], 1)) / np.linalg.norm(normal, axis=1)
    assert np.all(np.abs(hits["length"][found] - distance[found]) * cosine < 4e-6)
    reached = origins[found] + hits["length"][found, None] * directions[found]
    assert np.median(np.linalg.norm(reached - hits["position"][found], axis=1)) < 1e-15
    area = np.linalg.norm(normal, axis=1) / 2
    assert np.all(np.abs(hits["barycentric"][found] - barycentric[found]).max(1) * np.sqrt(area) * cosine < 1e-5)


def test_vertices_leak_no_more_than_in_embree_called_directly():
    """Embree's edges are watertight, its vertices nearly so: rays aimed at one exactly may pass it by rounding."""
    rng = np.random.default_rng(8)
    mesh = meshes.sphere(segments=64, rings=48)
    origins = rng.uniform(-0.5, 0.5, (100000, 3))
    directions = mesh[0][rng.integers(0, len(mesh[0]), len(origins))] - origins
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    direct = meshes.DirectEmbree(embree_path(), *mesh)
    direct_leaks = direct.intersect(origins, directions)[0] < 0
    direct.close()
    leaks = scene_of((*mesh, EYE)).intersect(origins, directions)["fate"] != 4
    np.testing.assert_array_equal(leaks, direct_leaks)
    assert 0 < leaks.mean() < 5e-3


def test_instances_are_affine_copies():
    """Any affine matrix, mirrored too: the same as one mesh of transformed vertices."""
    rng = np.random.default_rng(2)
    vertices, triangles = meshes.sphere(segments=24, rings=12)
    matrices = [random_affine(rng) for _ in range(12)]
    assert {np.sign(np.linalg.det(m)) for m in matrices} == {-1, 1}
    scene = Scene()
    mesh = scene.add_mesh(vertices, triangles)
    for matrix in matrices:
        scene.add_instance(mesh, matrix)
    scene.commit()
    flat = scene_of(*[(meshes.transform(m, vertices).astype(np.float32), triangles, EYE) for m in matrices])
    origins, directions = rng.uniform(-2.5, 2.5, (40000, 3)), meshes.directions(rng, 40000)
    a, b = scene.intersect(origins, directions), flat.intersect(origins, directions)
    same = (a["instance"] == b["instance"]) & (a["triangle"] == b["triangle"])
    assert (a["fate"] == 4).sum() > 10000
    assert np.all(np.linalg.norm(a["position"] - b["position"], axis=1)[same & (a["fate"] == 4)] < 1e-4)
    # The two differ in float32 rounding of vertices, so in rays within 1e-6 of an edge: triangles are about 0.2 wide.
    assert (~same).mean() < 3e-4


def test_visibility_and_length_range():
    scene = Scene()
    mesh = scene.add_mesh(*meshes.box((-1, -1, -1), (1, 1, 1)))
    for z, visibility in ((0, 1), (4, 2), (8, 15)):
        matrix = np.eye(4)
        matrix[2, 3] = z
        scene.add_instance(mesh, matrix, visibility=visibility)
    scene.commit()
    ray = np.array([[0.1, 0.2, -10.0]]), np.array([[0.0, 0.0, 1.0]])
    assert scene.intersect(*ray, visibility=1)["length"][0] == 9
    assert scene.intersect(*ray, visibility=2)["length"][0] == 13
    assert scene.intersect(*ray, visibility=4)["length"][0] == 17
    assert scene.intersect(*ray, length_min=9.5)["length"][0] == 11
    assert scene.intersect(*ray, length_min=11.5, length_max=12.5)["fate"][0] == 1
    escaped = scene.intersect(*ray, length_max=8.0)
    assert escaped["instance"][0] == -1 and np.isnan(escaped["position"]).all() and escaped["length"][0] == np.inf
    np.testing.assert_array_equal(escaped["direction"], ray[1])


MATRICES = {
    "plain": np.eye(3),
    "mirrored": np.array([[0, 1.0, 0], [1, 0, 0], [0, 0, 1]]),
    "flat": np.diag([1, 0.1, 1]) @ np.array([[0.8, -0.6, 0], [0.6, 0.8, 0], [0, 0, -1]]),
    "sheared": np.array([[0.9, 0.5, -0.3], [-0.2, 0.7, 0.4], [0.1, -0.6, 0.5]]),
}


def placed(mesh, linear, placement, offset):
    """Vertices and matrix of a mesh turned by `linear`, `offset` away from the world's origin."""
    vertices, triangles = mesh
    matrix, away = np.eye(4), offset * np.array([0.62, -0.55, 0.56])
    matrix[:3, :3] = linear
    if placement == "mesh":
        return (vertices + np.linalg.solve(linear, away)).astype(np.float32), triangles, matrix
    matrix[:3, 3] = away
    return vertices, triangles, matrix


# In a scene 1e5 times as large, as in a mesh that far out, float32 knows the ball to 1e-2: the flat one is 0.2 thick.
PLACES = [
    (kind, placement, offset)
    for kind in MATRICES
    for placement in ("instance", "mesh", "instance in a wide scene")
    for offset in (0, 30, 1000, 1e5)
    if not (kind == "flat" and placement != "instance" and offset == 1e5)
]


@pytest.mark.parametrize("kind, placement, offset", PLACES)
def test_rays_that_leave_a_surface_never_meet_it_at_once_nor_leak(kind, placement, offset):
    """Out of a ball no ray hits it, into it all do, however far from the origin, at slopes down to 1e-5."""
    rng = np.random.default_rng(3)
    ball = placed(meshes.sphere(segments=48, rings=32), MATRICES[kind], placement, offset)
    scene = scene_of(ball)
    if placement == "instance in a wide scene":
        speck = np.eye(4)
        speck[:3, 3] = -ball[2][:3, 3] - 3  # keeps the scene's center at the origin
        scene.add_instance(scene.add_mesh(*meshes.box((0, 0, 0), (1e-6, 1e-6, 1e-6))), speck)
        scene.commit()
    sources, origins, outward, inward = meshes.departures(rng, ball[2], *ball[:2], 20000, 1e-5)
    assert np.all(scene.intersect(origins, outward, sources=sources)["instance"] != 0)
    inside = scene.intersect(origins, inward, sources=sources)
    assert np.all((inside["instance"] == 0) & (inside["triangle"] != sources[:, 1]))


@pytest.mark.parametrize("kind", MATRICES)
@pytest.mark.parametrize("scale", [1e-6, 1e-3, 1e3, 1e6])
def test_scale_does_not_matter_to_rays_that_leave_a_surface(kind, scale):
    rng = np.random.default_rng(4)
    ball = placed(meshes.sphere(segments=48, rings=32), scale * MATRICES[kind], "instance", 3 * scale)
    sources, origins, outward, inward = meshes.departures(rng, ball[2], *ball[:2], 20000, 1e-2)
    scene = scene_of(ball)
    assert np.all(scene.intersect(origins, outward, sources=sources)["fate"] == 1)
    inside = scene.intersect(origins, inward, sources=sources)
    assert np.all((inside["fate"] == 4) & (inside["triangle"] != sources[:, 1]))
    # Within rounding of a vertex the triangle across it may be seen where the ray starts.
    assert np.mean(inside["length"] > 0) > 1 - 1e-3


@pytest.mark.parametrize("offset", [0, 30, 1000, 1e5])
def test_rays_that_leave_a_hollow_meet_what_is_there(offset):
    """A torus bends towards rays in its hole: first hits as brute force in double precision finds them."""
    rng = np.random.default_rng(5)
    ring = placed(meshes.torus(), MATRICES["sheared"], "instance", offset)
    sources, origins, outward, inward = meshes.departures(rng, ring[2], *ring[:2], 600, 1e-5)
    scene = scene_of(ring)
    for heading in (outward, inward):
        length = first_lengths(meshes.transform(ring[2], ring[0])[ring[1]], origins, heading, sources[:, 1])
        hits = scene.intersect(origins, heading, sources=sources)
        np.testing.assert_array_equal(hits["fate"] == 4, np.isfinite(length))
        met = np.isfinite(length)
        # Grazing rays that start 1e-6 higher may meet the next triangle; nearly all the others agree.
        off = np.abs(hits["length"][met] - length[met])
        assert met.sum() > 60 and np.percentile(off, 98) < 1e-9 + 1e-14 * offset


def first_lengths(corners, origins, directions, sources):
    """Lengths to the first hit with the triangles (m, 3, 3) except each ray's source, by brute force."""
    lengths = np.empty(len(origins))
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    for i, (origin, direction, source) in enumerate(zip(origins, directions, sources, strict=True)):
        a, b, c = (corners[:, k] - origin for k in range(3))
        volumes = np.stack([np.cross(b, c) @ direction, np.cross(c, a) @ direction, np.cross(a, b) @ direction])
        length = np.sum(a * normal, 1) / (normal @ direction)
        met = (np.all(volumes >= 0, 0) | np.all(volumes <= 0, 0)) & (length > 0)
        met[source] = False
        lengths[i] = length[met].min(initial=np.inf)
    return lengths


@pytest.mark.parametrize("angle", [90, 20, 5])
@pytest.mark.parametrize("offset", [0.0, 1.0, 100.0])
def test_no_leaks_where_surfaces_meet_at_sharp_angles(angle, offset):
    """From within 1e-12 of a wedge's edges and corners; the sharp edge is on the axis."""
    rng = np.random.default_rng(6)
    x, y = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    vertices = np.array([[a, b, z] for z in (-1, 1) for a, b in ((0, 0), (1, 0), (x, y))], np.float32)
    faces = [(0, 2, 1), (3, 4, 5), (0, 1, 4), (0, 4, 3), (0, 3, 5), (0, 5, 2), (1, 2, 5), (1, 5, 4)]
    matrix = np.eye(4)
    matrix[:3, 3] = offset
    wedge = vertices, np.array(faces, np.uint32), matrix
    sources, origins, outward, inward = meshes.departures(rng, matrix, *wedge[:2], 20000, 1e-3)
    corners = meshes.transform(matrix, wedge[0])[wedge[1][sources[:, 1]]]
    weights = rng.dirichlet((0.05, 0.05, 0.05), len(sources))
    origins = np.einsum("ij,ijk->ik", weights, corners)
    scene = scene_of(wedge)
    assert np.all(scene.intersect(origins, outward, sources=sources)["fate"] == 1)
    assert np.all(scene.intersect(origins, inward, sources=sources)["fate"] == 4)


def test_updates_equal_a_fresh_scene():
    rng = np.random.default_rng(4)
    vertices, triangles = meshes.sphere(segments=48, rings=32)
    origins, directions = rng.uniform(-2, 2, (5000, 3)), meshes.directions(rng, 5000)
    scene = Scene()
    mesh = scene.add_mesh(vertices, triangles)
    instance = scene.add_instance(mesh, EYE)
    scene.commit()
    for step in range(6):
        amount = (0.02, 0.02, 0.02, 5.0, 0.02, 0.0)[step]  # refits and a rebuild
        vertices = vertices + rng.normal(0, amount * 0.1, vertices.shape).astype(np.float32)
        matrix = random_affine(rng)
        scene.update_mesh(mesh, vertices)
        scene.update_instance(instance, matrix)
        with pytest.raises(RuntimeError, match="not committed"):
            scene.intersect(origins, directions)
        scene.commit()
        edited, fresh = (
            scene.intersect(origins, directions),
            scene_of((vertices, triangles, matrix)).intersect(origins, directions),
        )
        for name in edited:
            np.testing.assert_array_equal(edited[name], fresh[name], err_msg=f"{name} after step {step}")
    scene.clear_instances()
    scene.commit()
    assert np.all(scene.intersect(origins, directions)["fate"] == 1)


def test_odd_triangles_are_survived_and_reported():
    good, triangles = meshes.sphere()
    count = len(good)
    odd = np.array(
        [
            [0, 0, 0],
            [0, 0, 0],
            [1, 1, 1],
            [2, 2, 2],
            [1e30, 0, 0],
            [0, 1e30, 0],
            [0, 0, 1e30],
            [1e-20, 0, 0],
            [0, 1e-20, 0],
            [3e38, 3e38, 0],
        ],
        np.float32,
    )
    extra = np.array([[0, 1, 2], [0, 0, 0], [1, 2, 3], [4, 5, 6], [0, 7, 8], [4, 9, 5]]) + count
    all_triangles = np.concatenate([triangles, extra, triangles[5:7, [1, 2, 0]]]).astype(np.uint32)
    scene = Scene()
    mesh = scene.add_mesh(np.concatenate([good, odd]), all_triangles)
    assert scene.report_mesh(mesh) == {"degenerate": 4, "too_large": 2, "duplicate": 2}
    scene.add_instance(mesh, EYE)
    scene.add_instance(scene.add_mesh(np.empty((0, 3), np.float32), np.empty((0, 3), np.uint32)), EYE)
    scene.commit()
    rng = np.random.default_rng(5)
    origins, directions = rng.uniform(-2, 2, (5000, 3)), meshes.directions(rng, 5000)
    hits, plain = scene.intersect(origins, directions), scene_of((good, triangles, EYE)).intersect(origins, directions)
    np.testing.assert_array_equal(hits["fate"], plain["fate"])
    np.testing.assert_array_equal(hits["position"], plain["position"])


def bad_edits():
    v, t = meshes.box((0, 0, 0), (1, 1, 1))
    nan = v.copy()
    nan[3, 1] = np.nan
    singular, shifted, hole = np.diag([1.0, 0, 1, 1]), np.eye(4), np.eye(4)
    shifted[3, 0] = 1
    return {
        "vertices: contains NaN": lambda s: s.add_mesh(nan, t),
        "float32 C-contiguous array of shape": lambda s: s.add_mesh(v.astype(float), t),
        "got uint32 .*, not C-contiguous": lambda s: s.add_mesh(v, np.asfortranarray(t)),
        "names vertex 8 of 8": lambda s: s.add_mesh(v, t + np.uint32(1)),
        "there is no mesh 7": lambda s: s.add_instance(7, EYE),
        "singular": lambda s: s.add_instance(0, singular),
        "last row": lambda s: s.add_instance(0, shifted),
        "world_from_mesh: contains NaN": lambda s: s.add_instance(0, EYE * np.nan),
        "must keep 8 vertices": lambda s: s.update_mesh(0, v[:5].copy()),
        "there is no instance 3": lambda s: s.update_instance(3, EYE),
        "same on all axes": lambda s: s.set_spacetime(Spacetime.ellis(1.0), np.diag([1.0, 2, 1, 1])),
        "mirror": lambda s: s.set_spacetime(Spacetime.ellis(1.0), np.diag([1.0, -1, 1, 1])),
        "overlap": lambda s: s.set_spacetime_objects([(Spacetime.ellis(1.0), hole, 3.0, -1)] * 2),
        "exit 5 is not": lambda s: s.set_spacetime_objects([(Spacetime.ellis(1.0), hole, 3.0, 5)]),
        "larger than its horizon": lambda s: s.set_spacetime_objects([(Spacetime.ellis(1.0), hole, 0.4, -1)]),
    }


@pytest.mark.parametrize("message", bad_edits())
def test_bad_edits_are_refused_and_change_nothing(message):
    scene = scene_of((*meshes.box((0, 0, 0), (1, 1, 1)), EYE))
    with pytest.raises(ValueError, match=message):
        bad_edits()[message](scene)
    assert scene.intersect(np.full((1, 3), 0.5), np.array([[0.0, 0, 1]]))["length"][0] == 0.5


@pytest.mark.parametrize(
    "change, message",
    [
        ({"origins": np.full((2, 3), np.nan)}, "origins: contains NaN"),
        ({"directions": np.zeros((2, 3))}, "ray 0"),
        ({"directions": np.ones((3, 3))}, "directions: expected"),
        ({"tolerance": 0.0}, "tolerances must be positive"),
        ({"tolerance": np.nan}, "tolerances must be positive"),
        ({"length_min": -1.0}, "length_min"),
        ({"length_min": 2.0, "length_max": 1.0}, "length_min"),
        ({"sources": np.array([[0, 12], [0, 3]], np.int32)}, "no triangle 12 of instance 0"),
    ],
)
def test_bad_rays_are_refused(change, message):
    scene = scene_of((*meshes.box((0, 0, 0), (1, 1, 1)), EYE))
    rays = {"origins": np.zeros((2, 3)), "directions": np.ones((2, 3))} | change
    with pytest.raises(ValueError, match=message):
        scene.intersect(**rays)


def test_threads_and_batches_agree():
    rng = np.random.default_rng(6)
    scene = scene_of((*meshes.soup(rng, 5000, 0.05), EYE))
    origins, directions = rng.uniform(-2, 2, (20000, 3)), meshes.directions(rng, 20000)
    whole = scene.intersect(origins, directions)
    parts = [None] * 7
    cuts = np.array_split(np.arange(20000), 7)

    def work(k):
        parts[k] = scene.intersect(origins[cuts[k]], directions[cuts[k]])

    threads = [threading.Thread(target=work, args=(k,)) for k in range(7)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for name in whole:
        np.testing.assert_array_equal(whole[name], np.concatenate([p[name] for p in parts]))


def test_cancelled_calls_say_so():
    from bentlight_native import Cancelled

    scene = scene_of((*meshes.box((0, 0, 0), (1, 1, 1)), EYE))
    progress = Progress()
    progress.cancel()
    with pytest.raises(Cancelled):
        scene.intersect(np.zeros((5, 3)), np.ones((5, 3)), progress=progress)
