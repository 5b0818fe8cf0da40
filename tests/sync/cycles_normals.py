"""What Cycles scatters besides its BSDFs where a normal map turns the normal, by quadrature. Bentlight leaves it out.

Cycles 4.5 draws a reflection from the visible normals around the turned normal and drops it if it ends below the
geometric surface, but not if it ends below the turned normal, where its BSDF is zero: there it still weighs it with the
masking of the mirrored cosine. Cycles 5.0 drops both.

Cycles 5.0 draws from a diffuse lobe whose normal points into the surface, though it is zero there, and takes the lobes
above it in the direction drawn. What it draws from those does not have the diffuse lobe's density in its weight, so
that their light counts twice in part. Cycles 4.5 has that density in the weight.

Source: intern/cycles/kernel/closure, bsdf_microfacet_sample in bsdf_microfacet.h, and bump_shadowing_term in bsdf.h.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from cycles_scattering import VIEW, sky

from tests.native.microfacet_oracle import layer_energy, smith_lambda

STEPS = 400  # of each variable of an integral
LOWEST_MIRROR = 0.01  # cosine that Cycles raises mirror rays to


class Lobe(NamedTuple):
    """Of GGX without compensation; the reflectance (..., 3) is a function of wo.h."""

    roughness: float
    reflectance: Callable[[np.ndarray], np.ndarray]


def raised(normal, geometric):
    """Cycles' normal for reflections: turned towards the geometric one just so far that the mirror ray gets out."""
    sideways = normal - geometric * (normal @ geometric)
    sideways /= np.linalg.norm(sideways)

    def turned(angle):
        return np.cos(angle) * geometric + np.sin(angle) * sideways

    def gets_out(angle):
        mirror = 2 * (turned(angle) @ VIEW) * turned(angle) - VIEW
        return mirror @ geometric >= min(0.9 * (geometric @ VIEW), LOWEST_MIRROR)

    inside, outside = np.arctan2(normal @ sideways, normal @ geometric), 0.0
    if gets_out(inside):
        return normal
    for _ in range(50):
        middle = (inside + outside) / 2
        inside, outside = (inside, middle) if gets_out(middle) else (middle, outside)
    return turned(outside)


def around(normal, cosine):
    """Unit vectors (STEPS, STEPS, 3) at cosines (STEPS,) to the normal, all around it by equal steps."""
    x = np.cross(normal, VIEW if abs(normal[2]) < 0.9 else [1, 0, 0])
    x /= np.linalg.norm(x)
    turn = (np.arange(STEPS) + 0.5) / STEPS * 2 * np.pi
    circle = np.cos(turn)[:, None] * x + np.sin(turn)[:, None] * np.cross(normal, x)
    return cosine[:, None, None] * normal + np.sqrt(1 - cosine**2)[:, None, None] * circle


def below_normal(lobe: Lobe, normal, geometric) -> np.ndarray:
    """Light (3,) that Cycles 4.5 reflects from below the normal."""
    alpha, mu = lobe.roughness**2, normal @ VIEW
    if mu <= 0:
        return np.zeros(3)
    t = (np.arange(STEPS) + 0.5) / STEPS  # facets by equal steps of t, of which there are D(h) n.h dh
    u, step = t**2 * (3 - 2 * t), 6 * t * (1 - t) / STEPS**2
    cos_h = np.sqrt((1 - u) / (1 + (alpha**2 - 1) * u))
    facets = around(normal, cos_h)
    cos_i = facets @ VIEW
    wi = 2 * cos_i[..., None] * facets - VIEW
    cos_o = wi @ normal
    masking = 1 + smith_lambda(mu, alpha) + smith_lambda(np.abs(cos_o), alpha)
    kept = (cos_i > 0) & (cos_o < 0) & (wi @ geometric > 0)
    weight = np.where(kept, (step / cos_h)[:, None] * cos_i / (mu * masking), 0)
    return np.einsum("ij,ijk->k", weight, lobe.reflectance(np.maximum(cos_i, 1e-9)) * sky(wi))


def counted_twice(lobe: Lobe, ior, normal, color, diffuse_normal, geometric) -> np.ndarray:
    """Light (3,) of a layer of glass, of this lobe and IOR, that Cycles 5.0 adds when it draws from the diffuse lobe of
    this color below it."""
    alpha, mu = lobe.roughness**2, normal @ VIEW
    if mu <= 0:
        return np.zeros(3)
    _, taken = layer_energy(lobe.roughness, mu, ior)
    shares = np.array([taken, (1 - taken) * np.mean(color)])
    layer_share, diffuse_share = shares / shares.sum()
    cosine = np.sqrt(1 - (np.arange(STEPS) + 0.5) / STEPS)  # of equal chances for the diffuse lobe
    wi = around(diffuse_normal, cosine)
    half = wi + VIEW
    half /= np.linalg.norm(half, axis=-1, keepdims=True)
    cos_o, masking = wi @ normal, 1 + smith_lambda(mu, alpha)
    visible = alpha**2 / np.pi / (1 + (alpha**2 - 1) * (half @ normal) ** 2) ** 2 / (4 * mu)  # D / (4 n.wo)
    lit = (cos_o > 0) & (wi @ geometric > 0)
    value = np.where(lit, visible / (masking + smith_lambda(np.where(lit, cos_o, 1), alpha)), 0)
    density = layer_share * visible / masking + diffuse_share * cosine[:, None] / np.pi
    light = lobe.reflectance(half @ VIEW) * sky(wi)
    return np.einsum("ij,ijk->k", diffuse_share * value / density, light) / STEPS**2
