"""Limits and symmetries that rays must keep: no mass, no spin, mirrored spin, reversed time, scale, order of rays."""

import threading

import numpy as np
import pytest
from bentlight_native import Spacetime, instruction_set, lapse, ray_path, trace_rays
from golden import EPS
from rays import angle_between, kerr_functions, oblate_basis, unit

ROUTES = ["taylor", "auto"]
RNG = np.random.default_rng(7)
ORIGINS = 12 * unit(RNG.normal(size=(200, 3))) * RNG.uniform(0.5, 2, (200, 1))
DIRECTIONS = unit(unit(RNG.normal(size=(200, 3))) - 0.8 * unit(ORIGINS))


def assert_agree(one, other, turned=None, allowance=0.0):
    """Same fates, and directions (those of `one` given `turned`, if they are to be) within both estimates."""
    assert np.array_equal(one["fate"], other["fate"])
    out = np.isin(one["fate"], (1, 3))
    assert out.mean() > 0.5
    apart = angle_between((one["direction"] if turned is None else turned)[out], other["direction"][out])
    assert np.all(apart <= one["error"][out] + other["error"][out] + allowance)


@pytest.mark.parametrize("route", ROUTES)
@pytest.mark.parametrize("mass", [0.0, 1e-30, 1e-17])
def test_without_mass_rays_are_straight(mass, route):
    spaces = [Spacetime.schwarzschild(mass), Spacetime.schwarzschild(mass, "areal"), Spacetime.kerr(mass, 0.5 * mass)]
    for space in [*spaces, Spacetime.minkowski()]:
        got = trace_rays(space, ORIGINS, DIRECTIONS, 1e-15, route=route)
        assert np.all(got["fate"] == 1)
        assert angle_between(got["direction"], DIRECTIONS).max() < 1e-14


@pytest.mark.parametrize("route", ROUTES)
def test_a_small_mass_bends_by_the_weak_field_formula(route):
    """alpha = 4 M/b + 15 pi/4 (M/b)^2 + 128/3 (M/b)^3 from far away; the rest is rounding of the direction."""
    mass, b, distance = 1e-6, np.array([5.0, 20.0, 100.0]), 1e7
    origins = np.stack([b, -np.full(3, distance), np.zeros(3)], -1)
    directions = np.tile([0.0, 1.0, 0.0], (3, 1))
    got = trace_rays(Spacetime.schwarzschild(mass), origins, directions, 1e-14, route=route)
    bend = np.arctan2(-got["direction"][:, 0], got["direction"][:, 1])
    weak = 4 * mass / b + 15 * np.pi / 4 * (mass / b) ** 2 + 128 / 3 * (mass / b) ** 3
    assert np.all(np.abs(bend - weak) < 20 * EPS)


@pytest.mark.parametrize("route", ROUTES)
def test_no_spin_is_schwarzschild(route):
    areal = trace_rays(Spacetime.schwarzschild(1, "areal"), ORIGINS, DIRECTIONS, 1e-13, route=route)
    zero = trace_rays(Spacetime.kerr(1, 0.0), ORIGINS, DIRECTIONS, 1e-13, route=route)
    assert_agree(areal, zero)
    for spin in (1e-9, 1e-12):
        little = trace_rays(Spacetime.kerr(1, spin), ORIGINS, DIRECTIONS, 1e-13, route=route)
        # dragging turns a ray that keeps away from the critical one by about 4 a M / b^2
        assert_agree(areal, little, allowance=4 * spin)


@pytest.mark.parametrize("route", ROUTES)
@pytest.mark.parametrize("spin", [0.3, 0.998])
def test_mirrored_spin_mirrors_rays(spin, route):
    """A reflection in the x-z plane turns the spin round."""
    mirror = np.array([1.0, -1.0, 1.0])
    left = trace_rays(Spacetime.kerr(1, spin), ORIGINS, DIRECTIONS, 1e-12, route=route)
    right = trace_rays(Spacetime.kerr(1, -spin), ORIGINS * mirror, DIRECTIONS * mirror, 1e-12, route=route)
    assert_agree(left, right, left["direction"] * mirror)


@pytest.mark.parametrize("route", ROUTES)
def test_the_axis_of_symmetry(route):
    """A turn about the spin axis turns everything; a reflection in the equatorial plane reflects everything."""
    turn = np.array([[0.6, -0.8, 0], [0.8, 0.6, 0], [0, 0, 1.0]])
    space = Spacetime.kerr(1, 0.9)
    one = trace_rays(space, ORIGINS, DIRECTIONS, 1e-12, route=route)
    for matrix in (turn, np.diag([1.0, 1.0, -1.0])):
        other = trace_rays(space, ORIGINS @ matrix.T, DIRECTIONS @ matrix.T, 1e-12, route=route)
        assert_agree(one, other, one["direction"] @ matrix.T)


@pytest.mark.parametrize("route", ROUTES)
@pytest.mark.parametrize("scale", [1e-6, 1e6])
def test_scale_does_not_matter(scale, route):
    pairs = [
        (Spacetime.schwarzschild(1), Spacetime.schwarzschild(scale)),
        (Spacetime.kerr(1, 0.9), Spacetime.kerr(scale, 0.9 * scale)),
        (Spacetime.ellis(1), Spacetime.ellis(scale)),
    ]
    for small, large in pairs:
        one = trace_rays(small, ORIGINS, DIRECTIONS, 1e-12, route=route)
        other = trace_rays(large, ORIGINS * scale, DIRECTIONS, 1e-12, route=route)
        assert_agree(one, other)


def zamo(spin_seen, position):
    """Lapse, dragging rate omega, sqrt(g_phiphi) and the direction east at positions of the oblate chart, M = 1."""
    s, z = spin_seen, position[..., 2]
    square = np.sum(position**2, -1) - s**2
    r = np.sqrt((square + np.sqrt(square**2 + 4 * s**2 * z**2)) / 2)
    across = np.hypot(position[..., 0], position[..., 1])
    cosine, sine = z / r, across / np.hypot(r, s)
    sigma, delta, area = kerr_functions(s, r, sine, cosine)
    east = np.stack([-position[..., 1], position[..., 0], np.zeros_like(r)], -1) / across[..., None]
    return np.sqrt(sigma * delta / area), 2 * s * r / area, np.sqrt(area / sigma) * sine, east


def kerr_constants(spin_seen, position, heading):
    """E and L of a forward photon with local energy 1."""
    lapse_there, omega, g_phi, east = zamo(spin_seen, position)
    momentum = np.sum(heading * east, -1) * g_phi
    return lapse_there + omega * momentum, momentum


def local_energy(space, spin, origin, direction, position):
    """Energy that the observer at `position` measures of a ray launched at `origin` with local energy 1."""
    if spin is None:
        return lapse(space, tuple(origin)) / lapse(space, tuple(position))
    energy, momentum = kerr_constants(-spin, origin, direction)
    lapse_there, omega, _, _ = zamo(-spin, position)
    return (energy - omega * momentum) / lapse_there


@pytest.mark.parametrize(
    ("there", "back", "spin"),
    [
        (Spacetime.schwarzschild(1), Spacetime.schwarzschild(1), None),
        (Spacetime.schwarzschild(1, "areal"), Spacetime.schwarzschild(1, "areal"), None),
        (Spacetime.kerr(1, 0.9), Spacetime.kerr(1, -0.9), 0.9),
        (Spacetime.ellis(1), Spacetime.ellis(1), None),
    ],
    ids=["isotropic", "areal", "Kerr", "Ellis"],
)
def test_forward_then_backward_returns_to_the_start(there, back, spin):
    """From a point along the ray, the reversed ray (spin reversed too) is back at the start after the same Mino time,
    counted for local energy 1 at its own launch."""
    returned = 0
    for origin, direction in zip(ORIGINS, DIRECTIONS, strict=True):
        time = 2 / np.linalg.norm(origin)
        path = ray_path(there, origin, direction, [time], 1e-13)
        turned, heading = path["position"][0], path["direction"][0]
        if np.isnan(turned).any() or path["far"][0] or np.linalg.norm(turned) > 1e4:
            continue
        time *= local_energy(there, spin, origin, direction, turned)
        end = ray_path(back, turned, -heading, [time], 1e-13)
        stretch = 1e-13 * (1 + np.linalg.norm(turned)) / min(1, np.linalg.norm(turned) - back.core_radius)
        assert np.linalg.norm(end["position"][0] - origin) < stretch * np.linalg.norm(origin)
        assert angle_between(end["direction"][0], -direction) < stretch
        returned += 1
    assert returned > 100


@pytest.mark.parametrize("spin", [0.5, 0.998])
def test_constants_of_motion_along_kerr_paths(spin):
    """E and L from the local direction are the same at every point of a path: charts and frames fit the transport."""
    for origin, direction in zip(ORIGINS[:20], DIRECTIONS[:20], strict=True):
        path = ray_path(
            Spacetime.kerr(1, spin), origin, direction, np.linspace(0, 3 / np.linalg.norm(origin), 9), 1e-13
        )
        known = ~np.isnan(path["position"][:, 0])
        position, heading = path["position"][known], path["direction"][known]
        energy, momentum = kerr_constants(-spin, position, heading)
        away = np.linalg.norm(position, axis=1) > 1.2 * np.hypot(1 + np.sqrt(1 - spin**2), spin)
        ratio = (momentum / energy)[away]
        assert np.ptp(ratio) < 1e-12 * (1 + np.abs(ratio).max())


def test_directions_along_a_path_are_its_tangents():
    """In the conformally flat charts the drawn tangent is the local direction."""
    for space in (Spacetime.schwarzschild(1), Spacetime.ellis(1)):
        for origin, direction in zip(ORIGINS[:10], DIRECTIONS[:10], strict=True):
            center, step = 1 / np.linalg.norm(origin), 1e-5 / np.linalg.norm(origin)
            path = ray_path(space, origin, direction, center + step * np.array([-1, 0, 1]), 1e-13)
            if np.isnan(path["position"]).any() or path["far"].any():
                continue
            tangent = unit(path["position"][2] - path["position"][0])
            assert angle_between(tangent, path["direction"][1]) < 1e-9  # the difference is good to the step squared


def test_the_oblate_chart_draws_its_own_frame():
    position, *basis = oblate_basis(0.7, 5.0, np.sin(0.4), np.cos(0.4))
    frame = np.array(basis)
    assert np.allclose(frame @ frame.T, np.eye(3), atol=1e-15)
    path = ray_path(Spacetime.kerr(1, 0.7), position, frame[0], [0.0], 1e-12)
    assert np.allclose(path["position"][0], position, rtol=1e-14)
    assert np.allclose(path["direction"][0], frame[0], atol=1e-14)


@pytest.mark.parametrize("route", ROUTES)
def test_a_ray_does_not_depend_on_its_neighbors(route):
    """Bit for bit the same alone, in any order, and from four threads at once."""
    for space in (Spacetime.schwarzschild(1), Spacetime.kerr(1, 0.9), Spacetime.ellis(1)):
        together = trace_rays(space, ORIGINS, DIRECTIONS, 1e-8, route=route)
        order = np.random.default_rng(3).permutation(len(ORIGINS))
        shuffled = trace_rays(space, ORIGINS[order], DIRECTIONS[order], 1e-8, route=route)
        parts = [None] * 4

        def work(k, space=space, parts=parts):
            parts[k] = trace_rays(space, ORIGINS[k::4], DIRECTIONS[k::4], 1e-8, route=route)

        threads = [threading.Thread(target=work, args=(k,)) for k in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        for name, values in together.items():
            assert np.array_equal(values[order], shuffled[name], equal_nan=True)
            for k in range(4):
                assert np.array_equal(values[k::4], parts[k][name], equal_nan=True), instruction_set()
