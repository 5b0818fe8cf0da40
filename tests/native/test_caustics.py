"""Light beside caustics: a lamp in line with a hole becomes a ring, whose magnification goes like 1 / distance from the
line. Lamps of any size have samples that are bounded all the same, the others as far as clamping bounds them."""

import numpy as np
import pytest
from bentlight_native import Spacetime, connect
from scenes import add, diffuse, emission, look_at, material, new_scene, perspective, quad, render
from test_render_curved import placed

MASS, HEIGHT, LAMP, HALF = 0.02, 0.5, 1.0, 0.3  # the hole's height above the floor, the lamp's, and half its width
SPACETIMES = {"still": Spacetime.schwarzschild(MASS), "spinning": Spacetime.kerr(MASS, 0.9 * MASS)}
IMAGES = 4  # of one lamp, at most


def floor_below(spacetime, half_view):
    """A white floor, seen straight from above around the line through the hole; the camera hangs below the hole."""
    scene = new_scene()
    scene.set_spacetime(spacetime, placed(0, 0, HEIGHT))
    add(scene, quad(1, 1), diffuse((1, 1, 1)))
    perspective(scene, look_at((0.1, 0, 0.1), (0, 0, 0), up=(0, 1, 0)), half=half_view)
    return scene


def pictures(scene, seeds, **settings):
    """Direct light alone, one sample a pixel: (seeds, 64, 64)."""
    settings = {"max_bounces": 0, "light_threshold": 0, "tolerance": 1e-4, "names": ("combined",)} | settings
    runs = [render(scene, 64, 64, 1, seed=s, **settings)[0]["combined"][..., 0] for s in range(seeds)]
    return np.array(runs, float)


def quadrature():
    """What a white floor at the foot of the line sends back of an even square lamp of radiance 1: the integral of
    cos cos / (pi spread) over its area, in polar coordinates, in which the caustic is regular."""
    x, weight = np.polynomial.legendre.leggauss(24)
    turn, turn_weight = (x + 1) * np.pi / 8, weight * np.pi / 8
    edge = HALF / np.cos(turn)[:, None]
    radius, radius_weight = (x + 1) / 2 * edge, weight / 2 * edge
    at = np.stack([radius.ravel(), 0 * radius.ravel(), np.full(radius.size, LAMP - HEIGHT)], axis=1)
    images = connect(SPACETIMES["still"], np.tile([0, 0, -HEIGHT], (len(at), 1)), at, IMAGES, 1e-10)
    cosines = np.maximum(images["launch"][..., 2], 0) * np.abs(images["arrival"][..., 2])
    local = (1 + MASS / (2 * np.linalg.norm(at, axis=1))) ** 4  # areas of the isotropic chart
    light = (np.nansum(cosines / images["spread"], axis=1) * local).reshape(radius.shape) / np.pi
    return 8 * np.sum(turn_weight * np.sum(radius_weight * radius * light, axis=1))


@pytest.mark.parametrize("spacetime", SPACETIMES)
def test_lamps_of_any_size_make_no_fireflies(spacetime):
    """Radiance 1 of a lamp whose middle is in line. The weights bound each connection by half of what scattering could
    have brought, so no sample is brighter than 1 + IMAGES / 2; connections alone, which have no variance here that is
    finite, pass that bound. The mean is the quadrature's, and without bounds for chance the same (Z-tests)."""
    scene = floor_below(SPACETIMES[spacetime], 1e-3)
    lamp = np.diag([HALF, -HALF, -HALF, 1.0])
    lamp[2, 3] = LAMP
    add(scene, quad(), emission((1, 1, 1)), at=lamp)
    scene.commit()
    both = pictures(scene, 4)
    assert both.max() <= 1 + IMAGES / 2
    assert pictures(scene, 4, light_sampling="CONNECTIONS").max() > 1 + IMAGES / 2
    chance = pictures(scene, 8, light_sampling="SCATTERING")
    error = np.sqrt(both.var(ddof=1) / both.size + chance.var(ddof=1) / chance.size)
    assert abs(both.mean() - chance.mean()) < 4 * error
    assert both.var() < 0.5 * chance.var()
    if spacetime == "still":
        assert abs(both.mean() - quadrature()) < 4 * np.sqrt(both.var(ddof=1) / both.size)


@pytest.mark.parametrize("spacetime", SPACETIMES)
def test_clamping_bounds_lamps_without_size(spacetime):
    """Only connections find them, so nothing but a clamp bounds a lamp in line: each of its images by `clamp_direct`.
    Where the floor is too dim for the clamp, the picture stays as it is."""
    scene = floor_below(SPACETIMES[spacetime], 0.1)
    scene.set_lamps([placed(0, 0, LAMP)], scene.add_material(material(emission((1, 1, 1)))))
    scene.commit()
    clamp = 20.0
    free, clamped = pictures(scene, 1), pictures(scene, 1, clamp_direct=clamp)
    assert np.isfinite(free).all()
    assert free.max() > IMAGES * clamp
    assert clamped.max() <= IMAGES * clamp * (1 + 1e-6)
    dim = free < clamp
    assert 0.2 < dim.mean() < 1
    assert clamped[dim] == pytest.approx(free[dim], rel=1e-6)
