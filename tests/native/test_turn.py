"""The error that base/turn.h states, measured."""

import shutil
import subprocess
from pathlib import Path

ROOT = Path(__file__).parents[2]
STATED = 3e-16


def test_stated_error(tmp_path):
    compiler = shutil.which("cc") or shutil.which("gcc")
    program = tmp_path / "turn"
    source = Path(__file__).with_name("turn.c")
    subprocess.run([compiler, "-O2", f"-I{ROOT}/native/src", str(source), "-o", str(program), "-lm"], check=True)
    assert float(subprocess.run([program], check=True, capture_output=True, text=True).stdout) < STATED
