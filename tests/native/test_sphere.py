"""Tables of lens spheres against sums of their own, traced rays, and themselves."""

import numpy as np
import pytest
from bentlight_native import LensSphere, Spacetime, trace_rays
from rays import angle_between, unit

# Spacetimes in unit mass and throat, and radii from the smallest to large ones.
SPHERES = [
    (name, spacetime, radius)
    for name, spacetime, radii in (
        ("isotropic", Spacetime.schwarzschild(1.0), (2.92, 6.0, 40.0)),
        ("areal", Spacetime.schwarzschild(1.0, "areal"), (4.0, 7.0, 40.0)),
        ("ellis", Spacetime.ellis(1.0), (0.645, 2.0, 40.0)),
    )
    for radius in radii
]
NAMES = [f"{name} {radius}" for name, _, radius in SPHERES]
NODES, WEIGHTS = np.polynomial.legendre.leggauss(20)
HORIZON = 0.5 * (1 - 1e-7)  # M/r where a captured ray's way ends


def areal_size(name, radius):
    """r over M or rho."""
    return {"isotropic": radius * (1 + 0.5 / radius) ** 2, "areal": radius, "ellis": radius + 0.25 / radius}[name]


def critical_sine(name, radius):
    """Of the ray with b = b_c where it enters."""
    r = areal_size(name, radius)
    return 1 / r if name == "ellis" else np.sqrt(27) * np.sqrt(1 - 2 / r) / r


def gauss(f, low, high, *narrow):
    """Integral of f from low to high, in panels that shrink geometrically towards the points `narrow`."""
    edges = [low, high]
    for point in narrow:
        steps = np.geomspace(1e-9, 1, 80) * (high - low)
        edges += [x for x in np.concatenate([point - steps, [point], point + steps]) if low < x < high]
    edges = np.unique(edges)
    middle, half = (edges[1:] + edges[:-1]) / 2, np.diff(edges) / 2
    x = middle[:, None] + half[:, None] * NODES
    return np.array([np.sum(half[:, None] * WEIGHTS * part) for part in f(x)])


def drawn(name, u, beta):
    """Length that the chart draws per angle swept."""
    if name == "areal":
        return np.sqrt(1 / beta**2 + 2 * u**3) / u**2
    return (1 - u + np.sqrt(1 - 2 * u)) / (2 * u) / (beta * u * np.sqrt(1 - 2 * u))


def reference(name, radius, delta):
    """Angle swept and length drawn inside, by du / sqrt(P) and dl / sqrt(l^2 + 1 - b^2) as they stand."""
    r, b = areal_size(name, radius), 1 + delta
    if name == "ellis":
        edge = np.sqrt(r**2 - 1)  # l there
        if delta < 0:

            def rates(x):
                root = np.sqrt(x**2 - delta * (2 + delta))
                return b / np.sqrt(1 + x**2) / root, (x + np.sqrt(1 + x**2)) / 2 / root

            return gauss(rates, 0, edge, 0)
        turn = np.sqrt(delta * (2 + delta))

        def rates(w):  # l = turn + w^2
            x, root = turn + w**2, np.sqrt(2 * turn + w**2)
            return 4 * b / np.sqrt(1 + x**2) / root, 2 * (x + np.sqrt(1 + x**2)) / root

        return gauss(rates, 0, np.sqrt(edge - turn), 0)
    beta, u = np.sqrt(27) * b, 1 / r
    # In d = u - 1/3: d^2 + 2 d^3 + p0, whose three roots are known well where it is nearly a double one at 0.
    p0 = -delta * (2 + delta) / (27 * b * b)
    if delta < 0:

        def rates(s):  # u = (1 - s^2) / 2
            at = (1 - s**2) / 2
            turn = s / np.sqrt(p0 + (at - 1 / 3) ** 2 * (1 + 2 * (at - 1 / 3)))
            return turn, turn * drawn(name, at, beta)

        return gauss(rates, np.sqrt(1 - 2 * HORIZON), np.sqrt(1 - 2 * u), np.sqrt(1 / 3), np.sqrt(1 - 2 * HORIZON))
    low, middle, high = np.sort(np.roots([2, 1, 0, p0]).real)
    for _ in range(4):  # Newton: np.roots loses half of the digits near a double root
        low, middle, high = (d - (p0 + d**2 * (1 + 2 * d)) / (2 * d + 6 * d**2) for d in (low, middle, high))

    def rates(w):  # u = u_t - w^2
        at = middle + 1 / 3 - w**2
        turn = 2 * np.sqrt(2) / np.sqrt((high - middle + w**2) * (middle - low - w**2))
        return turn, turn * drawn(name, at, beta)

    # u_t - u from P(u) = cos^2 / beta^2, as the difference would lose the digits of grazing rays.
    slope2 = (1 - (critical_sine(name, radius) * b) ** 2) / beta**2
    return gauss(rates, 0, np.sqrt(slope2 / (2 * (high + 1 / 3 - u) * (u - low - 1 / 3))), 0)


def entering(radius, sine):
    """Rays in the plane of x and y that enter at (radius, 0, 0) at these angles to the inward radial."""
    sine = np.asarray(sine)
    points = np.tile([radius, 0.0, 0.0], (len(sine), 1))
    return points, np.stack([-np.sqrt((1 - sine) * (1 + sine)), sine, np.zeros(len(sine))], axis=1)


def in_plane(angle, radius=1.0):
    return radius * np.stack([np.cos(angle), np.sin(angle), np.zeros(len(angle))], axis=1)


@pytest.mark.parametrize("name, spacetime, radius", SPHERES, ids=NAMES)
def test_angles_and_lengths_are_the_integrals(name, spacetime, radius):
    """From head-on to grazing and on both sides of the critical ray, within the error that each answer states."""
    critical = critical_sine(name, radius)
    largest = 1 / critical - 1
    random = np.random.default_rng(2)
    delta = np.concatenate(
        [
            -(10.0 ** random.uniform(-8, -0.3, 30)), random.uniform(-0.999, -0.1, 20), [-1 + 1e-6],
            largest * 10.0 ** random.uniform(-8, -0.3, 30), largest * random.uniform(0.1, 1, 20),
            largest * (1 - 10.0 ** -np.arange(2, 12)),
        ]
    )  # fmt: skip
    sphere = LensSphere(spacetime, radius)
    got = sphere.cross(*entering(radius, critical * (1 + delta)))
    expected = np.array([reference(name, radius, d) for d in delta])
    np.testing.assert_array_equal(got["fate"], np.where(delta > 0, 1, 3 if name == "ellis" else 2))
    # Grazing rays: what rounding of the angle, eps, makes of its cosine.
    cosine = np.sqrt(np.maximum(1 - (critical * (1 + delta)) ** 2, 1e-30))
    rounding = np.where(delta > 0, 1e-15 / cosine, 0)
    assert np.all(np.abs(got["swept"] - expected[:, 0]) <= 2 * got["error"] + 4 * rounding)
    rate = radius * (got["error"] - sphere.measured.swept_max + rounding)  # dL/dphi is about the radius where it counts
    assert np.all(np.abs(got["length"] - expected[:, 1]) <= 4 * rate + 2 * sphere.measured.length_max)
    assert sphere.measured.swept_max <= 1e-12 and sphere.measured.length_max <= 2e-13 * (radius + 1)
    out = delta > 0
    np.testing.assert_allclose(got["exit"][out], in_plane(got["swept"][out], radius), atol=1e-13 * radius)
    away = got["swept"] + np.arccos(np.clip(cosine, 0, 1))  # the way out mirrors the way in
    np.testing.assert_allclose(got["direction"][out], in_plane(away[out]), atol=1e-12)


@pytest.mark.parametrize("name, spacetime, radius", SPHERES, ids=NAMES)
def test_a_crossing_is_the_middle_of_a_traced_ray(name, spacetime, radius):
    """A ray across the sphere by the table and traced on from there is the ray traced from where it enters."""
    random = np.random.default_rng(7)
    points = radius * unit(random.normal(size=(2000, 3)))
    critical = critical_sine(name, radius)
    sine = random.uniform([[critical], [0]], [[1], [critical]], (2, 1000)).reshape(-1, 1)
    tangent = unit(np.cross(points, random.normal(size=(2000, 3))))
    directions = sine * tangent - np.sqrt(1 - sine**2) * unit(points)
    crossing = LensSphere(spacetime, radius).cross(points, directions)
    whole = trace_rays(spacetime, points, directions, 1e-13, route="taylor")
    np.testing.assert_array_equal(crossing["fate"], whole["fate"])
    back = crossing["fate"] == 1
    assert back.sum() > 900
    rest = trace_rays(spacetime, crossing["exit"][back], crossing["direction"][back], 1e-13, route="taylor")
    assert np.all(rest["fate"] == 1)
    error = crossing["error"][back] + whole["error"][back] + rest["error"]
    assert np.all(angle_between(rest["direction"], whole["direction"][back]) <= 2 * error)
    assert np.all(np.abs(crossing["swept"][back] + rest["swept"] - whole["swept"][back]) <= 2 * error)


@pytest.mark.parametrize("radius", [0.7, 3.0, 60.0])
def test_out_of_the_throat_is_into_it_backwards(radius):
    random = np.random.default_rng(4)
    points = radius * unit(random.normal(size=(500, 3)))
    aims = unit(random.normal(size=(500, 3))) * random.uniform(0, 0.4, (500, 1))
    directions = unit(aims - points)
    sphere = LensSphere(Spacetime.ellis(1.0), radius)
    down = sphere.cross(points, directions)
    through = down["fate"] == 3
    assert through.sum() > 300
    np.testing.assert_allclose(np.linalg.norm(down["exit"][through], axis=1), 0.5, rtol=1e-14)
    up = sphere.emerge(down["exit"][through], -down["direction"][through])
    assert np.all(up["fate"] == 1)
    error = 2 * (down["error"][through] + up["error"])
    assert np.all(np.linalg.norm(up["exit"] - points[through], axis=1) <= radius * error)
    assert np.all(np.linalg.norm(up["direction"] + directions[through], axis=1) <= 2 * error)
    assert np.all(np.abs(up["swept"] - down["swept"][through]) <= error)
    assert np.all(np.abs(up["length"] - down["length"][through]) <= 2 * radius * error)


@pytest.mark.parametrize("name, spacetime, radius", SPHERES, ids=NAMES)
def test_rays_through_the_middle_are_straight(name, spacetime, radius):
    """Exactly radial ones sweep nothing; their length is the chart's own."""
    points = radius * unit(np.array([[1.0, 0, 0], [1, 2, 3]]))
    got = LensSphere(spacetime, radius).cross(points, -points)
    end = {"isotropic": end_isotropic(), "areal": 1 / HORIZON, "ellis": 0.5}[name]
    assert got["fate"].tolist() == ([3, 3] if name == "ellis" else [2, 2])
    np.testing.assert_allclose(got["swept"], 0, atol=1e-12)
    np.testing.assert_allclose(got["length"], radius - end, atol=1e-12 * radius + 1e-12)


def end_isotropic():
    """The isotropic radius at M/r = HORIZON."""
    return (1 - HORIZON + np.sqrt(1 - 2 * HORIZON)) / (2 * HORIZON)


def test_what_a_table_declines():
    """The critical ray, rays that do not enter, and everything out of the throat of a hole."""
    radius = 10.0
    for name, spacetime in (("isotropic", Spacetime.schwarzschild(1.0)), ("ellis", Spacetime.ellis(1.0))):
        sphere, critical = LensSphere(spacetime, radius), critical_sine(name, radius)
        points, directions = entering(radius, critical * (1 + np.array([0, 1e-10, -1e-10, 1e-6, -1e-6])))
        got = sphere.cross(points, directions)
        assert got["fate"].tolist() == [0, 0, 0, 1, 3 if name == "ellis" else 2]
        assert all(np.isnan(got[key][:3]).all() for key in ("exit", "direction", "swept", "length", "error"))
        assert not sphere.cross(points, -directions)["fate"].any()
        assert not sphere.emerge(0.5 * unit(points), directions)["fate"].any()
    hole = LensSphere(Spacetime.schwarzschild(1.0), radius)
    assert not hole.emerge([[0.5, 0, 0]], [[1.0, 0.1, 0]])["fate"].any()


@pytest.mark.parametrize("beside", [1e-7, -1e-7, 1e-10])
def test_a_start_beside_the_sphere_is_in_the_error(beside):
    """At the same angle b is larger by as much as the radius, and so is the way on."""
    sphere, critical = LensSphere(Spacetime.ellis(1.0), 8.0), critical_sine("ellis", 8.0)
    sine = critical * (1 + np.array([-0.5, -1e-2, 1e-2, 0.1, 1, 3]))
    points, directions = entering(8.0, sine)
    got = sphere.cross(points * (1 + beside), directions)
    true = sphere.cross(*entering(8.0, sine * (1 + beside)))
    assert np.all(np.abs(got["swept"] - true["swept"]) <= got["error"])
    assert np.all(got["error"] >= abs(beside)) and np.all(got["error"] <= 1e4 * abs(beside))


def test_units_and_lengths_of_directions_do_not_matter():
    random = np.random.default_rng(9)
    points, aims = 8 * unit(random.normal(size=(100, 3))), random.normal(size=(100, 3))
    one = LensSphere(Spacetime.schwarzschild(1.0), 8.0).cross(points, aims - points)
    large = LensSphere(Spacetime.schwarzschild(1e3), 8e3).cross(1e3 * points, 7 * (aims - points))
    np.testing.assert_array_equal(one["fate"], large["fate"])
    np.testing.assert_allclose(large["length"], 1e3 * one["length"], rtol=1e-11)
    np.testing.assert_allclose(large["swept"], one["swept"], atol=1e-11, rtol=1e-11)
    for n in range(1, 12):
        some = LensSphere(Spacetime.schwarzschild(1.0), 8.0).cross(points[:n], (aims - points)[:n])
        assert all(np.array_equal(some[key], one[key][:n], equal_nan=True) for key in one)


@pytest.mark.parametrize(
    "spacetime, radius",
    [
        (Spacetime.schwarzschild(1.0), 2.9), (Spacetime.schwarzschild(1.0, "areal"), 3.99),
        (Spacetime.schwarzschild(1.0), 1e7), (Spacetime.ellis(1.0), 0.64), (Spacetime.ellis(1.0), np.inf),
        (Spacetime.ellis(1.0), np.nan), (Spacetime.ellis(1.0), -3.0), (Spacetime.kerr(1.0, 0.5), 10.0),
        (Spacetime.minkowski(), 1.0), (Spacetime.schwarzschild(0.0), 1.0),
    ],
)  # fmt: skip
def test_spheres_without_a_table_are_refused(spacetime, radius):
    with pytest.raises(ValueError, match="lens sphere"):
        LensSphere(spacetime, radius)
    with pytest.raises(ValueError, match="directions"):
        LensSphere(Spacetime.ellis(1.0), 2.0).cross([[2.0, 0, 0]], [[np.nan, 0, 0]])
