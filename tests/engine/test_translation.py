"""What users are told can be translated: texts are whole, with places for names and numbers."""

import ast
from pathlib import Path

import bpy
import pytest

from blender_addon import report
from blender_addon.cycles.disk import warnings as disk_warnings
from blender_addon.report import RenderError, Reporter, told
from tests.engine.stage import add_camera, add_light, add_square, render

ADDON = Path(__file__).resolve().parents[2] / "blender_addon"
WORDS = {
    "Object '{}': its transform is not finite": "Objekt '{}': seine Lage ist nicht endlich",
    "{}, node '{}': {}": "{}, Knoten '{}': {}",
    "Material '{}'": "Werkstoff '{}'",
    "The disk of '{}' is not seen: it has no color ramp, image or material": (
        "Die Scheibe von '{}' fehlt: ohne Farbband, Bild oder Werkstoff"
    ),
    "The disk of '{}' only shines in Cycles; what scatters there is left out: {}": (
        "Die Scheibe von '{}' leuchtet nur in Cycles; es fehlt: {}"
    ),
    "'{}' is not supported yet; left out": "'{}' fehlt noch; ausgelassen",
    "{} % of the bent rays to lights were not found: of lamps without size that light is missing. Give them a size": (
        "{} % der krummen Strahlen zu Lampen fehlen: gib diesen eine Ausdehnung"
    ),
}


@pytest.fixture
def german(monkeypatch):
    """A user who reads German. (Blender as a Python module knows no languages.)"""
    monkeypatch.setattr(report, "pgettext_rpt", lambda text: WORDS.get(text, text))


def texts():
    """File, line and first text of every call that tells the user something."""
    for path in sorted(ADDON.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Call):
                name = getattr(node.func, "id", getattr(node.func, "attr", ""))
                if name in {"RenderError", "warn", "told"}:
                    yield from ((f"{path.name}:{node.lineno}", argument) for argument in node.args)


def test_no_text_is_put_together_before_it_is_translated():
    found = list(texts())
    assert len(found) > 100
    assert not [place for place, argument in found if isinstance(argument, ast.JoinedStr)]


def test_every_place_of_a_text_has_a_value():
    for path in sorted(ADDON.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text())):
            if not isinstance(node, ast.Call) or getattr(node.func, "id", "") not in {"RenderError", "told"}:
                continue
            if isinstance(node.args[0], ast.Constant):
                text = node.args[0].value
                assert text.count("{") == len(node.args) - 1, f"{path.name}:{node.lineno}: {text}"


def test_errors_and_warnings_are_told_in_the_users_language(german):
    said = []
    Reporter(lambda _, text: said.append(text)).warn("'{}' is not supported yet; left out", "Nebel")
    assert said == ["'Nebel' fehlt noch; ausgelassen"]
    assert str(RenderError("Object '{}': its transform is not finite", "Ball {")).startswith("Objekt 'Ball {'")
    assert told("no such text of anyone's {}", 3) == "no such text of anyone's 3" and told("") == ""


def test_what_cycles_does_not_show_is_told_in_the_users_language(german):
    bpy.ops.bentlight.black_hole_add()
    hole = bpy.context.object
    hole.name = "Loch"
    disk = hole.bentlight.disk
    disk.enable, disk.emission, disk.material = True, "MATERIAL", None
    assert disk_warnings(hole) == ["Die Scheibe von 'Loch' fehlt: ohne Farbband, Bild oder Werkstoff"]
    disk.material = bpy.data.materials.new("Staub")
    disk.material.use_nodes = True
    disk.material.node_tree.nodes.new("ShaderNodeBsdfDiffuse")
    assert disk_warnings(hole) == ["Die Scheibe von 'Loch' leuchtet nur in Cycles; es fehlt: Diffuse BSDF"]


def test_a_render_warns_in_the_users_language(german, tmp_path, capfd):
    add_camera()
    square = add_square(1.0, (0, 0, -3))
    material = bpy.data.materials.new("Wand")
    material.use_nodes = True
    tree = material.node_tree
    fog = tree.nodes.new("ShaderNodeVolumeScatter")
    output = next(node for node in tree.nodes if node.bl_idname == "ShaderNodeOutputMaterial")
    tree.links.new(fog.outputs[0], output.inputs["Volume"])
    square.data.materials.append(material)
    render(tmp_path)
    assert f"Werkstoff 'Wand', Knoten '{output.name}': 'Volume' fehlt noch" in "".join(capfd.readouterr())


def test_lost_light_is_told_in_the_users_language(german, tmp_path, capfd):
    add_camera((3, 0, 3))
    add_square(4.0, (3, 0, -2))
    add_light("POINT", (1.6, 0, 0), shadow_soft_size=0.0)
    bpy.ops.bentlight.black_hole_add()
    settings = bpy.context.object.bentlight
    settings.mass, settings.spin = 1.0, 0.999
    scene = bpy.context.scene
    scene.bentlight.samples, scene.bentlight.max_bounces = 1, 0
    scene.render.resolution_x = scene.render.resolution_y = 24
    render(tmp_path)
    assert " % der krummen Strahlen zu Lampen fehlen" in "".join(capfd.readouterr())
