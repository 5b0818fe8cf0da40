"""The endpoint route: how much it answers, and how well, against Taylor arcs on random rays and golden data."""

import numpy as np
import pytest
from bentlight_native import Spacetime, trace_rays
from golden import EPS, numbers, rows, sine_cosine_deg
from hard_cases import ergosphere
from rays import angle_between, image_grid, isotropic_radius, planar_rays, unit

SPACETIMES = {
    "schwarzschild": Spacetime.schwarzschild(1.0),
    "areal": Spacetime.schwarzschild(3.0, "areal"),
    "ellis": Spacetime.ellis(0.7),
    **{f"kerr {a:g}": Spacetime.kerr(1.0, a) for a in (1e-8, 1e-3, 0.1, 0.5, -0.9, 0.998, 0.99999, 1 - 1e-10)},
}


@pytest.fixture(params=SPACETIMES, ids=list(SPACETIMES))
def spacetime(request):
    return SPACETIMES[request.param]


def random_rays(spacetime, farthest, n=8000, seed=1):
    """Origins from beside the core to `farthest` core radii; directions aimed around the core or anywhere."""
    random = np.random.default_rng(seed)
    core = spacetime.core_radius
    nearest = 0.001 if spacetime.kind == "ellis" else 1.02
    radius = core * np.exp(random.uniform(np.log(nearest), np.log(farthest), n))
    origins = radius[:, None] * unit(random.normal(size=(n, 3)))
    aside = unit(random.normal(size=(n, 3))) * core * random.uniform(0, 12, n)[:, None]
    aimed = random.random(n) < 0.6
    return origins, unit(np.where(aimed[:, None], aside - origins, random.normal(size=(n, 3))))


@pytest.mark.parametrize("tolerance", [1e-3, 1e-6, 1e-12])
@pytest.mark.parametrize("farthest", [4.0, 1e4, 1e7])
def test_agrees_with_taylor_within_the_estimates(spacetime, farthest, tolerance):
    origins, directions = random_rays(spacetime, farthest)
    endpoint = trace_rays(spacetime, origins, directions, tolerance, route="endpoint")
    taylor = trace_rays(spacetime, origins, directions, 1e-13, route="taylor")
    both = (endpoint["fate"] != 0) & (taylor["fate"] != 0)
    assert np.array_equal(endpoint["fate"][both], taylor["fate"][both])
    out = both & (taylor["fate"] != 2)
    apart = angle_between(endpoint["direction"][out], taylor["direction"][out])
    assert np.all(apart <= 1.5 * endpoint["error"][out] + 2 * taylor["error"][out])
    # far away the rounding of the direction alone moves the impact parameter by EPS times the distance
    assert np.percentile(apart, 95) <= tolerance + 10 * EPS * farthest
    swept = np.abs(endpoint["swept"] - taylor["swept"])[out]
    assert np.all(swept <= 1e-4 * (1 + taylor["swept"][out]) + 2 * (endpoint["error"] + taylor["error"])[out])


def test_declines_little(spacetime):
    """Nothing but rays within rounding of the critical one without spin; with spin, few beyond 10 M."""
    origins, directions = random_rays(spacetime, 1e4)
    declined = trace_rays(spacetime, origins, directions, 1e-9, route="endpoint")["fate"] == 0
    if spacetime.kind != "kerr":
        assert declined.mean() < 1e-3
    far = np.linalg.norm(origins, axis=1) > 10
    assert declined[far].mean() < 0.005
    assert declined.mean() < 0.02


def test_declined_rays_say_so():
    """Rays with E <= 0 are left to Taylor: fate 0, error and direction NaN, no steps."""
    case = ergosphere(0.998, 1.2)
    negative = case.fates == 2
    assert negative.sum() > 5
    got = trace_rays(case.spacetime, case.origins[negative], case.directions[negative], route="endpoint")
    assert np.all(got["fate"] == 0)
    assert np.isnan(got["error"]).all()
    assert np.isnan(got["direction"]).all()
    assert np.all(got["steps"] == 0)


def test_golden_wormhole_rows():
    """Swept angles and sides of all Ellis rows but those that wind for ever."""
    golden = [row for row in rows("ellis_wormhole.csv") if float(row["b_minus_1"]) != 0]
    height = numbers(golden, "l_obs")
    sine, cosine = sine_cosine_deg(numbers(golden, "psi_deg"))
    r = np.hypot(height, 1)
    radius = np.where(height >= 0, (height + r) / 2, 0.5 / (r - np.minimum(height, 0)))
    got = trace_rays(Spacetime.ellis(1), *planar_rays(radius, cosine, sine), 1e-12, route="endpoint")
    assert np.array_equal(got["fate"], np.where([row["end_side"] == "+" for row in golden], 1, 3))
    error = np.abs(got["swept"] - numbers(golden, "swept_azimuth"))
    assert np.all(error <= 1e-13 + 20 * EPS * np.nan_to_num(np.abs(numbers(golden, "cond_dswept_dpsi"))))
    assert np.all(error <= 2 * got["error"])


@pytest.mark.parametrize("chart", ["isotropic", "areal"])
def test_golden_schwarzschild_rows(chart):
    golden = [row for row in rows("schwarzschild_deflection_finite.csv") if row["fate"] != "circular"]
    sine, cosine = sine_cosine_deg(numbers(golden, "psi_deg"))
    r = numbers(golden, "r_obs")
    origins, directions = planar_rays(isotropic_radius(r) if chart == "isotropic" else r, cosine, sine)
    got = trace_rays(Spacetime.schwarzschild(1, chart), origins, directions, 1e-12, route="endpoint")
    out = np.array([row["fate"] == "escape" for row in golden])
    assert np.array_equal(got["fate"], np.where(out, 1, 2))
    error = np.abs(got["swept"] - numbers(golden, "swept_azimuth"))[out]
    condition = np.nan_to_num(np.abs(numbers(golden, "cond_dswept_dpsi")))[out]
    assert np.all(error <= 1e-12 + 20 * EPS * condition)
    assert np.all(error <= 2 * got["error"][out])


def test_image_of_a_kerr_hole_at_99_percent():
    """The speed benchmark's rays: 2e-11 at the 99th percentile when 1e-10 is asked for, none declined."""
    origins, directions = image_grid(grid=64)
    spacetime = Spacetime.kerr(1, -0.9)
    got = trace_rays(spacetime, origins, directions, 1e-10, route="endpoint")
    truth = trace_rays(spacetime, origins, directions, 1e-13, route="taylor")
    assert np.array_equal(got["fate"], truth["fate"])
    out = truth["fate"] == 1
    assert np.percentile(angle_between(got["direction"][out], truth["direction"][out]), 99) <= 2e-11


def test_a_ray_does_not_depend_on_its_neighbors(spacetime):
    """Bit for bit the same alone, in any order, and in a batch of any length."""
    origins, directions = random_rays(spacetime, 100.0, n=777)
    whole = trace_rays(spacetime, origins, directions, 1e-7, route="endpoint")
    order = np.random.default_rng(2).permutation(777)
    shuffled = trace_rays(spacetime, origins[order], directions[order], 1e-7, route="endpoint")
    for name, values in whole.items():
        assert np.array_equal(values[order], shuffled[name], equal_nan=values.dtype.kind == "f"), name
    for i in range(0, 777, 97):
        alone = trace_rays(spacetime, origins[i : i + 1], directions[i : i + 1], 1e-7, route="endpoint")
        assert np.array_equal(alone["direction"][0], whole["direction"][i], equal_nan=True)
