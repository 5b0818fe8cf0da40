"""What Cycles does not show through lenses is told in the panel of warnings, for as long as it lasts."""

import bpy
import pytest

from blender_addon import checks
from blender_addon.cycles import failures, handlers, relay, setup, tables
from blender_addon.report import RenderError
from tests.engine import stage
from tests.engine.warned import add_hole, texts


@pytest.fixture
def hole():
    """With a lens of the radius 8, before a camera, in Cycles."""
    made = add_hole()
    made.bentlight.lens_radius = 8.0
    stage.add_camera(location=(0, -30, 0))
    bpy.context.scene.render.engine = "CYCLES"
    assert bpy.ops.bentlight.cycles_setup() == {"FINISHED"}
    assert texts() == []
    return made


def test_a_hole_that_lenses_cannot_show_any_more(hole):
    """Its own warning is enough, and it ends with the reason."""
    hole.scale = (1, 1, 2)
    assert texts() == ["Black hole 'Hole': its scale must be uniform and positive"]
    assert len(failures.of_scene(bpy.context.scene)) == 1
    hole.scale = (1, 1, 1)
    assert texts() == [] and failures.of_scene(bpy.context.scene) == ()


def test_tables_that_cannot_be_written_after_setting_up(hole, monkeypatch):
    """No finding of the scene itself tells this; the log does once."""

    def fail(_kind):
        raise RenderError("Deflection tables cannot be written: {}", "disk full")

    with monkeypatch.context() as patch:
        patch.setattr(tables, "ensured", fail)
        for mass in (2.1, 2.2):
            hole.bentlight.mass = mass
            (found,) = (texts(), checks.of_scene(bpy.context))[1]
            assert found.text == "Lenses for Cycles: Deflection tables cannot be written: disk full"
            assert (found.kind, found.owner) == ("SCENE", "Scene")
        bpy.context.scene.render.engine = "BENTLIGHT"
        assert texts() == []  # which needs no lens
        bpy.context.scene.render.engine = "CYCLES"
        assert len(texts()) == 1
    hole.bentlight.mass = 2.3
    assert texts() == []


@pytest.mark.parametrize("undo", [bpy.ops.bentlight.cycles_clear, lambda: handlers._on_load("")])
def test_failures_end_with_what_failed(hole, undo):
    failures.remember(bpy.context.scene, "lenses", "as it was")
    hole.location.x = 1
    assert texts() == []  # lenses were made anew, and nothing failed
    failures.remember(bpy.context.scene, "lenses", "as it was")
    assert [found.text for found in checks.of_scene(bpy.context)] == ["as it was"]
    undo()
    assert checks.of_scene(bpy.context) == []


def test_a_relay_camera_without_maps(hole, monkeypatch, tmp_path):
    scene = bpy.context.scene
    assert bpy.ops.bentlight.relay_setup(bake=False) == {"FINISHED"}

    def fail(*_):
        raise OSError("disk full")

    scene.cycles.samples = 1
    scene.render.resolution_x = scene.render.resolution_y = 8
    scene.render.filepath = str(tmp_path / "black.png")
    with monkeypatch.context() as patch:
        patch.setattr(relay, "update", fail)
        bpy.ops.render.render(write_still=True)
    said = "The relay camera has no maps, the picture stays black: disk full"
    assert said in texts()
    bpy.ops.bentlight.relay_clear()
    assert texts() == []


def test_a_graphics_card_without_optix_and_no_shading_language(hole, monkeypatch):
    """Chosen after setting up. (Tests have no graphics card: Blender renders on the CPU then.)"""
    cycles = bpy.context.scene.cycles
    cycles.device = "GPU"
    (text,) = texts()
    assert "without OptiX" in text
    monkeypatch.setattr(setup, "gpu_kind", lambda: "OPTIX")
    assert texts() == []
    cycles.shading_system = False
    (text,) = texts()
    assert text.startswith("Open Shading Language is off")
    bpy.ops.bentlight.cycles_clear()
    assert texts() == []


def test_meshes_and_disks_that_a_lens_leaves_out_later(hole):
    """As setting up says it, but for as long as it lasts: meshes move, disks grow."""
    cube = stage.add_square(1.0, (0, 0, 7), name="Tile")
    (text,) = texts()
    assert text.startswith("Inside the lens of 'Hole' (radius 8), and not seen bent: Tile.")
    for height, number in ((8.01, 0), (7.99, 1)):
        cube.location.z = height
        assert len(texts()) == number
    cube.rotation_euler.x = 0.5  # the near edge is at 7.75, the far one outside
    assert len(texts()) == 1
    cube.location.z = 9
    hole.bentlight.disk.enable = True
    hole.bentlight.disk.outer = 40
    (text,) = texts()
    assert text.startswith("The disk of 'Hole' reaches out of its lens")
    hole.bentlight.disk.emission = "IMAGE"
    (text,) = texts()
    assert "has no color ramp" in text
