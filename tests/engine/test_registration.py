"""Registering leaves no trace when it is undone; properties, operators and panels are what scripts rely on."""

import math
import subprocess
import sys
from pathlib import Path

import bpy
import pytest

import blender_addon
from blender_addon import compatibility, operators, properties, ui
from blender_addon.ui import influence
from tests.engine import stage


def our_panels() -> set[str]:
    return {panel.__name__ for panel in compatibility._panels() if "BENTLIGHT" in panel.COMPAT_ENGINES}


def everything_of_ours() -> dict[str, object]:
    found = {name for name in dir(bpy.types) if "bentlight" in name.lower()}
    return {
        "types": found,
        "operators": dir(bpy.ops.bentlight),
        "owners": [hasattr(owner, "bentlight") for owner in (bpy.types.Scene, bpy.types.Object, bpy.types.ViewLayer)],
        "panels": our_panels(),
        "menu": [
            f.__name__ for f in bpy.types.VIEW3D_MT_add._dyn_ui_initialize() if f.__module__ == operators.menus.__name__
        ],
    }


def test_register_and_unregister_are_clean_and_idempotent():
    registered = everything_of_ours()
    blender_addon.register()
    assert everything_of_ours() == registered
    blender_addon.unregister()
    gone = everything_of_ours()
    assert gone == {"types": set(), "operators": [], "owners": [False] * 3, "panels": set(), "menu": []}
    blender_addon.unregister()
    blender_addon.register()
    assert everything_of_ours() == registered
    assert registered["menu"] == ["_draw_add"]


def test_a_script_that_registers_comes_to_its_end():
    """Blender 4.5 as a module hangs at exit if operators are still registered after the file was reset."""
    script = (
        "import bpy, blender_addon; blender_addon.register(); bpy.ops.wm.read_factory_settings(use_empty=True); exit(7)"
    )
    root = Path(blender_addon.__file__).parents[1]
    assert subprocess.run([sys.executable, "-c", script], cwd=root, timeout=60).returncode == 7


def test_a_failing_registration_leaves_nothing(monkeypatch):
    blender_addon.unregister()

    def fail() -> None:
        raise RuntimeError("no")

    monkeypatch.setattr(ui, "register", fail)
    with pytest.raises(RuntimeError, match="no"):
        blender_addon.register()
    assert everything_of_ours()["types"] == set()
    monkeypatch.undo()
    blender_addon.register()
    assert everything_of_ours()["types"]


def test_blender_s_own_panels_show():
    expected = {
        "EEVEE_MATERIAL_PT_surface", "EEVEE_MATERIAL_PT_context_material", "EEVEE_WORLD_PT_surface",
        "MATERIAL_PT_preview", "DATA_PT_EEVEE_light", "DATA_PT_lens", "DATA_PT_camera", "WORLD_PT_context_world",
        "VIEWLAYER_PT_layer", "VIEWLAYER_PT_layer_passes", "RENDER_PT_format", "RENDER_PT_output",
        "RENDER_PT_color_management", "OBJECT_PT_visibility", "DATA_PT_uv_texture", "DATA_PT_context_light",
    }  # fmt: skip
    assert expected <= our_panels()
    assert not our_panels() & {"DATA_PT_light", "RENDER_PT_eevee_sampling", "RENDER_PT_eevee_film"}


def test_every_setting_says_what_it_is():
    for settings in properties._CLASSES:
        for item in settings.bl_rna.properties:
            if item.identifier not in {"rna_type", "name"}:
                assert item.name and len(item.description) > 20, item.identifier
    for panel in ui.CLASSES:
        assert panel.bl_label


def test_defaults_and_ranges():
    scene = bpy.context.scene.bentlight
    assert scene.is_property_set("samples") and not scene.is_property_set("max_bounces")
    assert (scene.max_bounces, scene.seed, scene.integrator) == (12, 0, "PATH")
    assert scene.tolerance == pytest.approx(1e-4)
    settings = bpy.data.objects.new("any", None).bentlight
    assert (settings.kind, settings.spin, settings.chart, settings.exit) == ("NONE", 0.0, "ISOTROPIC", None)
    settings.spin = 2.0
    assert settings.spin == pytest.approx(0.9999)
    settings.spin = -2.0
    assert settings.spin == pytest.approx(-0.9999)
    settings.mass = -1.0
    assert settings.mass == 0.0


def test_black_hole_add():
    bpy.ops.bentlight.black_hole_add(mass=0.3, spin=0.5, location=(1, 2, 3))
    hole = bpy.context.object
    assert hole.type == "EMPTY" and tuple(hole.location) == (1, 2, 3)
    assert hole.bentlight.kind == "BLACK_HOLE" and hole.bentlight.chart == "ISOTROPIC"
    assert (hole.bentlight.mass, hole.bentlight.spin) == pytest.approx((0.3, 0.5))
    outer_horizon = 0.3 * (1 + 0.75**0.5)
    assert hole.empty_display_size == pytest.approx((outer_horizon**2 + 0.15**2) ** 0.5)
    hole.bentlight.spin = 0
    assert hole.empty_display_size == pytest.approx(0.15)


def test_a_new_hole_is_as_large_as_the_meshes_that_blender_adds():
    """Seen from afar: a shadow of sqrt(27) masses, or a throat's own radius, beside a ball with a radius of 1."""
    bpy.ops.bentlight.black_hole_add(location=(0, 0, 0))
    assert 27**0.5 * bpy.context.object.bentlight.mass == pytest.approx(1.0, rel=0.05)
    bpy.context.object.bentlight.mass = 3.0
    bpy.ops.bentlight.spacetime_reset()
    assert 27**0.5 * bpy.context.object.bentlight.mass == pytest.approx(1.0, rel=0.05)
    bpy.ops.bentlight.wormhole_add(location=(9, 0, 0))
    assert bpy.context.object.bentlight.throat_radius == 1.0


def test_the_cursor_is_the_default_place():
    bpy.context.scene.cursor.location = (4, 5, 6)
    bpy.ops.bentlight.black_hole_add()
    assert tuple(bpy.context.object.location) == (4, 5, 6)
    bpy.ops.bentlight.wormhole_add(throat_radius=0.5)
    assert tuple(bpy.context.object.location) == (4, 5, 6)
    assert tuple(bpy.context.object.bentlight.exit.location) == (9, 5, 6)


def test_wormhole_add_makes_a_symmetric_pair():
    bpy.ops.bentlight.wormhole_add(throat_radius=0.5, location=(1, 0, 0), exit_location=(-1, 2, 0))
    entrance = bpy.context.object
    mouth = entrance.bentlight.exit
    assert tuple(entrance.location) == (1, 0, 0) and tuple(mouth.location) == (-1, 2, 0)
    assert mouth.bentlight.exit == entrance
    for end in (entrance, mouth):
        assert end.bentlight.kind == "WORMHOLE" and end.bentlight.throat_radius == 0.5
        assert end.empty_display_size == 0.25
        assert end.select_get()


def test_choosing_an_exit_makes_it_a_mouth():
    a, b = (stage.add_mesh(name, [(0, 0, 0)], []) for name in "ab")
    a.bentlight.kind, a.bentlight.throat_radius = "WORMHOLE", 0.7
    a.bentlight.exit = b
    assert b.bentlight.kind == "WORMHOLE" and b.bentlight.exit == a
    assert b.bentlight.throat_radius == pytest.approx(0.7)


def deflection(b: float) -> float:
    """In radians, of light that passes a hole without spin at the impact parameter b, in masses: Keeton and Petters,
    Physical Review D 72, 104006 (2005), up to terms of the fifth order."""
    return 4 / b + 15 * math.pi / 4 / b**2 + 128 / 3 / b**3 + 3465 * math.pi / 64 / b**4


def test_the_panel_tells_how_far_light_is_bent():
    bpy.ops.bentlight.black_hole_add(mass=0.1, location=(0, 0, 0))
    first = bpy.context.object
    layer = bpy.context.view_layer
    assert influence.describe_influence(first, layer) == "Bends light everywhere, exactly"
    bpy.ops.bentlight.black_hole_add(mass=0.2, location=(8, 0, 0))
    text = influence.describe_influence(first, layer)
    assert text == f"Bends light within 4; leaves out up to {deflection(40):.2g} rad"
    assert f"{deflection(20):.2g} rad" in influence.describe_influence(bpy.context.object, layer)
    bpy.context.object.bentlight.sphere_radius = 0.3  # within the photon sphere
    assert "leaves out rays that would fall in" in influence.describe_influence(bpy.context.object, layer)
    bpy.context.object.hide_render = True
    assert influence.describe_influence(bpy.context.object, layer) == "Not rendered"
