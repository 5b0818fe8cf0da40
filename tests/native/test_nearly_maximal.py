"""Holes that spin nearly as fast as they can: every ray's own error estimate against 113-bit arithmetic.

Close to such a horizon frame dragging turns rays up to 1/sqrt(1 - a^2) times faster than their own motion does, and
errors grow with it: rays that wind just outside it, and rays that start there.
"""

from functools import cache

import numpy as np
import pytest
from bentlight_native import Spacetime, trace_rays
from golden import EPS
from kerr_reference import KerrReference
from rays import angle_between, oblate_basis, rays_from_constants, unit
from test_golden_kerr import CONDITION, FATE, SPIN, TRUTH, local_rays

SPINS = (0.9, 0.9995, -0.9999, 0.999999, 1 - 1e-9, -(1 - 1e-12), 1 - 2**-53)  # the last: the largest double below 1
ROUTES = {"taylor": 1e-13, "endpoint": 1e-12}
COUNT, WORST = 8_000, 6


def random_rays(rng, spin):
    """From 1e-4 to 1e3 horizon radii above the horizon, on the equator and off it, a part aimed around the hole."""
    r = (1 + np.sqrt((1 - spin) * (1 + spin))) * (1 + 10 ** rng.uniform(-4, 3, COUNT))
    cosine = np.where(rng.random(COUNT) < 0.3, 0, rng.uniform(-1, 1, COUNT))
    origins, *_ = oblate_basis(spin, r, np.sqrt(1 - cosine**2), cosine)
    anywhere = unit(rng.normal(size=(COUNT, 3)))
    aimed = unit(8 * rng.uniform(0, 1, (COUNT, 1)) * anywhere - origins)
    return origins, np.where(rng.random((COUNT, 1)) < 0.6, aimed, anywhere)


def winding_rays(rng, spin):
    """Seen from the equator at 5 to 300 M, within 1e-9 to 1 of the spherical photon orbits (Bardeen 1973), half of them
    within 1e-6 to 1 of the prograde one, which is all but at the horizon."""
    a = -spin
    cosine = np.cos(2 / 3 * np.arccos(np.array([-abs(a), abs(a)])))
    prograde, retrograde = 2 * (1 + cosine)
    part = np.where(rng.random(COUNT) < 0.5, 10 ** rng.uniform(-6, 0, COUNT), rng.random(COUNT))
    r = prograde + (retrograde - prograde) * part
    L = (r**2 * (3 - r) - a**2 * (r + 1)) / (a * (r - 1))
    Q = np.maximum(0, r**3 * (4 * a**2 - r * (r - 3) ** 2) / (a * (r - 1)) ** 2)
    factor = 1 + 10 ** rng.uniform(-9, 0, COUNT) * rng.choice([-0.5, 1], COUNT)
    up = rng.choice([-1.0, 1.0], COUNT)
    return rays_from_constants(a, 10 ** rng.uniform(0.7, 2.5, COUNT), 1.0, 0.0, L * factor, Q * factor**2, up)


@cache
def rays_and_answers(make, spin):
    """Rays, and what both routes say about them."""
    space, (origins, directions) = Spacetime.kerr(1, spin), make(np.random.default_rng(4), spin)
    answers = {route: trace_rays(space, origins, directions, ROUTES[route], route=route) for route in ROUTES}
    return origins, directions, answers


@pytest.fixture(scope="module")
def reference(tmp_path_factory):
    return KerrReference(tmp_path_factory.mktemp("kerr_reference"))


CASES = pytest.mark.parametrize(("make", "spin"), [(make, a) for a in SPINS for make in (random_rays, winding_rays)])


def test_the_reference_is_right(reference):
    """Golden rays of all kinds, to the rounding of their input (angles in degrees) and of the golden directions."""
    origins, directions = local_rays()
    chosen = np.flatnonzero((FATE == 1) & (SPIN < 1))[::12]
    assert len(chosen) > 20
    for i in chosen:
        got, _ = reference.trace(SPIN[i], origins[i : i + 1], directions[i : i + 1])
        assert np.linalg.norm(got[0] - TRUTH[i]) <= 3 * EPS * (1 + CONDITION[i])


@CASES
@pytest.mark.parametrize("route", ROUTES)
def test_estimates_are_honest(reference, make, spin, route):
    """True error <= 2 estimates, of rays on which the routes differ most for what this one says, and of some others."""
    origins, directions, answers = rays_and_answers(make, spin)
    got, other = answers[route], answers["endpoint" if route == "taylor" else "taylor"]
    both = np.flatnonzero((got["fate"] != 0) & (other["fate"] != 0))
    assert len(both) > 0.7 * COUNT
    assert np.array_equal(got["fate"][both], other["fate"][both])
    out = both[got["fate"][both] == 1]
    apart = angle_between(got["direction"][out], other["direction"][out]) / got["error"][out]
    chosen = np.concatenate([out[np.argsort(apart)[-WORST:]], out[:WORST]])
    truth, _ = reference.trace(spin, origins[chosen], directions[chosen])
    error = angle_between(got["direction"][chosen], truth)
    assert np.all(error <= 2 * got["error"][chosen]), chosen[np.argmax(error / got["error"][chosen])]


@CASES
@pytest.mark.parametrize("tolerance", [1e-2, 1e-5, 1e-8])
def test_looser_tolerances_are_honest_too(make, spin, tolerance):
    origins, directions, answers = rays_and_answers(make, spin)
    exact = answers["taylor"]
    for route in ("taylor", "auto"):
        got = trace_rays(Spacetime.kerr(1, spin), origins, directions, tolerance, route=route)
        both = (got["fate"] != 0) & (exact["fate"] != 0)
        assert np.array_equal(got["fate"][both], exact["fate"][both])
        out = both & (exact["fate"] == 1)
        apart = angle_between(got["direction"][out], exact["direction"][out])
        assert np.all(apart <= 2 * (got["error"][out] + exact["error"][out])), route


@pytest.mark.parametrize("spin", SPINS)
def test_little_is_unresolved(spin):
    """Of rays in all directions one in a thousand at most. Of rays down to 1e-9 from the photon orbits one in ten: an
    error of 1e-16 grows to half a radian so near the horizon."""
    for make, share in ((random_rays, 1e-3), (winding_rays, 0.1)):
        origins, directions, _ = rays_and_answers(make, spin)
        got = trace_rays(Spacetime.kerr(1, spin), origins, directions, 1e-8)
        assert np.mean(got["fate"] == 0) <= share
        assert np.all(got["error"][got["fate"] == 0] > 0.5)


@CASES
def test_swept_angles(reference, make, spin):
    """The length of the path of n, to 1e-4 of 1 + itself on either route, as bent_trace_result says."""
    origins, directions, answers = rays_and_answers(make, spin)
    good = [(answer["fate"] == 1) & (answer["error"] < 1e-6) for answer in answers.values()]
    sure = np.flatnonzero(np.logical_and(*good))
    apart = np.abs(answers["taylor"]["swept"] - answers["endpoint"]["swept"])
    chosen = np.concatenate([sure[np.argsort(apart[sure])[-WORST:]], sure[:WORST]])
    _, truth = reference.trace(spin, origins[chosen], directions[chosen])
    for answer in answers.values():
        assert np.all(np.abs(answer["swept"][chosen] - truth) <= 1e-4 * (1 + truth))
