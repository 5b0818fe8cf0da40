"""The table mapping header is accepted by oslc as it stands, and computes there what it does in C."""

from pathlib import Path

import numpy as np
import pytest
import shader_values
from bentlight_native.table import map_values

HEADER = Path(__file__).parents[2] / "native" / "src" / "table" / "map.h"


def test_every_function_compiles(tmp_path):
    assert shader_values.compiled_functions(tmp_path, HEADER, "MAP_FUNCTION") >= 12


RANGES = {  # of the arguments; numbers alone stay what they are
    "delta_coordinate": [(1e-6, 1e6), -24, 24],
    "delta_from_coordinate": [(0.2, 0.6), -24, 24],
    "total_stored": [(1e-6, 1e3), (3, 9)],
    "total_from_stored": [(1e-6, 1e3), (2, 4)],
    "x_schwarzschild": [(1e-4, 0.4)],
    "ratio_schwarzschild": [(1e-4, 0.45)],
    "x_ellis": [(1e-3, 0.9)],
    "ratio_ellis": [(0.1, 0.999)],
    "delta_schwarzschild": [(1e-3, 0.3), (0.01, 1)],
    "delta_ellis": [(0, 0.99), (0.01, 1)],
    "edge_coordinate": [(1, 3), 0.5, 1e-4],
    "psi_from_coordinate": [(0, 1), 0.5, 1e-4],
}


@pytest.mark.parametrize("name", RANGES)
def test_shaders_compute_what_the_core_does(name, tmp_path):
    random = np.random.default_rng(5)
    given = [random.uniform(*span, 500) if isinstance(span, tuple) else np.full(500, span) for span in RANGES[name]]
    arguments = np.stack(given, axis=1).astype(np.float32)
    order = reversed(range(2)) if "stored" in name else range(len(given))  # map_values has the size first
    call = ", ".join(f"in[{i}]" for i in order)
    shader = shader_values.evaluate(tmp_path, ["map.h"], f"out = map_{name}({call});", arguments)[:, 0]
    exact = map_values(name, *arguments.T.astype(float))
    sensitivity = np.abs(exact) + 0.1
    for i in range(len(given)):
        shifted = arguments.T * np.where(np.arange(len(given)) == i, 1 + 1e-6, 1)[:, None]
        sensitivity += np.abs(map_values(name, *shifted) - exact) * 1e6
    # OSL's own logarithm and exponential are off by tens of roundings
    assert (np.abs(shader - exact) <= 64 * 2.0**-24 * sensitivity).all()
