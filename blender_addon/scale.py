"""Masses of nature and lengths of a scene: a black hole of mass m is as large as its gravitational radius, G m / c^2.

No bpy here. Constants: c is exact (SI, 2019); G is that of CODATA 2022, known to 2.2e-5; G times the solar mass is the
nominal one of IAU 2015 Resolution B3. One sun is thus 1476.625 m, and 1.98841e30 kg as exactly as G is known.
"""

from __future__ import annotations

import math

SPEED_OF_LIGHT = 299_792_458.0  # m / s
GRAVITATIONAL_CONSTANT = 6.674_30e-11  # m^3 / (kg s^2)
SOLAR_MASS_PARAMETER = 1.327_124_4e20  # m^3 / s^2

METERS_PER_SUN = SOLAR_MASS_PARAMETER / SPEED_OF_LIGHT**2
KILOGRAMS_PER_SUN = SOLAR_MASS_PARAMETER / GRAVITATIONAL_CONSTANT


def horizon(spin: float) -> float:
    """Radius of the outer horizon, in masses, as the Boyer-Lindquist coordinate r; `spin` is a/M."""
    return 1 + math.sqrt(max(0.0, 1 - spin * spin))


def parse_suns(text: str) -> float:
    """A mass in suns, from a number in kilograms: "2e30", "2e30 kg", or "10 suns". ValueError for anything else."""
    words = text.replace(",", ".").lower().split()
    unit = words.pop() if len(words) == 2 else "kg"
    if len(words) != 1 or unit not in {"kg", "kilograms", "suns", "sun"}:
        raise ValueError(f"a mass in kilograms, as 2e30, not '{text}'")
    value = float(words[0])
    if not (math.isfinite(value) and value >= 0):
        raise ValueError(f"a mass that is finite and not negative, not '{text}'")
    return value / KILOGRAMS_PER_SUN if unit.startswith("k") else value
