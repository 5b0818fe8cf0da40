"""Lights that shine by the length of the ray that sees them: as it is drawn, along every bend and through a throat,
whether scattering finds them or a connection."""

import meshes
import numpy as np
import pytest
from bentlight_native import ProgramBuilder, Spacetime
from scenes import add, diffuse, look_at, new_scene, perspective, quad, render
from test_join_lenses import MOUTHS, box
from test_render_curved import placed

GRAY = diffuse((0.7, 0.7, 0.7))


def shines_by_length(scene, power=1.0):
    """A material whose radiance is the length of the ray to this power."""
    builder = ProgramBuilder()
    (length,) = builder.emit("coordinate", immediates=("RAY_LENGTH",))
    (strength,) = builder.emit("math", length, builder.constant(power), builder.constant(0), immediates=("POWER",))
    builder.emit("emission", builder.constant(1), builder.constant(1), strength)
    return scene.add_material(builder.build())


def room_of(spacetime):
    scene = new_scene()
    scene.set_spacetime(spacetime, placed(0, 0, 0))
    add(scene, box(4.0), GRAY)
    ball = scene.add_mesh(*meshes.sphere(0.5, segments=16, rings=8))
    lamp = np.array([shines_by_length(scene)], np.int32)
    scene.add_instance(ball, placed(0.5, 1.8, 0.6), materials=lamp, visibility=14)
    perspective(scene, look_at((0, -3.5, 1.5), (0, 0, 0)), half=0.6)
    return scene


def two_rooms(_):
    scene = new_scene()
    scene.set_spacetime_objects(MOUTHS)
    for _, at, _, _ in MOUTHS:
        add(scene, box(4.0), GRAY, at=at)
    ball = scene.add_mesh(*meshes.sphere(1.0, segments=16, rings=8))
    lamp = np.array([shines_by_length(scene)], np.int32)
    scene.add_instance(ball, placed(20, 2.5, 1), materials=lamp, visibility=14)
    perspective(scene, look_at((0, -3.5, 1.5), (0, 3.9, 0)), half=0.5)
    return scene


@pytest.mark.parametrize(
    ("build", "spacetime"),
    [
        (room_of, Spacetime.schwarzschild(0.4)),
        (room_of, Spacetime.schwarzschild(0.4, "areal")),
        (room_of, Spacetime.ellis(0.8)),
        (two_rooms, None),
    ],
    ids=["isotropic", "areal", "wormhole", "two rooms"],
)
def test_found_or_joined_lights_look_from_the_same_distance(build, spacetime):
    scene = build(spacetime)
    scene.commit()
    means = {}
    for sampling, samples in [("SCATTERING", 256), ("CONNECTIONS", 64), ("BOTH", 64)]:
        settings = {"light_sampling": sampling, "max_bounces": 1, "roulette_start": 9, "names": ("combined",)}
        runs = [render(scene, 8, 8, samples, seed=s, **settings)[0]["combined"][..., 0].mean() for s in range(20)]
        means[sampling] = np.mean(runs, dtype=float), np.var(runs, ddof=1) / len(runs)
    a, va = means["SCATTERING"]
    for sampling in ("CONNECTIONS", "BOTH"):
        b, vb = means[sampling]
        assert abs(a - b) < 4 * np.sqrt(va + vb), (sampling, means)
        assert np.sqrt(va + vb) < 0.04 * a


@pytest.mark.parametrize("mouths", [MOUTHS, None], ids=["throat", "flat"])
def test_a_wall_shows_how_far_it_is(mouths):
    """A wall that shines by the length of the ray, seen by a fisheye, whose depth is a distance: both are equal."""
    scene = new_scene()
    if mouths:
        scene.set_spacetime_objects(mouths)
    wall = np.array([shines_by_length(scene)], np.int32)
    for x in (0, 20):
        scene.add_instance(scene.add_mesh(*box(4.0)), placed(x, 0, 0), materials=wall)
    add(scene, quad(0.5, 0.5), ("transparent", (1, 1, 1)), at=placed(0, 0, -2.5))
    scene.set_camera("FISHEYE_EQUIDISTANT", look_at((0, -3.5, 0.3), (0, 0, 0)), (0, 1, 0, 1), fisheye_fov=1.2)
    scene.commit()
    channels, _ = render(scene, 24, 24, 1, names=("combined", "depth"), max_bounces=0, filter="BOX")
    seen = channels["depth"][..., 0] < 1e9
    assert seen.sum() > 400
    np.testing.assert_allclose(channels["combined"][seen][:, 0], channels["depth"][seen][:, 0], rtol=1e-4)
