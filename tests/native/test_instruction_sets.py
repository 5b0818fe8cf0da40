"""All instruction sets of this processor give the same rays: how far apart the last bits may be."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from bentlight_native import Spacetime, instruction_set, trace_rays
from golden import EPS
from rays import angle_between, unit

SPACES = {
    "isotropic": Spacetime.schwarzschild(1),
    "areal": Spacetime.schwarzschild(1, "areal"),
    "kerr": Spacetime.kerr(1, 0.9),
    "ellis": Spacetime.ellis(1),
}
ROUTES = ("taylor", "auto")


def trace_all(tolerance: float) -> dict[str, np.ndarray]:
    """Rays from 10 M to all sides and closely around the core, by every spacetime and route."""
    random = np.random.default_rng(8)
    origins = 10 * unit(random.normal(size=(2000, 3)))
    aside = unit(random.normal(size=(2000, 3))) * random.uniform(0, 12, (2000, 1))
    directions = unit(aside - origins)
    return {
        f"{name} {route} {key}": values
        for name, space in SPACES.items()
        for route in ROUTES
        for key, values in trace_rays(space, origins, directions, tolerance, route=route).items()
    }


def others() -> list[str]:
    """Instruction sets that this process does not use; a processor takes those below its best."""
    names = ["v2", "v3", "v4"]
    return [name for name in names if name != instruction_set()] if instruction_set() in names else []


@pytest.mark.unsanitized
@pytest.mark.parametrize("other", others())
@pytest.mark.parametrize("tolerance", [1e-4, 1e-8])
def test_rays_differ_in_the_last_bits_alone(other, tolerance, tmp_path):
    """Fates are the same; directions differ by what rounding makes of a ray, its estimate when nothing is left to the
    tolerance, and by a thousandth of the error that the tolerance leaves, as lengths of arcs are rounded too."""
    script = (
        "import numpy, test_instruction_sets as t\n"
        f"numpy.savez({str(tmp_path / 'rays.npz')!r}, used=t.instruction_set(), **t.trace_all({tolerance}))"
    )
    path = os.pathsep.join([str(Path(__file__).parent), *sys.path])
    environment = {**os.environ, "BENTLIGHT_ISA": other, "PYTHONPATH": path}
    subprocess.run([sys.executable, "-c", script], check=True, env=environment)
    theirs = np.load(tmp_path / "rays.npz")
    if theirs["used"] != other:
        pytest.skip(f"this processor has no {other}")
    ours, rounding = trace_all(tolerance), trace_all(1e-15)
    for name in (f"{space} {route}" for space in SPACES for route in ROUTES):
        assert np.array_equal(ours[f"{name} fate"], theirs[f"{name} fate"]), name
        out = np.isin(ours[f"{name} fate"], (1, 3))
        apart = angle_between(ours[f"{name} direction"][out], theirs[f"{name} direction"][out])
        assert np.all(apart <= (rounding[f"{name} error"] + 1e-3 * ours[f"{name} error"])[out]), name
        assert np.median(apart) <= 5 * EPS
