"""A checkout is used as it is: the add-on registers from the repository's root, in a process of its own."""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
TWICE = """
import bpy, blender_addon
for _ in range(2):
    blender_addon.register()
    bpy.context.scene.render.engine = "BENTLIGHT"
    bpy.context.scene.render.engine = "CYCLES"
    blender_addon.unregister()
"""


def test_the_addon_registers_and_unregisters_twice_over():
    done = subprocess.run([sys.executable, "-c", TWICE], cwd=ROOT, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    assert not done.stderr
