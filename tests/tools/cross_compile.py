"""Builds the native wheel for platforms that this machine is not: cross_compile.py FOLDER [PLATFORM...]

It is native/CMakeLists.txt by way of its own build backend, with another compiler: Clang, as the Python package
`ziglang` brings it with the headers and libraries of every platform. All that Python adds is its headers, which differ
in pyconfig.h alone, and on Windows an import library, made from the list of the stable ABI in `abi3info`.
"""

import argparse
import os
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path
from typing import NamedTuple

import abi3info
import ziglang
from abi3info.models import PyVersion

NATIVE = Path(__file__).resolve().parents[2] / "native"
ZIG = Path(ziglang.__file__).resolve().parent / "zig"
PYTHON = PyVersion(3, 11)


class Platform(NamedTuple):
    """What a platform is called by each tool."""

    target: str  # by zig; with the oldest C library or system that it is compiled for
    system: str  # by CMake
    processor: str
    tag: str  # by sysconfig.get_platform(), and so in a wheel's name

    @property
    def is_windows(self) -> bool:
        return self.system == "Windows"


# Blender's names of platforms. macOS 11 is the oldest that Blender 4.5 runs on (its own binaries ask for 11.2).
PLATFORMS = {
    "linux-arm64": Platform("aarch64-linux-gnu.2.34", "Linux", "aarch64", "linux-aarch64"),
    "windows-x64": Platform("x86_64-windows-gnu", "Windows", "AMD64", "win-amd64"),
    "macos-x64": Platform("x86_64-macos.11.0", "Darwin", "x86_64", "macosx-11.0-x86_64"),
    "macos-arm64": Platform("aarch64-macos.11.0", "Darwin", "arm64", "macosx-11.0-arm64"),
}

# zig spells processors with underscores. Windows has no libdl, which CMake takes from the Python here; and zig would
# link its own C library as bitcode there and fail, but what was compiled with -flto is optimized by the linker anyway.
# For macOS it makes no bundles; Python loads dynamic libraries as well.
COMPILER = """#!/bin/sh
case " $* " in *" -c "*) links= ;; *) links={is_windows} ;; esac
for argument; do
  shift
  case $links$argument in
    *-march=x86-64-v*) argument=-march=x86_64_v${{argument##*v}} ;;
    yes-flto* | yes-ldl) continue ;;
    *-bundle) argument=-dynamiclib ;;
  esac
  set -- "$@" "$argument"
done
exec {zig} cc -target {target} "$@"
"""
TOOL = """#!/bin/sh
exec {zig} {name} "$@"
"""

TOOLCHAIN = """
set(CMAKE_SYSTEM_NAME {system})
set(CMAKE_SYSTEM_PROCESSOR {processor})
set(CMAKE_C_COMPILER "{folder}/cc")
set(CMAKE_AR "{folder}/ar")
set(CMAKE_C_COMPILER_AR "{folder}/ar")
set(CMAKE_RANLIB "{folder}/ranlib")
set(CMAKE_C_COMPILER_RANLIB "{folder}/ranlib")
set(CMAKE_INSTALL_NAME_TOOL "no module has a name to change")
set(CMAKE_OSX_SYSROOT "")
set(CMAKE_MODULE_LINKER_FLAGS_INIT "-s")
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(Python_EXECUTABLE "{python}")
set(Python_INCLUDE_DIR "{folder}/python")
set(Python_SABI_LIBRARY "{folder}/python3.lib")
"""

# What Python's headers ask of pyconfig.h under the limited API.
PYCONFIG = """
#define HAVE_STDDEF_H 1
#define HAVE_SYS_STAT_H 1
#define HAVE_SYS_TIME_H 1
#define SIZEOF_INT 4
#define SIZEOF_LONG {long}
#define SIZEOF_LONG_LONG 8
#define SIZEOF_SHORT 2
#define SIZEOF_SIZE_T 8
#define SIZEOF_VOID_P 8
#define SIZEOF_WCHAR_T {wchar}
"""
PYCONFIG_POSIX = PYCONFIG.format(long=8, wchar=4)
PYCONFIG_WINDOWS = PYCONFIG.format(long=4, wchar=2) + "#define MS_WINDOWS 1\n#define Py_ENABLE_SHARED 1\n"


def write_program(path: Path, text: str) -> None:
    """An executable script."""
    path.write_text(text)
    path.chmod(0o755)


def write_headers(folder: Path, platform: Platform) -> None:
    """This Python's headers in `folder`, with the platform's pyconfig.h."""
    shutil.copytree(sysconfig.get_path("include"), folder, dirs_exist_ok=True)
    (folder / "pyconfig.h").write_text(PYCONFIG_WINDOWS if platform.is_windows else PYCONFIG_POSIX)


def write_import_library(path: Path) -> None:
    """python3.lib: the stable ABI of Python 3.11, as python3.dll exports it."""
    lines = ["LIBRARY python3.dll", "EXPORTS"]
    for table, kind in ((abi3info.FUNCTIONS, ""), (abi3info.DATAS, " DATA")):
        lines += [f"{symbol.name}{kind}" for symbol, entry in table.items() if entry.added <= PYTHON]
    definition = path.with_suffix(".def")
    definition.write_text("\n".join(lines) + "\n")
    subprocess.run([ZIG, "dlltool", "-m", "i386:x86-64", "-d", definition, "-l", path], check=True)


def write_toolchain(folder: Path, platform: Platform) -> Path:
    """All that CMake needs to compile for `platform`, in `folder`; the path of the toolchain file."""
    folder.mkdir(parents=True, exist_ok=True)
    chosen = {"zig": ZIG, "target": platform.target, "is_windows": "yes" if platform.is_windows else ""}
    write_program(folder / "cc", COMPILER.format(**chosen))
    for name in ("ar", "ranlib"):
        write_program(folder / name, TOOL.format(zig=ZIG, name=name))
    write_headers(folder / "python", platform)
    if platform.is_windows:
        write_import_library(folder / "python3.lib")
    path = folder / "toolchain.cmake"
    path.write_text(TOOLCHAIN.format(folder=folder, python=sys.executable, **platform._asdict()))
    return path


def build(name: str, folder: Path) -> Path:
    """Builds the wheel of the platform that Blender calls `name` in `folder`; returns its path."""
    platform = PLATFORMS[name]
    toolchain = write_toolchain(folder / "toolchain", platform)
    settings = {
        "build-dir": folder / "cmake",
        "cmake.toolchain-file": toolchain,
        "cmake.define.CMAKE_COMPILE_WARNING_AS_ERROR": "ON",
        "cmake.python-hints": "false",
        "install.strip": "false",  # the linker does it
    }
    options = [f"-C{key}={value}" for key, value in settings.items()]
    command = ["pip", "--quiet", "--disable-pip-version-check", "wheel", "--no-build-isolation", "--no-deps"]
    wheels = folder / "wheelhouse"
    shutil.rmtree(wheels, ignore_errors=True)
    environment = {**os.environ, "_PYTHON_HOST_PLATFORM": platform.tag}
    command = [sys.executable, "-m", *command, *options, "--wheel-dir", wheels, NATIVE]
    subprocess.run(command, check=True, env=environment)
    (wheel,) = wheels.glob("*.whl")
    return wheel


def main() -> None:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path, help="where each platform gets a folder")
    parser.add_argument("platform", nargs="*", help=f"of {', '.join(PLATFORMS)}; default: all of them")
    arguments = parser.parse_args()
    for name in arguments.platform or PLATFORMS:
        print(build(name, arguments.folder.resolve() / name))


if __name__ == "__main__":
    main()
