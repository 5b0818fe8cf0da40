"""Subsurface scattering against Cycles: a ball, and a slab that is lit from behind, beside a wall that shines."""

import math

import bpy
import numpy as np
import pytest
from value_cases import empty_tree, new

from tests.engine import cycles_pictures, stage
from tests.engine.stage import blender  # noqa: F401 (a fixture)
from tests.images.image_statistics import compare

COLOR = (0.8, 0.5, 0.2, 1)
MEAN_ERROR = 0.01  # of the whole picture, in every channel, beside what chance explains


def principled(tree, method, **inputs):
    settings = {"Base Color": COLOR, "Roughness": 0.6, "Subsurface Weight": 1.0, "Subsurface Scale": 0.5} | inputs
    return new(tree, "BsdfPrincipled", settings, subsurface_method=method)


def scattering(tree, method, **inputs):
    settings = {"Color": COLOR, "Scale": 1.0, "Radius": (1.0, 0.5, 0.3)} | inputs
    return new(tree, "SubsurfaceScattering", settings, falloff=method)


SHADERS = {
    "walk": lambda t: principled(t, "RANDOM_WALK", **{"Subsurface Radius": (2.0, 0.7, 0.3)}),
    "half": lambda t: principled(t, "RANDOM_WALK", **{"Subsurface Weight": 0.5, "Coat Weight": 0.5}),
    "channels without a radius": lambda t: scattering(t, "RANDOM_WALK", Radius=(1.0, 0.0, 0.3)),
    "forward": lambda t: scattering(t, "RANDOM_WALK", Anisotropy=0.7, Roughness=0.3),
    "skin": lambda t: principled(t, "RANDOM_WALK_SKIN", **{"Subsurface IOR": 1.6, "Subsurface Anisotropy": 0.3}),
    "pale": lambda t: scattering(t, "RANDOM_WALK_SKIN", Color=(0.95, 0.1, 0.3, 1)),
}


def material(build):
    made = bpy.data.materials.new("Flesh")
    tree = empty_tree(made)
    new(tree, "OutputMaterial", {"Surface": build(tree).outputs[0]})
    return made


def ball(made) -> None:
    """Smooth, of radius 1."""
    bpy.ops.mesh.primitive_uv_sphere_add(segments=64, ring_count=32)
    bpy.context.object.data.materials.append(made)
    bpy.ops.object.shade_smooth()


def slab(made) -> None:
    """2.4 wide, 0.4 thick, turned."""
    bpy.ops.mesh.primitive_cube_add(size=1.0)
    bpy.context.object.scale = (2.4, 2.0, 0.4)
    bpy.context.object.rotation_euler = (0.3, -0.2, 0.1)
    bpy.context.object.data.materials.append(made)


@pytest.mark.parametrize("shape", [ball, slab])
@pytest.mark.parametrize("name", SHADERS)
def test_light_comes_out_as_in_cycles(name, shape, tmp_path):
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = 16, 16
    scene.bentlight.max_bounces = 1
    stage.add_camera((0, 0, 5), angle=math.radians(14))
    stage.set_world((0.2, 0.2, 0.3))
    shape(material(SHADERS[name]))
    wall = stage.add_square(6.0, (-3, 0, -1), stage.emission((1.0, 0.9, 0.7), 2.0, "Wall"), "Wall")
    wall.rotation_euler = (0, math.radians(60), 0)
    theirs, ours = cycles_pictures.noisy_pictures(tmp_path, seeds=8, samples=64)
    comparison = compare(theirs, ours, block=4)
    assert not comparison.differs(), str(comparison)
    assert np.abs(comparison.mean_b / comparison.mean_a - 1).max() < MEAN_ERROR + 3 * comparison.precision
