"""Images of the sky as lenses filter them: footprints against the picture's own differences, noise and light against
pictures without the filter, and what is left as it is."""

import os

import bpy
import numpy as np
import objects
import pytest
import rendering
import skies
from test_lens_pictures import SPACES, add_spacetime
from test_node_groups import new_group, use

from blender_addon.cycles import files, filtered_sky, lens, setup, sky_images
from blender_addon.report import RenderError
from tests.engine import stage

SIZE = (96, 56)


def hole_before(scene, image, kind="isotropic", far=1):
    """A hole before a sky, set up for small pictures."""
    node = skies.show(scene, image)
    objects.camera((0.3 * far, -8 * far, 1.3 * far), (0, 0, 0), lens_mm=60 * far)
    add_spacetime(kind)
    rendering.set_size(scene, *SIZE)
    assert bpy.ops.bentlight.cycles_setup() == {"FINISHED"}
    return node


def picture(scene, sky_filter, seed=0, samples=16):
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = "BOX", 1.0
    scene.bentlight.sky_filter = sky_filter
    scene.cycles.samples = samples
    setup.update(scene, bpy.context.evaluated_depsgraph_get())
    return rendering.render(scene, "CYCLES", seed, samples)


def material(scene):
    return lens.all_of(scene)[0].data.materials[0]


def is_filtered(scene):
    setup.update(scene, bpy.context.evaluated_depsgraph_get())
    return filtered_sky.seen(material(scene)).node.bl_idname == "ShaderNodeAddShader"


@pytest.mark.parametrize("kind", SPACES)
def test_footprints_are_the_differences_of_neighboring_pixels(kind, scene, tmp_path):
    """The ellipse of directions over a pixel, by the lens, from an eighth of it, and by the picture's differences where
    these hardly change from one pixel to the next. What is left is how the map bends across a pixel. The camera is far
    away, for Cycles takes all its pixels for as wide as that in the middle."""
    hole_before(scene, skies.sky_file(tmp_path, skies.points()), kind, far=5)
    rendering.set_size(scene, 288, 168)
    scene.cycles.samples, scene.bentlight.sky_filter = 1, 0.125
    setup.update(scene, bpy.context.evaluated_depsgraph_get())
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = "BOX", 0.01
    squares, toward = (skies.measured(scene, tmp_path, material(scene), what) for what in skies.KINDS)
    skies.check_footprints(squares, toward, 0.125)


@pytest.mark.parametrize("kind", ["isotropic", "kerr"])
def test_points_make_less_noise_and_as_much_light(kind, scene, tmp_path):
    """Texels smaller than pixels before a hole: the filter takes most of the noise, keeps the light, and blurs no more
    than a Gaussian of a quarter of a pixel does, which is its width: where a texel is wider it leaves it alone."""
    hole_before(scene, skies.sky_file(tmp_path, skies.points()), kind)
    skies.check_less_noise(scene, picture, SIZE)


def put_in_groups(scene, node):
    """The world's nodes in a group in a group, with textures of other kinds; its colors come from outside."""
    tree, image = scene.world.node_tree, node.image
    inner, given, result = new_group({"At": "Vector", "Strength": "Float"}, {"Color": "Color"})
    texture, noise, mixed = (inner.nodes.new(f"ShaderNode{kind}") for kind in ("TexEnvironment", "TexNoise", "MixRGB"))
    texture.image = image
    inner.links.new(given.outputs["At"], texture.inputs["Vector"])
    inner.links.new(given.outputs["Strength"], mixed.inputs["Fac"])
    inner.links.new(texture.outputs["Color"], mixed.inputs["Color1"])
    inner.links.new(noise.outputs["Color"], mixed.inputs["Color2"])
    inner.links.new(mixed.outputs["Color"], result.inputs["Color"])
    outer, given, result = new_group({"Strength": "Float"}, {"Color": "Color"})
    part, coordinate = use(outer, inner), outer.nodes.new("ShaderNodeTexCoord")
    outer.links.new(given.outputs["Strength"], part.inputs["Strength"])
    outer.links.new(coordinate.outputs["Generated"], part.inputs["At"])
    outer.links.new(part.outputs["Color"], result.inputs["Color"])
    whole = use(tree, outer)
    whole.inputs["Strength"].default_value = 0.3
    tree.links.new(whole.outputs["Color"], tree.nodes["Background"].inputs["Color"])


def tell_directions(scene, _node):
    """Adds textures that get the direction from each output that tells it in a world."""
    tree = scene.world.node_tree
    shown = tree.nodes["Background"].inputs["Color"].links[0].from_socket
    for kind, names in (
        ("TexCoord", ("Generated", "Normal", "Object", "Reflection")),
        ("NewGeometry", ("Position", "Normal", "True Normal", "Incoming")),
    ):
        told = tree.nodes.new(f"ShaderNode{kind}")
        for name in names:
            noise, mixed = tree.nodes.new("ShaderNodeTexNoise"), tree.nodes.new("ShaderNodeMixRGB")
            mixed.blend_type, mixed.inputs["Fac"].default_value = "DIFFERENCE", 0.5
            noise.inputs["Scale"].default_value, noise.inputs["Detail"].default_value = 1, 0
            tree.links.new(told.outputs[name], noise.inputs["Vector"])
            tree.links.new(shown, mixed.inputs["Color1"])
            tree.links.new(noise.outputs["Color"], mixed.inputs["Color2"])
            shown = mixed.outputs["Color"]
    tree.links.new(shown, tree.nodes["Background"].inputs["Color"])


def add_muted(scene, node):
    """Nodes that are switched off: a background, a texture before an input with a value of its own, a group."""
    tree = scene.world.node_tree
    off, both, texture = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("Background", "AddShader", "TexEnvironment"))
    texture.image, texture.mute, off.mute = node.image, True, True
    shown = tree.nodes["Background"]
    shown.inputs["Strength"].default_value = 0.8
    tree.links.new(texture.outputs["Color"], shown.inputs["Strength"])
    output = tree.get_output_node("CYCLES").inputs["Surface"]
    tree.links.new(shown.outputs[0], both.inputs[0])
    tree.links.new(off.outputs[0], both.inputs[1])
    tree.links.new(both.outputs[0], output)


def turn(scene, node):
    """Puts a Mapping node before an Environment Texture."""
    tree = scene.world.node_tree
    coordinate, mapping = tree.nodes.new("ShaderNodeTexCoord"), tree.nodes.new("ShaderNodeMapping")
    mapping.inputs["Rotation"].default_value = (0.4, -0.7, 1.1)
    tree.links.new(coordinate.outputs["Generated"], mapping.inputs["Vector"])
    tree.links.new(mapping.outputs["Vector"], node.inputs["Vector"])


@pytest.mark.parametrize(
    ("kind", "how"),
    [
        *[("isotropic", "plain"), ("kerr", "turned"), ("wormhole", "stars"), ("areal", "wall"), ("wormhole", "wall")],
        ("kerr", "rich"),
    ],
)
def test_smooth_skies_look_the_same(kind, how, scene, tmp_path):
    """Details wide enough for the filter to change nothing: all else of the world, and meshes, stay as they are."""
    if how == "stars":
        settings = scene.world.bentlight
        settings.stars, settings.star_count, settings.star_strength = "PROCEDURAL", 300, 30
    node = hole_before(scene, skies.sky_file(tmp_path, skies.smooth()), kind)
    if how == "turned":
        turn(scene, node)
        scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.7
    if how == "rich":
        for change in (put_in_groups, tell_directions, add_muted):
            change(scene, node)
        scene.world.cycles.sampling_method = "NONE"  # it lights nothing
        assert is_filtered(scene)
    if how == "wall":
        skies.add_wall()
    skies.check_same(scene, picture)


def test_bytes_on_the_srgb_curve(scene, tmp_path):
    """A file of 8 bits is filtered in linear colors."""
    image = bpy.data.images.new("Bytes", 64, 32)
    rng = np.random.default_rng(1)
    codes = np.repeat(rng.integers(0, 2, (32, 64, 1)), 4, axis=-1).astype(np.float32)
    codes[..., 3] = 1
    image.pixels.foreach_set(codes.ravel())
    image.filepath_raw, image.file_format = str(tmp_path / "bytes.png"), "PNG"
    image.save()
    hole_before(scene, bpy.data.images.load(image.filepath_raw))
    objects.camera((0.3, -8, 1.3), (0, 0, 0), lens_mm=12)
    rendering.set_size(scene, 24, 16)
    with_it = np.stack([picture(scene, 1.0, seed, 4) for seed in range(6)])
    without = np.stack([picture(scene, 0.0, seed, 256) for seed in range(2)])
    error = with_it.mean((1, 2, 3)).std(ddof=1) / np.sqrt(6)
    assert abs(with_it.mean() - without.mean()) < 5 * error + 0.01 * without.mean()


def test_passes_are_those_of_what_lies_behind(scene, tmp_path):
    """Bit for bit what they are without the filter, but Emission, which has what the filter changes; a lamp before the
    sky shines as ever."""
    hole_before(scene, skies.sky_file(tmp_path, skies.smooth()), "kerr")
    skies.add_wall()
    skies.add_lamp()
    lens.all_of(scene)[0].pass_index = 7

    def passes(sky_filter):
        picture(scene, sky_filter, samples=1)
        return stage.render(tmp_path)

    skies.check_passes(scene, passes)


def frames_of(folder, colors):
    """An image sequence, each frame of a color."""
    for i, color in enumerate(colors):
        skies.sky_file(folder, np.broadcast_to(color, (256, 512, 3))).name = "Frame"
        (folder / "sky.exr").rename(folder / f"sky_{i + 7:03}.exr")
    image = bpy.data.images.load(str(folder / "sky_007.exr"))
    image.source = "SEQUENCE"
    return image


@pytest.mark.parametrize("refreshes", [True, False])
def test_image_sequences_show_the_frame(refreshes, scene, tmp_path):
    """Offset, start, and going around, as Cycles has them, whether the viewport follows or not."""
    colors = np.array([(0.1, 0.8, 0.3), (0.9, 0.2, 0.5), (0.4, 0.6, 0.7), (0.3, 0.1, 0.9)])
    node = hole_before(scene, frames_of(tmp_path, colors))
    scene.world.cycles.sampling_method = "NONE"  # it lights nothing
    user = node.image_user
    user.frame_start, user.frame_duration, user.frame_offset, user.use_auto_refresh = 3, 4, 6, refreshes
    objects.camera((0.3, -8, 1.3), (0, 0, 0), lens_mm=12)
    rendering.set_size(scene, 16, 12)
    shown = {}
    for frame, cyclic in ((3, False), (5, False), (40, False), (2, True), (8, True)):
        scene.frame_set(frame)
        user.use_cyclic = cyclic
        bpy.context.view_layer.update()
        found = picture(scene, 1.0, samples=1)
        assert is_filtered(scene)
        corner, shown[frame] = found[0, 0], (found / found[0, 0]).max(axis=(0, 1))
        np.testing.assert_allclose(corner, colors[{3: 0, 5: 2, 40: 3, 2: 3, 8: 1}[frame]], rtol=1e-3)
    for ratio in shown.values():  # nothing is brighter than the sky: redshift is off
        np.testing.assert_allclose(ratio, 1, rtol=1e-3)


def test_animations_of_image_sequences_follow_the_frames(scene, tmp_path):
    """Rendered as artists do, with nobody else to keep lenses as they are."""
    colors = np.array([(0.1, 0.8, 0.3), (0.9, 0.2, 0.5), (0.4, 0.6, 0.7)])
    node = hole_before(scene, frames_of(tmp_path, colors))
    scene.world.cycles.sampling_method = "NONE"
    node.image_user.frame_duration, node.image_user.frame_offset = 3, 6
    objects.camera((0.3, -8, 1.3), (0, 0, 0), lens_mm=12)
    rendering.set_size(scene, 16, 12)
    scene.cycles.samples, scene.frame_end = 1, 3
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.filepath = str(tmp_path / "shown_")
    shown = []
    scene.render.engine = "CYCLES"
    bpy.app.handlers.render_post.append(lambda *_: shown.append(frame_file(scene)))
    bpy.ops.render.render(animation=True)
    bpy.app.handlers.render_post.pop()
    assert len(set(shown)) == 3
    for i, color in enumerate(colors):
        image = bpy.data.images.load(str(tmp_path / f"shown_{i + 1:04}.exr"))
        pixels = np.array(image.pixels).reshape(12, 16, -1)[..., :3]
        np.testing.assert_allclose(pixels, np.broadcast_to(color, pixels.shape), rtol=2e-3)


def frame_file(scene):
    """Of the sky's image, in the nodes that a lens has."""
    groups = [node.node_tree for node in material(scene).node_tree.nodes if node.bl_idname == "ShaderNodeGroup"]
    inputs = [node.inputs.get("Image") for node in groups[0].nodes if node.bl_idname == "ShaderNodeScript"]
    return next(socket.default_value for socket in inputs if socket)


def test_few_files_of_frames_stay():
    """Those that were asked for last, so that a sequence fills no disk."""
    made = []
    for i in range(20):
        for value in (0, i):
            made.append(files.passing("frame", np.full((2, 4, 3), value, np.float16)))
            os.utime(made[-1], (i, i))  # as if it was long ago
    assert made[0] == made[2] != made[3]
    assert set(made[-1].parent.glob("frame_*.exr")) == {made[0], *made[-13::2]}


def test_what_is_not_filtered(scene, tmp_path):
    """Where a material could not show what the world does, or nobody asks, rays leave a lens as ever."""
    node = hole_before(scene, skies.sky_file(tmp_path, skies.points(10, 64)))
    tree = scene.world.node_tree
    assert is_filtered(scene)
    for owner, name, value in (
        (scene.bentlight, "sky_filter", 0.0),
        (scene.render, "film_transparent", True),
        (scene.world.cycles_visibility, "camera", False),
        (scene.view_layers[0], "use_sky", False),
        (node, "projection", "MIRROR_BALL"),
        (node, "image", None),
        (node.texture_mapping, "scale", (1, 1, 2)),
    ):
        before = getattr(owner, name)
        before = tuple(before) if isinstance(value, tuple) else before
        setattr(owner, name, value)
        assert not is_filtered(scene), name
        setattr(owner, name, before)
        assert is_filtered(scene), name
    volume = tree.nodes.new("ShaderNodeVolumeScatter")
    tree.links.new(volume.outputs[0], tree.get_output_node("CYCLES").inputs["Volume"])
    assert not is_filtered(scene)
    tree.nodes.remove(volume)
    assert is_filtered(scene)
    coordinate = tree.nodes.new("ShaderNodeTexCoord")
    link = tree.links.new(coordinate.outputs["Window"], node.inputs["Vector"])
    assert not is_filtered(scene)
    tree.links.remove(link)
    assert is_filtered(scene)  # nobody sees what it says


def test_transparent_films_show_a_hole_as_ever(scene, tmp_path):
    hole_before(scene, skies.sky_file(tmp_path, skies.points(10, 64)))
    scene.render.film_transparent = True
    assert picture(scene, 1.0).max() == 0


def test_images_are_read_again_when_they_change(scene, tmp_path):
    """A file of other pixels, one that is painted on, and one that is gone."""
    node = hole_before(scene, skies.sky_file(tmp_path, skies.points(10, 64)))
    first = sky_images.file_of(node.image)
    assert sky_images.file_of(node.image) is first and first.path.is_file()
    skies.sky_file(tmp_path, skies.points(20, 64))
    node.image.reload()
    second = sky_images.file_of(node.image)
    assert second.path != first.path and second.height == 64
    second.path.unlink()
    assert sky_images.file_of(node.image) == second and second.path.is_file()
    painted = bpy.data.images.new("Painted", 8, 4, float_buffer=True)
    black = sky_images.file_of(painted)
    painted.pixels.foreach_set(np.ones(8 * 4 * 4, np.float32))
    sky_images.forget()
    assert sky_images.file_of(painted).path != black.path
    node.image.filepath = str(tmp_path / "gone.exr")
    node.image.reload()
    with pytest.raises(RenderError, match=r"Image 'sky\.exr': its file .* is missing"):
        sky_images.file_of(node.image)
    assert not is_filtered(scene)


def test_nodes_come_and_go(scene, tmp_path):
    """With a disk's own material too; nothing is left behind."""
    hole_before(scene, skies.sky_file(tmp_path, skies.points(10, 64)), "kerr")
    hole = lens.all_of(scene)[0].parent
    disk = bpy.data.materials.new("Disk")
    disk.use_nodes = True
    hole.bentlight.disk.enable, hole.bentlight.disk.emission = True, "MATERIAL"
    hole.bentlight.disk.material = disk

    def state(sky_filter):
        scene.bentlight.sky_filter = sky_filter
        setup.update(scene, bpy.context.evaluated_depsgraph_get())
        tree = material(scene).node_tree
        links = sorted(
            (a.from_node.bl_idname, a.from_socket.name, a.to_node.bl_idname, a.to_socket.name) for a in tree.links
        )
        return links, len(tree.nodes), len(bpy.data.node_groups)

    without, with_it = state(0.0), state(1.0)
    assert with_it[1:] == (without[1] + 2, without[2] + 1)
    assert state(0.0) == without and state(1.0) == with_it
    hole.bentlight.disk.emission = "PAGE_THORNE"
    assert state(1.0)[1:] == (4, 1)
    hole.bentlight.disk.emission = "MATERIAL"
    assert state(1.0) == with_it
    bpy.ops.bentlight.cycles_clear()
    assert len(bpy.data.node_groups) == 0
