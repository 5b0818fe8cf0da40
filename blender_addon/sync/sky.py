"""A clear sky as an image: sunlight scattered once by air and haze, absorbed by ozone.

After Nishita et al., "Display of the Earth Taking into Account Atmospheric Scattering" (SIGGRAPH 1993), with the
atmosphere of Blender's Sky Texture of the single-scattering kind, for 21 wavelengths, and with its quadrature. Cycles
looks its table of the same radiance up half a texel beside the place that it was made for, which moves light by 2 % on
average, and by up to 8 % at the horizon at sunset; here it is not moved. No bpy here. Lengths in meters.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .cie_1931 import RGB_FROM_XYZ

_EARTH_RADIUS = 6360e3
_ATMOSPHERE_RADIUS = 6420e3
_AIR_HEIGHT, _HAZE_HEIGHT = 8e3, 1.2e3  # over which the density falls by a factor of e
_HAZE_SCATTERING = 2e-5  # per meter at the ground
_HAZE_EXTINCTION = 1.11 * _HAZE_SCATTERING
_HAZE_ANISOTROPY = 0.76
_WAVELENGTHS = np.linspace(380e-9, 780e-9, 21)
# Absorption by ozone per meter where it is densest (Chappuis band), 1e-9.
_OZONE = 1e-9 * np.array(
    [3, 6, 20, 73, 201, 404, 636, 967, 1548, 2090, 2461, 2736, 2151, 1591, 1124, 735, 465, 331, 225, 149, 168]
)
_STEPS = 32  # along a line of sight
# Along a ray of sunlight, whose densities fall about exponentially: Gauss-Laguerre up to x = 25, as in Blender.
_NODES, _WEIGHTS = np.polynomial.laguerre.laggauss(8)
_NODES, _WEIGHTS = _NODES / 25, _WEIGHTS * np.exp(_NODES) / 25
# CIE 1931 standard observer at these wavelengths (CIE 15:2004, table T.4).
_OBSERVER = np.array(
    [
        (0.001368, 0.000039, 0.00645), (0.01431, 0.000396, 0.06785), (0.13438, 0.004, 0.6456),
        (0.34828, 0.023, 1.74706), (0.2908, 0.06, 1.6692), (0.09564, 0.13902, 0.81295), (0.0049, 0.323, 0.272),
        (0.06327, 0.71, 0.07825), (0.2904, 0.954, 0.0203), (0.5945, 0.995, 0.0039), (0.9163, 0.87, 0.00165),
        (1.0622, 0.631, 0.0008), (0.85445, 0.381, 0.00019), (0.4479, 0.175, 0.00002), (0.1649, 0.061, 0),
        (0.04677, 0.017, 0), (0.011359, 0.004102, 0), (0.002899, 0.001047, 0), (0.00069, 0.000249, 0),
        (0.000166, 0.00006, 0), (0.000042, 0.000015, 0),
    ]
)  # fmt: skip


@dataclass(frozen=True)
class Atmosphere:
    """Where the sun and the observer are, and how much of each substance there is beside the earth's own 1."""

    sun_elevation: float  # radians
    altitude: float = 0.0
    air: float = 1.0
    haze: float = 1.0
    ozone: float = 1.0


def _air_scattering() -> np.ndarray:
    """Rayleigh's coefficient per meter at the ground, from the refractive index and the number density of air."""
    index, number = 1.0002926, 2.504e25
    return 8 * np.pi**3 * (index**2 - 1) ** 2 / (3 * number * _WAVELENGTHS**4)


def _sunlight() -> np.ndarray:
    """Irradiance above the atmosphere, W/m^2 per nanometer: a black body of 5778 K."""
    planck, light, boltzmann, sun_over_distance = 6.62607015e-34, 2.99792458e8, 1.380649e-23, 6.955e8 / 1.496e11
    exponent = planck * light / (_WAVELENGTHS * boltzmann * 5778)
    radiance = 2 * planck * light**2 / _WAVELENGTHS**5 / np.expm1(exponent)
    return 1e-9 * np.pi * sun_over_distance**2 * radiance


def _rgb(spectrum: np.ndarray) -> np.ndarray:
    """Linear Rec. 709 from (..., 21) per nanometer."""
    return spectrum @ (_OBSERVER * 20) @ RGB_FROM_XYZ.T


def _densities(height: np.ndarray) -> np.ndarray:
    """Of air, haze and ozone (..., 3), relative to where each is densest."""
    ozone = np.clip(1 - np.abs(height - 25e3) / 15e3, 0, 1)
    return np.stack([np.exp(-height / _AIR_HEIGHT), np.exp(-height / _HAZE_HEIGHT), ozone], axis=-1)


def _way_out(position: np.ndarray, direction: np.ndarray) -> np.ndarray:
    """Distance (...,) to the top of the atmosphere."""
    b = (position * direction).sum(axis=-1)
    return -b + np.sqrt(b**2 - (position**2).sum(axis=-1) + _ATMOSPHERE_RADIUS**2)


def _column(position: np.ndarray, direction: np.ndarray) -> np.ndarray:
    """Density integrated to the top of the atmosphere (..., 3)."""
    way = _way_out(position, direction)[..., None]
    places = position[..., None, :] + (way * _NODES)[..., None] * direction[..., None, :]
    height = np.linalg.norm(places, axis=-1) - _EARTH_RADIUS
    return np.einsum("...nk,n->...k", _densities(height), _WEIGHTS) * way


def _extinction(columns: np.ndarray) -> np.ndarray:
    """Optical depth (..., 21) of columns (..., 3)."""
    return columns @ np.stack([_air_scattering(), np.full(21, _HAZE_EXTINCTION), _OZONE])


def sky_radiance(atmosphere: Atmosphere, elevation: np.ndarray, azimuth: np.ndarray) -> np.ndarray:
    """Radiance (..., 3) of the sky at angles (...,); azimuth from the sun's. Directions are above the horizon."""
    amounts = np.array([atmosphere.air, atmosphere.haze, atmosphere.ozone])
    sun = np.array([np.cos(atmosphere.sun_elevation), 0.0, np.sin(atmosphere.sun_elevation)])
    planar = np.cos(elevation)
    view = np.stack([planar * np.cos(azimuth), planar * np.sin(azimuth), np.sin(elevation)], axis=-1)
    start = np.array([0.0, 0.0, _EARTH_RADIUS + max(atmosphere.altitude, 1.0)])
    step = _way_out(np.broadcast_to(start, view.shape), view) / _STEPS
    mu = view @ sun
    g = _HAZE_ANISOTROPY
    air_phase = 3 / (16 * np.pi) * (1 + mu**2)
    haze_phase = 3 * (1 - g**2) * (1 + mu**2) / (8 * np.pi * (2 + g**2) * (1 + g**2 - 2 * g * mu) ** 1.5)
    behind = np.zeros((*view.shape[:-1], 3))
    spectrum = np.zeros((*view.shape[:-1], 21))
    for i in range(_STEPS):
        place = start + ((i + 0.5) * step)[..., None] * view
        density = _densities(np.linalg.norm(place, axis=-1) - _EARTH_RADIUS) * amounts
        behind += density * step[..., None]
        depth = _extinction(behind + _column(place, np.broadcast_to(sun, place.shape)) * amounts)
        scattering = (density[..., 0] * air_phase)[..., None] * _air_scattering()
        scattering = scattering + (density[..., 1] * haze_phase * _HAZE_SCATTERING)[..., None]
        lit = ~_meets_earth(place, sun)
        spectrum += np.where(lit[..., None], scattering * np.exp(-depth), 0.0) * step[..., None]
    return _rgb(spectrum * _sunlight())


def _meets_earth(position: np.ndarray, direction: np.ndarray) -> np.ndarray:
    b = position @ direction
    return (b < 0) & (b**2 >= (position**2).sum(axis=-1) - _EARTH_RADIUS**2)


def sun_radiance(atmosphere: Atmosphere, angular_diameter: float) -> np.ndarray:
    """Radiance (3,) of the middle of the sun's disk; 0 below the horizon. Through air and haze only, as in Blender."""
    if atmosphere.sun_elevation <= 0:
        return np.zeros(3)
    amounts = np.array([atmosphere.air, atmosphere.haze, 0.0])
    sun = np.array([np.cos(atmosphere.sun_elevation), 0.0, np.sin(atmosphere.sun_elevation)])
    start = np.array([0.0, 0.0, _EARTH_RADIUS + max(atmosphere.altitude, 1.0)])
    spectrum = _sunlight() * np.exp(-_extinction(_column(start, sun) * amounts))
    return _rgb(spectrum) / (2 * np.pi * (1 - np.cos(angular_diameter / 2)))


def sky_image(atmosphere: Atmosphere, sun_azimuth: float, width: int = 512, height: int = 512) -> np.ndarray:
    """(height, width, 4) float32: an equirectangular image, +z up, +x in the middle, seen from within.

    Within 1 % of sky_radiance above the horizon; below it the ground's haze fades to black over 24 degrees, as in
    Blender.
    """
    rows = (np.arange(height) + 0.5) / height * np.pi - np.pi / 2
    turn = np.pi - (np.arange(width) + 0.5) / width * 2 * np.pi - sun_azimuth
    elevations = np.linspace(0, 1, 96) ** 2 * np.pi / 2
    azimuths = np.linspace(0, 1, 64) ** 1.5 * np.pi  # denser towards the sun
    table = sky_radiance(atmosphere, *np.meshgrid(elevations, azimuths, indexing="ij"))
    folded = np.abs((turn + np.pi) % (2 * np.pi) - np.pi)
    by_turn = np.stack([[np.interp(folded, azimuths, row[:, k]) for k in range(3)] for row in table])
    above = np.clip(rows, 0, None)
    sky = np.stack(
        [[np.interp(above, elevations, by_turn[:, k, j]) for j in range(width)] for k in range(3)]
    ).transpose(2, 1, 0)
    fade = np.clip(1 + 2.5 * np.sin(np.minimum(rows, 0)), 0, 1) ** 3
    image = np.ones((height, width, 4), np.float32)
    image[..., :3] = np.maximum(sky, 0) * fade[:, None, None]
    return image
