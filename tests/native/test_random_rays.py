"""Rays from everywhere to everywhere: tolerances and routes agree within their own estimates, whatever the ray.

Origins from 1e-4 above the horizon to 1e6 M, half of the rays aimed near the object, spins up to 1 - 1e-12 M, observers
on the equator and next to the axis. A failure names the seed and the ray.
"""

import numpy as np
import pytest
from bentlight_native import Spacetime, trace_rays
from rays import angle_between, oblate_basis, unit

COUNT = 1500


def directions_from(rng, origins, aimed, spread):
    anywhere = unit(rng.normal(size=origins.shape))
    return unit(spread * rng.uniform(0, 1, (len(origins), 1)) * anywhere - origins) if aimed else anywhere


def random_kerr(rng, aimed):
    spin = rng.choice([-1, 1]) * rng.choice([1e-8, 1e-3, 0.1, 0.5, 0.9, 0.99, 0.999, 0.9999, 0.999999, 1 - 1e-12])
    r = (1 + np.sqrt(1 - spin**2)) * (1 + 10 ** rng.uniform(-4, 6, COUNT))
    cosine = rng.uniform(-1, 1, COUNT)
    kind = rng.integers(3)
    sine = [np.sqrt(1 - cosine**2), np.ones(COUNT), np.full(COUNT, 1e-9)][kind]
    position, *_ = oblate_basis(spin, r, sine, [cosine, np.zeros(COUNT), np.sign(cosine)][kind])
    return Spacetime.kerr(1, spin), position, directions_from(rng, position, aimed, 8)


def random_schwarzschild(rng, aimed):
    chart = rng.choice(["isotropic", "areal"])
    core = Spacetime.schwarzschild(1, chart).core_radius
    origins = unit(rng.normal(size=(COUNT, 3))) * core * (1 + 10 ** rng.uniform(-4, 6, (COUNT, 1)))
    return Spacetime.schwarzschild(1, chart), origins, directions_from(rng, origins, aimed, 8)


def random_ellis(rng, aimed):
    origins = unit(rng.normal(size=(COUNT, 3))) * 10 ** rng.uniform(-3, 6, (COUNT, 1))
    return Spacetime.ellis(1), origins, directions_from(rng, origins, aimed, 3)


def check_agreement(one, other, allowance, label):
    both = (one["fate"] != 0) & (other["fate"] != 0)
    assert np.array_equal(one["fate"][both], other["fate"][both]), label
    out = both & (one["fate"] != 2)
    apart = angle_between(one["direction"][out], other["direction"][out])
    excess = apart - allowance * (one["error"][out] + other["error"][out])
    assert np.all(excess <= 0), (label, np.flatnonzero(out)[np.argmax(excess)])


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("make", [random_kerr, random_schwarzschild, random_ellis])
def test_random_rays(make, seed):
    space, origins, directions = make(np.random.default_rng(seed), aimed=seed % 2 == 0)
    exact = trace_rays(space, origins, directions, 1e-13, route="taylor")
    assert np.mean(exact["fate"] == 0) < 2e-3
    for tolerance in (10.0, 1e-3, 1e-6, 1e-10):
        got = trace_rays(space, origins, directions, tolerance, route="taylor")
        assert got["steps"].max() < 2000
        check_agreement(got, exact, 2, (seed, repr(space), tolerance))
    for tolerance in (1e-6, 1e-12):
        quick = trace_rays(space, origins, directions, tolerance)
        check_agreement(quick, exact, 3, (seed, repr(space), "auto", tolerance))
