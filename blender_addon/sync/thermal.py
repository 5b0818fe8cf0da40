"""The color and brightness of thermal light, for tables that the core and shaders read. No bpy here."""

from __future__ import annotations

import functools

import numpy as np

from .cie_1931 import COLOR_MATCHING, FIRST_NM, RGB_FROM_XYZ, RGB_FROM_XYZ_5, STEP_NM

LOWEST_K, HIGHEST_K = 300.0, 1e7
"""Temperatures of the first and the last entry of a table. Colder bodies are dark; hotter ones only get brighter."""
_ENTRIES = 400
_C2 = 1.438776877e-2  # h c / k, m K
_WIEN_K = 23979.8  # DISK_WIEN_KELVIN of native/src/scene/disk.h


def blackbody_xyz(kelvin: np.ndarray) -> np.ndarray:
    """(n, 3) CIE 1931 tristimulus values of Planck's radiance at temperatures (n,), up to one factor for all."""
    meters = (FIRST_NM + STEP_NM * np.arange(len(COLOR_MATCHING))) * 1e-9
    exponent = _C2 / (meters * np.asarray(kelvin, float)[:, None])
    # Exponents beyond 700 would overflow; what they stand for is too dark to count in the sum.
    radiance = (6e-7 / meters) ** 5 / np.expm1(np.minimum(exponent, 700))
    return radiance @ COLOR_MATCHING


def blackbody_rgb(kelvin: np.ndarray, version: tuple[int, ...]) -> np.ndarray:
    """(n, 3) scene-linear RGB of luminance 1 at temperatures (n,), in the RGB of Blender `version`. Colors out of
    gamut, those of less than 1900 K, have no blue."""
    return _with_luminance_1(blackbody_xyz(kelvin), _rgb_matrix(version))


def _rgb_matrix(version: tuple[int, ...]) -> np.ndarray:
    return RGB_FROM_XYZ if version < (5, 0) else RGB_FROM_XYZ_5


def _with_luminance_1(xyz: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    rgb = np.maximum(xyz @ matrix.T, 0)
    return rgb / (rgb @ np.linalg.inv(matrix)[1])[:, None]


def luminance(kelvin: float) -> float:
    """Y of `blackbody_xyz`."""
    return float(blackbody_xyz(np.array([kelvin]))[0, 1])


@functools.cache
def _table(version: tuple[int, ...]) -> np.ndarray:
    kelvin = np.geomspace(LOWEST_K, HIGHEST_K, _ENTRIES)
    xyz = blackbody_xyz(kelvin)
    rgb = _with_luminance_1(xyz, _rgb_matrix(version))
    stored = np.log(xyz[:, 1]) + _WIEN_K / kelvin
    return np.column_stack([rgb, stored]).astype(np.float32)


def blackbody_table(version: tuple[int, ...]) -> np.ndarray:
    """(n, 4) float32 over equal steps of ln T: scene-linear RGB of luminance 1, and the luminance as
    native/src/scene/disk.h stores it. Colors out of gamut, those of less than 1900 K, have no blue. `version` is
    Blender's, whose RGB it is."""
    return _table(tuple(version))
