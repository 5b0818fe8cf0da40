"""The errors that base/lane_math.h states for its functions, measured with every instruction set of this processor."""

import shutil
import subprocess
from pathlib import Path

import pytest
from bentlight_native import instruction_set

ROOT = Path(__file__).parents[2]
# Of each instruction set: the flags that native/CMakeLists.txt compiles it with.
FLAGS = {"v2": ["-march=x86-64-v2"], "v3": ["-march=x86-64-v3"], "v4": ["-march=x86-64-v4"], "neon": []}
STATED = {"log": 0.9, "log_near_1": 0.9, "log1p": 1.2, "log1p_near_1": 1.2, "exp": 1.2, "exp_small": 1.2, "rf": 6}


def instruction_sets():
    best = instruction_set()
    return [name for name in FLAGS if name == best or (best[0] == name[0] == "v" and name <= best)]


@pytest.mark.parametrize("isa", instruction_sets())
def test_stated_errors(isa, tmp_path):
    compiler = shutil.which("cc") or shutil.which("gcc")
    program = tmp_path / "lane_math"
    sources = [f"-I{ROOT}/native/src", f"-I{ROOT}/native/include", str(Path(__file__).with_name("lane_math.c"))]
    options = ["-O2", "-std=gnu17", "-fno-math-errno", "-fno-trapping-math", "-ffp-contract=fast", *FLAGS[isa]]
    subprocess.run([compiler, *options, *sources, "-o", str(program), "-lm"], check=True)
    output = subprocess.run([program], check=True, capture_output=True, text=True).stdout
    measured = {name: float(value) for name, value in (line.split() for line in output.splitlines())}
    assert measured.keys() == STATED.keys()
    over = {name: value for name, value in measured.items() if value > STATED[name]}
    assert not over
