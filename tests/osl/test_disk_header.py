"""The header of the accretion disk is accepted by oslc as it stands, every function of it."""

import re
from pathlib import Path

import pytest

HEADER = Path(__file__).parents[2] / "native" / "src" / "scene" / "disk.h"
bpy = pytest.importorskip("bpy")


def test_every_function_compiles(tmp_path):
    import _cycles

    functions = re.findall(r"DISK_FUNCTION (disk_\w+)\(([^)]*)\)", HEADER.read_text())
    assert len(functions) >= 20
    calls = "\n".join(f"  result += {name}({', '.join(['a'] * (args.count(',') + 1))});" for name, args in functions)
    shader = f'#include "{HEADER}"\nshader probe(float a = 0.1, output float result = 0)\n{{\n{calls}\n}}\n'
    (tmp_path / "probe.osl").write_text(shader)
    assert _cycles.osl_compile(str(tmp_path / "probe.osl"), str(tmp_path / "probe.oso"))
    code = (tmp_path / "probe.oso").read_text()
    assert "OpenShadingLanguage" in code and "shader probe" in code
