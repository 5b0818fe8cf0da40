"""Use in Cycles and its undoing: what they change, what follows the holes, and what is made anew when it is missing."""

import json
import os
import shutil
import time

import bpy
import numpy as np
import objects
import pytest
import rendering

from blender_addon.cycles import files, lens, radius, setup, shaders
from blender_addon.report import RenderError
from blender_addon.ui import influence


@pytest.fixture(autouse=True)
def own_tables(tmp_path, monkeypatch):
    """Tables of this test alone."""
    folder = tmp_path / "tables"
    folder.mkdir()
    monkeypatch.setattr(files, "folder", lambda _name: folder)
    return folder


def add_hole(**settings) -> bpy.types.Object:
    bpy.ops.bentlight.black_hole_add(mass=0.1, location=(0, 0, 0), **settings)
    return bpy.context.object


def state(scene: bpy.types.Scene) -> dict:
    """All that a user could see of a scene, its settings of Cycles, and its datablocks."""
    settings = {p.identifier: getattr(scene.cycles, p.identifier) for p in scene.cycles.bl_rna.properties}
    settings = {name: str(value) for name, value in settings.items()}
    holes = {obj.name: obj.bentlight.lens_radius for obj in scene.objects}
    data = {kind: sorted(item.name for item in getattr(bpy.data, kind)) for kind in ("objects", "meshes", "materials")}
    return {"settings": settings, "holes": holes, "data": data, "before": scene.bentlight.cycles_before}


def node_of(scene: bpy.types.Scene) -> bpy.types.Node:
    (obj,) = lens.find(scene).values()
    return next(n for n in obj.data.materials[0].node_tree.nodes if n.bl_idname == "ShaderNodeScript")


def inputs_of(scene: bpy.types.Scene) -> dict:
    return {s.name: s.default_value for s in node_of(scene).inputs}


def test_clear_leaves_the_scene_as_it_was(scene):
    add_hole()
    objects.camera((0, -8, 0), (0, 0, 0))
    before = state(scene)
    assert bpy.ops.bentlight.cycles_setup() == {"FINISHED"}
    assert state(scene) != before
    assert bpy.ops.bentlight.cycles_setup() == {"FINISHED"}  # twice is as once
    assert len(lens.find(scene)) == 1
    assert bpy.ops.bentlight.cycles_clear() == {"FINISHED"}
    assert state(scene) == before


def test_a_radius_of_the_users_own_stays(scene):
    add_hole().bentlight.lens_radius = 1.25
    before = state(scene)
    bpy.ops.bentlight.cycles_setup()
    assert inputs_of(scene)["Radius"] == pytest.approx(12.5)
    bpy.ops.bentlight.cycles_clear()
    assert state(scene) == before


def test_settings_that_the_user_changed_since_stay(scene):
    add_hole()
    bpy.ops.bentlight.cycles_setup()
    scene.cycles.transparent_max_bounces = 77
    bpy.ops.bentlight.cycles_clear()
    assert scene.cycles.transparent_max_bounces == 77
    assert not scene.cycles.shading_system


def test_it_says_what_it_changed(scene):
    add_hole()
    depsgraph = bpy.context.evaluated_depsgraph_get()
    done, warnings = setup.setup(scene, depsgraph)
    bounces = scene.cycles.transparent_max_bounces
    assert done == ["lenses: 1", "Open Shading Language on", f"transparent bounces: {bounces}"]
    assert bounces > scene.cycles.max_bounces
    assert not warnings
    assert json.loads(scene.bentlight.cycles_before).keys() == {"shading_system", "transparent_max_bounces"}


def test_a_graphics_card_without_optix_is_left(scene):
    add_hole()
    scene.cycles.device = "GPU"
    done, _ = setup.setup(scene, bpy.context.evaluated_depsgraph_get())
    assert scene.cycles.device == "CPU"
    assert any("OptiX" in text for text in done)
    bpy.ops.bentlight.cycles_clear()
    assert scene.cycles.device == "GPU"


@pytest.mark.parametrize("problem", ["nothing there", "uneven scale", "no exit"])
def test_what_cannot_be_rendered_is_refused_and_changes_nothing(problem, scene):
    if problem == "uneven scale":
        add_hole().scale = (1, 2, 1)
    if problem == "no exit":
        add_hole().bentlight.kind = "WORMHOLE"
    bpy.context.view_layer.update()
    before = state(scene)
    with pytest.raises(RuntimeError, match={"nothing there": "no black hole"}.get(problem, "scale|exit")):
        bpy.ops.bentlight.cycles_setup()
    assert state(scene) == before


def test_the_lens_keeps_camera_and_meshes_outside_if_it_can(scene):
    hole = add_hole()
    objects.camera((0, -8, 0), (0, 0, 0))
    material = bpy.data.materials.new("Wall")
    objects.quad("Wall", (-9, 3, -9), (18, 0, 0), (0, 0, 18), material)
    bpy.ops.bentlight.cycles_setup()
    assert hole.bentlight.lens_radius == pytest.approx(0.95 * 3, rel=1e-5)
    bpy.ops.bentlight.cycles_clear()
    objects.box("Near", (0.5, 0, 0), (0.2, 0.2, 0.2), material)
    _, warnings = setup.setup(scene, bpy.context.evaluated_depsgraph_get())
    assert hole.bentlight.lens_radius == pytest.approx(0.8)
    (warning,) = warnings
    assert "Near" in warning and "Wall" not in warning
    assert radius.distances(scene, bpy.context.evaluated_depsgraph_get(), hole.location)["Near"] == pytest.approx(0.4)


@pytest.mark.parametrize("place", [(5, 5, 5), (0.7, 0.1, 0), (1, 2, 3)])
def test_lenses_that_touch_do_not_overlap_by_rounding(scene, place):
    holes = [add_hole(), add_hole()]
    holes[1].location = place
    bpy.context.view_layer.update()
    bpy.ops.bentlight.cycles_setup()
    apart = (holes[1].location - holes[0].location).length
    assert apart * (1 - 1e-5) < sum(hole.bentlight.lens_radius for hole in holes) <= apart


def test_the_sphere_of_influence_is_the_lens(scene):
    hole = add_hole()
    hole.bentlight.sphere_radius = 2.5
    bpy.ops.bentlight.cycles_setup()
    assert hole.bentlight.lens_radius == 0
    assert inputs_of(scene)["Radius"] == pytest.approx(25)


def test_lenses_follow_their_holes(scene):
    hole = add_hole()
    bpy.ops.bentlight.cycles_setup()
    (obj,) = lens.find(scene).values()
    hole.bentlight.mass, hole.location, hole.scale = 0.2, (1, 2, 3), (2, 2, 2)
    hole.bentlight.lens_radius = 4
    bpy.context.view_layer.update()
    assert inputs_of(scene)["Radius"] == pytest.approx(20)
    bpy.context.view_layer.update()
    assert np.array(obj.matrix_world)[:3, :3] == pytest.approx(8 * np.eye(3))
    assert obj.matrix_world.translation[:] == (1, 2, 3)
    hole.bentlight.spin = 0.5
    bpy.context.view_layer.update()
    assert inputs_of(scene)["Spin"] == 0.5
    assert inputs_of(scene)["Chart"] == 1
    hole.hide_render = True
    bpy.context.view_layer.update()
    assert obj.hide_render


def test_holes_that_come_and_go_have_lenses(scene):
    """Without another press of the button; what setting up changed is taken back in full all the same."""
    add_hole().bentlight.sphere_radius = 1
    own = scene.cycles.transparent_max_bounces
    bpy.ops.bentlight.cycles_setup()
    for_one = scene.cycles.transparent_max_bounces
    bpy.ops.bentlight.black_hole_add(mass=0.1, location=(5, 0, 0))
    second = bpy.context.object
    bpy.context.view_layer.update()
    assert set(lens.find(scene)) == {obj.name for obj in scene.objects if obj.bentlight.kind != "NONE"}
    assert scene.cycles.transparent_max_bounces - own == 2 * (for_one - own)
    bpy.data.objects.remove(second)
    bpy.context.view_layer.update()
    assert set(lens.find(scene)) == {obj.name for obj in scene.objects if obj.bentlight.kind != "NONE"}
    for hole in [obj for obj in scene.objects if obj.bentlight.kind != "NONE"]:
        bpy.data.objects.remove(hole)
    bpy.context.view_layer.update()
    assert not lens.find(scene)
    bpy.ops.bentlight.cycles_clear()
    assert scene.cycles.transparent_max_bounces == own


def test_every_frame_has_its_own_lens(scene, tmp_path):
    """In a background animation: each picture is that of its frame rendered alone."""
    hole = add_hole(spin=0.3)
    objects.camera((0, -3, 0), (0, 0, 0))
    objects.set_world((1, 1, 1))
    for frame, spin in ((1, 0.0), (3, 0.9)):
        hole.bentlight.spin = spin
        hole.bentlight.keyframe_insert("spin", frame=frame)
    bpy.ops.bentlight.cycles_setup()
    scene.render.resolution_x = scene.render.resolution_y = 48
    scene.frame_start, scene.frame_end = 1, 3
    scene.render.image_settings.file_format = "PNG"
    scene.render.filepath = str(tmp_path / "frame")
    spins = []

    def look(*_):
        spins.append(inputs_of(scene)["Spin"])

    bpy.app.handlers.render_post.append(look)
    try:
        bpy.ops.render.render(animation=True)
    finally:
        bpy.app.handlers.render_post.remove(look)
    assert spins == pytest.approx([0, 0.45, 0.9])
    frames = [_pixels(tmp_path / f"frame{frame:04}.png") for frame in (1, 2, 3)]
    assert (frames[0] != frames[2]).any()
    for frame in (3, 1):
        scene.frame_set(frame)
        scene.render.filepath = str(tmp_path / "still.png")
        bpy.ops.render.render(write_still=True)
        assert (_pixels(tmp_path / "still.png") == frames[frame - 1]).all()


def _pixels(path) -> np.ndarray:
    image = bpy.data.images.load(str(path))
    pixels = np.array(image.pixels)
    bpy.data.images.remove(image)
    return pixels


def test_a_file_opened_elsewhere_makes_its_tables_anew(scene, tmp_path, own_tables, monkeypatch):
    add_hole()
    objects.camera((0, -4, 0), (0, 0, 0))
    objects.set_world((1, 1, 1))
    bpy.ops.bentlight.cycles_setup()
    picture = rendering.render(scene, "CYCLES")
    node_of(scene).bytecode_hash = "of another version"
    node_of(scene).bytecode = "shader lens\n"
    path = tmp_path / "scene.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    shutil.rmtree(own_tables)
    monkeypatch.setattr(files, "folder", lambda _name: elsewhere)
    bpy.ops.wm.open_mainfile(filepath=str(path))
    scene = bpy.context.scene
    assert inputs_of(scene)["Total"].startswith(str(elsewhere))
    assert sorted(p.suffix for p in elsewhere.iterdir()) == [".exr", ".exr"]
    assert node_of(scene).bytecode == shaders.compiled("lens").code
    assert (rendering.render(scene, "CYCLES") == picture).all()
    assert (picture == 0).any() and (picture > 0).any()


def test_missing_and_damaged_tables_are_made_before_a_render(scene, own_tables):
    add_hole()
    objects.camera((0, -4, 0), (0, 0, 0))
    bpy.ops.bentlight.cycles_setup()
    for path in own_tables.iterdir():
        path.unlink()
    scene.render.resolution_x = scene.render.resolution_y = 8
    rendering.render(scene, "CYCLES")
    assert len(list(own_tables.iterdir())) == 2
    whole = {path: path.read_bytes() for path in own_tables.iterdir()}
    for path in whole:
        path.write_bytes(b"damaged")
    bpy.ops.bentlight.cycles_setup()
    assert {path: path.read_bytes() for path in own_tables.iterdir()} == whole


def test_a_folder_that_cannot_be_written_is_an_error(scene, monkeypatch, tmp_path):
    add_hole()
    before = state(scene)
    monkeypatch.setattr(files, "folder", lambda _name: tmp_path / "not there")
    with pytest.raises(RuntimeError, match="cannot be written"):
        bpy.ops.bentlight.cycles_setup()
    assert state(scene) == before


def test_files_that_nobody_asks_for_are_removed_after_a_month(own_tables):
    pixels = np.zeros((3, 2, 2, 1), np.float32) + np.arange(3)[:, None, None, None]
    first, second = (files.named_by_content("colors", each) for each in pixels[:2])
    other = files.named_by_content("sky", pixels[0])
    month_ago = time.time() - 32 * 24 * 3600
    for path in (first, second, other):
        os.utime(path, (month_ago, month_ago))
    assert files.named_by_content("colors", pixels[0]) == first
    third = files.named_by_content("colors", pixels[2])
    assert sorted(own_tables.iterdir()) == sorted([first, third, other])
    with pytest.raises(RenderError, match="cannot be written"):
        shutil.rmtree(own_tables)
        files.named_by_content("colors", pixels[1])


def test_the_engine_does_not_see_lenses(scene):
    add_hole()
    objects.camera((0, -4, 0), (0, 0, 0))
    objects.set_world((1, 1, 1))
    before = rendering.render(scene, "BENTLIGHT", samples=4)
    scene.render.engine = "CYCLES"
    bpy.ops.bentlight.cycles_setup()
    assert (rendering.render(scene, "BENTLIGHT", samples=4) == before).all()


def test_the_shadow_is_opaque_and_the_sky_around_it_is_not(scene, tmp_path):
    """Film > Transparent: what the hole swallows hides what is composited behind it; bent rays to the sky do not."""
    import OpenEXR

    add_hole()
    objects.camera((0, -4, 0), (0, 0, 0))
    bpy.ops.bentlight.cycles_setup()
    scene.render.film_transparent = True
    settings = scene.render.image_settings
    settings.file_format, settings.color_mode, settings.color_depth = "OPEN_EXR", "RGBA", "32"
    scene.render.filepath = str(tmp_path / "film.exr")
    bpy.ops.render.render(write_still=True)
    alpha = OpenEXR.File(str(tmp_path / "film.exr"), separate_channels=True).channels()["A"].pixels
    assert alpha[32, 32] == 1
    assert alpha[0, 0] == 0
    assert set(np.unique(alpha)) == {0, 1}


def test_panels_tell_what_a_lens_leaves_out(scene):
    hole = add_hole()
    assert influence.describe_influence(hole, bpy.context.view_layer) == "Bends light everywhere, exactly"
    assert influence.describe_influence(hole, bpy.context.view_layer, lenses=True) == "Not set up for Cycles"
    for own, soft_edge, left_out in ((4, 0.0, "0.11"), (8, 0.0, "0.052"), (8, 0.5, "0.055")):
        hole.bentlight.lens_radius, hole.bentlight.lens_soft_edge = own, soft_edge
        text = influence.describe_influence(hole, bpy.context.view_layer, lenses=True)
        assert text == f"Bends light within {own}; leaves out up to {left_out} rad"
