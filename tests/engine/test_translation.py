"""What users are told can be translated: texts are whole, with places for names and numbers."""

import ast
import re
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


TRANSLATING = {"RenderError", "told", "rpt_", "iface_", "pgettext_rpt", "pgettext_iface"}


def name_of(call: ast.Call) -> str:
    return getattr(call.func, "id", getattr(call.func, "attr", ""))


def raw_words(node: ast.AST) -> list[str]:
    """Words written in an expression that no translator is shown; the engine's own name is not translated."""
    if isinstance(node, ast.Call) and name_of(node) in TRANSLATING:
        return []
    if isinstance(node, ast.Constant):
        is_word = isinstance(node.value, str) and any(c.isalpha() for c in node.value) and node.value != "Bentlight"
        return [node.value] if is_word else []
    return [word for child in ast.iter_child_nodes(node) for word in raw_words(child)]


def shown():
    """File, line and expression of every text that operators report, and that a render's status line shows."""
    for path in sorted(ADDON.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Call) and name_of(node) in {"report", "update_stats"}:
                where = f"{path.name}:{node.lineno}"
                yield from ((where, text) for text in node.args[1 if name_of(node) == "report" else 0 :])
            if isinstance(node, ast.FunctionDef) and node.name == "_work":  # relay_operators report what it returns
                yield from ((f"{path.name}:{n.lineno}", n.value) for n in ast.walk(node) if isinstance(n, ast.Return))


def test_what_words_are_raw():
    for raw in ('"Done: " + text', 'f"Sample {n}"', '"a" if x else told("b")', '"{} left".format(n)'):
        assert raw_words(ast.parse(raw, mode="eval")), raw
    for whole in ('told("Sample {}", n)', 'f"{a} {b}".strip()', '"; ".join(done)', '"Bentlight"', "str(error)"):
        assert not raw_words(ast.parse(whole, mode="eval")), whole


def test_reports_and_status_lines_are_translated():
    found = list(shown())
    assert len(found) > 20
    assert not [(place, raw_words(text)) for place, text in found if raw_words(text)]


def test_operators_report_in_the_users_language(monkeypatch, capfd):
    """Every text that a translator is shown comes back between marks: a report is such a text, whole."""
    monkeypatch.setattr(report, "pgettext_rpt", lambda text: f"<{text}>")
    add_camera(location=(0, -9, 0))
    bpy.context.scene.render.engine = "CYCLES"
    operators, suns = bpy.ops.bentlight, 10.0
    assert operators.black_hole_add(mass=0.1) == {"FINISHED"}
    capfd.readouterr()
    for operator in (operators.cycles_setup, operators.cycles_clear, operators.relay_clear):
        assert operator() == {"FINISHED"}
    assert operators.relay_setup(bake=False) == operators.relay_clear() == {"FINISHED"}
    assert operators.unit_scale_fit(suns=suns) == {"FINISHED"}
    assert operators.object_select(name="nobody") == operators.material_select(name="nothing") == {"CANCELLED"}
    said = re.findall(r"^(?:Info|Warning|Error): (.*)$", "".join(capfd.readouterr()), re.MULTILINE)
    assert len(said) == 8
    assert all(text.startswith("<") and text.endswith(">") for text in said), said


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
