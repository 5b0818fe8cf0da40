"""Wormholes' mouths as light portals: what is drawn leaves the mean of pictures as it is, and lowers their noise."""

import meshes
import numpy as np
import pytest
from bentlight_native import Spacetime
from scenes import add, diffuse, emission, glass, glossy, look_at, material, new_scene, perspective, render
from test_join_lenses import MOUTHS, box
from test_render_curved import placed
from test_render_light import z_score

WHITE = diffuse((0.8, 0.8, 0.8))


def rooms(closures, *lit):
    """Two closed rooms that only a wormhole joins, the camera in the one, glowing walls in the other."""
    scene = new_scene()
    scene.set_spacetime_objects(MOUTHS)
    add(scene, box(4.0), *closures, at=MOUTHS[0][1])
    add(scene, box(4.0), *closures, *lit, at=MOUTHS[1][1])
    perspective(scene, look_at((0, -3.5, 1.5), (0, 3.9, 0)), half=0.5)
    return scene


def glowing_room(closures):
    return rooms(closures, emission((0.5, 0.5, 0.5)))


def lamp_room(closures):
    scene = rooms(closures)
    add(scene, meshes.sphere(1.0, segments=16, rings=8), emission((10,) * 3), at=placed(20, 2.5, 1), visibility=14)
    return scene


def open_mouth(closures):
    """A room around a lone wormhole, whose far side is nothing but an uneven sky; a ball on the near side glows."""
    scene = new_scene()
    scene.set_spacetime(Spacetime.ellis(0.5))
    add(scene, box(4.0), *closures)
    add(scene, meshes.sphere(0.4, segments=16, rings=8), emission((3,) * 3), at=placed(2, 1, -2), visibility=14)
    scene.set_world(material(emission((1, 1, 1))))
    scene.set_suns([(0.3, -0.5, 1)], [(20, 18, 15)], 0.3)
    perspective(scene, look_at((0, -3.5, 1.5), (0, 3.9, 0)), half=0.5)
    return scene


SCENES = {"glowing": glowing_room, "lamp": lamp_room, "sky": open_mouth}
SURFACES = {
    "diffuse": [WHITE],
    "metal": [glossy((0.9, 0.9, 0.9), 0.7)],
    "glazed": [diffuse((0.4, 0.4, 0.4)), glossy((0.4, 0.4, 0.4), 0.0)],
    "glass": [diffuse((0.4, 0.4, 0.4)), glass((0.4, 0.4, 0.4), 0.8, 1.3)],
}


def runs_of(scene, samples, seeds, **settings):
    settings = {"max_bounces": 2, "roulette_start": 9, "names": ("combined",)} | settings
    return np.array([render(scene, 8, 8, samples, seed=s, **settings)[0]["combined"][..., 0] for s in range(seeds)])


@pytest.mark.parametrize("surface", SURFACES)
@pytest.mark.parametrize("name", SCENES)
def test_portals_leave_the_mean(name, surface):
    """With and without portals, with and without connections: one mean, by Z-tests over independent seeds."""
    scene = SCENES[name](SURFACES[surface])
    scene.commit()
    means = {}
    for sampling, portal, samples in [("SCATTERING", False, 256), ("SCATTERING", True, 128), ("BOTH", True, 32)]:
        runs = runs_of(scene, samples, 16, light_sampling=sampling, portal_sampling=portal)
        runs = runs.mean(axis=(1, 2), dtype=float)
        means[sampling, portal] = runs.mean(), runs.var(ddof=1) / len(runs)
    a, va = means["SCATTERING", False]
    for key, (b, vb) in means.items():
        assert abs(a - b) <= 4 * np.sqrt(va + vb), (key, means)


@pytest.mark.parametrize("light_sampling", ["SCATTERING", "BOTH"])
def test_furnace(light_sampling):
    """White walls and a sky of 1 on both sides: every pixel is 1."""
    scene = new_scene((1, 1, 1))
    scene.set_spacetime(Spacetime.ellis(0.5))
    add(scene, meshes.box((-4, -4, -3), (4, 4, -2.5)), diffuse((1, 1, 1)))
    add(scene, meshes.box((-4, 2, -3), (4, 2.5, 3)), diffuse((1, 1, 1)))
    perspective(scene, look_at((0, -5, 1), (0, 0, -1)), half=0.5)
    scene.commit()
    settings = {"max_bounces": 200, "diffuse_bounces": 200, "roulette_start": 200, "names": ("combined",)}
    values = render(scene, 24, 24, 32, light_sampling=light_sampling, **settings)[0]["combined"][..., 0]
    assert values.std() > 0
    assert abs(z_score(values, 1)) < 4
