"""Rays that leave all geometry behind go to infinity by table or endpoint route: nothing may change by that."""

import bentlight_native as native
import numpy as np
import pytest

SPACETIMES = {
    "isotropic": native.Spacetime.schwarzschild(1.0),
    "areal": native.Spacetime.schwarzschild(1.0, "areal"),
    "kerr": native.Spacetime.kerr(1.0, 0.9),
    "ellis": native.Spacetime.ellis(1.0),
}


def random_rays(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Origins 3 to 40 from the center, directions to every side, a little more of them inward."""
    random = np.random.default_rng(5)
    origins = random.normal(size=(count, 3))
    origins *= random.uniform(3, 40, (count, 1)) / np.linalg.norm(origins, axis=1, keepdims=True)
    directions = random.normal(size=(count, 3)) - origins / 10
    return origins, directions / np.linalg.norm(directions, axis=1, keepdims=True)


def speck_scene(spacetime: native.Spacetime, position: tuple[float, float, float]) -> native.Scene:
    """One tiny triangle at `position`, so small that no ray of these tests meets it."""
    scene = native.Scene()
    vertices = np.array([[0, 0, 0], [1e-4, 0, 0], [0, 1e-4, 0]], np.float32) + np.float32(position)
    scene.add_instance(scene.add_mesh(vertices, np.array([[0, 1, 2]], np.uint32)), np.eye(4))
    scene.set_spacetime(spacetime, np.eye(4))
    scene.commit()
    return scene


@pytest.mark.parametrize("name", SPACETIMES)
@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-10])
@pytest.mark.parametrize("position", [(2.5, 0, 0), (30, 0, 0)])
def test_escape_directions_do_not_depend_on_the_way(name, tolerance, position):
    """At 1e-4 and 1e-6 the table answers (Kerr: the endpoint route), at 1e-10 always the endpoint route; where the
    geometry lies decides where a ray jumps. The reference marches Taylor arcs to the end."""
    origins, directions = random_rays(4000)
    hits = speck_scene(SPACETIMES[name], position).intersect(
        origins, directions, tolerance=1e-4, angular_tolerance=tolerance
    )
    exact = native.trace_rays(SPACETIMES[name], origins, directions, 1e-12, route="taylor")
    np.testing.assert_array_equal(hits["fate"], exact["fate"])
    escaped = np.isin(exact["fate"], (1, 3))
    assert escaped.sum() > 2000
    asymptote = np.where((exact["fate"] == 3)[:, None], exact["direction"] * [1, -1, 1], exact["direction"])
    difference = np.linalg.norm(hits["direction"] - asymptote, axis=1)[escaped]
    assert np.all(difference <= tolerance + 2 * hits["error"][escaped])
    assert np.quantile(difference, 0.95) <= tolerance


def test_jumps_do_not_depend_on_the_batch():
    origins, directions = random_rays(600)
    scene = speck_scene(SPACETIMES["kerr"], (30, 0, 0))
    together = scene.intersect(origins, directions, angular_tolerance=1e-6)
    order = np.random.default_rng(1).permutation(600)
    shuffled = scene.intersect(origins[order], directions[order], angular_tolerance=1e-6)
    for key, value in together.items():
        np.testing.assert_array_equal(value[order], shuffled[key])
