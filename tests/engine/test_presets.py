"""Presets make what they are named after, can be rendered, and leave nothing behind; resets undo everything."""

from pathlib import Path

import bpy
import pytest

import blender_addon
from blender_addon.operators import preset
from tests.engine import stage

FILES = {path.stem: path for path in Path(blender_addon.__file__).parent.glob(f"presets/{preset.FOLDER}/*.py")}


@pytest.fixture
def hole():
    bpy.ops.bentlight.black_hole_add(mass=0.5, location=(0, 0, 0))
    return bpy.context.object


def apply(name: str) -> None:
    menu = preset.BENTLIGHT_MT_spacetime_presets.__name__
    assert bpy.ops.script.execute_preset(filepath=str(FILES[name]), menu_idname=menu) == {"FINISHED"}


def test_blender_finds_those_that_are_asked_for():
    (folder,) = bpy.utils.preset_paths(preset.FOLDER)
    assert {path.stem for path in Path(folder).glob("*.py")} == set(FILES)
    assert set(FILES) == {"Gargantua", "Schwarzschild_Room", "Stellar_Mass", "Wormhole"}
    blender_addon.unregister()
    assert bpy.utils.preset_paths(preset.FOLDER) == []
    blender_addon.register()


def test_gargantua(hole):
    apply("Gargantua")
    settings = hole.bentlight
    assert (settings.kind, settings.mass, settings.disk.enable) == ("BLACK_HOLE", 0.5, True)
    assert settings.spin == pytest.approx(0.6)  # as in James et al., Classical and Quantum Gravity 32, 065001 (2015)
    assert settings.disk.doppler == settings.disk.gravitational == 0


def test_schwarzschild_room(hole):
    apply("Gargantua")
    apply("Schwarzschild_Room")
    settings = hole.bentlight
    assert (settings.kind, settings.spin, settings.chart, settings.disk.enable) == ("BLACK_HOLE", 0, "ISOTROPIC", False)
    assert settings.mass == pytest.approx(0.1)


def test_stellar_mass(hole):
    apply("Stellar_Mass")
    disk = hole.bentlight.disk
    assert (disk.enable, disk.emission, disk.doppler, disk.gravitational) == (True, "PAGE_THORNE", 1, 1)
    assert disk.temperature == 1e7


def test_wormhole(hole):
    hole.scale = (2, 2, 2)
    bpy.context.view_layer.update()
    apply("Wormhole")
    mouth = hole.bentlight.exit
    assert hole.bentlight.kind == mouth.bentlight.kind == "WORMHOLE" and mouth.bentlight.exit == hole
    assert tuple(mouth.location) == (20, 0, 0) and tuple(mouth.scale) == (2, 2, 2)
    apply("Wormhole")
    assert hole.bentlight.exit == mouth and len(bpy.context.scene.objects) == 2


@pytest.mark.parametrize("name", sorted(FILES))
def test_every_preset_renders(hole, name, tmp_path):
    stage.add_camera(location=(0, 0, 30))
    stage.set_world((1, 1, 1))
    bpy.context.scene.bentlight.samples = 1
    apply(name)
    passes = stage.render(tmp_path)
    assert passes["Combined"].max() > 0


def test_saved_values_are_the_user_s_settings(hole):
    add = preset.BENTLIGHT_OT_spacetime_preset_add
    for line in add.preset_values:
        owner = hole.bentlight.disk if line.startswith("hole.disk.") else hole.bentlight
        assert hasattr(owner, line.rpartition(".")[2]), line
    users = {item.identifier for item in hole.bentlight.disk.bl_rna.properties if item.type != "POINTER"}
    saved = {line.rpartition(".")[2] for line in add.preset_values if line.startswith("hole.disk.")}
    assert users - {"name"} == saved


def is_default(settings, name: str) -> bool:
    item = settings.bl_rna.properties[name]
    value = getattr(settings, name)
    if item.type == "POINTER":
        return value is None
    return tuple(value) == tuple(item.default_array) if getattr(item, "is_array", False) else value == item.default


def test_reset_of_a_hole(hole):
    apply("Stellar_Mass")
    hole.bentlight.sphere_radius, hole.bentlight.chart = 3.0, "OBLATE"
    hole.bentlight.disk.emission = "RAMP"
    bpy.ops.bentlight.spacetime_reset()
    assert hole.bentlight.kind == "BLACK_HOLE" and hole.empty_display_size == pytest.approx(0.1)
    for name in ("mass", "spin", "chart", "throat_radius", "sphere_radius"):
        assert is_default(hole.bentlight, name), name
    for item in hole.bentlight.disk.bl_rna.properties:
        assert item.identifier in {"rna_type", "name"} or is_default(hole.bentlight.disk, item.identifier), item.name


def test_reset_of_a_mouth_keeps_the_wormhole():
    bpy.ops.bentlight.wormhole_add(throat_radius=0.3, location=(0, 0, 0))
    mouth = bpy.context.object
    bpy.ops.bentlight.spacetime_reset()
    other = mouth.bentlight.exit
    assert mouth.bentlight.throat_radius == other.bentlight.throat_radius == 1.0
    assert mouth.empty_display_size == other.empty_display_size == 0.5


def test_reset_of_rendering_and_stars():
    scene = bpy.context.scene
    settings = scene.bentlight
    settings.samples, settings.accuracy, settings.integrator, settings.overlay.ray_count = (
        7,
        "CUSTOM",
        "BIDIRECTIONAL",
        3,
    )
    bpy.ops.bentlight.render_reset()
    assert (settings.samples, settings.accuracy, settings.integrator) == (128, "PRODUCTION", "PATH")
    assert settings.overlay.ray_count == 3  # of the viewport, not of a render
    assert not bpy.ops.bentlight.stars_reset.poll()
    world = stage.set_world((0, 0, 0))
    world.bentlight.stars, world.bentlight.star_rotation = "PROCEDURAL", (1, 2, 3)
    bpy.ops.bentlight.stars_reset()
    assert world.bentlight.stars == "OFF" and tuple(world.bentlight.star_rotation) == (0, 0, 0)
