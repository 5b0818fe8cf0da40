"""The examples' .blend files: they open, hold all they need, have a thumbnail, and render."""

import subprocess
import sys
from pathlib import Path

import bpy
import common
import numpy as np
import pytest
import save_blends
import thumbnail

ROOT = Path(__file__).parents[2]

FILES = sorted((ROOT / "examples").glob("*.blend"))


def test_there_is_one_of_each_scene():
    assert {path.stem for path in FILES} == set(save_blends.NAMES)


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_it_is_complete(path, tmp_path):
    common.register()
    bpy.ops.wm.open_mainfile(filepath=str(path))
    assert bpy.context.scene.render.engine == ("CYCLES" if path.stem.startswith("cycles") else "BENTLIGHT")
    assert bpy.context.scene.render.filepath == "//"
    outside = bpy.utils.blend_paths(absolute=False, packed=False)
    assert not outside, outside
    plain = tmp_path / path.name
    bpy.ops.wm.save_as_mainfile(filepath=str(plain), compress=False, copy=True)
    shown = thumbnail.read(plain)
    assert shown.shape == (*save_blends.SIZE[::-1], 4)
    assert (shown[..., 3] == 255).all()
    assert shown[..., :3].std() > 10


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_it_renders(path, tmp_path):
    output = tmp_path / "tiny.png"
    command = [sys.executable, ROOT / "examples" / "render.py", path, "-o", output, "--samples", "1"]
    done = subprocess.run([*command, "--resolution", "32x18"], capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr
    image = bpy.data.images.load(str(output))
    assert np.std(np.array(image.pixels)) > 0.01
    bpy.data.images.remove(image)


@pytest.mark.parametrize("size", [(256, 144), (1, 1), (3, 256)])
def test_a_thumbnail_is_what_was_put_in(size, tmp_path):
    path = tmp_path / "small.blend"
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.save_as_mainfile(filepath=str(path), compress=False)
    assert thumbnail.read(path) is None
    pixels = np.random.default_rng(1).integers(0, 256, (size[1], size[0], 4), np.uint8)
    thumbnail.embed(path, pixels)
    assert np.array_equal(thumbnail.read(path), pixels)
    with pytest.raises(ValueError, match="one thumbnail"):
        thumbnail.embed(path, pixels)
    bpy.ops.wm.open_mainfile(filepath=str(path))  # Blender reads it, and keeps it
    bpy.ops.wm.save_as_mainfile(filepath=str(path), compress=False)
    assert np.array_equal(thumbnail.read(path), pixels)


def test_what_is_no_blend_file_is_refused(tmp_path):
    path = tmp_path / "not.blend"
    path.write_bytes(b"BLENDER")
    with pytest.raises(ValueError, match="uncompressed"):
        thumbnail.read(path)
