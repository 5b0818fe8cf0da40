"""Rays that join two points: golden images, retraced rays, closed forms, reciprocity, rings, the sky, bad input.

Retracing uses the Taylor arcs of ray_path and the routes of trace_rays, which share no equation with the search. In
Mino time a planar ray turns at the constant rate L, so it has swept Phi after Phi / L.
"""

import numpy as np
import pytest
from bentlight_native import (
    CONNECTION_STATES,
    Cancelled,
    Progress,
    Spacetime,
    connect,
    connect_sky,
    ray_path,
    trace_rays,
)
from golden import numbers, rows
from rays import angle_between, isotropic_radius, unit
from sanitized import fewer

NONE, MET, RING, COARSE, FAILED = range(5)
AREAL, ISOTROPIC, ELLIS = Spacetime.schwarzschild(1, "areal"), Spacetime.schwarzschild(1), Spacetime.ellis(1)
# innermost and outermost radius of random points, in units of the core's; Ellis: both sides of the throat
SPACES = {"areal": (AREAL, 1.001, 1e3), "isotropic": (ISOTROPIC, 1.001, 1e3), "ellis": (ELLIS, 1e-3, 1e3)}
VALUES = ["launch", "arrival", "spread", "frequency_ratio", "swept", "error"]


def random_points(seed, n, low, high):
    """Directions even on the sphere, radii even in the logarithm."""
    rng = np.random.default_rng(seed)
    return unit(rng.normal(size=(n, 3))) * np.exp(rng.uniform(np.log(low), np.log(high), (n, 1)))


def random_pairs(name, n, seed=1):
    space, low, high = SPACES[name]
    low, high = low * space.core_radius, high * space.core_radius
    return space, random_points(seed, n, low, high), random_points(seed + 1, n, low, high)


def length(vectors):
    return np.linalg.norm(vectors, axis=-1)


def stretch(space, points):
    """Local length over scene length, across the radial direction."""
    radius = length(points)
    if space.chart == "areal":
        return np.ones_like(radius)
    return (1 + 0.5 * space.mass / radius) ** 2 if space.mass else 1 + (space.core_radius / radius) ** 2


def lapse_squared(space, points):
    radius = length(points)
    if not space.mass:
        return np.ones_like(radius)
    if space.chart == "areal":
        return 1 - 2 * space.mass / radius
    return ((radius - 0.5 * space.mass) / (radius + 0.5 * space.mass)) ** 2


def chart_direction(space, points, local):
    """The scene direction of a local direction: the areal chart is stretched along the radius."""
    if space.chart != "areal":
        return local
    outward = unit(points)
    along = np.sum(outward * local, -1, keepdims=True)
    return unit(local + (np.sqrt(lapse_squared(space, points))[..., None] - 1) * along * outward)


def retrace(space, points, launches, swept):
    """Where rays are once they have swept an angle about the center."""
    turning = length(points) * stretch(space, points) * length(np.cross(unit(points), launches))
    ends = np.empty_like(points)
    for i, (point, launch, time) in enumerate(zip(points, launches, swept / turning, strict=True)):
        path = ray_path(space, point, launch, [time], 1e-14)
        ends[i] = path["position"][0]
        if path["far"][0]:  # from the other mouth's axes back to the one continuous chart
            ends[i] *= np.array([1, -1, 1]) * space.core_radius**2 / np.dot(ends[i], ends[i])
    return ends


def misses(space, a, b, launches, arrivals, swept):
    """Distances by which retraced rays pass b, over its scene radius."""
    apart = retrace(space, a, launches, swept) - b
    return length(np.cross(apart, chart_direction(space, b, arrivals))) / length(b)


GOLDEN = rows("images.csv")
GOLDEN_RING = np.array([row["type"] == "einstein_ring" for row in GOLDEN])
GOLDEN_IMAGE = np.where(GOLDEN_RING, 2, 1) * numbers(GOLDEN, "order").astype(int)


@pytest.mark.parametrize("scale", [1.0, 1e-6, 1e6])
@pytest.mark.parametrize("chart", ["areal", "isotropic"])
def test_golden_images_and_einstein_rings(chart, scale):
    r_obs, r_src = numbers(GOLDEN, "r_obs"), numbers(GOLDEN, "r_src")
    offset = np.deg2rad(numbers(GOLDEN, "offset_deg"))
    outward = np.stack([-np.cos(offset), np.sin(offset), np.zeros_like(offset)], -1)
    outward[GOLDEN_RING] = [-1.0, 0, 0]
    radius = isotropic_radius if chart == "isotropic" else np.asarray
    a = scale * radius(r_obs)[:, None] * np.array([1.0, 0, 0])
    b = scale * radius(r_src)[:, None] * outward
    got = connect(Spacetime.schwarzschild(scale, chart), a, b, 6, 1e-8)
    got = {key: got[key][np.arange(len(GOLDEN)), GOLDEN_IMAGE] for key in ["status", *VALUES]}
    assert np.all(got["status"] == np.where(GOLDEN_RING, RING, MET))
    assert np.all(got["error"] <= 1e-8)
    got_psi = np.arctan2(length(got["launch"][:, 1:]), -got["launch"][:, 0])
    assert np.max(np.abs(got_psi - numbers(GOLDEN, "psi_from_inward_rad"))) < 2e-10
    assert np.max(np.abs(got["swept"] - numbers(GOLDEN, "swept_azimuth"))) < 4e-15
    ratio = numbers(GOLDEN, "redshift_static_src=nu_obs/nu_src")
    assert np.max(np.abs(got["frequency_ratio"] / ratio - 1)) < 1e-14
    # the golden magnification is of a patch of the sphere r = r_src, seen in curved and in flat space
    flat = np.stack([r_src * np.cos(offset) + r_obs, r_src * np.sin(offset)], -1)
    flat_cosine = (r_src + r_obs * np.cos(offset)) / length(flat)
    cosine = np.abs(np.sum(got["arrival"] * outward, -1))
    image = ~GOLDEN_RING
    magnification = (cosine * length(flat) ** 2 / flat_cosine)[image] / got["spread"][image] * scale**2
    assert np.max(np.abs(magnification / numbers(GOLDEN, "magnification")[image] - 1)) < 2e-8
    assert np.all(got["spread"][GOLDEN_RING] == 0)


@pytest.mark.parametrize(("tolerance", "pairs"), [(1e-5, 3000), (1e-8, 100000), (1e-11, 3000)])
@pytest.mark.parametrize("name", SPACES)
def test_retraced_rays_meet_their_target(name, tolerance, pairs):
    space, a, b = random_pairs(name, fewer(pairs))
    got = connect(space, a, b, 2, tolerance)
    assert not got["counts"]["failed"]
    if tolerance >= 1e-8:
        assert got["counts"]["met"] == 2 * len(a)
    for k in range(2):
        missed = misses(space, a, b, *(got[key][:, k] for key in ("launch", "arrival", "swept")))
        assert np.all(missed <= got["error"][:, k])
        met = got["status"][:, k] == MET
        assert np.count_nonzero(met) > 0.9 * len(a)
        assert np.all(missed[met] <= tolerance)


@pytest.mark.parametrize("name", SPACES)
def test_relativistic_images(name):
    space, a, b = random_pairs(name, 300, seed=5)
    got = connect(space, a, b, 6, 1e-8)
    assert not got["counts"]["failed"]
    assert got["counts"]["coarse"] > 0  # the sixth image's landing point magnifies rounding by e^swept
    for k in range(6):
        missed = misses(space, a, b, *(got[key][:, k] for key in ("launch", "arrival", "swept")))
        assert np.all(missed <= got["error"][:, k])
        assert np.all(missed[got["status"][:, k] == MET] <= 1e-8)
    fainter = got["spread"][:, :-1] / got["spread"][:, 1:]
    assert np.all(fainter[:, 1:] < 1)
    assert np.allclose(fainter[:, 3] * fainter[:, 4], np.exp(-2 * np.pi), rtol=0.02)  # one more turn


@pytest.mark.parametrize("name", SPACES)
def test_many_pairs_are_found(name):
    """Nothing fails, and two images are as good as asked."""
    space, a, b = random_pairs(name, 100000, seed=3)
    got = connect(space, a, b, 2, 1e-7)
    assert got["counts"] == {"none": 0, "met": 200000, "ring": 0, "coarse": 0, "failed": 0}
    assert all(np.isfinite(got[key]).all() for key in VALUES)
    assert np.allclose(length(got["launch"]), 1, atol=1e-14)
    assert np.allclose(length(got["arrival"]), 1, atol=1e-14)
    assert np.all(got["spread"] > 0)


@pytest.mark.parametrize("name", SPACES)
def test_reciprocity(name):
    """The way back is the same ray, and lapse_a^2 dA_b / d(omega_a) is symmetric (Etherington 1933)."""
    space, a, b = random_pairs(name, 3000, seed=7)
    there, back = connect(space, a, b, 3, 1e-10), connect(space, b, a, 3, 1e-10)
    assert np.max(angle_between(there["launch"], -back["arrival"])) < 1e-9
    assert np.max(angle_between(there["arrival"], -back["launch"])) < 1e-9
    assert np.max(np.abs(there["frequency_ratio"] * back["frequency_ratio"] - 1)) < 1e-14
    forth = there["spread"] * lapse_squared(space, a)[:, None]
    assert np.max(np.abs(back["spread"] * lapse_squared(space, b)[:, None] / forth - 1)) < 1e-8


@pytest.mark.parametrize("name", ["isotropic", "ellis"])
def test_spread_is_the_area_of_a_traced_cone(name):
    """Central differences of fourth order; in conformally flat charts areas are scene areas times stretch^2."""
    space = SPACES[name][0]
    a, b = (random_points(seed, 500, 0.05 if name == "ellis" else 0.6, 20) for seed in (9, 10))
    got = connect(space, a, b, 2, 1e-12)
    for k in range(2):
        launch, arrival, swept = (got[key][:, k] for key in ("launch", "arrival", "swept"))
        across = [unit(np.cross(launch, [[0.3, -0.5, 0.8]]))]
        across.append(np.cross(launch, across[0]))
        reach = np.sqrt(got["spread"][:, k]) / stretch(space, b) / length(b)  # of the landing point, per radian
        h = (1e-4 / np.maximum(1, reach))[:, None]
        turning = length(a) * stretch(space, a) * length(np.cross(unit(a), launch))
        change = []
        for side in across:
            ends = []
            for step in (-2, -1, 1, 2):
                look = unit(launch + step * h * side)
                rate = length(a) * stretch(space, a) * length(np.cross(unit(a), look))
                ends.append(retrace(space, a, look, swept * rate / turning))
            change.append((8 * (ends[2] - ends[1]) - (ends[3] - ends[0])) / (12 * h))
        area = np.abs(np.sum(np.cross(*change) * arrival, -1)) * stretch(space, b) ** 2
        error = np.abs(area / got["spread"][:, k] - 1)
        assert np.median(error) < 1e-9
        assert np.max(error) < 1e-5


def test_both_charts_draw_the_same_rays():
    space, a, b = random_pairs("areal", 1000, seed=11)
    drawn = [unit(x) * isotropic_radius(length(x))[:, None] for x in (a, b)]
    areal, isotropic = connect(space, a, b, 2, 1e-10), connect(ISOTROPIC, *drawn, 2, 1e-10)
    near_horizon = 1 / np.minimum(length(a), length(b)) ** 2 / np.minimum(length(a) - 2, length(b) - 2)
    for key in ("launch", "arrival"):
        assert np.all(length(areal[key] - isotropic[key]).max(1) < 1e-9 + 1e-14 * near_horizon)
    assert np.all(np.abs(areal["spread"] / isotropic["spread"] - 1).max(1) < 1e-8 + 1e-13 * near_horizon)


def test_flat_space_has_the_straight_ray():
    a, b = random_points(1, 1000, 0.01, 100), random_points(2, 1000, 0.01, 100)
    distance = length(b - a)
    for space in (Spacetime.minkowski(), Spacetime.schwarzschild(0), Spacetime.kerr(0, 0)):
        got = connect(space, a, b, 3)
        assert np.all(got["status"] == [MET, NONE, NONE])
        assert np.allclose(got["launch"][:, 0], unit(b - a), atol=1e-15)
        assert np.allclose(got["spread"][:, 0], distance**2, rtol=1e-14)
        assert np.isnan(got["launch"][:, 1:]).all()
        sky = connect_sky(space, a, b)
        assert np.allclose(sky["launch"][:, 0], unit(b), atol=1e-15)
        assert np.all(sky["spread"][:, 0] == 1)


@pytest.mark.parametrize("chart", ["areal", "isotropic"])
def test_the_limit_of_small_mass(chart):
    """A ray that passes the center at p is bent by 4 M / p; the rest is flat."""
    mass = 1e-9
    a, b = random_points(1, 1000, 0.1, 10), random_points(2, 1000, 0.1, 10)
    got = connect(Spacetime.schwarzschild(mass, chart), a, b, 1, 1e-13)
    passing = length(np.cross(a, b)) / length(b - a)
    bend = 10 * mass / np.minimum(passing, np.minimum(length(a), length(b)))
    assert np.all(angle_between(got["launch"][:, 0], unit(b - a)) < bend + 1e-13)
    assert np.all(np.abs(got["spread"][:, 0] / length(b - a) ** 2 - 1) < 100 * bend * length(b - a) / passing + 1e-12)


def test_circular_orbits():
    """On the photon sphere and in the throat x'' = Phi^2 x: the cone grows like sinh in the plane, like sin across."""
    angles = np.linspace(0.05, 3, 40)
    b = np.stack([np.cos(angles), np.sin(angles), 0 * angles], -1)
    for space, radius, factor in ((AREAL, 3.0, 9.0), (ELLIS, 0.5, 1.0)):
        got = connect(space, np.tile([radius, 0, 0], (40, 1)), radius * b, 2, 1e-9)
        assert np.all(got["status"] == MET)
        assert np.max(np.abs(np.abs(got["launch"][..., 1]) - 1)) < 1e-15
        truth = factor * np.sinh(got["swept"]) * np.abs(np.sin(got["swept"]))
        assert np.max(np.abs(got["spread"] / truth - 1)) < 1e-8


def test_radial_rays():
    """Limits of small impact parameter: spread = (r_b - r_a)^2 / lapse_a^2; Ellis (r_a r_b (chi_b - chi_a) / rho)^2."""
    r = np.array([2.001, 2.5, 3, 4, 100, 1e6])
    start, end = (x.ravel() for x in np.meshgrid(r, r, indexing="ij"))
    start, end = start[start != end], end[start != end]
    axis = unit(np.array([0.3, -0.5, 0.7]))
    got = connect(AREAL, start[:, None] * axis, end[:, None] * axis, 1)
    assert np.all(got["status"] == MET)
    assert np.allclose(got["spread"][:, 0], (end - start) ** 2 / (1 - 2 / start), rtol=1e-9)
    assert np.allclose(got["launch"][:, 0], np.sign(end - start)[:, None] * axis, atol=1e-15)
    start, end = np.full(3, 4.0), np.array([1 / 16, 0.5, 0.01])
    got = connect(ELLIS, start[:, None] * axis, end[:, None] * axis, 1)
    proper = [x - 0.25 / x for x in (start, end)]
    areal = [x + 0.25 / x for x in (start, end)]
    assert np.all(got["status"] == MET)
    assert np.allclose(got["launch"][:, 0], -axis, atol=1e-15)
    truth = (areal[0] * areal[1] * (np.arctan(proper[1]) - np.arctan(proper[0]))) ** 2
    assert np.allclose(got["spread"][:, 0], truth, rtol=1e-9)


@pytest.mark.parametrize("name", SPACES)
def test_rings(name):
    """In line with the center: finite, flagged, and the limit of pairs that are nearly so."""
    space, a, b = random_pairs(name, 200, seed=13)
    b = -unit(a) * length(b)[:, None]
    got = connect(space, a, b, 4, 1e-8)
    assert np.all((got["status"] == RING) | ((got["status"] == COARSE) & (got["error"] > 1e-8)))
    assert np.mean(got["status"] == RING) > 0.9
    assert all(np.isfinite(got[key]).all() for key in VALUES)
    assert np.all(got["spread"] == 0)
    missed = misses(space, a, b, *(got[key][:, 0] for key in ("launch", "arrival", "swept")))
    assert np.all(missed <= got["error"][:, 0])
    # the factor in the plane is finite on the caustic: spread falls like the sine of the angle that is left
    side = unit(np.cross(a, [[0.1, 0.2, 0.9]]))
    spreads = []
    for angle in (1e-6, 1e-8):
        near = connect(space, a, length(b)[:, None] * (np.sin(angle) * side - np.cos(angle) * unit(a)), 2, 1e-8)
        assert np.all(near["status"] == MET)
        spreads.append(near["spread"] / np.sin(angle))
    assert np.allclose(spreads[0], spreads[1], rtol=1e-3)


def test_coincident_points_have_only_rings():
    for space, point in ((AREAL, [5.0, 1, 0]), (ELLIS, [0.1, 1, 0])):
        got = connect(space, [point], [point], 3)
        assert list(got["status"][0]) == [FAILED, RING, RING]
        assert np.isnan(got["launch"][0, 0]).all()
        assert got["counts"]["failed"] == 1


SKIES = [("areal", False), ("isotropic", False), ("ellis", False), ("ellis", True)]


@pytest.mark.parametrize(("name", "far_side"), SKIES)
def test_the_sky(name, far_side):
    space, a, _ = random_pairs(name, 3000, seed=17)
    wanted = unit(np.random.default_rng(18).normal(size=(3000, 3)))
    got = connect_sky(space, a, 7 * wanted, 2, 1e-9, far_side=far_side)
    assert not got["counts"]["failed"]
    assert np.all(np.abs(got["arrival"] - (-wanted if far_side else wanted)[:, None]) < 1e-15)
    assert np.allclose(got["frequency_ratio"], 1 / np.sqrt(lapse_squared(space, a))[:, None], rtol=1e-12)
    for k in range(2):
        traced = trace_rays(space, a, got["launch"][:, k], 1e-13)
        assert np.all(traced["fate"] == (3 if far_side else 1))
        missed = angle_between(traced["direction"], wanted)
        assert np.all(missed <= got["error"][:, k] + traced["error"])


@pytest.mark.parametrize(("name", "far_side"), SKIES)
def test_spread_of_the_sky(name, far_side):
    """Solid angles by central differences of traced rays."""
    space, a, _ = random_pairs(name, 2000, seed=19)
    wanted = unit(np.random.default_rng(20).normal(size=(2000, 3)))
    got = connect_sky(space, a, wanted, 1, 1e-12, far_side=far_side)
    launch, spread = got["launch"][:, 0], got["spread"][:, 0]
    across = [unit(np.cross(launch, [[0.3, -0.5, 0.8]]))]
    across.append(np.cross(launch, across[0]))
    h = (1e-3 / np.maximum(1, np.sqrt(spread)))[:, None]
    change = []
    for side in across:
        ends = [trace_rays(space, a, launch + s * h * side, 1e-13)["direction"] for s in (-2, -1, 1, 2)]
        change.append((8 * (ends[2] - ends[1]) - (ends[3] - ends[0])) / (12 * h))
    area = np.abs(np.sum(np.cross(*change) * wanted, -1))
    error = np.abs(area / spread - 1)
    assert np.median(error) < 1e-8
    assert np.quantile(error, 0.99) < 1e-4


def test_a_distant_point_is_the_sky():
    space, a, b = random_pairs("areal", 500, seed=21)
    a, far = a[length(a) < 50], 1e9 * unit(b)[length(a) < 50]
    near, sky = connect(space, a, far, 2, 1e-10), connect_sky(space, a, far, 2, 1e-10)
    assert np.max(angle_between(near["launch"], sky["launch"])) < 1e-6
    assert np.allclose(near["spread"] / 1e18, sky["spread"], rtol=1e-5)


def test_a_kerr_hole_without_spin_is_the_areal_chart():
    _, a, b = random_pairs("areal", 100, seed=23)
    one, other = connect(AREAL, a, b), connect(Spacetime.kerr(1, 0), a, b)
    assert all(np.array_equal(one[key], other[key]) for key in ["status", *VALUES])


def test_faint_images_end_the_list():
    space, a, b = random_pairs("areal", 1000, seed=25)
    full, short = connect(space, a, b, 4), connect(space, a, b, 4, min_share=1e-3)
    light = 1 / full["spread"]
    faint = light[:, 1:] < 1e-3 * np.cumsum(light, 1)[:, :-1]
    expected = np.concatenate([np.ones((1000, 1), bool), ~np.logical_or.accumulate(faint, 1)], 1)
    assert np.array_equal(short["status"] != NONE, expected)
    assert 0.2 < expected.mean() < 0.8
    assert short["counts"]["none"] == np.count_nonzero(~expected)
    for key in VALUES:
        assert np.array_equal(short[key][expected], full[key][expected])
        assert np.isnan(short[key][~expected]).all()


@pytest.mark.parametrize("name", SPACES)
def test_an_answer_depends_on_its_pair_alone(name):
    space, a, b = random_pairs(name, 203, seed=27)
    order = np.random.default_rng(0).permutation(203)
    one, other = connect(space, a, b, 3), connect(space, a[order], b[order], 3)
    assert all(np.array_equal(one[key][order], other[key]) for key in ["status", *VALUES])


EXTREMES = [(1 + 1e-12, 1.01), (1 + 1e-9, 1e12), (1e5, 1e7), (1.3, 1.6)]


@pytest.mark.parametrize(("low", "high"), EXTREMES)
@pytest.mark.parametrize("name", SPACES)
def test_extreme_radii(name, low, high):
    """Next to the horizon, very far, around the photon sphere: eight images each, and none is lost."""
    space = SPACES[name][0]
    low, high = (1 / high if name == "ellis" else low) * space.core_radius, high * space.core_radius
    got = connect(space, random_points(1, 1000, low, high), random_points(2, 1000, low, high), 8, 1e-8)
    assert not got["counts"]["failed"]
    assert all(np.isfinite(got[key]).all() for key in VALUES)
    assert np.all((got["status"] == COARSE) == (got["error"] > 1e-8))


@pytest.mark.parametrize("toward", [1, -1])
@pytest.mark.parametrize("name", SPACES)
def test_nearly_in_line(name, toward):
    """Down to rounding on both sides of the center."""
    space, a, b = random_pairs(name, 1000, seed=31)
    b = toward * unit(a) * length(b)[:, None] * (1 + 1e-3)
    b += length(b)[:, None] * 10.0 ** np.linspace(-17, -3, 1000)[:, None] * random_points(33, 1000, 0.1, 0.9)
    got = connect(space, a, b, 3, 1e-7)
    assert got["counts"]["met"] + got["counts"]["ring"] == 3000
    assert all(np.isfinite(got[key]).all() for key in VALUES)
    missed = misses(space, a, b, *(got[key][:, 1] for key in ("launch", "arrival", "swept")))
    assert np.all(missed <= got["error"][:, 1])


def test_counts_add_up():
    space, a, b = random_pairs("isotropic", 100, seed=29)
    got = connect(space, a, b, 8, 1e-9)
    assert sum(got["counts"].values()) == 800
    for index, name in enumerate(CONNECTION_STATES):
        assert got["counts"][name] == np.count_nonzero(got["status"] == index)
    assert connect(space, np.empty((0, 3)), np.empty((0, 3)))["status"].shape == (0, 2)


def test_bad_input():
    a, b = np.array([[10.0, 0, 0]] * 3), np.array([[0, 10.0, 0]] * 3)
    inside, bad = a.copy(), b.copy()
    inside[1] = [1.9, 0, 0]
    bad[2, 0] = np.nan
    with pytest.raises(ValueError, match="points_a: point 1 is"):
        connect(AREAL, inside, b)
    with pytest.raises(ValueError, match="points_b: point 2 is"):
        connect(AREAL, a, bad)
    with pytest.raises(ValueError, match="directions: direction 0 is zero"):
        connect_sky(AREAL, a, 0 * b)
    with pytest.raises(ValueError, match="far_side: only a wormhole has one"):
        connect_sky(AREAL, a, b, far_side=True)
    with pytest.raises(ValueError, match="max_images: must be 1 to 8, got 9"):
        connect(AREAL, a, b, 9)
    with pytest.raises(ValueError, match="max_images: must be 1 to 8, got 0"):
        connect(AREAL, a, b, 0)
    with pytest.raises(ValueError, match="min_share: must be in"):
        connect(AREAL, a, b, min_share=1.0)
    with pytest.raises(ValueError, match="tolerance: must be positive"):
        connect(AREAL, a, b, 2, np.nan)
    with pytest.raises(ValueError, match="points_a: point 1 is"):
        connect(Spacetime.kerr(1, 0.5), 0.9 * inside, b)
    with pytest.raises(ValueError, match="ends: expected float64 C-contiguous array of shape"):
        connect(AREAL, a, b[:2])


def test_cancel():
    progress = Progress()
    space, a, b = random_pairs("areal", 1000)
    connect(space, a, b, progress=progress)
    assert progress.done == 1000
    progress.cancel()
    with pytest.raises(Cancelled, match="cancelled after 0 of 1000 pairs"):
        connect(space, a, b, progress=progress)
