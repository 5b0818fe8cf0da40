"""A final render by our engine as Blender delivers it: the part of the image asked for, layers, film, frames."""

import time

import bpy
import numpy as np
import pytest

from blender_addon import final
from tests.engine import stage

GREEN, RED = (0.1, 0.8, 0.2), (0.9, 0.1, 0.05)


def simple_scene() -> bpy.types.Scene:
    """A shining square before a sky, with a black hole between the camera and the square."""
    scene = bpy.context.scene
    stage.add_camera((0, 0, 6))
    stage.set_world(GREEN)
    stage.add_square(2.0, material=stage.emission(RED, 2.0))
    bpy.ops.bentlight.black_hole_add(mass=0.1, location=(0.3, 0.2, 2.0))
    return scene


def test_colors_are_linear_and_unclipped(tmp_path):
    scene = simple_scene()
    bpy.data.objects.remove(bpy.data.objects["Black Hole"])
    picture = stage.render(tmp_path)["Combined"]
    assert picture.shape == (48, 64, 4)
    np.testing.assert_allclose(picture[24, 32], (1.8, 0.2, 0.1, 1.0), rtol=1e-5)
    np.testing.assert_allclose(picture[2, 2], (*GREEN, 1.0), rtol=1e-5)
    assert scene.render.engine == "BENTLIGHT"


def test_a_black_hole_swallows_and_bends(tmp_path):
    scene = simple_scene()
    scene.view_layers[0].bentlight.use_pass_fate = True
    fate = stage.render(tmp_path)["Bentlight Fate"]
    assert set(np.unique(fate)) == {1.0, 2.0, 4.0}
    # A disk of the shadow's radius sqrt(27) M at distance 4 (isotropic radius 4 is areal radius 4.1 to 1e-3), seen
    # at the angle that static observers there measure (Synge 1966).
    r, mass = 4 + 0.1 + 0.1**2 / 16, 0.1
    sine = np.sqrt(27) * mass / r * np.sqrt(1 - 2 * mass / r)
    height_of_view = 2 * 0.5 * 36 / 50 * 48 / 64
    pixels = np.pi * (np.tan(np.arcsin(sine)) / height_of_view * 48) ** 2
    assert (fate == 2).sum() == pytest.approx(pixels, rel=0.1)


def test_a_border_is_the_same_part_of_the_picture(tmp_path):
    scene = simple_scene()
    whole = stage.render(tmp_path)["Combined"]
    render = scene.render
    render.use_border = True
    render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y = 0.3, 0.71, 0.2, 0.9
    render.use_crop_to_border = True
    cropped = stage.render(tmp_path)["Combined"]
    rows, columns = slice(9, 43), slice(19, 45)
    assert np.array_equal(cropped, whole[rows, columns])
    render.use_crop_to_border = False
    uncropped = stage.render(tmp_path)["Combined"]
    assert np.array_equal(uncropped[rows, columns], whole[rows, columns])
    outside = np.ones(whole.shape[:2], bool)
    outside[rows, columns] = False
    assert (uncropped[outside] == 0).all()


@pytest.mark.parametrize("lines", [(10, 34), (1, 47), (16, 31)])
def test_a_border_of_whole_pixels_is_filled(lines, tmp_path):
    """Fractions of 48 lines that are not exact: Blender's rounding is ours."""
    render = simple_scene().render
    whole = stage.render(tmp_path)["Combined"]
    render.use_border = render.use_crop_to_border = True
    render.border_min_x, render.border_max_x = 0.0, 1.0
    render.border_min_y, render.border_max_y = (line / 48 for line in lines)
    assert np.array_equal(stage.render(tmp_path)["Combined"], whole[slice(*lines)])


@pytest.mark.parametrize("axis", "xy")
@pytest.mark.parametrize(("low", "high"), [(0.5, 0.501), (0.7, 0.3)])
def test_an_empty_border_is_refused_by_blender_and_harms_nothing(axis, low, high, tmp_path):
    render = simple_scene().render
    whole = stage.render(tmp_path)["Combined"]
    render.use_border = True
    setattr(render, f"border_min_{axis}", low)
    setattr(render, f"border_max_{axis}", high)
    (tmp_path / "render.exr").unlink()
    with stage.counted_renders() as count, pytest.raises(RuntimeError, match="Image too small"):
        stage.render(tmp_path)
    assert not count and not list(tmp_path.iterdir())
    render.use_border = False
    assert np.array_equal(stage.render(tmp_path)["Combined"], whole)


@pytest.mark.parametrize("axis", "xy")
def test_the_narrowest_border_is_one_row_or_column(axis, tmp_path):
    render = simple_scene().render
    whole = stage.render(tmp_path)["Combined"]
    render.use_border = render.use_crop_to_border = True
    at, size = (30, 64) if axis == "x" else (20, 48)
    setattr(render, f"border_min_{axis}", (at + 0.25) / size)
    setattr(render, f"border_max_{axis}", (at + 1.25) / size)
    one = whole[:, at : at + 1] if axis == "x" else whole[at : at + 1]
    assert np.array_equal(stage.render(tmp_path)["Combined"], one)


@pytest.mark.parametrize(("percentage", "shape"), [(50, (24, 32)), (33, (15, 21))])
def test_resolution_percentage(percentage, shape, tmp_path):
    simple_scene().render.resolution_percentage = percentage
    assert stage.render(tmp_path)["Combined"].shape[:2] == shape


def test_the_picture_does_not_depend_on_threads_or_tiles(tmp_path, monkeypatch):
    scene = simple_scene()
    stage.add_light("AREA", (0, 0, 5), size=1.0, energy=100.0)
    bpy.ops.mesh.primitive_ico_sphere_add(location=(0.8, 0, 0.5), radius=0.4)
    pictures = []
    for threads, sizes in [(1, (16,)), (2, (16,)), (2, (32,)), (5, (7,))]:
        scene.render.threads = threads
        monkeypatch.setattr(final, "_TILE_SIZES", sizes)
        pictures.append(stage.render(tmp_path)["Combined"])
    for picture in pictures[1:]:
        assert np.array_equal(picture, pictures[0])


def test_no_tile_takes_long(tmp_path, monkeypatch):
    """Whatever the samples: the user sees the picture grow."""
    sizes = []

    def no_tiles(*rectangle_and_size: int) -> list:
        sizes.append(rectangle_and_size[-1])
        return []

    monkeypatch.setattr(final, "spiral_tiles", no_tiles)
    scene = simple_scene()
    scene.render.resolution_x, scene.render.resolution_y = 1920, 1080
    for samples in (16, 1024, 4096):
        scene.bentlight.samples = samples
        stage.render(tmp_path)
    assert sizes == [64, 32, 16]


def test_the_seed_changes_the_noise(tmp_path):
    scene = simple_scene()
    first = stage.render(tmp_path)["Combined"]
    scene.bentlight.seed = 7
    assert not np.array_equal(stage.render(tmp_path)["Combined"], first)


def test_a_transparent_film_leaves_the_sky_out(tmp_path):
    scene = simple_scene()
    scene.render.film_transparent = True
    picture = stage.render(tmp_path)["Combined"]
    assert (picture[2, 2] == 0).all()
    assert picture[..., 3].max() == 1
    scene.render.film_transparent = False
    assert (stage.render(tmp_path)["Combined"][..., 3] == 1).all()


def test_view_layers_render_what_they_contain(tmp_path):
    scene = bpy.context.scene
    stage.add_camera((0, 0, 6))
    stage.set_world((0, 0, 0))
    left = stage.add_square(1.0, (-1, 0, 0), stage.emission(RED), name="left")
    right = stage.add_square(1.0, (1, 0, 0), stage.emission(GREEN), name="right")
    for obj in (left, right):
        collection = bpy.data.collections.new(obj.name)
        scene.collection.children.link(collection)
        collection.objects.link(obj)
        scene.collection.objects.unlink(obj)
    second = scene.view_layers.new("second")
    second.layer_collection.children["left"].exclude = True
    second.layer_collection.children["right"].holdout = True
    second.samples = 1
    scene.render.film_transparent = True
    layers = stage.render_layers(tmp_path)
    assert set(layers) == {"ViewLayer", "second"}
    first, other = layers["ViewLayer"]["Combined"], layers["second"]["Combined"]
    at_left, at_right = (24, 17), (24, 46)
    np.testing.assert_allclose(first[at_left], (*RED, 1), rtol=1e-5)
    np.testing.assert_allclose(first[at_right], (*GREEN, 1), rtol=1e-5)
    assert (other[at_left] == 0).all()
    assert (other[at_right] == 0).all()


def test_a_holdout_is_a_hole_for_the_camera_alone(tmp_path):
    """A held out lamp before a wall: black and see-through itself, and the wall is lit by it."""
    scene = bpy.context.scene
    stage.add_camera((0, 0, 6))
    stage.set_world((0, 0, 0))
    stage.add_square(20.0)
    lamp = stage.add_square(1.0, (0, 0, 1), stage.emission((5, 5, 5)), name="lamp")
    lamp.is_holdout = True
    scene.render.film_transparent = True
    scene.bentlight.samples = 64
    picture = stage.render(tmp_path)["Combined"]
    assert (picture[24, 32] == 0).all()
    assert picture[24, 46, 3] == 1
    assert picture[20:28, 44:50, :3].mean() > 0.05


@pytest.mark.parametrize("part", [1.0, 0.25])
def test_a_holdout_shader_is_a_hole_as_in_cycles(tmp_path, part):
    """Alone, and mixed with a lamp; behind it is another lamp, which a hole hides too."""
    scene = bpy.context.scene
    stage.add_camera((0, 0, 6))
    stage.set_world(GREEN)
    stage.add_square(2.0, (0.7, 0, -1), stage.emission((0, 0, 2)))
    material = stage.emission(RED)
    nodes, links = material.node_tree.nodes, material.node_tree.links
    mix, output = nodes.new("ShaderNodeMixShader"), next(n for n in nodes if n.bl_idname == "ShaderNodeOutputMaterial")
    mix.inputs[0].default_value = part
    links.new(next(n for n in nodes if n.bl_idname == "ShaderNodeEmission").outputs[0], mix.inputs[1])
    links.new(nodes.new("ShaderNodeHoldout").outputs[0], mix.inputs[2])
    links.new(mix.outputs[0], output.inputs["Surface"])
    stage.add_square(1.0, (0, 0, 0), material)
    scene.cycles.samples, scene.cycles.use_denoising = 4, False
    for scene.render.film_transparent in (False, True):
        pictures = []
        for scene.render.engine in ("CYCLES", "BENTLIGHT"):
            pictures.append(stage.render(tmp_path)["Combined"][[24, 24, 5], [32, 52, 5]])
        np.testing.assert_allclose(pictures[1], pictures[0], rtol=1e-5, atol=1e-6)


def test_a_layer_may_leave_out_sky_and_surfaces_and_override_the_material(tmp_path):
    scene = simple_scene()
    layer = scene.view_layers[0]
    layer.use_sky = False
    assert (stage.render(tmp_path)["Combined"][2, 2, :3] == 0).all()
    layer.use_sky = True
    layer.material_override = stage.emission((0, 0, 3), name="blue")
    assert stage.render(tmp_path)["Combined"][..., 2].max() == pytest.approx(3)
    layer.use_solid = False
    bpy.data.objects.remove(bpy.data.objects["Black Hole"])
    np.testing.assert_allclose(stage.render(tmp_path)["Combined"], np.broadcast_to((*GREEN, 1), (48, 64, 4)), rtol=1e-5)


def test_hidden_objects_and_ray_visibility(tmp_path):
    simple_scene()
    square, hole = bpy.data.objects["Square"], bpy.data.objects["Black Hole"]
    hole.hide_render = True
    assert stage.render(tmp_path)["Combined"][24, 32, 0] > 1
    square.visible_camera = False
    assert stage.render(tmp_path)["Combined"][24, 32, 0] < 1
    square.visible_camera, square.hide_render = True, True
    assert stage.render(tmp_path)["Combined"][24, 32, 0] < 1


def test_an_animation_renders_each_frame(tmp_path):
    scene = simple_scene()
    square = bpy.data.objects["Square"]
    for frame, x in ((1, -1.0), (3, 1.0)):
        square.location.x = x
        square.keyframe_insert("location", index=0, frame=frame)
        scene.bentlight.samples = frame
        scene.bentlight.keyframe_insert("samples", frame=frame)
    hole = bpy.data.objects["Black Hole"]
    hole.location = (-0.5, -0.8, 3)
    for frame, mass in ((1, 0.01), (3, 0.03)):
        hole.bentlight.mass = mass
        hole.bentlight.keyframe_insert("mass", frame=frame)
    stage.set_multilayer(scene)
    scene.view_layers[0].bentlight.use_pass_fate = True
    scene.frame_start, scene.frame_end = 1, 3
    scene.render.filepath = str(tmp_path / "frame_")
    with stage.counted_renders() as count:
        bpy.ops.render.render(animation=True)
    assert len(count) == 3
    frames = [stage.read_exr(tmp_path / f"frame_{i:04}.exr") for i in (1, 2, 3)]
    surface = [np.nonzero(f["ViewLayer.Bentlight Fate"] == 4)[1].mean() for f in frames]
    shadow = [(f["ViewLayer.Bentlight Fate"] == 2).sum() for f in frames]
    assert surface[0] + 2 < surface[1] < surface[2] - 2
    assert 3 * shadow[0] < shadow[2] and shadow[0] < shadow[1] < shadow[2]


def test_stereo_views_differ_by_parallax(tmp_path):
    scene = simple_scene()
    bpy.data.objects.remove(bpy.data.objects["Black Hole"])
    scene.render.use_multiview = True
    scene.render.views_format = "STEREO_3D"
    scene.camera.data.stereo.interocular_distance = 1.0
    stage.set_multilayer(scene)
    scene.render.image_settings.views_format = "MULTIVIEW"
    scene.render.filepath = str(tmp_path / "stereo.exr")
    with stage.counted_renders() as count:
        bpy.ops.render.render(write_still=True)
    assert count
    (path,) = tmp_path.glob("stereo*.exr")
    views = stage.read_exr(path)
    (left,) = (pixels for name, pixels in views.items() if name.endswith("left") and "Combined" in name)
    (right,) = (pixels for name, pixels in views.items() if name.endswith("right") and "Combined" in name)
    center = [np.nonzero(picture[24, :, 0] > 1)[0].mean() for picture in (left, right)]
    assert left.shape == right.shape == (48, 64, 4)
    assert center[0] != center[1]


def test_settings_reach_the_native_renderer():
    scene, layer = simple_scene(), bpy.context.view_layer
    user = scene.bentlight
    user.samples, user.seed, user.max_bounces, user.transparent_bounces = 33, 5, 7, 3
    user.tolerance, user.clamp_indirect, user.pixel_filter = 1e-3, 2.0, "GAUSSIAN"
    user.clamp_direct, user.light_threshold, user.portal_sampling = 3.0, 0.5, False
    user.blur_glossy, user.caustics_reflective, user.caustics_refractive = 1.0, False, False
    user.sky_filter = 0.5
    scene.render.filter_size, scene.render.film_transparent = 2.0, True
    found = final.render_settings(scene, layer, is_preview=False)
    assert (found.width, found.height, found.sample_count, found.seed) == (64, 48, 33, 5)
    assert {found.max_bounces, found.diffuse_bounces, found.glossy_bounces, found.transmission_bounces} == {7}
    assert (found.transparent_bounces, found.clamp_indirect, found.filter) == (3, 2.0, "GAUSSIAN")
    assert (found.clamp_direct, found.light_threshold, found.portal_sampling) == (3.0, 0.5, False)
    assert (found.blur_glossy, found.caustics_reflective, found.caustics_refractive) == (1.0, False, False)
    assert (found.filter_width, found.film_transparent) == (6.0, True)  # a Gaussian reaches three times as far
    assert found.tolerance == pytest.approx(1e-3)
    assert found.sky_filter == pytest.approx(0.5 / np.sqrt(33))
    assert (found.noise_threshold, found.min_samples) == (pytest.approx(0.01), 64)
    user.adaptive_min_samples, user.adaptive_threshold = 20, 0.1
    found = final.render_settings(scene, layer, is_preview=False)
    assert (found.noise_threshold, found.min_samples) == (pytest.approx(0.1), 20)
    user.use_adaptive_sampling = False
    assert final.render_settings(scene, layer, is_preview=False).noise_threshold == 0
    layer.samples = 9
    assert final.render_settings(scene, layer, is_preview=False).sample_count == 9


def test_a_time_limit_ends_a_render(tmp_path):
    scene = simple_scene()
    scene.bentlight.samples, scene.bentlight.use_adaptive_sampling = 1 << 22, False
    scene.bentlight.time_limit = 0.5
    start = time.monotonic()
    picture = stage.render(tmp_path)
    assert time.monotonic() - start < 5
    assert (picture["Combined"][..., :3].max(axis=-1) > 0).sum() > 40 * 60  # all tiles; the hole is black


def test_a_preview_of_a_material_is_quick():
    scene = simple_scene()
    scene.bentlight.samples, scene.bentlight.max_bounces = 4096, 64
    found = final.render_settings(scene, bpy.context.view_layer, is_preview=True)
    assert found.sample_count <= 32
    assert found.max_bounces <= 4


def test_bidirectional_says_where_it_is_not_possible(capfd, tmp_path):
    """A spinning hole: the picture is that of path tracing, and one line says why."""
    scene = simple_scene()
    pictures = {}
    for scene.bentlight.integrator in ("PATH", "BIDIRECTIONAL"):
        for obj in scene.objects:
            obj.bentlight.spin = 0.5
        pictures[scene.bentlight.integrator] = stage.render(tmp_path)["Combined"]
    assert np.array_equal(pictures["PATH"], pictures["BIDIRECTIONAL"])
    assert "".join(capfd.readouterr()).count("light is followed from the camera alone: a black hole spins") == 1
