"""Light that asks by what kind of lobe it is looked at: the three ways to find it agree with the sum over the lobes,
each under the light that it sees."""

import numpy as np
import pytest
from bentlight_native import ProgramBuilder
from scenes import add, diffuse, glossy, look_at, material, new_scene, perspective, quad, render
from test_render_curved import placed

DIFFUSE_COLOR, GLOSSY_COLOR = (0.4, 0.2, 0.1), (0.3, 0.5, 0.6)
DIM, BRIGHT = 1.0, 6.0  # as diffuse and as glossy rays see the light
LOBES = {"diffuse": diffuse(DIFFUSE_COLOR), "glossy": glossy(GLOSSY_COLOR, 0.55)}


def asking_light():
    """Emits DIM, but BRIGHT to glossy rays."""
    builder = ProgramBuilder()
    (is_glossy,) = builder.emit("light_path", immediates=("IS_GLOSSY",))
    color = builder.emit("mix", is_glossy, builder.constant(DIM), builder.constant(BRIGHT))[0]
    builder.emit("emission", builder.constant(1), color, builder.constant(1))
    return builder.build()


def mean_radiance(kind, program, lobes, sampling, samples):
    """Mean color of a patch under a light and its standard error, from 64 pixels of one place."""
    scene = new_scene()
    if kind == "sky":
        scene.set_world(program)
        screen = quad(3, 3)  # hides half of the sky, so that it is worth drawing
        add(scene, screen, diffuse((0, 0, 0)), at=placed(2.9, 0, 0.8), visibility=14)
    else:
        index = scene.add_material(program)
        matrix = placed(0.3, 0.2, 0.9) @ np.diag([1, -1, -1, 1])
        scene.add_instance(
            scene.add_mesh(*quad(0.5, 0.4)), matrix, materials=np.array([index], np.int32), visibility=14
        )
    add(scene, quad(1e-4, 1e-4), *lobes)
    perspective(scene, look_at((-0.8e-4, 0, 1e-4), (0, 0, 0)), half=1e-6)
    scene.commit()
    settings = {"max_bounces": 1, "light_threshold": 0, "light_sampling": sampling}
    image = render(scene, 8, 8, samples, names=("combined",), **settings)[0]["combined"][..., :3].reshape(-1, 3)
    return image.mean(axis=0), image.std(axis=0, ddof=1) / 8


@pytest.mark.parametrize("sampling", ["SCATTERING", "CONNECTIONS", "BOTH"])
@pytest.mark.parametrize("kind", ["quad", "sky"])
def test_each_lobe_sees_its_own_light(kind, sampling):
    parts = [
        mean_radiance(kind, material(("emission", light, 1.0)), [lobe], "BOTH", 512)
        for lobe, light in zip(LOBES.values(), (DIM, BRIGHT), strict=True)
    ]
    exact, variance = sum(mean for mean, _ in parts), sum(error**2 for _, error in parts)
    mean, error = mean_radiance(kind, asking_light(), LOBES.values(), sampling, 1024)
    assert (error < 0.02 * exact).all()
    assert (np.abs(mean - exact) < 4 * np.sqrt(variance + error**2)).all(), (mean, exact, error)
