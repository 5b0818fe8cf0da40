"""The documents: every Python block in them runs as it stands, every command names what exists.

A block that needs another program says so after its language, as in "python opencue"; it is not run.
"""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
DOCUMENTS = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
# What a reader has before a block: the extension, and a saved file with a camera and of a small picture.
BEFORE = """
import sys
sys.path.insert(0, {root!r})
import blender_addon
blender_addon.register()
import os
import bpy
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.context.scene.camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
bpy.context.scene.camera.location = 0, -9, 2
bpy.context.scene.camera.rotation_euler = 1.57, 0, 0
bpy.context.collection.objects.link(bpy.context.scene.camera)
bpy.ops.bentlight.black_hole_add(mass=0.1, location=(5, 5, 5))
bpy.context.scene.render.resolution_percentage = 10  # a relay camera's rays alone take a minute in full size
bpy.ops.wm.save_as_mainfile(filepath=os.path.abspath("scene.blend"))  # Blender 4.5 keeps a name as it is told
"""


def blocks(language):
    """(document, number of the block in it, text) of each block in a language."""
    for path in DOCUMENTS:
        found = re.findall(rf"^```{language}\n(.*?)^```", path.read_text(), re.MULTILINE | re.DOTALL)
        yield from ((path.name, number, text) for number, text in enumerate(found))


def commands():
    """Every line of a shell block, without its comment."""
    lines = [re.split(r"\s#\s", line)[0].strip() for _, _, text in blocks("sh") for line in text.splitlines()]
    return [line for line in lines if line and not line.startswith("#")]


@pytest.mark.parametrize(
    ("document", "number", "text"), [pytest.param(*b, id=f"{b[0]}-{b[1]}") for b in blocks("python")]
)
def test_a_block_of_python_runs(document, number, text, tmp_path):
    script = tmp_path / "block.py"
    script.write_text(BEFORE.format(root=str(ROOT)) + text)
    done = subprocess.run([sys.executable, script], cwd=tmp_path, env=os.environ, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    for name in re.findall(r'filepath = "//([\w.]+)"', text):
        assert (tmp_path / name).stat().st_size > 0


def test_commands_name_what_exists():
    targets = re.findall(r"^([\w.-]+):(?!=)", (ROOT / "Makefile").read_text(), re.MULTILINE)
    assert commands()
    for line in commands():
        words = line.split()
        if words[0] == "make":
            assert set(words[1:]) <= set(targets), line
        elif words[0].startswith(".venv"):
            assert words[0] == ".venv/bin/python", line
            script = next(word for word in words[1:] if word.endswith(".py"))
            assert (ROOT / script).is_file(), line
        else:
            assert words[0] == "blender", line  # test_docs_commands reads the rest


def test_options_beside_examples_are_theirs():
    """As "--natural: as one would see it" in a comment."""
    lines = [line for _, _, text in blocks("sh") for line in text.splitlines() if "#" in line and ".py" in line]
    named = [(re.search(r"\S+\.py", line)[0], option) for line in lines for option in re.findall(r"--[a-z-]+", line)]
    assert named
    for script, option in named:
        assert f'"{option}"' in (ROOT / script).read_text(), (script, option)


def test_the_guide_tells_of_every_panel():
    guide = (ROOT / "docs" / "guide.md").read_text()
    labels = {
        label
        for path in (ROOT / "blender_addon" / "ui").glob("*.py")
        for label in re.findall(r'^    bl_label = "(.+)"', path.read_text(), re.MULTILINE)
    }
    assert labels
    assert not {label for label in labels if f"**{label}**" not in guide and f"**{label}." not in guide}


def test_the_guide_tells_of_every_pass_of_ours():
    guide = (ROOT / "docs" / "guide.md").read_text()
    names = re.findall(r'"(Bentlight [\w ]+)"', (ROOT / "blender_addon" / "passes.py").read_text())
    assert names
    assert not {name for name in names if f"| {name} |" not in guide}
