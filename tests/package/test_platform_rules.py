"""The rules of Blender's extension platform that the sources can be held to.

https://developer.blender.org/docs/features/extensions/moderation/guidelines/ and the manual's page on the manifest.
What the extension does to files and the network while it runs is watched by install_and_render.py.
"""

import ast
import re
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
ADDON = ROOT / "blender_addon"
SOURCES = sorted([*ADDON.rglob("*.py"), *(ROOT / "native" / "python").rglob("*.py")])
NETWORK = {"socket", "ssl", "urllib", "http", "requests", "ftplib", "smtplib", "xmlrpc", "asyncio", "webbrowser"}
PROCESSES = {"subprocess", "multiprocessing", "pty", "pip", "ensurepip", "ctypes"}
CALLS = {"exec", "eval", "compile", "__import__", "print"}
ATTRIBUTES = {
    *("os.environ", "os.putenv", "os.system", "os.popen", "os.fork", "sys.path", "sys.meta_path"),
    *("bpy.app.online_access", "bpy.utils.register_module", "bpy.ops.wm.url_open", "bpy.ops.preferences"),
}
TAGS = {
    *("3D View", "Add Curve", "Add Mesh", "Animation", "Bake", "Camera", "Compositing", "Development", "Game Engine"),
    *("Geometry Nodes", "Grease Pencil", "Import-Export", "Lighting", "Material", "Modeling", "Mesh", "Node", "Object"),
    *("Paint", "Pipeline", "Physics", "Render", "Rigging", "Scene", "Sculpt", "Sequencer", "System", "Text Editor"),
    *("Tracking", "User Interface", "UV"),
}
REGISTERED = {"Operator", "Panel", "Menu", "Header", "UIList", "PropertyGroup", "RenderEngine", "AddonPreferences"}


def trees():
    return {path: ast.parse(path.read_text()) for path in SOURCES}


def dotted(node):
    """`a.b.c` of an attribute, or ""."""
    if isinstance(node, ast.Name):
        return node.id
    base = dotted(node.value) if isinstance(node, ast.Attribute) else ""
    return f"{base}.{node.attr}" if base else ""


def forbidden(tree):
    """What a module imports, calls or touches that an extension must not."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and not node.level:
            names = [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
        else:
            names = []
        yield from (name for name in names if name.split(".")[0] in NETWORK | PROCESSES or name in ATTRIBUTES)
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in CALLS:
            yield node.func.id
        if isinstance(node, ast.Attribute):
            name = dotted(node)
            yield from (bad for bad in ATTRIBUTES if name == bad)


@pytest.mark.parametrize(
    "code",
    ["import socket", "from urllib import request", "os.environ['A'] = 'b'", "sys.path.insert(0, '')", "eval('1')"],
)
def test_what_is_forbidden_is_found(code):
    assert list(forbidden(ast.parse(code)))


def test_no_network_no_processes_no_environment():
    for path, tree in trees().items():
        assert not list(forbidden(tree)), path.relative_to(ROOT)


def test_it_never_names_its_own_place():
    """The repository that it is installed in decides its module's name: `__package__` knows it."""
    for path in SOURCES:
        assert "bl_ext" not in path.read_text(), path.relative_to(ROOT)


def test_registered_classes_carry_its_name():
    found = set()
    for path, tree in trees().items():
        for node in ast.walk(tree):
            bases = {dotted(base) for base in getattr(node, "bases", ())}
            if any(base == f"bpy.types.{kind}" for base in bases for kind in REGISTERED):
                found.add(node.name)
                assert node.name.lower().startswith("bentlight"), f"{path.relative_to(ROOT)}: {node.name}"
    assert len(found) > 30


def test_operators_and_panels_are_under_its_name():
    names = [
        node.value.value
        for tree in trees().values()
        for node in ast.walk(tree)
        if isinstance(node, ast.Assign)
        and isinstance(node.value, ast.Constant)
        and dotted(node.targets[0]) == "bl_idname"
    ]
    assert len(names) > 10
    assert not [name for name in names if not re.match(r"bentlight\.|BENTLIGHT_|BENTLIGHT$", name)]


def test_the_manifest_is_as_the_platform_wants_it():
    manifest = tomllib.loads((ADDON / "blender_manifest.toml").read_text())
    assert re.fullmatch(r"\d+\.\d+\.\d+", manifest["version"])
    assert 0 < len(manifest["tagline"]) <= 64 and manifest["tagline"][-1].isalnum()
    assert set(manifest["tags"]) <= TAGS
    assert set(manifest["permissions"]) == {"files"}, "the one that it needs"
    assert all(0 < len(why) <= 64 and why[-1].isalnum() for why in manifest["permissions"].values())
    assert all(re.fullmatch(r"\d{4}(-\d{4})? \S.*", line) for line in manifest["copyright"])


def test_nothing_made_or_hidden_is_among_the_sources():
    names = [path.name for path in ADDON.rglob("*") if "__pycache__" not in path.parts and path.is_file()]
    assert not [name for name in names if name.startswith(".") or Path(name).suffix not in {".py", ".toml"}]
