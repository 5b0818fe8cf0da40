"""A room around a hole by the engine, by the lens, and by the relay camera with the lens: the same picture, by Z-tests.

What scatters in the room crosses the sphere again and again; the camera stands outside of it, inside, or close to the
horizon. Colors are dark: of what comes by way of a lens Cycles misses the last bounce, 0.3 % of the light among white
walls.
"""

import agreement
import bpy
import objects
import pytest
from image_statistics import compare

SEEDS, SAMPLES = 5, 9


def room(name: str, place: str, size: tuple[int, int]) -> bpy.types.Scene:
    """Two walls and a box on a floor, lit by a shining plate and the sky, all outside of the sphere; the same at the
    wormhole's other end."""
    scene = agreement.new_scene(*size)
    agreement.box_samples(scene)
    objects.set_world((0.3, 0.4, 0.6))
    scene.cycles.sample_clamp_indirect = scene.cycles.blur_glossy = 0
    scene.cycles.use_light_tree = False
    scene.bentlight.max_bounces = scene.cycles.max_bounces = scene.cycles.diffuse_bounces = 4
    white = agreement.only_shader("White", "ShaderNodeBsdfDiffuse", (0.4, 0.4, 0.4))
    red = agreement.only_shader("Red", "ShaderNodeBsdfDiffuse", (0.4, 0.1, 0.05))
    shining = agreement.only_shader("Shining", "ShaderNodeEmission", (6, 5, 4))
    holes = agreement.add_hole(name, exit_at=60.0)
    for hole in holes:
        things = [
            objects.quad("Floor", (-5, -6, -3), (10, 0, 0), (0, 10, 0), white),
            objects.quad("Back", (-5, 4, -3), (10, 0, 0), (0, 0, 6), red),
            objects.quad("Side", (-4, -6, -3), (0, 10, 0), (0, 0, 6), white),
            objects.quad("Plate", (3, -1.5, -1.5), (0, 0, 3), (0, 3, 0), shining),
            objects.box("Box", (1.8, -2.4, -2.4), (1, 1, 1.2), red),
        ]
        for thing in things:
            thing.matrix_world = hole.matrix_world @ thing.matrix_world
    agreement.add_camera(name, agreement.PLACES[place], holes[0])
    return scene


def check(name: str, place: str, way: str, size: tuple[int, int] = (30, 18)) -> None:
    scene = room(name, place, size)
    comparison = compare(*(agreement.pictures(scene, one, SEEDS, SAMPLES) for one in (way, "engine")))
    assert comparison.precision < 0.03
    assert not comparison.differs(), str(comparison)


@pytest.mark.parametrize(("name", "place"), agreement.CASES)
def test_by_the_lens(name, place):
    check(name, place, "lens")


RELAY_CASES = [
    pytest.param(name, place, id=f"{name}-{place}")
    for name, place in (
        ("schwarzschild", "far"),
        ("kerr 0.6", "near"),
        ("kerr 0.9", "near"),
        ("kerr 0.998", "horizon"),
        ("ellis", "near"),
    )
]


@pytest.mark.parametrize(("name", "place"), RELAY_CASES)
def test_by_the_relay_camera(name, place):
    """What its camera rays meet, in every kind of space; what scatters there goes by the lens."""
    check(name, place, "relay", (24, 14))
