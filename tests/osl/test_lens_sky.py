"""Images of the sky as lenses filter them: footprints against the picture's own differences, noise and light against
pictures without the filter, and what is left as it is."""

import bpy
import numpy as np
import objects
import pytest
import rendering
import skies
from test_lens_pictures import SPACES, add_spacetime

from blender_addon.cycles import lens, lens_sky, setup, sky_images
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
    return lens_sky.seen(material(scene)).node.bl_idname == "ShaderNodeAddShader"


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


def turn(scene, node):
    """Puts a Mapping node before an Environment Texture."""
    tree = scene.world.node_tree
    coordinate, mapping = tree.nodes.new("ShaderNodeTexCoord"), tree.nodes.new("ShaderNodeMapping")
    mapping.inputs["Rotation"].default_value = (0.4, -0.7, 1.1)
    tree.links.new(coordinate.outputs["Generated"], mapping.inputs["Vector"])
    tree.links.new(mapping.outputs["Vector"], node.inputs["Vector"])


@pytest.mark.parametrize(
    ("kind", "how"),
    [("isotropic", "plain"), ("kerr", "turned"), ("wormhole", "stars"), ("areal", "wall"), ("wormhole", "wall")],
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


def test_what_is_not_filtered(scene, tmp_path):
    """Where a material could not show what the world does, or nobody asks, rays leave a lens as ever."""
    node = hole_before(scene, skies.sky_file(tmp_path, skies.points(10, 64)))
    tree = scene.world.node_tree
    assert is_filtered(scene)
    for owner, name, value in (
        (scene.bentlight, "sky_filter", 0.0),
        (scene.render, "film_transparent", True),
        (scene.world.cycles_visibility, "camera", False),
        (scene.world, "lightgroup", "Sky"),
        (scene.view_layers[0], "use_sky", False),
        (node, "projection", "MIRROR_BALL"),
        (node, "image", None),
    ):
        before = getattr(owner, name)
        setattr(owner, name, value)
        assert not is_filtered(scene), name
        setattr(owner, name, before)
        assert is_filtered(scene), name
    volume = tree.nodes.new("ShaderNodeVolumeScatter")
    tree.links.new(volume.outputs[0], tree.get_output_node("CYCLES").inputs["Volume"])
    assert not is_filtered(scene)
    tree.nodes.remove(volume)
    assert is_filtered(scene)
    geometry = tree.nodes.new("ShaderNodeNewGeometry")
    tree.links.new(geometry.outputs["Position"], node.inputs["Vector"])
    assert not is_filtered(scene)


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
    assert sky_images.file_of(node.image) is None
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
