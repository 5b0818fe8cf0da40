"""What panels say: every setting's tooltip, words that can be translated, and what is left of them after all is gone.

That they are drawn without an error is tested in the true window.
"""

import ast
import re
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace

import bpy
import pytest

import blender_addon
from blender_addon import changes, properties, ui
from blender_addon.operators import menus
from blender_addon.ui import camera, influence, object, render, view_layer, warnings
from tests.engine import stage
from tests.engine.paper import REGION, Paper

ADDON = Path(blender_addon.__file__).parent
UNITS = (
    r"mass|radian|kelvin|second|kilometer|suns|pixel|magnitude|angle|fraction|part|power|factor|times|how (often|many)"
)


def settings() -> list[bpy.types.Property]:
    """All that users see."""
    return [
        item
        for group in properties._CLASSES
        for item in group.bl_rna.properties
        if item.identifier not in {"rna_type", "name"} and not item.is_hidden
    ]


def test_tooltips_of_numbers_tell_unit_and_range():
    for item in settings():
        if item.type not in {"INT", "FLOAT"}:
            continue
        if item.type == "FLOAT" and item.unit == "NONE" and item.subtype != "FACTOR":
            assert re.search(UNITS, item.description + item.name, re.IGNORECASE), item.identifier
        if item.subtype != "EULER":
            assert re.search(r"\d", item.description), item.identifier
        assert item.description[0].isupper() and not item.description.endswith("."), item.identifier


# What a picture, or the drawing in a viewport, is like.
LOOKS = (
    r"\b(grain|nois|clean|picture|flicker|dark|bright|black|red|blue|color|hue|shadow|edge|sharp|smooth|blur|ghost|"
    r"seen|sees|see |shows?\b|drawn|pattern|looks?|image|shin|glow|fade|kink|straight|caustic|lines|circles|"
    r"transparent|streak|places|ring)"
)


def operator_settings() -> Iterator[bpy.types.Property]:
    """All that users see of operators that they call."""
    for cls in bpy.types.Operator.__subclasses__():
        if cls.__module__.startswith("blender_addon") and "INTERNAL" not in cls.bl_options:
            group, name = cls.bl_idname.split(".")
            own = getattr(getattr(bpy.ops, group), name).get_rna_type().properties
            yield from (item for item in own if item.identifier != "rna_type")


def test_tooltips_tell_what_it_looks_like():
    """In words of what is seen; those of choices count."""
    theirs = {"mass_kilograms", "horizon_kilometers", "mass_suns", "star_catalog", "time_limit", "relay_source"}
    missing = []
    for item in settings():
        if item.identifier in theirs:  # what is seen stays as it is, or is the scene's own
            continue
        choices = [choice.description for choice in item.enum_items] if item.type == "ENUM" else []
        if not re.search(LOOKS, " ".join([item.description, *choices]), re.IGNORECASE):
            missing.append(item.identifier)
    assert not missing


def test_tooltips_of_operators_numbers_tell_what_they_look_like_and_their_range():
    found = [item for item in operator_settings() if item.type in {"INT", "FLOAT"} and item.array_length == 0]
    assert {item.identifier for item in found} == {"mass", "spin", "throat_radius", "suns"}
    for item in found:
        assert re.search(r"\d", item.description) and re.search(LOOKS, item.description), item.identifier
    assert all(len(item.description) > 15 for item in operator_settings())


def test_lengths_angles_and_the_like_have_blender_s_units():
    expected = {
        "mass": "LENGTH", "throat_radius": "LENGTH", "sphere_radius": "LENGTH", "lens_radius": "LENGTH",
        "temperature": "TEMPERATURE", "time_limit": "TIME_ABSOLUTE", "star_rotation": "ROTATION",
    }  # fmt: skip
    assert {
        item.identifier: item.unit for item in settings() if item.type == "FLOAT" and item.unit != "NONE"
    } == expected


def test_sliders_of_beginners_end_where_it_is_still_safe():
    """Nobody drags a number to where a render takes for ever or shows nothing."""
    limits = {item.identifier: (item.soft_min, item.soft_max) for item in settings() if item.type in {"INT", "FLOAT"}}
    assert limits["spin"] == pytest.approx((-0.998, 0.998))
    assert limits["tolerance"] == pytest.approx((1e-8, 0.01))
    assert limits["samples"][1] <= 4096 and limits["mass"][1] <= 10 and limits["ray_count"][1] <= 64


def test_every_choice_is_explained():
    for item in settings():
        for choice in item.enum_items if item.type == "ENUM" else ():
            assert choice.name and choice.description, (item.identifier, choice.identifier)


def test_operators_and_panels_have_names_and_tooltips():
    ours = [
        cls
        for kind in (bpy.types.Operator, bpy.types.Panel, bpy.types.Menu)
        for cls in kind.__subclasses__()
        if cls.__module__.startswith("blender_addon")
    ]
    assert len(ours) > 30
    for cls in ours:
        assert cls.bl_label, cls.__name__
        description = getattr(cls, "bl_description", "") or cls.__doc__
        assert description and len(description) > 15, cls.__name__
        assert issubclass(cls, bpy.types.Panel) or not description.rstrip().endswith("."), cls.__name__


def menu_layout(found: set[str]) -> SimpleNamespace:
    """Collects the operators and submenus that are drawn on it."""
    return SimpleNamespace(
        separator=lambda: None,
        operator=lambda name, **_: found.add(name),
        menu=lambda name, **_: found.add(name),
    )


def menu_entries(menu: str, engine: str) -> set[str]:
    """Operators and submenus that we add to one of Blender's menus."""
    found: set[str] = set()
    layout = menu_layout(found)
    for draw in getattr(bpy.types, menu)._dyn_ui_initialize():
        if draw.__module__.startswith("blender_addon"):
            draw(SimpleNamespace(layout=layout), SimpleNamespace(engine=engine))
    return found


def test_what_users_do_is_in_menus_where_f3_finds_it():
    added = menu_entries("VIEW3D_MT_add", "BENTLIGHT")
    done = menu_entries("VIEW3D_MT_object", "BENTLIGHT")
    assert added == {"bentlight.black_hole_add", "bentlight.wormhole_add"}
    assert done == {"BENTLIGHT_MT_spacetime"}
    cycles = menu_entries("TOPBAR_MT_render", "CYCLES") - menu_entries("TOPBAR_MT_render", "BENTLIGHT")
    assert cycles == {f"bentlight.{name}" for name in ("cycles_setup", "cycles_clear", "relay_setup", "relay_clear")}
    drawn: set[str] = set()
    menus.BENTLIGHT_MT_spacetime.draw(SimpleNamespace(layout=menu_layout(drawn)), bpy.context)
    for menu in ("VIEW3D_MT_add", "TOPBAR_MT_render"):
        drawn |= menu_entries(menu, "BENTLIGHT") | menu_entries(menu, "CYCLES")
    ours = [cls for cls in bpy.types.Operator.__subclasses__() if cls.__module__.startswith("blender_addon")]
    assert {cls.bl_idname for cls in ours if "INTERNAL" not in cls.bl_options} <= drawn


@pytest.fixture
def dummy_language(monkeypatch):
    """Where every text begins with a sign of its own. (The wheels have no languages.)"""
    for module in (camera, influence, object, render):
        monkeypatch.setattr(module, "iface_", lambda text: "¤" + text)


def test_a_translation_reaches_what_panels_write(dummy_language):
    stage.add_camera(location=(0, -9, 0))
    bpy.ops.bentlight.black_hole_add(mass=1.0, location=(0, 0, 0))
    bpy.context.object.bentlight.disk.enable = True
    hole = bpy.context.object
    bpy.context.view_layer.update()
    context = SimpleNamespace(
        scene=bpy.context.scene, view_layer=bpy.context.view_layer, object=hole, engine="BENTLIGHT", region=REGION
    )
    panels = {
        render.BENTLIGHT_PT_sampling: f"¤Within {1e-4 / (36 / 50 / 64):.2g} pixels",
        object.BENTLIGHT_PT_scale: "¤Drawn with radius 0.5",
        object.BENTLIGHT_PT_disk: "¤6.000 masses",
        camera.BENTLIGHT_PT_camera: None,
    }
    for cls, expected in panels.items():
        context.object = bpy.context.scene.camera if cls is camera.BENTLIGHT_PT_camera else hole
        found = Paper().of(cls, context)
        assert found and all(text.startswith("¤") for text in found), cls
        assert expected is None or expected in found
    for lenses in (False, True):
        assert influence.describe_influence(hole, bpy.context.view_layer, lenses).startswith("¤")


def test_all_labels_are_words_that_can_be_found_and_translated():
    """A label is a literal, or was translated before something was put into it."""
    files = [*ADDON.glob("ui/*.py"), *ADDON.glob("operators/*.py"), *ADDON.glob("cycles/*operators.py")]
    assert len(files) > 12
    for path in files:
        for call in ast.walk(ast.parse(path.read_text())):
            if not isinstance(call, ast.Call) or getattr(call.func, "attr", "") != "label":
                continue
            words = {keyword.arg: keyword.value for keyword in call.keywords}
            literal = isinstance(words.get("text", ast.Constant("")), ast.Constant)
            assert literal or "translate" in words, f"{path.name}:{call.lineno}"


def test_words_on_buttons_can_be_found_and_translated():
    """Blender translates what it is given whole: no word is put together, none is a number's format."""
    for path in [*ADDON.glob("ui/*.py"), *ADDON.glob("operators/*.py")]:
        for call in ast.walk(ast.parse(path.read_text())):
            if not isinstance(call, ast.Call) or getattr(call.func, "attr", "") not in {
                "prop",
                "operator",
                "menu",
                "row",
            }:
                continue
            for text in (keyword.value for keyword in call.keywords if keyword.arg in {"text", "heading"}):
                parts = [text.body, text.orelse] if isinstance(text, ast.IfExp) else [text]
                assert all(isinstance(part, ast.Constant | ast.Name) for part in parts), f"{path.name}:{call.lineno}"


def test_where_the_camera_is():
    """8.5 from an isotropic hole of mass 1: r = 8.5 (1 + 1/17)^2."""
    camera_object = stage.add_camera(location=(0, -8.5, 0))
    bpy.ops.bentlight.black_hole_add(mass=1.0, location=(0, 0, 0))
    bpy.context.view_layer.update()
    context = SimpleNamespace(view_layer=bpy.context.view_layer, object=camera_object, region=REGION)
    (text,) = Paper().of(camera.BENTLIGHT_PT_camera, context)
    assert text == f"{8.5 * (1 + 1 / 17) ** 2:.4g} masses from 'Black Hole'"


def test_warnings_wrap_and_are_counted():
    paper = Paper()
    long = warnings.Finding("word " * 40, "OBJECT", "any")
    warnings.draw_findings(paper, [long] * 15, width=300.0)
    lines = [text for text, _ in paper.labels]
    assert max(map(len, lines)) < 40 and lines[-1] == "+ 3"


def test_changes_are_counted_and_nothing_listens_afterwards():
    before = changes.count()
    bpy.context.scene.frame_set(5)
    bpy.context.view_layer.update()
    assert changes.count() > before
    blender_addon.unregister()
    for event in changes._EVENTS:
        assert not [f for f in getattr(bpy.app.handlers, event) if f.__module__.startswith("blender_addon.changes")]
    assert changes._listeners == []
    count = changes.count()
    bpy.context.scene.frame_set(6)
    assert changes.count() == count
    blender_addon.register()


def test_panels_show_for_their_engines_only():
    stage.add_camera()
    bpy.ops.bentlight.black_hole_add(mass=1.0, location=(0, 0, 5))
    shown = {}
    for engine in ("BENTLIGHT", "CYCLES", "BLENDER_WORKBENCH"):
        context = SimpleNamespace(
            engine=engine, scene=bpy.context.scene, view_layer=bpy.context.view_layer, object=bpy.context.object,
            camera=bpy.context.scene.camera.data, world=None, material=None,
            evaluated_depsgraph_get=bpy.context.evaluated_depsgraph_get,
        )  # fmt: skip
        shown[engine] = {
            cls.__name__.removeprefix("BENTLIGHT_PT_")
            for cls in ui.CLASSES
            if not hasattr(cls, "poll") or cls.poll(context)
        }
    assert shown["BLENDER_WORKBENCH"] == {"overlay"}
    assert {"spacetime", "scale", "cycles", "overlay"} <= shown["CYCLES"] and "sampling" not in shown["CYCLES"]
    assert {"sampling", "light_paths", "spacetime", "disk", "scale", "camera", "overlay"} <= shown["BENTLIGHT"]


def test_vector_is_gray_where_motion_blur_leaves_it_zero():
    """Blender blurs a layer if its scene and the layer itself say so."""
    scene, layer = bpy.context.scene, bpy.context.view_layer
    rows: dict[str, SimpleNamespace] = {}

    def row() -> SimpleNamespace:
        made = SimpleNamespace(active=True)
        made.prop = lambda _owner, name, **_options: rows.__setitem__(name, made)
        return made

    drawn = SimpleNamespace(column=lambda: SimpleNamespace(row=row), layout=Paper())
    for scene.render.use_motion_blur in (False, True):
        for layer.use_motion_blur in (False, True):
            view_layer.BENTLIGHT_PT_passes.draw(drawn, bpy.context)
            is_blurred = scene.render.use_motion_blur and layer.use_motion_blur
            assert rows["use_pass_vector"].active is not is_blurred and rows["use_pass_z"].active
