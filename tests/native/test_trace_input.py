"""Bad input to spacetimes, trace_rays and ray_path: one clear error each; empty input is no error."""

import numpy as np
import pytest
from bentlight_native import Cancelled, Progress, Spacetime, contains, lapse, local_from_covector, ray_path, trace_rays
from rays import kerr_functions, oblate_basis

KERR = Spacetime.kerr(1, 0.9)
ORIGIN, LOOK = np.array([[10.0, 0, 0]]), np.array([[-1.0, 0, 0]])
SPACES = [
    Spacetime.minkowski(),
    Spacetime.schwarzschild(1),
    Spacetime.schwarzschild(1, "areal"),
    KERR,
    Spacetime.ellis(1),
]


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1e200])
@pytest.mark.parametrize("space", SPACES, ids=repr)
def test_bad_numbers_are_named(space, bad):
    origins, looks = np.tile(ORIGIN, (20, 1)), np.tile(LOOK, (20, 1))
    origins[13, 1] = bad
    with pytest.raises(ValueError, match="origins: ray 13"):
        trace_rays(space, origins, looks)
    origins[13, 1], looks[17, 2] = 0, bad
    with pytest.raises(ValueError, match="directions: ray 17"):
        trace_rays(space, origins, looks)


@pytest.mark.parametrize("space", SPACES, ids=repr)
def test_zero_direction(space):
    with pytest.raises(ValueError, match=r"directions: ray 0 .* zero"):
        trace_rays(space, ORIGIN, np.zeros((1, 3)))


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, -1.0])
def test_spacetimes_of_bad_sizes(bad):
    for chart in ("isotropic", "areal"):
        with pytest.raises(ValueError, match="mass: must be finite and not negative, got"):
            Spacetime.schwarzschild(bad, chart)
    with pytest.raises(ValueError, match="mass: must be finite and not negative, got"):
        Spacetime.kerr(bad, 0.0)
    with pytest.raises(ValueError, match="throat_radius: must be finite and positive, got"):
        Spacetime.ellis(bad)


def test_spin_must_be_smaller_than_the_mass():
    for mass, spin in [
        (1, 1),
        (1, -1),
        (1, 1.5),
        (2, -5),
        (0, 0.1),
        (1, np.nan),
        (1, np.inf),
        (1, -np.inf),
        (1e-300, 1),
    ]:
        with pytest.raises(ValueError, match=r"spin: \|spin\| must be smaller than the mass"):
            Spacetime.kerr(mass, spin)
    assert Spacetime.kerr(1, np.nextafter(1, 0)).spin < 1
    assert Spacetime.kerr(0, 0).core_radius == 0


def test_other_bad_spacetimes():
    with pytest.raises(ValueError, match="throat_radius: must be finite and positive, got 0"):
        Spacetime.ellis(0)
    with pytest.raises(ValueError, match="chart: expected 'isotropic' or 'areal', got 'oblate'"):
        Spacetime.schwarzschild(1, "oblate")
    for make in (Spacetime.schwarzschild, Spacetime.ellis):
        with pytest.raises(TypeError):
            make("1")


def test_origins_within_the_horizon():
    for space, inside in [
        (Spacetime.schwarzschild(1), (0.5, 0, 0)),
        (Spacetime.schwarzschild(1), (0, 0, 0)),
        (Spacetime.schwarzschild(1, "areal"), (0, 1.2, 1.2)),
        (KERR, (0, 0, 1.43)),
        (KERR, (1.69, 0, 0)),
        (Spacetime.ellis(1), (0, 0, 0)),
    ]:
        assert not contains(space, inside)
        assert lapse(space, inside) == 0
        with pytest.raises(ValueError, match=r"origins: ray 0 .* inside a horizon"):
            trace_rays(space, [inside], LOOK)
    assert contains(KERR, (0, 0, 1.4359))
    assert contains(KERR, (1.695, 0, 0))


@pytest.mark.parametrize("tolerance", [0, -1e-6, np.nan, np.inf])
def test_bad_tolerance(tolerance):
    with pytest.raises(ValueError, match="tolerance: must be positive"):
        trace_rays(KERR, ORIGIN, LOOK, tolerance)


@pytest.mark.parametrize("shape", [(3,), (1, 2), (1, 1, 3), (2, 3)])
def test_bad_shapes(shape):
    with pytest.raises(ValueError, match=r"origins: expected|directions: expected"):
        trace_rays(KERR, np.ones(shape), LOOK)
    with pytest.raises(ValueError, match=r"origins: expected|directions: expected"):
        trace_rays(KERR, ORIGIN, np.ones(shape))


def test_other_errors():
    with pytest.raises(TypeError, match="Spacetime"):
        trace_rays("kerr", ORIGIN, LOOK)
    with pytest.raises(ValueError, match="route: expected one of"):
        trace_rays(KERR, ORIGIN, LOOK, route="fast")
    with pytest.raises(ValueError, match="mino_times"):
        ray_path(KERR, ORIGIN[0], LOOK[0], [0.2, 0.1])
    with pytest.raises(ValueError, match="mino_times"):
        ray_path(KERR, ORIGIN[0], LOOK[0], [-0.1])
    with pytest.raises(ValueError, match="origin"):
        ray_path(KERR, [0, 0, 0.1], LOOK[0], [0.1])


@pytest.mark.parametrize("space", SPACES, ids=repr)
def test_empty_and_convertible_input(space):
    got = trace_rays(space, np.empty((0, 3)), np.empty((0, 3)))
    assert [len(values) for values in got.values()] == [0] * 5
    doubled = trace_rays(space, [[10, 0, 0]], np.array([[0, 3, 0]], np.float32))
    unit = trace_rays(space, ORIGIN, [[0.0, 1.0, 0.0]])
    assert np.array_equal(doubled["direction"], unit["direction"])


def test_covectors_of_the_oblate_and_areal_charts():
    """The legs of the tetrad, e_(a)^i d_i f, against differences of f along the coordinates."""
    for a, space in ((0.9, KERR), (0.0, Spacetime.schwarzschild(1, "areal"))):
        r, sine, cosine = 3.0, np.sin(0.7), np.cos(0.7)
        position, e_r, e_theta, e_phi = oblate_basis(a, r, sine, cosine)
        sigma, delta, area = kerr_functions(a, r, sine, cosine)
        h = 1e-6

        def rise(dr, dtheta, covector, a=a, r=r):
            """Change of f = covector . X along a coordinate step, by central differences of the chart itself."""
            ends = [oblate_basis(a, r + k * dr, np.sin(0.7 + k * dtheta), np.cos(0.7 + k * dtheta))[0] for k in (1, -1)]
            return covector @ (ends[0] - ends[1]) / 2

        matrix = np.array(local_from_covector(space, tuple(position)))
        for covector in np.eye(3):
            local = matrix @ covector
            along_r = rise(h, 0, covector) / h / np.sqrt(sigma / delta)
            along_theta = rise(0, h, covector) / h / np.sqrt(sigma)
            along_phi = covector @ e_phi * np.hypot(r, a) * sine / (sine * np.sqrt(area / sigma))
            assert local @ e_r == pytest.approx(along_r, abs=1e-9)
            assert local @ e_theta == pytest.approx(along_theta, abs=1e-9)
            assert local @ e_phi == pytest.approx(along_phi, abs=1e-12)
    for space in (Spacetime.minkowski(), Spacetime.schwarzschild(1), Spacetime.ellis(1)):
        assert np.array_equal(local_from_covector(space, (1.0, 2.0, 3.0)), np.eye(3))


@pytest.mark.parametrize("space", SPACES, ids=repr)
def test_progress_counts_rays_and_cancels(space):
    origins, looks = np.tile(ORIGIN, (3000, 1)), np.tile(LOOK, (3000, 1))
    progress = Progress()
    trace_rays(space, origins, looks, progress=progress)
    assert progress.done == 3000
    progress.cancel()
    with pytest.raises(Cancelled, match="0 of 3000 rays"):
        trace_rays(space, origins, looks, progress=progress)
    with pytest.raises(TypeError, match="Progress"):
        trace_rays(space, origins, looks, progress=1)
