"""Rays that join two points around a spinning hole: retraced rays, rays traced in a scene to marks at their ends,
constants of the motion, success rates, reciprocity, the limit without spin, areas of traced cones, the axis, bad luck.

Retracing uses ray_path and trace_rays, which share the equations of motion with the search, but neither its
derivatives nor its root finding; constants of the motion are the textbook's (rays.py).
"""

import numpy as np
import pytest
from bentlight_native import Scene, Spacetime, connect, connect_sky, ray_path, trace_rays
from rays import angle_between, kerr_functions, unit
from sanitized import fewer

NONE, MET, RING, COARSE, FAILED = range(5)
VALUES = ["launch", "arrival", "spread", "frequency_ratio", "swept", "error"]


def length(vectors):
    return np.linalg.norm(vectors, axis=-1)


def horizon(spin):
    return 1 + np.sqrt(1 - spin**2)


def random_points(seed, n, spin, low, high):
    """Directions even on the sphere, radii r even in the logarithm from low to high horizons."""
    rng = np.random.default_rng(seed)
    r = horizon(spin) * np.exp(rng.uniform(np.log(low), np.log(high), (n, 1)))
    return unit(rng.normal(size=(n, 3))) * np.concatenate([np.hypot(r, spin), np.hypot(r, spin), r], 1)


def random_pairs(spin, n, low, high, seed=1):
    ends = (random_points(seed + k, n, spin, low, high) for k in range(2))
    return Spacetime.kerr(1, spin), *ends


class Place:
    """Boyer-Lindquist coordinates, local frame and metric functions of points (M = 1)."""

    def __init__(self, spin, x):
        half = 0.5 * (np.sum(x * x, -1) - spin**2)
        self.r = r = np.sqrt(half + np.sqrt(half**2 + (spin * x[..., 2]) ** 2))
        out = np.hypot(x[..., 0], x[..., 1])
        self.cosine, self.sine = x[..., 2] / r, out / np.hypot(r, spin)
        sigma, delta, area = kerr_functions(spin, r, self.sine, self.cosine)
        q, zero, x1, y1 = np.hypot(r, spin), 0 * r, x[..., 0] / out, x[..., 1] / out
        root = np.sqrt(sigma)[..., None]
        er = np.stack([r * self.sine * x1, r * self.sine * y1, q * self.cosine], -1) / root
        et = np.stack([q * self.cosine * x1, q * self.cosine * y1, -r * self.sine], -1) / root
        self.east = np.stack([-y1, x1, zero], -1)
        self.basis = np.stack([er, et, self.east], -2)
        self.lapse, self.east_root = np.sqrt(sigma * delta / area), np.sqrt(area / sigma)
        self.drag = 2 * spin * r / area
        self.sigma = sigma
        # local lengths of displacements of the chart, along the basis
        self.stretch = np.stack([q / np.sqrt(delta), np.ones_like(r), self.east_root / q], -1)
        # the ZAMO sees places of the chart move along -phi; rays are traced against time, so along +phi for spin > 0
        self.wind = -(self.drag * self.east_root * self.sine / self.lapse)[..., None] * self.east

    def local(self, displacement):
        parts = np.einsum("...ij,...j->...i", self.basis, displacement) * self.stretch
        return np.einsum("...i,...ij->...j", parts, self.basis)

    def constants(self, spin, direction):
        """L / E and Q / E^2 of rays traced against time: the hole spins the other way."""
        d = np.einsum("...ij,...j->...i", self.basis, direction)
        momentum = d[..., 2] * self.east_root * self.sine
        energy = self.lapse - self.drag * momentum
        polar = d[..., 1] ** 2 * self.sigma
        carter = polar + self.cosine**2 * ((d[..., 2] * self.east_root) ** 2 - spin**2 * energy**2)
        return momentum / energy, carter / energy**2, energy


def closest(space, spin, origin, launch, target, swept):
    """Point of the ray nearest to a target, and its direction, in the chart. In Mino time it turns at the rate
    sqrt(C + s^2 E^2 n_z^2), which bounds the time; radial rays get the whole range."""
    momentum, carter, energy = Place(spin, origin).constants(spin, launch)
    curl = (carter + momentum**2) * energy**2
    low = swept / np.sqrt(curl + (spin * energy) ** 2) * 0.999
    high = swept / np.sqrt(curl) * 1.001 if curl > 1e-3 else 20.0
    for _ in range(14):
        times = np.linspace(low, high, 17) if _ or high < 3 * low else np.geomspace(max(low, 1e-7), high, 400)
        path = ray_path(space, origin, launch, times, 1e-14)["position"]
        k = np.nanargmin(length(path - target))
        low, high = times[max(k - 1, 0)], times[min(k + 1, len(times) - 1)]
        if high - low < 1e-7 * high:
            break
    times = np.linspace(low, high, 3)
    path = ray_path(space, origin, launch, times, 1e-14)["position"]
    return path[1], unit(path[2] - path[0])


def misses(space, spin, a, b, launch, swept):
    """Distances by which retraced rays pass b, over its scene radius."""
    missed = np.empty(len(a))
    for i in range(len(a)):
        point, along = closest(space, spin, a[i], launch[i], b[i], swept[i])
        missed[i] = length(np.cross(point - b[i], along)) / length(b[i])
    return missed


@pytest.mark.parametrize(("spin", "low", "high"), [(0.3, 1.05, 50), (0.9, 1.05, 50), (-0.9, 3, 1e3), (0.999, 1.05, 50)])
def test_retraced_rays_meet_their_target(spin, low, high):
    space, a, b = random_pairs(spin, 300, low, high, seed=11)
    got = connect(space, a, b, 2, 1e-8)
    for k in range(2):
        found = np.isin(got["status"][:, k], (MET, COARSE))
        assert np.mean(found) > 0.93
        launch, swept, error = (got[key][found, k] for key in ("launch", "swept", "error"))
        missed = misses(space, spin, a[found], b[found], launch, swept)
        assert np.all(missed <= error + 1e-10)  # retraced to about 1e-10
        assert np.all(missed[got["status"][found, k] == MET] <= 1e-8 + 1e-10)


def test_errors_beside_the_poles_of_the_horizon():
    """There the oblate chart stretches angles over the radius by up to sqrt(2)."""
    space, a, b = random_pairs(0.999, 300, 1.1, 20, seed=13)
    r = horizon(0.999) * np.random.default_rng(14).uniform(1.2, 1.6, (300, 1))
    n = unit(b * [0.1, 0.1, 1])
    b = n * np.concatenate([np.hypot(r, 0.999), np.hypot(r, 0.999), r], 1)
    got = connect(space, a, b, 1, 1e-7)
    found = np.isin(got["status"][:, 0], (MET, COARSE))
    assert np.mean(found) > 0.95
    launch, swept, error = (got[key][found, 0] for key in ("launch", "swept", "error"))
    assert np.all(misses(space, 0.999, a[found], b[found], launch, swept) <= error + 1e-10)


def test_the_last_step_of_newton():
    """Rays meet their target far better than the tolerance, which bounds the last step that needs no trial."""
    space, a, b = random_pairs(0.9, fewer(2000), 1.2, 50, seed=15)
    got, exact = (connect(space, a, b, 2, tolerance) for tolerance in (1e-6, 1e-12))
    same = (got["status"] == MET) & (exact["error"] < 1e-9) & (np.abs(got["swept"] - exact["swept"]) < 1e-2)
    assert np.mean(same) > 0.99
    for end in ("launch", "arrival"):
        assert np.quantile(angle_between(got[end], exact[end])[same], 0.99) < 1e-8
    spread = np.abs(got["spread"] / exact["spread"] - 1)[same]
    assert np.median(spread) < 3e-6
    assert np.quantile(spread, 0.99) < 2e-5


# Rates of first and second images that bentlight/connect.h states, less half of a unit of their last digit; of spin
# 0.5, which it does not name, the like.
MANY = [
    (0.5, 1.001, 1e3, 20000, 0.9999, 0.9996),
    (0.9, 3, 100, 30000, 0.99985, 0.99975),
    (0.9, 1.001, 1e3, 20000, 0.9985, 0.9985),
    (0.999, 3, 100, 20000, 0.99985, 0.99945),
    (0.999, 1.001, 1e3, 10000, 0.9915, 0.9885),
]


def least(rate, pairs):
    """A success rate that so many random pairs fall below by chance once in 30,000 times (four standard errors)."""
    return rate - 4 * np.sqrt(rate * (1 - rate) / pairs)


@pytest.mark.parametrize(("spin", "low", "high", "pairs", "first", "second"), MANY)
def test_many_pairs(spin, low, high, pairs, first, second):
    """Success rates, and the ends are on one geodesic: constants of the motion agree, and rays traced on from b and
    from a go to the same place. Errors of the ends grow on the way; how much is measured beside them."""
    space, a, b = random_pairs(spin, fewer(pairs), low, high, seed=3)
    tolerance = 1e-7
    got = connect(space, a, b, 2, tolerance)
    assert sum(got["counts"].values()) == 2 * len(a)
    for k, rate in enumerate((first, second)):
        met = got["status"][:, k] == MET
        assert np.mean(met) >= least(rate, len(a))
        launch, arrival = got["launch"][met, k], got["arrival"][met, k]
        here, there = Place(spin, a[met]).constants(spin, launch), Place(spin, b[met]).constants(spin, arrival)
        scale = 1 + np.abs(here[0]) + np.abs(here[1]) ** 0.5  # impact parameter
        assert np.quantile(np.abs(there[0] - here[0]) / scale, 0.999) < 10 * tolerance
        ratio = there[2] / here[2]
        assert np.quantile(np.abs(got["frequency_ratio"][met, k] / ratio - 1), 0.999) < 10 * tolerance
        from_a, from_b = trace_rays(space, a[met], launch, 1e-11), trace_rays(space, b[met], arrival, 1e-11)
        growth, alike = np.zeros(len(launch)), from_a["fate"] == from_b["fate"]
        for side in (unit(np.cross(arrival, [0.3, -0.5, 0.8])), unit(np.cross(arrival, [0.7, 0.2, -0.4]))):
            for shift in (-1e-6, 1e-6):
                aside = trace_rays(space, b[met], arrival + shift * side, 1e-11)
                turned = angle_between(aside["direction"], from_b["direction"])
                growth = np.fmax(growth, turned / np.abs(shift))
                alike |= aside["fate"] == from_a["fate"]  # beside the critical ray either may happen
        assert np.all(alike)
        apart = angle_between(from_a["direction"], from_b["direction"])
        near = np.isfinite(apart) & np.isfinite(growth)
        assert np.mean((apart / (1 + growth))[near] < 30 * tolerance) > 0.9999
    # two images of a pair are two rays
    both = np.all(got["status"] == MET, 1)
    distinct = length(got["launch"][both, 0] - got["launch"][both, 1]) > 1e-7
    assert np.all(distinct | (np.abs(got["swept"][both, 0] - got["swept"][both, 1]) > 1))


OCTAHEDRON = np.concatenate([np.eye(3), -np.eye(3)])
FACES = np.array([[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]])
MARK = 3e-4  # size of marks, over their radius


def marked_scene(space, places):
    """An octahedron around each place, in which triangles 8 k to 8 k + 7 are those of place k."""
    scene = Scene()
    scene.set_spacetime(space)
    vertices = places[:, None] + MARK * length(places)[:, None, None] * OCTAHEDRON
    triangles = 6 * np.arange(len(places))[:, None, None] + FACES
    mesh = vertices.reshape(-1, 3).astype(np.float32), triangles.reshape(-1, 3).astype(np.uint32)
    scene.add_instance(scene.add_mesh(*mesh), np.eye(4))
    scene.commit()
    return scene


def passes(space, spin, a, b, launch):
    """By how much, over the radius of b, rays traced in a scene pass b; NaN where they do not come to the mark at b."""
    missed, left = np.full(len(a), np.nan), np.arange(len(a))
    while len(left):
        hit = marked_scene(space, b[left]).intersect(a[left], launch[left], tolerance=3e-5)
        met = (hit["fate"] == 4) & (hit["triangle"] // 8 == np.arange(len(left)))
        place = Place(spin, b[left[met]])
        off, along = place.local(hit["position"][met] - b[left[met]]), unit(hit["direction"][met] + place.wind)
        missed[left[met]] = length(np.cross(off, along)) / length(b[left[met]])
        others = (hit["fate"] == 4) & ~met  # they have met another's mark before: once more, without that
        assert met.any()
        left = left[others]
    return missed


@pytest.mark.parametrize(("spin", "low", "high"), [row[:3] for row in MANY])
def test_every_image_of_many_pairs_meets_its_target(spin, low, high):
    """Of 1e5 pairs over all spins, as shadow rays are traced: each comes to a small mark at b, and passes b in it as
    near as the tolerances say, that of the join and that by which rays are traced."""
    space, a, b = random_pairs(spin, fewer(20000), low, high, seed=5)
    got = connect(space, a, b, 2, 1e-6)
    for k in range(2):
        met = got["status"][:, k] == MET
        missed = passes(space, spin, a[met], b[met], got["launch"][met, k])
        assert met.mean() > 0.98 and not np.isnan(missed).any()
        assert np.median(missed) < 1e-7 and np.quantile(missed, 0.998) < 1e-5, np.quantile(missed, [0.5, 0.998])


@pytest.mark.parametrize("spin", [0.2, 0.9, 0.99])
def test_the_sky(spin):
    space, a, _ = random_pairs(spin, 5000, 1.05, 100, seed=17)
    wanted = unit(np.random.default_rng(18).normal(size=(5000, 3)))
    got = connect_sky(space, a, 7 * wanted, 2, 1e-9)
    for k in range(2):
        met = got["status"][:, k] == MET
        assert np.mean(met) > (0.985 if spin > 0.95 else 0.997)
        traced = trace_rays(space, a[met], got["launch"][met, k], 1e-13)
        assert np.all(traced["fate"] == 1)
        missed = angle_between(traced["direction"], wanted[met])
        assert np.all(missed <= got["error"][met, k] + traced["error"])
        assert np.all(np.abs(got["arrival"][met, k] - wanted[met]) < 1e-15)
        assert np.all(np.abs(traced["swept"] - got["swept"][met, k]) < 1e-4 * (1 + traced["swept"]))
        energy = Place(spin, a[met]).constants(spin, got["launch"][met, k])[2]
        assert np.allclose(got["frequency_ratio"][met, k], 1 / energy, rtol=1e-9)


@pytest.mark.parametrize("spin", [0.5, 0.95])
def test_spread_of_the_sky(spin):
    """Solid angles by central differences of traced rays."""
    space, a, _ = random_pairs(spin, 1000, 1.2, 30, seed=19)
    wanted = unit(np.random.default_rng(20).normal(size=(1000, 3)))
    got = connect_sky(space, a, wanted, 2, 1e-11)
    for k in range(2):
        met = got["error"][:, k] < 1e-10
        launch, spread = got["launch"][met, k], got["spread"][met, k]
        across = [unit(np.cross(launch, [[0.3, -0.5, 0.8]]))]
        across.append(np.cross(launch, across[0]))
        h = (1e-4 / np.maximum(1, np.sqrt(spread)))[:, None]
        change = []
        for side in across:
            ends = [trace_rays(space, a[met], launch + s * h * side, 1e-14)["direction"] for s in (-2, -1, 1, 2)]
            change.append((8 * (ends[2] - ends[1]) - (ends[3] - ends[0])) / (12 * h))
        error = np.abs(np.abs(np.sum(np.cross(*change) * wanted[met], -1)) / spread - 1)
        assert np.median(error) < 1e-8
        assert np.nanquantile(error, 0.98) < 1e-5


@pytest.mark.parametrize("spin", [0.5, -0.95])
def test_spread_is_the_area_of_a_traced_cone(spin):
    """The piece of a surface at b that a cone of rays covers. The surface rests in the chart, past which the ZAMO
    moves: its area is spread (1 + n.v) / |N.(n + v)| with the direction n of arrival and v of places of the chart."""
    space, a, b = random_pairs(spin, 40, 1.3, 20, seed=9)
    got = connect(space, a, b, 2, 1e-11)
    place, rng = Place(spin, b), np.random.default_rng(4)
    errors = []
    for i, k in np.argwhere(np.isin(got["status"], (MET, COARSE))):
        launch, arrival, swept = (got[key][i, k] for key in ("launch", "arrival", "swept"))
        normal = unit(arrival + 0.4 * rng.normal(size=3))  # local; of the chart: the covector
        stretch = np.einsum("ij,i,ik->jk", place.basis[i], place.stretch[i], place.basis[i])
        covector = stretch.T @ normal
        across = [unit(np.cross(launch, [0.3, -0.5, 0.8]))]
        across.append(np.cross(launch, across[0]))
        h = 1e-4 / max(1, np.sqrt(got["spread"][i, k]) / length(b[i]))
        change = []
        for side in across:
            ends = []
            for step in (-1, 1):
                look = unit(launch + step * h * side)
                point, along = closest(space, spin, a[i], look, b[i], swept)
                for _ in range(2):  # from the nearest point to the surface
                    point = point + along * np.dot(covector, b[i] - point) / np.dot(covector, along)
                ends.append(point)
            change.append(stretch @ (ends[1] - ends[0]) / (2 * h))
        area = np.abs(np.dot(np.cross(*change), normal))
        wind = place.wind[i]
        expected = got["spread"][i, k] * (1 + np.dot(arrival, wind)) / np.abs(np.dot(normal, arrival + wind))
        errors.append(area / np.abs(expected) - 1)
    assert len(errors) > 70
    assert np.median(np.abs(errors)) < 1e-5
    assert np.quantile(np.abs(errors), 0.9) < 1e-3


@pytest.mark.parametrize("spin", [0.4, 0.95])
def test_reciprocity(spin):
    """Against time the hole spins the other way: the same ray joins b and a, with the same spread / g (Etherington)."""
    space, a, b = random_pairs(spin, 2000, 1.2, 100, seed=7)
    there, back = connect(space, a, b, 2, 1e-10), connect(Spacetime.kerr(1, -spin), b, a, 2, 1e-10)
    known = (there["error"] < 1e-8) & (back["error"] < 1e-8)
    same = known & (angle_between(there["launch"], -back["arrival"]) < 1e-6)
    assert np.mean(known) > 0.99
    assert np.mean(same[known]) > 0.995  # beside the caustics the order of two images may differ
    assert np.max(angle_between(there["arrival"], -back["launch"])[same]) < 1e-6
    assert np.max(np.abs(there["frequency_ratio"] * back["frequency_ratio"] - 1)[same]) < 1e-6
    forth, home = (got["spread"] / got["frequency_ratio"] for got in (there, back))
    assert np.quantile(np.abs(home / forth - 1)[same], 0.999) < 1e-8
    assert np.median(np.abs(home / forth - 1)[same]) < 1e-9


def test_the_limit_without_spin():
    areal = Spacetime.schwarzschild(1, "areal")
    for spin in (1e-12, 1e-6):
        space, a, b = random_pairs(spin, 2000, 1.01, 1e3, seed=23)
        none, some = connect(areal, a, b, 2, 1e-10), connect(space, a, b, 2, 1e-10)
        assert np.mean(some["status"] == MET) > 0.999
        met = (some["status"] == MET) & (none["status"] == MET)
        assert np.max(angle_between(none["launch"], some["launch"])[met]) < 1e-8 + 100 * spin
        assert np.quantile(np.abs(some["spread"] / none["spread"] - 1)[met], 0.99) < 1e-7 + 1e3 * spin
        assert np.max(np.abs(some["swept"] - none["swept"])[met]) < 1e-4 + 1e3 * spin


def test_the_mirror_image_spins_the_other_way():
    space, a, b = random_pairs(0.8, 500, 1.5, 50, seed=25)
    mirror = np.array([1, -1, 1])
    one, other = connect(space, a, b, 2), connect(Spacetime.kerr(1, -0.8), mirror * a, mirror * b, 2)
    met = (one["status"] == MET) & (other["status"] == MET)
    assert np.mean(met) > 0.99
    same = angle_between(one["launch"], mirror * other["launch"])[met] < 1e-7
    assert np.mean(same) > 0.999


def test_units_of_length():
    space, a, b = random_pairs(0.8, 200, 1.5, 50, seed=26)
    one, other = connect(space, a, b), connect(Spacetime.kerr(1e-3, 0.8e-3), 1e-3 * a, 1e-3 * b)
    met = (one["status"] == MET) & (other["status"] == MET)
    assert np.mean(met) > 0.99
    assert np.max(angle_between(one["launch"], other["launch"])[met]) < 1e-7
    assert np.quantile(np.abs(other["spread"] * 1e6 / one["spread"] - 1)[met], 0.99) < 1e-6


def test_the_axis_and_the_line_through_the_center():
    """Both ends on the axis: rings, spread 0. One end on it, or a, the center and b in line off it: nothing special."""
    space = Spacetime.kerr(1, 0.9)
    on_axis = np.array([[0.0, 0, 5], [0, 0, 30], [0, 0, -8]])
    got = connect(space, on_axis, -1.5 * on_axis, 2, 1e-8)
    assert np.all(got["status"] == RING)
    assert np.all(got["spread"] == 0)
    above = connect(space, on_axis, 1.5 * on_axis, 2, 1e-8)
    assert np.all(above["status"][:, 0] == MET)
    assert np.allclose(np.abs(above["launch"][:, 0, 2]), 1, atol=1e-12)
    _, _, b = random_pairs(0.9, 3, 2, 50, seed=31)
    one = connect(space, on_axis, b, 2, 1e-8)
    assert np.all(one["status"] == MET)
    a = random_points(41, 300, 0.9, 3, 50)
    line = connect(space, a, -1.7 * a, 2, 1e-8)
    assert np.mean(line["status"] == MET) > 0.97
    found = np.isin(line["status"][:, 0], (MET, COARSE))
    assert np.all(line["spread"][found, 0] > 0)
    missed = misses(space, 0.9, a[found], -1.7 * a[found], line["launch"][found, 0], line["swept"][found, 0])
    assert np.all(missed <= line["error"][found, 0] + 1e-10)


def test_inside_the_photon_sphere():
    space, a, b = random_pairs(0.9, 1000, 1.02, 1.6, seed=33)
    got = connect(space, a, b, 2, 1e-8)
    assert np.mean(got["status"][:, 0] == MET) > 0.97
    assert np.mean(got["status"][:, 1] == MET) > 0.92


def test_relativistic_images():
    space, a, b = random_pairs(0.7, 300, 3, 50, seed=35)
    got = connect(space, a, b, 4, 1e-8)
    found = np.isin(got["status"], (MET, COARSE))
    assert np.all(np.mean(found, 0) > [0.99, 0.99, 0.98, 0.8])
    assert np.all((got["status"] == COARSE)[found] == (got["error"] > 1e-8)[found])
    for k in (2, 3):
        use = found[:, k]
        assert np.all(got["swept"][use, k] > 4)
        missed = misses(space, 0.7, a[use], b[use], got["launch"][use, k], got["swept"][use, k])
        assert np.all(missed <= got["error"][use, k] + 1e-9)


def test_coincident_points_have_no_first_image():
    point = [[5.0, 1, 2]]
    got = connect(Spacetime.kerr(1, 0.9), point, point, 2)
    assert got["status"][0, 0] == FAILED
    assert np.isnan(got["launch"][0, 0]).all()


def test_faint_images_end_the_list():
    space, a, b = random_pairs(0.9, 500, 3, 100, seed=27)
    full, short = connect(space, a, b, 3), connect(space, a, b, 3, min_share=1e-3)
    met = np.all(np.isin(full["status"], (MET, COARSE)), 1)
    light = 1 / full["spread"][met]
    faint = light[:, 1:] < 1e-3 * np.cumsum(light, 1)[:, :-1]
    expected = np.concatenate([np.ones((len(light), 1), bool), ~np.logical_or.accumulate(faint, 1)], 1)
    assert np.array_equal(short["status"][met] != NONE, expected)
    assert 0.2 < expected.mean() < 0.9


def test_an_answer_depends_on_its_pair_alone():
    space, a, b = random_pairs(0.95, 203, 1.1, 100, seed=29)
    order = np.random.default_rng(0).permutation(203)
    one, other = connect(space, a, b, 3), connect(space, a[order], b[order], 3)
    assert all(np.array_equal(one[key][order], other[key], equal_nan=True) for key in ["status", *VALUES])


@pytest.mark.parametrize(("low", "high"), [(1 + 1e-12, 1.01), (1 + 1e-9, 1e12), (1e5, 1e7)])
def test_extreme_radii(low, high):
    """Next to the horizon and very far: finite, and honest about what was not found."""
    space, a, b = random_pairs(0.9, 300, low, high, seed=43)
    got = connect(space, a, b, 4, 1e-8)
    found = np.isin(got["status"], (MET, COARSE))
    assert all(np.isfinite(got[key][found]).all() for key in VALUES)
    assert np.all((got["status"] == COARSE)[found] == (got["error"] > 1e-8)[found])
    assert np.isnan(got["launch"][got["status"] == FAILED]).all()
    if low > 1e3:
        assert np.all(got["status"][:, 0] == MET)
