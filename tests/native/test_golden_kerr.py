"""Kerr rays against the golden data: fates, directions, error estimates, equator crossings, frequency shifts."""

import numpy as np
import pytest
from bentlight_native import Spacetime, lapse, ray_path, trace_rays
from golden import EPS, number_lists, numbers, rows, sine_cosine_deg
from rays import kerr_functions, oblate_basis, unit

GOLDEN = rows("kerr_geodesics.csv")
SPIN, RADIUS = numbers(GOLDEN, "a"), numbers(GOLDEN, "r_obs")
SINE, COSINE = sine_cosine_deg(numbers(GOLDEN, "theta_obs_deg"))
LOOK = unit(np.stack([numbers(GOLDEN, f"n_{k}") for k in ("r", "theta", "phi")], -1))
FATE = np.array([{"escape": 1, "capture": 2}[row["fate"]] for row in GOLDEN])
TRUTH = np.stack([numbers(GOLDEN, f"{k}_inf") for k in "xyz"], -1)
# d(direction)/d(input); rows without a direction get that of a ray as close to the critical one
CONDITION = np.nan_to_num(np.fmax(numbers(GOLDEN, "cond_dir"), 10 / np.abs(numbers(GOLDEN, "delta"))))
CATEGORY = np.array([row["category"] for row in GOLDEN])


def local_rays():
    position, *basis = oblate_basis(SPIN, RADIUS, SINE, COSINE)
    return position, sum(LOOK[:, k, None] * e for k, e in enumerate(basis))


def trace_all(tolerance, route):
    """All golden rays, spin by spin."""
    origins, directions = local_rays()
    result = {}
    for a in np.unique(SPIN):
        chosen = a == SPIN
        part = trace_rays(Spacetime.kerr(1, a), origins[chosen], directions[chosen], tolerance, route=route)
        for name, values in part.items():
            result.setdefault(name, np.empty((len(GOLDEN), *values.shape[1:]), values.dtype))[chosen] = values
    return result


@pytest.mark.parametrize("route", ["taylor", "auto"])
def test_every_row_at_the_tightest_tolerance(route):
    got = trace_all(1e-12, route)
    assert np.array_equal(got["fate"], FATE)
    out = FATE == 1
    error = np.linalg.norm(got["direction"] - TRUTH, axis=1)[out]
    limit = (1e-12 + 100 * EPS * CONDITION)[out]
    worst = np.argmax(error / limit)
    assert error[worst] <= limit[worst], f"row {np.array([row['id'] for row in GOLDEN])[out][worst]}"
    assert np.isnan(got["direction"][~out]).all()


@pytest.mark.parametrize("route", ["taylor", "auto"])
@pytest.mark.parametrize("tolerance", [1e-3, 1e-6, 1e-9])
def test_tolerance_is_kept(tolerance, route):
    """Every row keeps its tolerance, up to what double precision allows; fates are right at any tolerance."""
    got = trace_all(tolerance, route)
    assert np.array_equal(got["fate"], FATE)
    out = FATE == 1
    error = np.linalg.norm(got["direction"] - TRUTH, axis=1)
    assert np.all(error[out] <= (tolerance + 1e-12 + 100 * EPS * CONDITION)[out])
    ordinary = out & (CATEGORY == "ordinary")
    assert np.percentile(error[ordinary], 99) <= 0.5 * tolerance + 1e-12


@pytest.mark.parametrize("tolerance", [1e-3, 1e-6, 1e-9, 1e-12])
def test_the_error_estimate_is_honest(tolerance):
    """The true error stays within twice the estimate and the rounding of the row's own input; the estimate says at most
    twenty times the tolerance unless the ray is badly conditioned."""
    got = trace_all(tolerance, "taylor")
    out = FATE == 1
    error = np.linalg.norm(got["direction"] - TRUTH, axis=1)[out]
    assert np.all(error <= 2 * got["error"][out] + 2 * EPS * CONDITION[out])
    assert np.all(got["error"][out] <= 20 * tolerance + 1e-12 + 1000 * EPS * np.maximum(CONDITION[out], 20))


def crossings():
    """(row, Mino times, radii, azimuths) of the golden crossings of the equatorial plane."""
    columns = [number_lists(GOLDEN, f"eq_{k}") for k in ("tau", "r", "phi")]
    return [(i, *values) for i, *values in zip(range(len(GOLDEN)), *columns, strict=True) if len(values[0])]


def test_equator_crossings_lie_on_the_path():
    """At the golden Mino times the path is in the equatorial plane, at the golden radius and azimuth."""
    origins, directions = local_rays()
    cases = crossings()
    assert len(cases) > 100
    for i, tau, r, phi in cases:
        points = ray_path(Spacetime.kerr(1, SPIN[i]), origins[i], directions[i], tau, 1e-12)["position"]
        scale = np.hypot(r, SPIN[i])
        truth = scale[:, None] * np.stack([np.cos(phi), np.sin(phi), np.zeros_like(phi)], -1)
        # near the horizon and close to infinity positions run away from rounding errors of the Mino time
        _, delta, _ = kerr_functions(SPIN[i], r, 1.0, 0.0)
        sensitivity = (1 + r) / np.minimum(1, delta) * max(1.0, CONDITION[i])
        assert np.all(np.linalg.norm(points - truth, axis=1) / scale <= 1e-11 + 200 * EPS * sensitivity), GOLDEN[i][
            "id"
        ]


def test_constants_of_motion_from_the_direction_at_the_crossings():
    """L rebuilt from the local direction at the path's own points is the golden one: frames and lapse agree."""
    origins, directions = local_rays()
    checked = 0
    for i, tau, r, phi in crossings():
        a, delta = SPIN[i], r**2 - 2 * r + SPIN[i] ** 2
        if CONDITION[i] > 1e4 or delta.min() < 1e-3 or r.max() > 1e3:
            continue
        space = Spacetime.kerr(1, a)
        path = ray_path(space, origins[i], directions[i], tau, 1e-12)
        for k in range(len(tau)):
            area = (r[k] ** 2 + a**2) ** 2 - delta[k] * a**2
            omega, g_phi = 2 * a * r[k] / area, np.sqrt(area) / r[k]
            north_east = path["direction"][k] @ np.array([-np.sin(phi[k]), np.cos(phi[k]), 0.0])
            alpha = lapse(space, path["position"][k])
            # the photon runs against the ray: its L is minus the look direction's
            energy = (float(GOLDEN[i]["E"]) - omega * float(GOLDEN[i]["L"])) / alpha
            limit = 10 * 1e-12 * abs(energy) * g_phi  # what ten tolerances of the direction make
            assert -energy * north_east * g_phi == pytest.approx(float(GOLDEN[i]["L"]), rel=0, abs=limit)
            checked += 1
    assert checked > 50


def test_frequency_shifts_of_a_disk():
    """g = E_obs / (u^t (E - Omega L)) of orbiting matter, with L/E taken from the path's direction at the disk."""
    index = {row["id"]: i for i, row in enumerate(GOLDEN)}
    table = [row for row in rows("redshift.csv") if row["kerr_row:crossing"]]
    origins, directions = local_rays()
    checked = 0
    for row in table:
        name, k = row["kerr_row:crossing"].split(":")
        if name not in index or CONDITION[index[name]] > 1e4:
            continue
        i, r, k = index[name], float(row["r_em"]), int(k)
        a, tau = SPIN[i], number_lists([GOLDEN[index[name]]], "eq_tau")[0]
        crossing = np.argmin(np.abs(number_lists([GOLDEN[i]], "eq_r")[0] - r))
        space = Spacetime.kerr(1, a)
        path = ray_path(space, origins[i], directions[i], tau[crossing : crossing + 1], 1e-12)
        position, direction = path["position"][0], path["direction"][0]
        _, _, area = kerr_functions(a, r, 1.0, 0.0)
        omega, g_phi = 2 * a * r / area, np.sqrt(area) / r
        east = direction @ np.array([-position[1], position[0], 0.0]) / np.hypot(*position[:2])
        L_over_local = -east * g_phi
        energy = lapse(space, position) + omega * L_over_local  # E / E_loc
        u_t = (r**1.5 + a) / (r**0.75 * np.sqrt(r**1.5 - 3 * r**0.5 + 2 * a))
        shift = 1 / (u_t * (1 - L_over_local / energy / (r**1.5 + a))) / float(GOLDEN[i]["E"])
        assert shift == pytest.approx(float(row["g=nu_obs/nu_em"]), rel=1e-12)
        checked += 1
    assert checked > 20


def test_lapse_of_every_observer():
    """alpha = E - omega L of the photon with local energy 1."""
    origins, _ = local_rays()
    for i, row in enumerate(GOLDEN):
        _, _, area = kerr_functions(SPIN[i], RADIUS[i], SINE[i], COSINE[i])
        omega = 2 * SPIN[i] * RADIUS[i] / area
        expected = float(row["E"]) - omega * float(row["L"])
        assert lapse(Spacetime.kerr(1, SPIN[i]), tuple(origins[i])) == pytest.approx(expected, rel=1e-12)
