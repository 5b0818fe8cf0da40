"""Depth of field against Cycles: Z-tests of glowing squares before, in and behind the focus, by every kind of lens."""

import bpy
import pytest

from tests.engine import cycles_pictures, stage
from tests.engine.stage import blender  # noqa: F401 (a fixture)
from tests.images.image_statistics import compare

SEEDS = 8
FISHEYE = {"type": "PANO", "panorama_type": "FISHEYE_EQUIDISTANT", "fisheye_fov": 1.2}
BLADES = {"aperture_blades": 3, "aperture_rotation": 0.4, "aperture_ratio": 2.0}
CAMERAS = {
    "disk": ({}, {}),
    "six blades": ({}, {"aperture_blades": 6, "aperture_rotation": 0.2}),
    "two blades": ({}, {"aperture_blades": 2}),
    "squeezed": ({"shift_x": 0.1}, {"aperture_ratio": 2.0}),
    "triangle": ({}, BLADES),
    "orthographic": ({"type": "ORTHO", "ortho_scale": 2.6}, {"aperture_fstop": 0.25, **BLADES}),
    "fisheye": (FISHEYE, {"aperture_fstop": 0.015, **BLADES}),
    "mirror ball": ({"type": "PANO", "panorama_type": "MIRRORBALL"}, {"aperture_fstop": 0.015, **BLADES}),
}


def build(lens: dict, opening: dict) -> bpy.types.Object:
    """Squares to the left, in the middle and to the right at the depths 2, 4 and 8; the middle is in focus."""
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = 24, 16
    camera = stage.add_camera((0.3, 0, 4), (0, 0, 0.2), **lens)
    stage.set_world((1 / 128, 1 / 128, 1 / 128))  # of which float32 adds up any number exactly
    for i, depth in enumerate((2, 4, 8)):
        colors = ((1, 0.3, 0.2), (0.2, 1, 0.3), (0.3, 0.2, 1))
        material = stage.emission(colors[i], 3.0, name=f"glow {i}")
        stage.add_square(0.06 * depth, (0.3 + 0.25 * (i - 1) * depth, 0, 4 - depth), material, f"square {i}")
    dof = camera.data.dof
    dof.use_dof, dof.focus_distance, dof.aperture_fstop = True, 4.0, 0.03
    for name, value in opening.items():
        setattr(dof, name, value)
    return camera


def assert_same_as_cycles(tmp_path, samples: int = 256) -> None:
    theirs, ours = cycles_pictures.noisy_pictures(tmp_path, SEEDS, samples)
    comparison = compare(theirs, ours, block=2)
    assert not comparison.differs(), str(comparison)
    assert comparison.precision < 0.01


@pytest.mark.parametrize("name", CAMERAS)
def test_bokeh_is_that_of_cycles(name, tmp_path):
    build(*CAMERAS[name])
    assert_same_as_cycles(tmp_path, 256 if CAMERAS[name][0].get("type") is None else 512)


def test_focus_object_and_scale_of_the_scene(tmp_path):
    """Focus is at the object's depth, wherever it lies beside the axis; the scene's scale does not matter."""
    bpy.context.scene.unit_settings.scale_length = 0.1
    camera = build({}, {"focus_distance": 0.5})
    camera.data.dof.focus_object = bpy.data.objects["square 2"]
    camera.scale = (2, 2, 2)
    assert_same_as_cycles(tmp_path)


def test_focus_on_a_bone(tmp_path):
    armature = bpy.data.armatures.new("rig")
    rig = bpy.data.objects.new("rig", armature)
    bpy.context.collection.objects.link(rig)
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    bone = armature.edit_bones.new("tip")
    bone.head, bone.tail = (0, 0, 2), (0, 1, 2)
    bpy.ops.object.mode_set(mode="OBJECT")
    camera = build({}, {})
    camera.data.dof.focus_object, camera.data.dof.focus_subtarget = rig, "tip"
    assert_same_as_cycles(tmp_path)
