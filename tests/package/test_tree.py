"""The order of the source tree: who may know whom, sizes, headers that stand alone, and docs that name what exists."""

import ast
import re
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
FOLDERS = ("blender_addon", "osl", "native", "tests", "examples", "docs", ".ci")
CODE = {".py", ".pyi", ".c", ".h", ".osl", ".sh", ".md", ".txt", ".toml"}
HEADERS = sorted((ROOT / "native" / "include").rglob("*.h"))
BLENDER = {"bpy", "bpy_extras", "bmesh", "gpu", "mathutils", "blf", "_cycles"}


def source_files(*suffixes):
    """The text files of the tree, as a checkout of it holds them."""
    files = [ROOT / name for name in ("README.md", "Makefile", "pyproject.toml", ".gitignore")]
    for folder in FOLDERS:
        files += [path for path in (ROOT / folder).rglob("*") if path.is_file() and "__pycache__" not in path.parts]
    return [path for path in files if not suffixes or path.suffix in suffixes]


def python_imports(path):
    """The dotted names of the modules that a Python file imports, relative ones with their dots."""
    names = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            names.add("." * node.level + (node.module or ""))
    return names


def c_includes(path):
    """The headers that a C file includes, as written, with their quotes or angle brackets."""
    return set(re.findall(r'^\s*#\s*include\s*(["<][^">]+[">])', path.read_text(), re.MULTILINE))


def within(folder, *suffixes):
    return [path for path in source_files(*suffixes) if path.is_relative_to(ROOT / folder)]


def test_the_core_package_knows_no_blender():
    for path in within("native/python", ".py"):
        modules = {name.split(".")[0] for name in python_imports(path)}
        assert not modules & (BLENDER | {"blender_addon"}), path


def test_the_addon_reaches_the_core_by_its_package_alone():
    for path in within("blender_addon", ".py"):
        names = python_imports(path)
        assert not [name for name in names if name.startswith("bentlight_native.")], path
        assert "blender_addon" not in {name.split(".")[0] for name in names}, f"{path}: installed, it has another name"


@pytest.mark.parametrize("name", ["scene_data", "native", "sky"])
def test_plain_data_of_the_sync_knows_no_blender(name):
    path = ROOT / "blender_addon" / "sync" / f"{name}.py"
    assert not {module.split(".")[0] for module in python_imports(path)} & BLENDER


def test_the_core_knows_no_python():
    for path in within("native/src", ".c", ".h") + within("native/include", ".h"):
        if not path.is_relative_to(ROOT / "native/src/python"):
            known = [name for name in c_includes(path) if "python" in name.lower()]
            assert not known, path


def test_public_headers_know_each_other_alone():
    for path in HEADERS:
        private = [name for name in c_includes(path) if name[0] == '"' and not name.startswith('"bentlight/')]
        assert not private, path


@pytest.mark.parametrize("header", HEADERS, ids=lambda path: path.name)
def test_a_public_header_compiles_alone(header):
    flags = ["-std=c17", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-fsyntax-only", "-x", "c"]
    subprocess.run(["cc", *flags, "-I", ROOT / "native" / "include", header], check=True)


def test_files_are_short():
    lengths = {str(path.relative_to(ROOT)): len(path.read_text().splitlines()) for path in source_files(*CODE)}
    assert not {name: length for name, length in lengths.items() if length > 600}


def test_every_code_file_says_what_it_is():
    for path in source_files(".py", ".c", ".h", ".osl", ".sh"):
        head = path.read_text()[:200]
        assert re.match(r'(#![^\n]*\n)?("""|/\*|//|#)', head), path


def test_no_place_of_one_machine_is_named():
    places = re.compile(r"(?<![\w./-])/(?:work|tmp|home|Users)/|//(?:[\w.-]*\.)?(?:pypi|pythonhosted|debian)\.")
    for path in source_files(*CODE, ""):
        assert not places.search(path.read_text()), path


def test_docs_name_what_exists():
    links, code = r"\]\((?!https?:)([^)#]+)", r"`([\w.-]+/[\w./-]*|[\w-]+\.(?:md|py|c|h))`"
    made = ("output/", "dist/", "build/", ".venv")
    for path in source_files(".md"):
        for name in re.findall(links, path.read_text()) + re.findall(code, path.read_text()):
            if not name.startswith(made):
                assert (ROOT / name).exists() or (path.parent / name).exists(), f"{path.name} names {name}"


def test_the_core_calls_nothing_that_glibc_2_34_lacks():
    """hypot is versioned 2.35 (double) there: a wheel that calls it does not run on Enterprise Linux 9."""
    for path in within("native/src", ".c", ".h"):
        code = re.sub(r"/\*.*?\*/", "", path.read_text(), flags=re.S)
        assert not re.search(r"\bhypot\(", code), path.relative_to(ROOT)
