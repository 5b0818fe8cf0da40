"""Speed of geodesic connections: microseconds a pair of random points, and how many images met their tolerance.

Points lie at radii even in the logarithm from just outside the horizon, or from deep on a wormhole's far side, to 50
times the core's radius.
"""

import sys
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import numpy as np
from bench_table import fastest
from bentlight_native import Spacetime, connect

sys.path.insert(0, str(Path(__file__).parents[1] / "native"))
from rays import unit

# and the innermost radius; the Kerr hole's horizon has about the same size as the others' cores
SPACETIMES = {
    "Schwarzschild": (Spacetime.schwarzschild(1.0), 1.05),
    "Ellis": (Spacetime.ellis(1.0), 0.02),
    "Kerr, a = 0.9 M": (Spacetime.kerr(0.3, 0.27), 1.05),
    "Kerr, a = 0.9 M, from 3 horizons": (Spacetime.kerr(0.3, 0.27), 3.0),
}
PAIRS = 20000
GOALS = {"Schwarzschild": 2.0, "Kerr, a = 0.9 M": 20.0, "Kerr, a = 0.9 M, from 3 horizons": 20.0}  # us, two images


def random_points(seed: int, innermost: float) -> np.ndarray:
    """Points around a core of radius 1/2."""
    rng = np.random.default_rng(seed)
    radii = 0.5 * np.exp(rng.uniform(np.log(innermost), np.log(50), (PAIRS, 1)))
    return radii * unit(rng.normal(size=(PAIRS, 3)))


def measure(repeat: int = 5) -> Iterator[list[str | int]]:
    """Rows: spacetime, images, tolerance, microseconds a pair, images that met the tolerance, goal."""
    for name, (space, innermost) in SPACETIMES.items():
        a, b = random_points(1, innermost), random_points(2, innermost)
        for images, tolerance in ((1, 1e-6), (2, 1e-6), (2, 1e-8), (4, 1e-8)):
            seconds = fastest(partial(connect, space, a, b, images, tolerance), repeat)
            met = connect(space, a, b, images, tolerance)["counts"]["met"] / (images * PAIRS)
            goal = f"{GOALS[name]:g}" if name in GOALS and images == 2 else ""
            yield [name, images, f"{tolerance:.0e}", f"{seconds / PAIRS * 1e6:.2f}", f"{met:.2%}", goal]
