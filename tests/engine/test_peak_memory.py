"""The memory that renders tell of."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import blender_addon.memory as memory

_CHILD = """
import runpy, sys
used_and_peak = runpy.run_path(sys.argv[1])["used_and_peak"]
held = bytearray(64 << 20)
del held
print(*used_and_peak())
"""


@pytest.mark.skipif(sys.platform != "linux", reason="other systems tell less")
def test_the_most_is_that_of_this_process_alone():
    """Not what the one had that started it; what is let go of again counts."""
    held = np.ones(400 << 17)  # 400 MiB
    done = subprocess.run([sys.executable, "-c", _CHILD, Path(memory.__file__)], capture_output=True, text=True)
    used, peak = map(float, done.stdout.split())
    assert 64 < peak < 200 and used < peak - 60
    assert memory.used_and_peak()[0] > held.nbytes / (1 << 20)
