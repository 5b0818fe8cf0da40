"""Sheen against a layer of fibers that is simulated here: textbook formulas, shared with no line of the core or of the
program that makes its table."""

import numpy as np
import pytest
from bsdf_tools import SCENE, direction, material, sheen

SAMPLES = 200_000
TABLE_SAMPLES, TABLE_REFLECTED = 3_000_000, 700_000  # of tools/fit_sheen.c: whichever comes first
NODES = 31  # steps of the table


def projected_area(w, across):
    """Of SGGX fibers along z: Heitz et al., "The SGGX Microflake Distribution" (2015)."""
    return np.sqrt(w[:, 0] ** 2 + w[:, 1] ** 2 + (across * w[:, 2]) ** 2)


def mirrored(w, across, rng):
    """Directions (n, 3) after a flake that is seen from w: a normal of the ellipsoid with half axes (1, 1, 1 / across),
    the convex body that has these projected areas, where a random ray along w meets it."""
    semi = np.array((1, 1, 1 / across))
    flat = rng.normal(size=w.shape)
    flat -= w * np.einsum("ni,ni->n", flat, w)[:, None]  # not parallel to w
    # In the space where the ellipsoid is a sphere, rays are parallel still: a uniform point of the disk that they fill.
    ray = w / semi
    ray /= np.linalg.norm(ray, axis=1)[:, None]
    side = flat / semi
    side -= ray * np.einsum("ni,ni->n", side, ray)[:, None]
    side /= np.linalg.norm(side, axis=1)[:, None]
    other = np.cross(ray, side)
    radius, turn = np.sqrt(rng.random(len(w)))[:, None], rng.random(len(w))[:, None] * 2 * np.pi
    point = radius * (np.cos(turn) * side + np.sin(turn) * other) + np.sqrt(1 - radius**2) * ray
    normal = point / semi  # of the ellipsoid at semi * point
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    return 2 * np.einsum("ni,ni->n", normal, w)[:, None] * normal - w


def reflected_part(roughness, mu, rng):
    """Of light that falls on the layer: flags (SAMPLES,). Nothing hinders it after the 16th bounce."""
    across = roughness**2
    going = np.tile(-direction(mu), (SAMPLES, 1))
    depth, alive, result = np.zeros(SAMPLES), np.arange(SAMPLES), np.zeros(SAMPLES, bool)
    for _ in range(16):
        way = rng.exponential(size=len(alive)) / projected_area(going, across)
        depth = depth - way * going[:, 2]
        result[alive[depth < 0]] = True
        inside = (depth >= 0) & (depth <= 1)
        alive, depth = alive[inside], depth[inside]
        going = mirrored(-going[inside], across, rng)
    result[alive[going[:, 2] > 0]] = True
    return result


@pytest.mark.parametrize("row, column", [(31, 31), (31, 1), (20, 6), (15, 15), (12, 3), (8, 10), (5, 2)])
def test_albedo_is_that_of_a_layer_of_fibers(row, column):
    """At entries of the table, each with its own statistical error."""
    roughness, mu = row / NODES, column / NODES
    (albedo,) = SCENE.shade(material(sheen(roughness=roughness)), wo=direction(mu))["albedo"][:, 0]
    part = reflected_part(roughness, mu, np.random.default_rng([row, column])).mean()
    variance = part * (1 - part)
    table = variance / min(TABLE_SAMPLES, TABLE_REFLECTED / part)
    assert abs(albedo - part) < 4.5 * np.sqrt(variance / SAMPLES + table)
