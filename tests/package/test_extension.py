"""The extension's zip: what is in it, what its native wheel needs, and that Blender installs and renders with it."""

import json
import os
import re
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import abi3info
import pytest

HERE = Path(__file__).parent
ROOT = HERE.parents[1]


@pytest.fixture(scope="module")
def wheel():
    """The release wheel that `make` built."""
    wheels = list((ROOT / "build" / "wheelhouse").glob("*.whl"))
    assert len(wheels) == 1, "make build/native.stamp builds the wheel"
    return wheels[0]


@pytest.fixture(scope="module")
def archive(wheel, tmp_path_factory):
    """The zip, built and validated by Blender's own tool."""
    folder = tmp_path_factory.mktemp("dist")
    command = [sys.executable, ROOT / "tests" / "tools" / "build_extension.py", "--wheel", wheel, "--output", folder]
    subprocess.run(command, check=True)
    (path,) = folder.glob("*.zip")
    return path


@pytest.fixture(scope="module")
def library(archive, tmp_path_factory):
    """The native module out of the wheel out of the zip."""
    folder = tmp_path_factory.mktemp("unpacked")
    with zipfile.ZipFile(archive) as outer:
        (name,) = (name for name in outer.namelist() if name.endswith(".whl"))
        outer.extract(name, folder)
    with zipfile.ZipFile(folder / name) as inner:
        (module,) = (name for name in inner.namelist() if name.endswith(".so"))
        return Path(inner.extract(module, folder))


def readelf(option, path):
    done = subprocess.run(["readelf", "--wide", option, path], check=True, stdout=subprocess.PIPE, text=True)
    return done.stdout


def test_versions_agree():
    manifest = tomllib.loads((ROOT / "blender_addon" / "blender_manifest.toml").read_text())
    native = tomllib.loads((ROOT / "native" / "pyproject.toml").read_text())
    assert manifest["version"] == native["project"]["version"]


def test_the_zip_holds_the_extension_and_nothing_else(archive):
    sources = [path for path in (ROOT / "blender_addon").rglob("*") if path.is_file() and path.suffix != ".pyc"]
    expected = {str(path.relative_to(ROOT / "blender_addon")) for path in sources}
    expected |= {str(path.relative_to(ROOT)) for path in (ROOT / "osl").rglob("*") if path.is_file()}
    with zipfile.ZipFile(archive) as opened:
        names = set(opened.namelist())
    wheels = {name for name in names if name.startswith("wheels/")}
    assert len(wheels) == 1
    assert names - wheels == expected | {"LICENSE"}


def test_the_zip_is_named_and_described(archive):
    with zipfile.ZipFile(archive) as opened:
        manifest = tomllib.loads(opened.read("blender_manifest.toml").decode())
        (wheel,) = manifest["wheels"]
        assert wheel.removeprefix("./") in opened.namelist()
    assert manifest["id"] == "bentlight"
    assert manifest["blender_version_min"] == "4.5.0"
    assert manifest["license"] == ["SPDX:GPL-3.0-or-later"]
    assert archive.name == f"bentlight-{manifest['version']}-{manifest['platforms'][0].replace('-', '_')}.zip"


def test_the_wheel_is_for_every_python_from_3_11_on(archive, library):
    with zipfile.ZipFile(archive) as opened:
        assert any("-cp311-abi3-manylinux_2_" in name for name in opened.namelist())
    assert library.name == "_core.abi3.so"
    stable = {
        str(symbol.name): (entry.added.major, entry.added.minor)
        for symbol, entry in [*abi3info.FUNCTIONS.items(), *abi3info.DATAS.items()]
    }
    used = re.findall(r" UND (_?Py\w+)$", readelf("--dyn-syms", library), re.M)
    assert used
    assert not [name for name in used if stable.get(name, (9, 9)) > (3, 11)]


def test_an_audit_finds_the_stable_abi_alone(wheel):
    command = [sys.executable, "-m", "abi3audit", "--strict", "--report", wheel]
    done = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True, timeout=60)
    ((wanted,),) = ([item["result"] for item in spec["wheel"]] for spec in json.loads(done.stdout)["specs"].values())
    assert wanted["is_abi3"] and wanted["is_abi3_baseline_compatible"]
    assert wanted["baseline"] == "3.11"


def test_the_library_needs_libc_and_libm_alone(library):
    needed = re.findall(r"\(NEEDED\).*\[(.*)\]", readelf("--dynamic", library))
    assert set(needed) <= {"libc.so.6", "libm.so.6"}
    assert not re.search(r"\((RPATH|RUNPATH|TEXTREL)\)", readelf("--dynamic", library))


def test_the_library_shows_its_entry_alone(library):
    symbols = re.findall(r"(?:GLOBAL|WEAK) +DEFAULT +\d+ (\w+)$", readelf("--dyn-syms", library), re.M)
    assert symbols == ["PyInit__core"]


def test_it_holds_no_path_of_the_machine_that_built_it(archive, library):
    content = library.read_bytes()
    assert str(ROOT).encode() not in content
    with zipfile.ZipFile(archive) as opened:
        assert not [name for name in opened.namelist() if str(ROOT).encode() in opened.read(name)]


def test_blender_installs_it_and_renders(archive, tmp_path):
    script = HERE / "install_and_render.py"
    environment = {**os.environ, "BLENDER_USER_RESOURCES": str(tmp_path / "user"), "TMPDIR": str(tmp_path / "scratch")}
    environment.pop("PYTHONPATH", None)
    for folder in ("user", "scratch"):
        (tmp_path / folder).mkdir()
    command = [sys.executable, script, archive, tmp_path / "frame.exr"]
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr
    assert (tmp_path / "frame.exr").exists()
