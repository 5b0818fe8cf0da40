"""Deflection tables against the golden data, the traced rays, and themselves."""

import math

import numpy as np
import pytest
from bentlight_native import Cancelled, DeflectionTable, Progress, Spacetime, _core, trace_rays
from bentlight_native.table import map_values
from golden import numbers, rows, sine_cosine_deg
from rays import angle_between, isotropic_radius, planar_rays, unit
from tables import SPACETIMES

CRITICAL = 3 * np.sqrt(3)


def random_rays(spacetime, n=20000, seed=3):
    """From just outside the core to far away, directions both over the sphere and close around the core."""
    random = np.random.default_rng(seed)
    core = spacetime.core_radius
    nearest = 0.01 if spacetime.kind == "ellis" else 1.0001
    radius = core * np.exp(random.uniform(np.log(nearest), np.log(1e4), n))
    origins = radius[:, None] * unit(random.normal(size=(n, 3)))
    aside = unit(random.normal(size=(n, 3))) * core * random.uniform(0, 30, n)[:, None]
    near = random.random(n) < 0.5
    return origins, unit(np.where(near[:, None], aside - origins, random.normal(size=(n, 3))))


def test_total_deflection_matches_the_golden_rows():
    """Within 1e-10 wherever |b/b_c - 1| >= 1e-6, the stated domain, and what rounding of b allows closer."""
    golden = rows("schwarzschild_deflection_infinity.csv")
    delta = numbers(golden, "b_over_bc_minus_1")
    got = DeflectionTable(SPACETIMES["isotropic"]).total(delta) - np.pi
    error = np.abs(got - numbers(golden, "alpha"))
    assert np.all(error[np.abs(delta) >= 1e-6] <= 1e-10)
    assert np.all(error <= 1e-12 + 1e-15 / np.abs(delta))


def test_total_deflection_at_the_critical_ray():
    """b = b_c (1 + 10^-k) exactly, down to k = 16 and beyond the segments."""
    golden = rows("schwarzschild_deflection_critical_exact.csv")
    got = DeflectionTable(SPACETIMES["isotropic"]).total(10.0 ** -numbers(golden, "k")) - np.pi
    assert np.all(np.abs(got - numbers(golden, "alpha")) <= 2e-12)


@pytest.mark.parametrize("b", [1e-9, 0.3, 0.999, 1.001, 2.0, 1e5])
def test_total_angle_through_and_past_a_throat(b):
    """2 b K(b) and 2 K(1/b), K by the arithmetic-geometric mean written out here."""
    small = min(b, 1 / b)
    x, y = 1.0, math.sqrt((1 - small) * (1 + small))
    for _ in range(40):
        x, y = (x + y) / 2, math.sqrt(x * y)
    expected = (b if b < 1 else 1) * math.pi / x
    assert DeflectionTable(SPACETIMES["ellis"]).total([b - 1])[0] == pytest.approx(expected, abs=1e-11)


def test_total_outside_its_domain_is_nan():
    assert np.isnan(DeflectionTable(SPACETIMES["areal"]).total([0.0, -0.5, np.nan, np.inf])).all()
    assert np.isnan(DeflectionTable(SPACETIMES["ellis"]).total([0.0, -1.0, -2.0, np.nan, -np.inf])).all()


def test_finite_radius_matches_the_golden_rows():
    golden = rows("schwarzschild_deflection_finite.csv")
    sine, cosine = sine_cosine_deg(numbers(golden, "psi_deg"))
    truth = numbers(golden, "swept_azimuth")
    got = DeflectionTable(SPACETIMES["isotropic"]).sweep(isotropic_radius(numbers(golden, "r_obs")), cosine, sine)
    expected = np.array([{"escape": 1, "capture": 2, "circular": 0}[row["fate"]] for row in golden])
    assert np.array_equal(got[0], expected)
    escaped = expected == 1
    condition = np.nan_to_num(numbers(golden, "cond_dswept_dpsi"))[escaped]
    assert np.all(np.abs(got[1] - truth)[escaped] <= 1e-8 + 1e-14 * np.abs(condition))


def test_lookup_agrees_with_tracing(table):
    """Fates equal and directions within 1e-8, beyond what rounding does near the critical ray."""
    origins, directions = random_rays(table.spacetime)
    looked_up, traced = (
        table.trace(origins, directions),
        trace_rays(table.spacetime, origins, directions, 1e-12, route="taylor"),
    )
    decided = (looked_up["fate"] != 0) & (traced["fate"] != 0)
    assert decided.mean() > 0.999
    assert np.array_equal(looked_up["fate"][decided], traced["fate"][decided])
    out = decided & (traced["fate"] != 2)
    apart = angle_between(looked_up["direction"][out], traced["direction"][out])
    assert np.all(apart <= 1e-8 + 2 * traced["error"][out])
    assert np.percentile(apart, 99) <= 1e-8
    assert np.all(apart <= 2 * (looked_up["error"] + traced["error"])[out])


def test_lookups_keep_the_measured_error(table):
    """The error that the table carries is the one that other points than its own find."""
    random = np.random.default_rng(5)
    delta = 10 ** random.uniform(-6, 5, 5000)
    b = 1 + delta
    if table.spacetime.kind == "ellis":
        x, y = b, np.sqrt(delta * (2 + delta))
        for _ in range(12):
            x, y = (x + y) / 2, np.sqrt(x * y)
        assert np.abs(table.total(delta) - np.pi * b / x).max() <= 2 * table.measured.total_max
    origins, directions = random_rays(table.spacetime, 5000, 6)
    direct = trace_rays(table.spacetime, origins, directions, 1e-12, route="endpoint")
    looked_up = table.trace(origins, directions)
    out = np.isfinite(direct["swept"] + looked_up["swept"]) & (direct["error"] < 1e-12)
    error = np.abs(direct["swept"] - looked_up["swept"])[out]
    assert error.max() <= 2 * (table.measured.total_max + table.measured.sweep_max)
    assert np.sqrt(np.mean(error**2)) <= 10 * table.measured.sweep_rms
    assert table.measured.total_max <= 1e-12
    assert table.measured.sweep_max <= 1e-8


def test_scalar_and_batch_agree_at_any_length(table):
    delta = np.geomspace(1e-9, 1e9, 37)
    whole = table.total(delta)
    for n in range(1, 20):
        assert np.array_equal(table.total(delta[:n]), whole[:n])


def test_rows_in_any_order_give_the_same_table():
    one, other = _core.table_new(SPACETIMES["ellis"]), _core.table_new(SPACETIMES["ellis"])
    one.build(0, one.rows)
    for row in reversed(range(other.rows)):
        other.build(row, row + 1)
    assert one.measured() == other.measured()


def test_unbuilt_cancelled_and_wrong():
    table = _core.table_new(SPACETIMES["areal"])
    table.build(0, table.rows - 1)
    with pytest.raises(RuntimeError, match="not built"):
        table.measured()
    with pytest.raises(RuntimeError, match="not built"):
        table.total(np.ones(1), np.empty(1))
    with pytest.raises(ValueError, match="rows"):
        table.build(0, table.rows + 1)
    with pytest.raises(ValueError, match="rows"):
        table.build(-1, 2)
    progress = Progress()
    progress.cancel()
    with pytest.raises(Cancelled):
        DeflectionTable(SPACETIMES["areal"], progress=progress)
    for spacetime in (Spacetime.minkowski(), Spacetime.kerr(1, 0.5), Spacetime.schwarzschild(0)):
        with pytest.raises(ValueError, match="Schwarzschild"):
            DeflectionTable(spacetime)
    watched = Progress()
    DeflectionTable(SPACETIMES["areal"], progress=watched, threads=2)
    assert watched.done == table.rows


def test_bad_input_is_refused_or_unresolved(table):
    with pytest.raises(ValueError, match="origins"):
        table.trace([[np.nan, 0, 0]], [[1.0, 0, 0]])
    fate, swept = table.sweep([np.nan, 0.0, -1.0, 5.0], [1.0, 1.0, 1.0, np.nan], [0.0, 0.0, 0.0, 0.0])
    assert fate.tolist() == [0, 0, 0, 0]
    assert np.isnan(swept).all()


MAPS = {
    "delta": ("delta_coordinate", "delta_from_coordinate", np.geomspace(2.0**-24, 2.0**24, 101), (-24.0, 24.0)),
    "schwarzschild": ("ratio_schwarzschild", "x_schwarzschild", np.linspace(1e-9, 0.4999, 101), ()),
    "ellis": ("ratio_ellis", "x_ellis", np.linspace(0.2, 0.99999, 101), ()),
    "edge": ("edge_coordinate", "psi_from_coordinate", np.linspace(0.31, 3.14, 101), (0.3, 1e-4)),
}


@pytest.mark.parametrize("name", MAPS)
def test_map_of_inverse_is_the_identity(name):
    forward, inverse, values, parameters = MAPS[name]
    assert map_values(inverse, map_values(forward, values, *parameters), *parameters) == pytest.approx(
        values, rel=1e-12
    )


def test_stored_totals_are_smooth_and_restored():
    """What diverges like -log(size) near the critical ray and is level far from it is stored as a constant."""
    size = np.geomspace(1e-7, 1e7, 51)
    total = 3.0 - np.log(size / (1 + size))
    stored = map_values("total_stored", size, total)
    assert stored == pytest.approx(np.full(51, 3.0), abs=1e-13)
    assert map_values("total_from_stored", size, stored) == pytest.approx(total, abs=1e-13)


def test_impact_parameters_of_the_map():
    """b/b_c - 1 from position and angle, against b = r sin(psi) / sqrt(1 - 2M/r) and b = r sin(psi)."""
    x, sine = np.array([0.01, 0.1, 0.2]), np.array([0.2, 0.5, 0.9])
    expected = sine / x / np.sqrt(1 - 2 * x) / CRITICAL - 1
    assert map_values("delta_schwarzschild", x, sine) == pytest.approx(expected, rel=1e-13)
    position, direction = planar_rays(np.array([2.0]), np.array([0.6]), np.array([0.8]))
    ratio = 0.5 / np.linalg.norm(position)
    b = (2.0 + 0.125) * np.linalg.norm(np.cross(position, direction)) / np.linalg.norm(position)
    x = map_values("x_ellis", [ratio])
    assert map_values("delta_ellis", x, [0.8]) == pytest.approx([b - 1], rel=1e-12)
