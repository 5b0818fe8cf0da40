"""Schwarzschild and Ellis rays against the golden data: deflections, points along rays, charts, lapse, images."""

import numpy as np
import pytest
from bentlight_native import Spacetime, lapse, ray_path, trace_rays
from golden import EPS, numbers, rows, sine_cosine_deg
from rays import angle_between, isotropic_radius, planar_rays

ROUTES = ["taylor", "endpoint", "auto"]
CHARTS = {"isotropic": isotropic_radius, "areal": lambda r: r}
# any axis and any plane through it do as well as another, but for the rounding of their components
ALONG, TOWARD = np.array([0.36, 0.48, 0.8]), np.array([0.8, -0.6, 0.0])
EXACT = np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])


def asymptote(swept, along=ALONG, toward=TOWARD):
    return np.cos(swept)[:, None] * along + np.sin(swept)[:, None] * toward


FINITE = [row for row in rows("schwarzschild_deflection_finite.csv") if row["fate"] != "circular"]
FINITE_FATE = np.array([{"escape": 1, "capture": 2}[row["fate"]] for row in FINITE])


@pytest.mark.parametrize("route", ROUTES)
@pytest.mark.parametrize("chart", CHARTS)
@pytest.mark.parametrize(
    ("scale", "axes"), [(1.0, EXACT), (1.0, (ALONG, TOWARD)), (1e-6, (ALONG, TOWARD)), (1e6, (ALONG, TOWARD))]
)
def test_schwarzschild_from_finite_observers(chart, route, scale, axes):
    r = numbers(FINITE, "r_obs")
    sine, cosine = sine_cosine_deg(numbers(FINITE, "psi_deg"))
    origins, directions = planar_rays(scale * CHARTS[chart](r), cosine, sine, *axes)
    got = trace_rays(Spacetime.schwarzschild(scale, chart), origins, directions, 1e-12, route=route)
    decided = got["fate"] != 0 if route == "endpoint" else np.ones(len(FINITE), bool)
    assert np.count_nonzero(decided) > 0.9 * len(FINITE)
    assert np.array_equal(got["fate"][decided], FINITE_FATE[decided])
    out = (FINITE_FATE == 1) & decided
    swept = numbers(FINITE, "swept_azimuth")
    limit = 1e-12 + 100 * EPS * np.nan_to_num(numbers(FINITE, "cond_dswept_dpsi"))
    if axes is not EXACT:
        # Rounded components and scales move r by up to 2 eps r and psi by eps. The golden data give tangential rays no
        # conditioning; beside the photon sphere it is d(swept) = (dr + sqrt(3) dpsi) / (r - 3).
        limit += np.where(cosine == 0, (6 + np.sqrt(3)) * EPS / np.maximum(np.abs(r - 3), EPS), 0)
    assert np.all(np.abs(got["swept"] - swept)[out] <= limit[out])
    assert np.all(angle_between(got["direction"], asymptote(swept, *axes))[out] <= limit[out])


def test_schwarzschild_swept_angle_at_the_horizon():
    fallen = [row for row in FINITE if row["fate"] == "capture"]
    sine, cosine = sine_cosine_deg(numbers(fallen, "psi_deg"))
    origins, directions = planar_rays(isotropic_radius(numbers(fallen, "r_obs")), cosine, sine)
    got = trace_rays(Spacetime.schwarzschild(1), origins, directions, 1e-12, route="taylor")
    truth = numbers(fallen, "swept_azimuth_at_horizon")
    error = np.abs(got["swept"] - truth)
    assert np.all(error <= got["error"])
    ordinary = np.array(["near" not in row["category"] for row in fallen])
    assert np.all(error[ordinary] <= 1e-12)


@pytest.mark.parametrize("route", ["taylor", "auto"])
def test_the_circular_orbit_is_unresolved(route):
    for chart, radius in CHARTS.items():
        got = trace_rays(Spacetime.schwarzschild(1, chart), [[radius(3.0), 0, 0]], [[0, 1.0, 0]], 1e-6, route=route)
        assert got["fate"][0] == 0
        assert np.isnan(got["direction"]).all()
        assert got["error"][0] > 0.5


@pytest.mark.parametrize("route", ROUTES)
@pytest.mark.parametrize("name", ["infinity", "critical_exact"])
def test_schwarzschild_from_infinity_to_infinity(name, route):
    """A ray that starts at its turning point r0 sweeps half of alpha + pi. Rounding r0 changes b/b_c - 1 = d by
    eps sqrt(d) only, so the exact critical rows can be tested in double precision."""
    table = rows(f"schwarzschild_deflection_{name}.csv")
    r0, alpha = numbers(table, "r0"), numbers(table, "alpha")
    origins, directions = planar_rays(isotropic_radius(r0), np.zeros_like(r0), np.ones_like(r0), ALONG, TOWARD)
    got = trace_rays(Spacetime.schwarzschild(1), origins, directions, 1e-12, route=route)
    decided = got["fate"] != 0 if route == "endpoint" else np.ones(len(r0), bool)
    assert np.count_nonzero(decided) > 0.8 * len(r0)
    limit = 1e-12 + 100 * EPS * 3 / np.abs(r0 - 3)
    assert np.all(got["fate"][decided] == 1)
    assert np.all(np.abs(2 * got["swept"] - alpha - np.pi)[decided] <= limit[decided])


def test_points_along_rays_in_the_isotropic_chart():
    table = rows("isotropic_points.csv")
    assert len(table) > 50
    space = Spacetime.schwarzschild(1)
    for ray in sorted({row["ray"] for row in table}):
        points = [row for row in table if row["ray"] == ray]
        sine, cosine = sine_cosine_deg(numbers(points[:1], "psi_deg"))
        origins, directions = planar_rays(isotropic_radius(numbers(points[:1], "r_obs")), cosine, sine)
        path = ray_path(space, origins[0], directions[0], numbers(points, "mino_tau"), 1e-12)
        truth = np.stack([numbers(points, f"{k}_iso") for k in "xyz"], -1)
        radius = numbers(points, "R_isotropic")
        # close to the critical ray the input's rounding has grown (the deflection of ray 0 says how much at most)
        assert np.all(np.linalg.norm(path["position"] - truth, axis=1) <= 1e-12 * radius * (1 + radius / 10)), ray


def test_charts_and_lapse():
    for row in rows("isotropic_conversion.csv"):
        r, R = float(row["r_areal"]), float(row["R_isotropic"])
        assert isotropic_radius(r) == pytest.approx(R, rel=1e-14)
        if r > 2:
            rounding = EPS / (1 - 2 / r)
            assert lapse(Spacetime.schwarzschild(1), (0, R, 0)) == pytest.approx(
                float(row["lapse"]), rel=1e-14 + 4 * rounding
            )
            assert lapse(Spacetime.schwarzschild(1, "areal"), (0, 0, r)) == pytest.approx(
                float(row["lapse"]), rel=1e-14 + 4 * rounding
            )


def test_images_of_a_point():
    """Rays at the image angles have the source's azimuth when they reach its radius; lapses give its shift."""
    for row in rows("images.csv"):
        r_obs, r_src, swept = float(row["r_obs"]), float(row["r_src"]), float(row["swept_azimuth"])
        psi = float(row["psi_from_inward_rad"])
        space = Spacetime.schwarzschild(1)
        shift = lapse(space, (isotropic_radius(r_src), 0, 0)) / lapse(space, (isotropic_radius(r_obs), 0, 0))
        assert shift == pytest.approx(float(row["redshift_static_src=nu_obs/nu_src"]), rel=1e-13)
        origins, directions = planar_rays(isotropic_radius(np.array([r_obs])), -np.cos(psi), np.sin(psi))
        momentum = r_obs * np.sin(psi)
        path = ray_path(space, origins[0], directions[0], [swept / momentum], 1e-12)
        turn = np.arctan2(path["position"][0, 1], path["position"][0, 0])
        magnified = 1 / abs(float(row["dpsi_dswept"]))
        assert np.cos(turn - swept) == pytest.approx(1, abs=1e-12)
        radius = np.linalg.norm(path["position"][0])
        assert radius == pytest.approx(isotropic_radius(r_src), rel=1e-11 + 100 * EPS * magnified * r_src / 10)


def ellis_rows():
    """Rows that leave, with their input; b exactly 1 winds for ever."""
    table = [row for row in rows("ellis_wormhole.csv") if row["end_side"] in "+-" and row["end_side"]]
    table = [row for row in table if float(row["b_minus_1"]) != 0]
    height, (sine, cosine) = numbers(table, "l_obs"), sine_cosine_deg(numbers(table, "psi_deg"))
    r = np.hypot(height, 1)
    # R = (l + r) / 2 without cancellation on the far side
    return table, np.where(height >= 0, (height + r) / 2, 0.5 / (r - height)), sine, cosine


@pytest.mark.parametrize("route", ROUTES)
@pytest.mark.parametrize("throat", [1.0, 1e-6, 1e6])
def test_ellis(route, throat):
    table, radius, sine, cosine = ellis_rows()
    assert len(table) > 100
    origins, directions = planar_rays(throat * radius, cosine, sine, ALONG, TOWARD)
    got = trace_rays(Spacetime.ellis(throat), origins, directions, 1e-12, route=route)
    side = np.array([{"+": 1, "-": 3}[row["end_side"]] for row in table])
    closeness = np.abs(numbers(table, "b_minus_1"))
    sure = closeness > 20 * EPS * (1 + radius)  # nearer ones may fall to either side by the input's rounding
    decided = sure & (got["fate"] != 0) if route == "endpoint" else sure
    assert np.count_nonzero(decided) > 0.9 * len(table)
    assert np.array_equal(got["fate"][decided], side[decided])
    swept = numbers(table, "swept_azimuth")
    limit = 1e-12 + 100 * EPS * np.fmax(numbers(table, "cond_dswept_dpsi"), 1)
    assert np.all(np.abs(got["swept"] - swept)[decided] <= limit[decided])
    assert np.all(angle_between(got["direction"], asymptote(swept))[decided] <= limit[decided])


@pytest.mark.parametrize("route", ["taylor", "auto"])
def test_the_throat_ray_is_unresolved(route):
    """b = rho to the last bit winds round the throat for ever: no answer, and an error that says so."""
    got = trace_rays(Spacetime.ellis(1.0), [[0.5, 0, 0]], [[0, 1.0, 0]], 1e-6, route=route)
    assert got["fate"][0] == 0
    assert np.isnan(got["direction"]).all()
    assert got["error"][0] > 0.5
