"""Thin films: what each color channel sees of light whose waves took ways of different lengths.

The Fourier transforms of the channels' sensitivities, 1 for equal ways, as Cycles has them: from Blender 5.0 on of the
standard observer's curves, before that of Gaussian curves that Belcour and Barla fitted to them ("A Practical Extension
to Microfacet Theory for the Modeling of Varying Iridescence", SIGGRAPH 2017).
"""

from __future__ import annotations

from functools import cache

import numpy as np

from ..cie_1931 import COLOR_MATCHING, FIRST_NM, RGB_FROM_XYZ, RGB_FROM_XYZ_5, STEP_NM
from .compiler import NodeView

_REACH_NM = 60000 / (2 * np.pi)  # the largest difference of ways
_ENTRIES, _ENTRIES_OF_GAUSSIANS = 512, 4096  # linear in between: Cycles' own steps; so many that none are seen
_THINNEST_NM, _THINNEST_NM_4 = 1.0, 30.0  # films thinner than that fade

# x, y, z and the second bump of x: area, middle and variance over angular frequency
_GAUSSIANS = np.array(
    [
        [5.4856e-13, 1.6810e6, 4.3278e9],
        [4.4201e-13, 1.7953e6, 9.3046e9],
        [5.2481e-13, 2.2084e6, 6.6121e9],
        [1.64408e-8 / np.sqrt(2 * np.pi * 4.5282e9), 2.2399e6, 4.5282e9],
    ]
)
_GAUSSIANS_AREA = 1.0685e-7


def emit_film(node: NodeView) -> None:
    """The film of a node, for the closure that comes next, if it has one."""
    if node.is_default("Thin Film Thickness", 0.0):
        return
    modern = node.compiler.version >= (5, 0)
    table = node.compiler.builder.table(_sensitivity(modern))
    thinnest = node.constant(_THINNEST_NM if modern else _THINNEST_NM_4)
    operands = (node.input("Thin Film Thickness"), node.input("Thin Film IOR"), thinnest, node.constant(_REACH_NM))
    node.emit("film", *operands, immediates=table)


@cache
def _sensitivity(modern: bool) -> np.ndarray:
    """Rows (2 n, 4) by difference of ways: real parts of RGB, then the imaginary parts."""
    ways = np.linspace(0, _REACH_NM, _ENTRIES if modern else _ENTRIES_OF_GAUSSIANS)
    channels = _of_observer(ways) if modern else _of_gaussians(ways)
    rows = np.zeros((len(ways), 2, 4), np.float32)
    rows[:, 0, :3], rows[:, 1, :3] = channels.real, channels.imag
    return rows.reshape(-1, 4)


def _of_observer(ways_nm: np.ndarray) -> np.ndarray:
    """(n, 3) complex; each channel's curve has the area 1."""
    given = FIRST_NM + STEP_NM * np.arange(len(COLOR_MATCHING))
    wavelengths = np.arange(given[0], given[-1], 0.25)
    curves = np.stack([np.interp(wavelengths, given, curve) for curve in COLOR_MATCHING.T], axis=1)
    channels = np.exp(-2j * np.pi * ways_nm[:, None] / wavelengths) @ curves @ RGB_FROM_XYZ_5.T
    return channels / channels[0].real


def _of_gaussians(ways_nm: np.ndarray) -> np.ndarray:
    """(n, 3) complex; the white of equal energy becomes that of the color space."""
    phase = 2 * np.pi * ways_nm[:, None] * 1e-9
    area, middle, variance = _GAUSSIANS.T
    bumps = area * np.sqrt(2 * np.pi * variance) * np.exp(-variance * phase**2 - 1j * middle * phase)
    xyz = bumps[:, :3] / _GAUSSIANS_AREA
    xyz[:, 0] += bumps[:, 3] / _GAUSSIANS_AREA
    white = np.linalg.inv(RGB_FROM_XYZ) @ np.ones(3)
    return (xyz * white) @ RGB_FROM_XYZ.T
