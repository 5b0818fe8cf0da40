"""Images of skies for tests, and what shaders that filter them tell of directions."""

import bpy
import materials
import numpy as np
import objects
import rendering
from bentlight_native.exr import write_exr

from blender_addon.cycles import shaders

KINDS = ("squares", "direction")  # of the derivatives, scaled; itself and 2
SQUARES_SCALE, SQUARES_OFFSET = 1e6, 1e3  # the products may be negative
_MEASURE = f"""
shader measure(vector Vector = 0, float Sky = 0, int Squares = 0, output closure color BSDF = 0)
{{
  vector x = Dx(Vector), y = Dy(Vector);
  color squares = {SQUARES_SCALE} * color(dot(x, x), dot(y, y), dot(x, y)) + color(0, 0, {SQUARES_OFFSET});
  if (Sky > 0) BSDF = emission() * (Squares ? squares : color(Vector) + 2);
}}
"""


def sky_file(folder, pixels):
    """An image of (height, width, 3), rows from the bottom."""
    write_exr(folder / "sky.exr", {c: pixels[::-1, :, i].astype(np.float32) for i, c in enumerate("RGB")}, {})
    return bpy.data.images.load(str(folder / "sky.exr"))


def points(count=3000, height=512):
    """White texels on black."""
    rng, pixels = np.random.default_rng(3), np.zeros((height, 2 * height, 3))
    row = ((np.arcsin(rng.uniform(-1, 1, count)) / np.pi + 0.5) * height).astype(int)
    pixels[row, rng.integers(0, 2 * height, count)] = 1
    return pixels


def smooth(height=256):
    """Of several colors, with details of many texels."""
    latitude, longitude = np.meshgrid(
        (np.arange(height) + 0.5) / height * np.pi, (np.arange(2 * height) + 0.5) / height * np.pi, indexing="ij"
    )
    waves = [np.sin(3 * longitude) * np.sin(latitude) ** 3, np.cos(5 * latitude), np.cos(2 * longitude + latitude)]
    waves[2] *= np.sin(latitude) ** 2
    return 0.5 + 0.4 * np.stack(waves, axis=-1)


def show(scene, image):
    """The world shows an image; returns its node."""
    tree = scene.world.node_tree
    node = tree.nodes.new("ShaderNodeTexEnvironment")
    node.image = image
    tree.links.new(node.outputs["Color"], tree.nodes["Background"].inputs["Color"])
    tree.nodes["Background"].inputs["Strength"].default_value = 1
    return node


def add_wall():
    """Behind a hole, on its left."""
    objects.quad("Wall", (-6, 5, -6), (7, 0, 0), (0, 0, 12), materials.emission("Light", (0.2, 0.5, 0.9)))


def add_lamp():
    """A ball that is seen, brighter than any sky, on its right."""
    lamp = bpy.data.lights.new("Lamp", "POINT")
    lamp.energy, lamp.shadow_soft_size = 1e5, 0.6
    shown = objects.place(bpy.data.objects.new("Lamp", lamp))
    shown.location, shown.visible_camera = (3, 5, 0), True


def measured(scene, folder, material, kind):
    """What the shader of a lens or a screen tells of each pixel's direction in the sky, in its middle: one of KINDS."""
    import _cycles  # there once bpy is

    (folder / "measure.osl").write_text(_MEASURE)
    assert _cycles.osl_compile(str(folder / "measure.osl"), str(folder / "measure.oso"))
    tree = material.node_tree
    script = next(node for node in tree.nodes if node.bl_idname == "ShaderNodeScript")
    node = tree.nodes.new("ShaderNodeScript")
    inputs = {
        "Vector": ("NodeSocketVector", None),
        "Sky": ("NodeSocketFloat", None),
        "Squares": ("NodeSocketInt", int(kind == "squares")),
    }
    shaders.fill_node(node, shaders.Shader((folder / "measure.oso").read_text(), f"measure {kind}"), inputs)
    tree.links.new(script.outputs["Toward"], node.inputs["Vector"])
    tree.links.new(script.outputs["Sky"], node.inputs["Sky"])
    output = tree.get_output_node("CYCLES").inputs["Surface"]
    before = output.links[0].from_socket
    tree.links.new(node.outputs["BSDF"], output)
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = "BOX", 0.01
    shown = rendering.render(scene, "CYCLES", 0, 1)
    tree.links.new(before, output)
    tree.nodes.remove(node)
    return shown


def check_footprints(squares, toward, pixels):
    """The ellipse of directions over a pixel, as a shader tells it over so many pixels, and by the picture's
    differences where these hardly change from one pixel to the next. What is left: how the map bends across a pixel."""
    known = np.abs(toward).max(axis=-1) > 0
    toward = toward - 2
    inner = known[1:-1, 1:-1] & known[2:, 1:-1] & known[:-2, 1:-1] & known[1:-1, 2:] & known[1:-1, :-2]
    x, y = (toward[1:-1, 2:] - toward[1:-1, :-2]) / 2, (toward[2:, 1:-1] - toward[:-2, 1:-1]) / 2
    bend_x = np.linalg.norm(toward[1:-1, 2:] + toward[1:-1, :-2] - 2 * toward[1:-1, 1:-1], axis=-1)
    bend_y = np.linalg.norm(toward[2:, 1:-1] + toward[:-2, 1:-1] - 2 * toward[1:-1, 1:-1], axis=-1)
    sum_seen, product_seen = (x * x + y * y).sum(-1), (x * x).sum(-1) * (y * y).sum(-1) - (x * y).sum(-1) ** 2
    told = np.where(known[..., None], (squares - (0, 0, SQUARES_OFFSET)) / SQUARES_SCALE, 0) / pixels**2
    xx, yy, xy = np.moveaxis(told[1:-1, 1:-1], -1, 0)
    even = inner & (np.maximum(bend_x, bend_y) < 0.02 * np.sqrt(sum_seen))
    assert even.sum() > 2000
    # axes' squares by sum and product; frames differ, what is the same in all of them does not
    ratio = (xx + yy)[even] / sum_seen[even]
    area = np.sqrt(np.maximum(xx * yy - xy**2, 0)[even] / product_seen[even])
    assert np.abs(np.median(ratio) - 1) < 0.02 and np.abs(np.median(area) - 1) < 0.04
    assert np.quantile(np.abs(ratio - 1), 0.9) < 0.1


def check_less_noise(scene, picture, size):
    """Texels smaller than pixels before a hole, pictures by `picture(scene, sky_filter, seed, samples)`: the filter
    takes most of the noise, keeps the light, and blurs no more than a Gaussian of a quarter of a pixel does, which is
    its width: where a texel is wider it leaves it alone."""
    noise, light = {}, {}
    for sky_filter in (0.0, 1.0):
        pictures = np.stack([picture(scene, sky_filter, seed, 16)[..., 0] for seed in range(3)])
        noise[sky_filter] = pictures.var(axis=0, ddof=1).mean()
        light[sky_filter], mean = pictures.sum(axis=(1, 2)), pictures.mean(axis=0)
    assert noise[1.0] < noise[0.0] / 4
    rendering.set_size(scene, 4 * size[0], 4 * size[1])
    fine = picture(scene, 0.0, 9, 32)[..., 0]
    rendering.set_size(scene, *size)
    weights = np.exp(-(np.arange(-4, 5) ** 2) / 2) / np.exp(-(np.arange(-4, 5) ** 2) / 2).sum()
    blurred = fine
    for axis in (0, 1):
        blurred = np.apply_along_axis(np.convolve, axis, blurred, weights, "same")
    truth, most = (each.reshape(size[1], 4, size[0], 4).mean((1, 3)) for each in (fine, blurred))
    # of three pictures, and of the fine one, which has 32 times the samples of those without the filter
    error = np.sqrt(light[1.0].var(ddof=1) / 3 + light[0.0].var(ddof=1) / 32) / truth.sum()
    # light moves between places that are magnified differently: docs/limits.md
    assert error < 0.01 and abs(light[1.0].mean() / truth.sum() - 1) < 4 * error + 0.005
    assert ((mean - truth) ** 2).mean() - noise[1.0] / 3 < ((most - truth) ** 2).mean()


def check_same(scene, picture):
    """Of a sky whose details are wide enough for the filter to change nothing: blocks of 8 x 8 pixels, each color."""
    pictures = [[picture(scene, sky_filter, seed, 16) for seed in range(3)] for sky_filter in (0.0, 1.0)]
    height, width, _ = pictures[0][0].shape
    blocks = [np.stack(each).reshape(3, height // 8, 8, width // 8, 8, 3).mean((2, 4)) for each in pictures]
    without, with_it = blocks
    off = with_it.mean(0) - without.mean(0)
    variance = (with_it.var(0, ddof=1) + without.var(0, ddof=1)) / 3
    # what light moves where a hole magnifies differently: docs/limits.md
    share, brightness = 0.005, without.mean()
    assert abs(off.mean()) < 5 * np.sqrt(variance.sum()) / off.size + 0.4 * share * brightness
    assert (off**2).mean() < 2 * variance.mean() + (share * brightness) ** 2


def check_passes(scene, picture, error=0.0):
    """Passes by `picture(sky_filter)`, with one sample in each pixel: to an absolute error what they are without the
    filter, but Emission, which has what it changes. A shining lamp before the sky is as bright as ever."""
    layer = scene.view_layers[0]
    for name in ("z", "mist", "position", "normal", "object_index", "uv", "emit", "environment", "cryptomatte_object"):
        setattr(layer, f"use_pass_{name}", True)
    scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = False
    without, with_it = picture(0.0), picture(1.0)
    assert len(without) > 10 and with_it.keys() == without.keys()
    emission = "Emission" if "Emission" in without else "Emit"  # in Blender 4.5
    for name in without.keys() - {"Combined", emission}:
        np.testing.assert_allclose(with_it[name], without[name], rtol=0, atol=error, err_msg=name)
    change, added = (with_it[name][..., :3] - without[name][..., :3] for name in ("Combined", emission))
    np.testing.assert_allclose(change, added, atol=1e-6 * without["Combined"].max())
    assert without["Depth"].max() == 1e10 and np.abs(added)[without["Depth"][..., 0] == 1e10].max() > 0.1
    shining = without["Combined"][..., 0] > 100
    assert shining.sum() > 20
    np.testing.assert_allclose(with_it["Combined"][shining], without["Combined"][shining], atol=1)
