"""The sky against Cycles: orientation of environment images, mapping, strength, and coordinates of a direction."""

import bentlight_native
import bpy
import mathutils
import numpy as np
import pytest
from cycles_values import render_world
from value_cases import empty_tree, new

from blender_addon.sync.images import ImageTable
from blender_addon.sync.material import compile_world

WIDTH, HEIGHT = 48, 32
ROTATION = mathutils.Euler((1.1, 0.3, -2.0))


def panorama():
    """A packed image of 9 x 6 random colors."""
    pixels = np.random.default_rng(3).random((6, 9, 4), np.float32) * 2
    pixels[..., 3] = 1
    image = bpy.data.images.new("panorama", 9, 6, float_buffer=True)
    image.pixels.foreach_set(pixels.ravel())
    image.update()
    image.pack()
    return image


def environment(tree, projection, interpolation, rotated=False):
    inputs = {}
    if rotated:
        place = new(tree, "TexCoord").outputs["Generated"]
        inputs = {0: new(tree, "Mapping", {0: place, "Rotation": (0.3, -0.4, 2.5)}).outputs[0]}
    settings = {"image": panorama(), "projection": projection, "interpolation": interpolation}
    return new(tree, "TexEnvironment", inputs, **settings).outputs[0]


CASES = {
    "equirectangular": lambda tree: environment(tree, "EQUIRECTANGULAR", "Closest"),
    "equirectangular_rotated": lambda tree: environment(tree, "EQUIRECTANGULAR", "Linear", rotated=True),
    "equirectangular_cubic": lambda tree: environment(tree, "EQUIRECTANGULAR", "Cubic"),
    "mirror_ball": lambda tree: environment(tree, "MIRROR_BALL", "Linear"),
    "generated": lambda tree: new(tree, "TexCoord").outputs["Generated"],
    "object": lambda tree: new(tree, "TexCoord").outputs["Object"],
    "normal": lambda tree: new(tree, "TexCoord").outputs["Normal"],
    "reflection": lambda tree: new(tree, "TexCoord").outputs["Reflection"],
}


def make_world(name, build):
    world = bpy.data.worlds.new(name)
    tree = empty_tree(world)
    background = new(tree, "Background", {"Color": build(tree), "Strength": 1.7})
    new(tree, "OutputWorld", {"Surface": background.outputs[0]})
    return world


def directions(offset=(0.0, 0.0)):
    """Of the pixels' centers, moved by a part of a pixel, for a field of view of 90 degrees across."""
    x = (np.arange(WIDTH) + 0.5 + offset[0]) / WIDTH * 2 - 1
    y = ((np.arange(HEIGHT) + 0.5 + offset[1]) / HEIGHT * 2 - 1) * HEIGHT / WIDTH
    rays = np.stack(np.broadcast_arrays(x[None, :], y[:, None], -1.0), axis=-1).reshape(-1, 3)
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    return rays @ np.array(ROTATION.to_matrix()).T


def render(world, path):
    camera = bpy.data.cameras.new("camera")
    camera.angle = np.pi / 2
    return render_world(world, camera, ROTATION, WIDTH, HEIGHT, path).reshape(-1, 3)


@pytest.mark.parametrize("name", CASES)
def test_sky_is_that_of_cycles(name, tmp_path):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    world = make_world(name, CASES[name])
    theirs = render(world, tmp_path / "sky.exr")
    images, scene = ImageTable(), bentlight_native.Scene()
    program = compile_world(world, images).program
    for pixels in images.images:
        scene.add_image(*pixels)
    scene.set_world(program)
    # A sample lies within 0.005 pixels of the center: where the sky changes over that, so much may it differ.
    ours = scene.sky(directions())
    around = [np.abs(scene.sky(directions((dx, dy))) - ours) for dx in (-0.006, 0.006) for dy in (-0.006, 0.006)]
    allowed = 1e-5 + 1e-5 * np.abs(ours) + np.max(around, axis=0)
    assert np.median(allowed) < 1e-3
    assert (np.abs(ours - theirs) <= allowed).mean() == 1


def test_turned_images_are_averaged_along_turned_directions():
    """The filter goes through the nodes in front of the texture."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    skies = []
    for rotated in (False, True):
        world = make_world("sky", lambda tree, rotated=rotated: environment(tree, "EQUIRECTANGULAR", "Linear", rotated))
        images, scene = ImageTable(), bentlight_native.Scene()
        program = compile_world(world, images).program
        for pixels in images.images:
            scene.add_image(*pixels)
        scene.set_world(program)
        skies.append(scene)
    rays = directions()
    across = np.cross(rays[:, None], [(0.6, 0.2, -0.3), (0, -0.9, 0.7)])
    turn = np.array(mathutils.Euler((0.3, -0.4, 2.5)).to_matrix())
    plain, rotated = skies
    averaged = rotated.sky(rays, across=across)
    np.testing.assert_allclose(averaged, plain.sky(rays @ turn.T, across=across @ turn.T), rtol=1e-5)
    assert averaged.std(axis=0).max() < 0.6 * rotated.sky(rays).std(axis=0).min()


def test_a_new_world_has_its_color():
    """Up to Blender 4.5 it has no nodes and its own color counts; later that of its Background node."""
    world = bpy.data.worlds.new("plain")
    world.color = (0.1, 0.2, 0.3)
    nodes = world.node_tree.nodes if world.node_tree else ()
    background = next((node for node in nodes if node.type == "BACKGROUND"), None)
    color = background.inputs["Color"].default_value[:3] if background else world.color
    scene = bentlight_native.Scene()
    scene.set_world(compile_world(world, ImageTable()).program)
    np.testing.assert_allclose(scene.sky([(0, 0, 1.0)]), [color], rtol=1e-6)


def test_no_world_is_black():
    scene = bentlight_native.Scene()
    assert (scene.sky([(0, 0, 1.0)]) == 0).all()
    scene.set_world(None)
    assert (scene.sky([(0, 0, 1.0)]) == 0).all()
