"""The header of the accretion disk in OSL: oslc accepts every function as it stands, and Cycles computes what the core
does."""

from pathlib import Path

import numpy as np
import shader_values
from bentlight_native import ProgramBuilder, Scene, disk_drawn_radius, disk_flux, disk_isco

HEADER = Path(__file__).parents[2] / "native" / "src" / "scene" / "disk.h"


def test_every_function_compiles(tmp_path):
    assert shader_values.compiled_functions(tmp_path, HEADER, "DISK_FUNCTION") >= 20


def shade(operation, columns, immediates=()):
    """(n, outputs) of one of the core's operations on columns (n,) of operands."""
    rows = []
    for values in zip(*columns, strict=True):
        builder = ProgramBuilder()
        outputs = builder.emit(operation, *map(builder.constant, values), immediates=immediates)
        builder.emit("emission", builder.constant(1.0), outputs[0], builder.constant(1.0))
        scene = Scene()
        material = scene.add_material(builder.build())
        rows.append(scene.shade(material, position=(0, 0, 0), wo=(0, 0, 1))["emission"][0, 0])
    return np.array(rows)


def core_shift(spin, r, k_r, k_phi):
    """g at infinity, by the core's operation for disks."""
    builder = ProgramBuilder()
    operands = map(builder.constant, (1.0, spin))
    _radius, _azimuth, doppler, gravitational, _order = builder.emit("disk", *operands, immediates=("OBLATE",))
    builder.emit("emission", builder.constant(1.0), doppler, gravitational)
    scene = Scene()
    material = scene.add_material(builder.build())
    wo = (k_r, k_phi, np.sqrt(1 - k_r**2 - k_phi**2))
    return scene.shade(material, position=(disk_drawn_radius(r, spin, False), 0, 0), wo=wo)["emission"][0, 0]


def test_cycles_computes_what_the_core_does(tmp_path):
    """In single precision: flux to 1e-3 from 1.2 times the radius of the last stable orbit on (temperature to a 4th),
    g to 2e-6, the pattern to 1e-3 (its noise is that of Cycles)."""
    rng, count = np.random.default_rng(5), 60
    a = np.float32(rng.uniform(0, 0.998, count)).astype(float)
    inner = np.array([disk_isco(spin) for spin in a])
    r = np.float32(inner * np.exp(rng.uniform(np.log(1.2), np.log(30), count))).astype(float)
    k = rng.normal(size=(count, 3))
    k_r, k_phi, _ = np.float32(k / np.linalg.norm(k, axis=1, keepdims=True)).astype(float).T
    code = """
      float r = in[0], a = in[1], k_r = in[2], k_phi = in[3];
      out = vector(1e4 * disk_flux(r, a), disk_doppler(r, a, k_r, k_phi) * disk_gravitational(r, a, k_phi),
                   2 + disk_pattern(r, a, 3 * k_phi, 0.3 + k_r, 40, 2));
    """
    seen = shader_values.evaluate(tmp_path, ["disk.h"], code, np.stack([r, a, k_r, k_phi], axis=1)).astype(float)
    flux = np.array([disk_flux(x, spin) for x, spin in zip(r, a, strict=True)])
    assert np.abs(seen[:, 0] / (1e4 * flux) - 1).max() < 1e-3
    shift = np.array([core_shift(*row) for row in zip(a, r, k_r, k_phi, strict=True)])
    assert np.abs(seen[:, 1] / shift - 1).max() < 2e-6
    ones = np.ones(count)
    pattern = shade("disk_pattern", (r, 3 * k_phi, a, 0.3 + k_r, 40 * ones, 2 * ones, ones))
    assert np.abs(seen[:, 2] - 2 - pattern).max() < 1e-3
