"""What `make packages` made, a zip for each platform: its name, its manifest, and the module in its wheel, as far as a
machine of another platform can tell. It is too long for CI; the command runs this itself.
"""

import json
import os
import re
import struct
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import pefile
import pytest
from elftools.elf.elffile import ELFFile

FOLDER = os.environ["BENTLIGHT_PACKAGES"]

# Blender's platform: the wheel's platform, the module, the first bytes of it, and the symbols that it may show.
PYTHON, MACH_O = {"PyInit__core"}, {"_PyInit__core", "__mh_dylib_header", "___dso_handle"}
ELF, PE = b"\x7fELF\2\1\1", b"MZ"
PLATFORMS = {
    "linux-x64": (r"manylinux_2_\d+_x86_64", "_core.abi3.so", ELF, PYTHON),
    "linux-arm64": (r"manylinux_2_\d+_aarch64", "_core.abi3.so", ELF, PYTHON),
    "windows-x64": ("win_amd64", "_core.pyd", PE, PYTHON),
    "macos-x64": ("macosx_11_0_x86_64", "_core.abi3.so", struct.pack("<II", 0xFEEDFACF, 0x01000007), MACH_O),
    "macos-arm64": ("macosx_11_0_arm64", "_core.abi3.so", struct.pack("<II", 0xFEEDFACF, 0x0100000C), MACH_O),
}
LOAD_COMMANDS = {"symbols": 0x02, "signature": 0x1D, "build version": 0x32}


@pytest.fixture(scope="module", params=PLATFORMS)
def package(request, tmp_path_factory):
    """Of each platform: its name, its zip, the wheel in it, the module in that."""
    (archive,) = Path(FOLDER).glob(f"bentlight-*-{request.param.replace('-', '_')}.zip")
    folder = tmp_path_factory.mktemp(request.param)
    with zipfile.ZipFile(archive) as opened:
        (name,) = (name for name in opened.namelist() if name.endswith(".whl"))
        wheel = Path(opened.extract(name, folder))
    with zipfile.ZipFile(wheel) as opened:
        (name,) = (name for name in opened.namelist() if name.endswith((".so", ".pyd", ".dll", ".dylib")))
        return request.param, archive, wheel, Path(opened.extract(name, folder))


def mach_o_command(module, number):
    """The 32-bit words of a load command, without its number and size."""
    data = module.read_bytes()
    (count,), at = struct.unpack_from("<I", data, 16), 32
    for _ in range(count):
        command, size = struct.unpack_from("<II", data, at)
        if command == number:
            return struct.unpack_from(f"<{size // 4 - 2}I", data, at + 8)
        at += size
    return None


def shown(module):
    """The symbols that a module offers to others."""
    if module.suffix == ".pyd":
        return {symbol.name.decode() for symbol in pefile.PE(module).DIRECTORY_ENTRY_EXPORT.symbols}
    data = module.read_bytes()
    if data.startswith(ELF):
        with module.open("rb") as file:
            symbols = list(ELFFile(file).get_section_by_name(".dynsym").iter_symbols())
        outside = [item for item in symbols if item["st_info"]["bind"] != "STB_LOCAL"]
        return {item.name for item in outside if item["st_shndx"] != "SHN_UNDEF"}
    first, count, strings, _ = mach_o_command(module, LOAD_COMMANDS["symbols"])
    entries = [struct.unpack_from("<IB", data, first + 16 * i) for i in range(count)]
    places = [strings + name for name, kind in entries if kind & 0x0F == 0x0F]  # external, and defined in a section
    return {data[at : data.index(b"\0", at)].decode() for at in places}


def test_the_zip_is_for_its_platform_alone(package):
    name, archive, wheel, _ = package
    with zipfile.ZipFile(archive) as opened:
        manifest = tomllib.loads(opened.read("blender_manifest.toml").decode())
    assert manifest["platforms"] == [name]
    assert manifest["wheels"] == [f"./wheels/{wheel.name}"]


def test_the_wheel_is_named_after_the_platform(package):
    name, _, wheel, module = package
    tag, file, magic, _ = PLATFORMS[name]
    assert re.fullmatch(rf"bentlight_native-[\d.]+-cp311-abi3-{tag}\.whl", wheel.name)
    assert module.name == file and module.read_bytes().startswith(magic)


def test_all_zips_hold_the_same_files_but_for_the_wheel():
    contents = []
    for archive in Path(FOLDER).glob("*.zip"):
        with zipfile.ZipFile(archive) as opened:
            contents.append({item.filename: item.CRC for item in opened.infolist()})
            del contents[-1]["blender_manifest.toml"]
    kept = [{name: crc for name, crc in content.items() if not name.endswith(".whl")} for content in contents]
    assert len(kept) == len(PLATFORMS)
    assert all(content == kept[0] for content in kept)


def test_an_audit_finds_the_stable_abi_alone(package):
    command = [sys.executable, "-m", "abi3audit", "--strict", "--report", package[2]]
    done = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True, timeout=60)
    ((wanted,),) = ([item["result"] for item in spec["wheel"]] for spec in json.loads(done.stdout)["specs"].values())
    assert wanted["is_abi3"] and wanted["is_abi3_baseline_compatible"]
    assert wanted["baseline"] == "3.11"


def test_the_module_shows_its_entry_alone(package):
    assert shown(package[3]) == PLATFORMS[package[0]][3]


def test_it_holds_no_path_of_the_machine_that_built_it(package):
    assert str(Path(__file__).parents[2]).encode() not in package[3].read_bytes()


def test_a_module_for_macos_is_signed_and_for_macos_11(package):
    name, _, _, module = package
    if not name.startswith("macos"):
        pytest.skip("of macOS alone")
    platform, oldest, *_ = mach_o_command(module, LOAD_COMMANDS["build version"])
    assert (platform, oldest >> 16) == (1, 11)
    if name == "macos-arm64":  # Apple's processors run nothing without one
        at, size = mach_o_command(module, LOAD_COMMANDS["signature"])
        magic, length = struct.unpack_from(">II", module.read_bytes(), at)
        assert magic == 0xFADE0CC0 and length <= size
