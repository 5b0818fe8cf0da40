"""The Ambient Occlusion node against Cycles, in a corner with a ball."""

import math

import bpy
import pytest
from value_cases import empty_tree, new

from tests.engine import cycles_pictures, stage
from tests.engine.stage import blender  # noqa: F401 (a fixture)
from tests.images.image_statistics import compare


def occluded(output="AO", inputs=(), **settings):
    """A material that shines as much as it is open."""
    made = bpy.data.materials.new("Occluded")
    tree = empty_tree(made)
    node = new(tree, "AmbientOcclusion", {"Distance": 0.8} | dict(inputs), **settings)
    light = new(tree, "Emission", {"Color": node.outputs[output]})
    new(tree, "OutputMaterial", {"Surface": light.outputs[0]})
    return made


CASES = {
    "default": {},
    "color": {"output": "Color", "inputs": {"Color": (0.9, 0.5, 0.2, 1)}},
    "far": {"inputs": {"Distance": 5.0}, "samples": 4},
    "inside": {"inside": True},
    "own": {"only_local": True, "samples": 5},
    "own, inside": {"only_local": True, "inside": True, "samples": 1},
    "no distance": {"inputs": {"Distance": 1e-4}},
}


@pytest.mark.parametrize("name", CASES)
def test_corners_are_as_dark_as_in_cycles(name, tmp_path):
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = 24, 18
    stage.add_camera((2.5, -3.5, 3.0), (math.radians(52), 0, math.radians(36)))
    stage.set_world((0, 0, 0))
    made = occluded(**CASES[name])
    corner = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0), (-1, 1, 1.5), (1, 1, 1.5), (-1, -1, 1.5)]
    stage.add_mesh("Corner", corner, [(0, 1, 2, 3), (3, 2, 5, 4), (0, 3, 4, 6)], material=made)
    stage.add_mesh(
        "Block", [(x, y, z) for x in (0, 0.5) for y in (0, 0.6) for z in (0.1, 0.7)],
        [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)], material=made,
    )  # fmt: skip
    theirs, ours = cycles_pictures.noisy_pictures(tmp_path, seeds=6, samples=8)
    comparison = compare(theirs, ours)
    assert not comparison.differs(), str(comparison)
