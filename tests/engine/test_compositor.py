"""What Blender's own compositor nodes make of Bentlight's passes: known figures, real motion blur, and Cycles."""

import math

import bpy
import numpy as np
import pytest

from examples.compositor import new_tree
from tests.engine import stage
from tests.engine.stage import blender  # noqa: F401 (a fixture)

FRAME, SIZE, SPEED, SHUTTER = 5, (120, 40), 24.0, 0.5  # pixels; pixels a frame; frames


@pytest.fixture(autouse=True)
def scene(blender) -> bpy.types.Scene:  # noqa: F811
    """A camera along -z from which a pixel is a unit of the plane at z = 0, and a black world."""
    scene = bpy.context.scene
    scene.frame_set(FRAME)
    scene.render.resolution_x, scene.render.resolution_y = SIZE
    stage.add_camera((0, 0, SIZE[0] * 50 / 36))
    scene.camera.data.clip_end = 1000
    stage.set_world((0, 0, 0))
    scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = False
    scene.bentlight.use_adaptive_sampling = False
    scene.cycles.samples = scene.bentlight.samples = 16
    return scene


def composited(scene: bpy.types.Scene, kind: str, tmp_path, links: dict[str, str], **settings) -> np.ndarray:
    """RGB, rows upwards, of what one node makes of the picture: `links` from its inputs to passes, `settings` of it."""
    scene.view_layers[0].update_render_passes()
    tree, output = new_tree(scene, kind)
    layers, node = tree.nodes.new("CompositorNodeRLayers"), tree.nodes.new(f"CompositorNode{kind}")
    if kind == "Defocus":
        node.scene = scene
    for name, value in settings.items():
        if name in node.inputs:
            node.inputs[name].default_value = value
        else:
            setattr(node, name, value)
    for name, source in links.items():
        tree.links.new(layers.outputs[source], node.inputs[name])
    tree.links.new(node.outputs["Image"], output.inputs[0])
    scene.render.use_compositing = True
    pictures = stage.render_layers(tmp_path)
    scene.render.use_compositing = False
    (combined,) = [passes["Combined"] for layer, passes in pictures.items() if layer != "ViewLayer"]
    return combined[..., :3]


def plain(scene: bpy.types.Scene, tmp_path) -> np.ndarray:
    """RGB of the picture itself, rows upwards."""
    return stage.render(tmp_path)["Combined"][..., :3]


def make_pixels_sharp(scene: bpy.types.Scene) -> None:
    """With edges between pixels there is then no noise: both engines' pictures are the same."""
    scene.cycles.pixel_filter_type = scene.bentlight.pixel_filter = "BOX"
    scene.cycles.filter_width = scene.render.filter_size = 1.0


def add_moving(width: float, height: float) -> None:
    """A rectangle that shines, with its middle in the picture's, and moves along x by SPEED a frame."""
    shown = stage.add_square(1.0, material=stage.emission((1, 1, 1)))
    shown.scale = (width, height, 1)
    for frame in (FRAME - 1, FRAME + 1):
        shown.location.x = SPEED * (frame - FRAME)
        shown.keyframe_insert("location", frame=frame)
    stage.make_even(shown)
    bpy.context.scene.frame_set(FRAME)


def vector_blur(scene: bpy.types.Scene, tmp_path) -> np.ndarray:
    """The picture through the node, with vectors that Vector Blur takes for the motion."""
    scene.view_layers[0].use_pass_vector = scene.view_layers[0].use_pass_z = True
    links = {"Image": "Image", "Speed": "Vector", "Z": "Depth"}
    return composited(scene, "VecBlur", tmp_path, links, Shutter=SHUTTER, Samples=64)


def spread(picture: np.ndarray) -> tuple[float, float, float]:
    """Of light along x: all of it in an average row, and its middle and standard deviation, pixels from the left."""
    light = picture.mean(axis=(0, 2))
    x = np.arange(len(light)) + 0.5
    middle = (light * x).sum() / light.sum()
    return light.sum(), middle, math.sqrt((light * (x - middle) ** 2).sum() / light.sum())


def test_vector_blur_is_as_wide_as_the_motion(scene, tmp_path):
    """A bar of w pixels that goes L > w while the shutter is open: a trapezoid, w / L high and w + L wide."""
    width, path = 8, SPEED * SHUTTER
    make_pixels_sharp(scene)
    add_moving(width, 4 * SIZE[1])
    blurred = {}
    for scene.render.engine in ("CYCLES", "BENTLIGHT"):
        blurred[scene.render.engine] = vector_blur(scene, tmp_path)
    np.testing.assert_allclose(blurred["BENTLIGHT"], blurred["CYCLES"], atol=1e-4)
    light, middle, _ = spread(blurred["BENTLIGHT"])
    assert light == pytest.approx(width, rel=0.03) and middle == pytest.approx(SIZE[0] / 2, abs=0.02)
    edges = np.abs(np.arange(SIZE[0] + 1) - SIZE[0] / 2)
    trapezoid = np.clip((path + width) / 2 - edges, 0, width) / path
    expected = (trapezoid[1:] + trapezoid[:-1]) / 2
    np.testing.assert_allclose(blurred["BENTLIGHT"][..., 0].mean(axis=0), expected, atol=0.04)


def test_vector_blur_of_a_bent_image_is_its_real_motion_blur(scene, tmp_path):
    """Beside a hole an image goes less far than what it is of: 10 pixels of 12 here."""
    scene.render.engine, scene.bentlight.samples = "BENTLIGHT", 64
    add_moving(6, 6)
    bpy.ops.bentlight.black_hole_add(mass=2.0, location=(-40, 0, 80))
    sharp = spread(plain(scene, tmp_path)[:, 60:])
    by_node = spread(vector_blur(scene, tmp_path)[:, 60:])
    scene.bentlight.motion_slices, scene.render.motion_blur_shutter = 32, SHUTTER
    scene.render.use_motion_blur = True
    real = spread(plain(scene, tmp_path)[:, 60:])
    assert by_node[0] == pytest.approx(real[0], rel=0.03) and by_node[1] == pytest.approx(real[1], abs=0.2)
    assert by_node[2] == pytest.approx(real[2], rel=0.04)
    path = math.sqrt(12 * (by_node[2] ** 2 - sharp[2] ** 2))
    assert path < 0.9 * SPEED * SHUTTER


def test_defocus_blurs_what_is_out_of_focus_as_it_does_for_cycles(scene, tmp_path):
    """By the pass Depth: a square at the focus stays as it is, one behind it is spread out."""
    make_pixels_sharp(scene)
    distance, apart = scene.camera.location.z, 100.0
    farther = 1 + apart / distance
    lens = scene.camera.data
    lens.lens, lens.sensor_width, lens.dof.focus_distance = 1000, 720, distance  # in meters: pixels are large here
    stage.add_square(8.0, (-30, 0, 0), stage.emission((1, 1, 1)))
    stage.add_square(6.0 * farther, (25 * farther, 0, -apart), stage.emission((1, 1, 1)))
    scene.view_layers[0].use_pass_z = True
    found = {}
    for scene.render.engine in ("CYCLES", "BENTLIGHT"):
        links = {"Image": "Image", "Z": "Depth"}
        found[scene.render.engine] = composited(
            scene, "Defocus", tmp_path, links, use_zbuffer=True, f_stop=0.04, blur_max=32
        )
    ours, before = found["BENTLIGHT"], plain(scene, tmp_path)
    np.testing.assert_allclose(ours, found["CYCLES"], atol=1e-4)
    np.testing.assert_allclose(ours[:, :60], before[:, :60], atol=1e-5)
    assert before[:, 60:].max() == 1 and ours[:, 60:].max() < 0.6


def test_the_denoise_node_with_our_passes_takes_the_noise_away(scene, tmp_path):
    """By two thirds and more, from two walls of different colors, whose edge the passes tell it to keep."""
    make_pixels_sharp(scene)
    scene.render.engine, scene.bentlight.samples = "BENTLIGHT", 4
    for color, x in (((0.8, 0.3, 0.2), -30), ((0.2, 0.3, 0.8), 30)):
        material = bpy.data.materials.new("Wall")
        stage._use_nodes(material)
        principled = material.node_tree.nodes["Principled BSDF"]
        principled.inputs["Base Color"].default_value = (*color, 1)
        stage.add_square(60.0, (x, 0, 0), material)
    stage.add_light("AREA", (0, 0, 40), energy=2e5, size=60)
    scene.view_layers[0].bentlight.use_pass_denoising = True
    noisy = plain(scene, tmp_path)
    guides = {"Albedo": "Denoising Albedo", "Normal": "Denoising Normal"}
    clean = composited(scene, "Denoise", tmp_path, {"Image": "Image", **guides})
    unguided = composited(scene, "Denoise", tmp_path, {"Image": "Image"})
    scene.bentlight.samples = 128
    truth = plain(scene, tmp_path)
    before, after, alone = (float(np.sqrt(((one - truth) ** 2).mean())) for one in (noisy, clean, unguided))
    assert after < before / 3 and after < alone / 1.5
