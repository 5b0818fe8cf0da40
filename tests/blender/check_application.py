"""The extension in the real Blender application: installed from the zip, rendering frames from the command line.

Not collected by `make test`: it needs root and Debian's Blender. `make test-blender` gives the tree and the zip.
"""

import os
import shutil
import subprocess
from pathlib import Path

import numpy as np
import OpenEXR
import pytest

HERE = Path(__file__).parent


@pytest.fixture(scope="session")
def shared(tmp_path_factory):
    """The folder that the application sees as /share."""
    return tmp_path_factory.mktemp("share")


@pytest.fixture(scope="session")
def blender(shared):
    """A function that runs Blender with some arguments and returns its exit code and output."""
    tree = os.environ["BENTLIGHT_BLENDER_DIR"]

    def run(*arguments):
        command = [HERE / "in_tree.sh", tree, shared, "blender", *arguments]
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=300)
        return done.returncode, done.stdout

    return run


@pytest.fixture(scope="session")
def scenes(blender, shared):
    """Installs the extension from the zip and writes good.blend and bad.blend into /share."""
    shutil.copy(os.environ["BENTLIGHT_ZIP"], shared / "bentlight.zip")
    shutil.copy(HERE / "make_scenes.py", shared)
    code, output = blender(
        *("--command", "extension", "install-file", "-r", "user_default", "--enable", "/share/bentlight.zip")
    )
    assert code == 0, output
    code, output = blender("-b", "--python-exit-code", "3", "--python", "/share/make_scenes.py", "--", "/share")
    assert code == 0, output


def pixels(path):
    """The Combined pass (height, width, 4), of a file that only Bentlight can have written."""
    channels = {}
    with OpenEXR.File(str(path), separate_channels=True) as file:
        for part in file.parts:
            channels |= {name: channel.pixels for name, channel in part.channels.items()}
    assert any("Bentlight Fate" in name for name in channels), sorted(channels)
    return np.stack([next(channels[n] for n in channels if n.endswith(f"Combined.{c}")) for c in "RGBA"], axis=-1)


def test_version_is_supported(blender):
    _, output = blender("--version")
    assert tuple(map(int, output.split()[1].split(".")[:2])) >= (4, 5), output


def test_one_frame(blender, scenes, shared):
    code, output = blender("-b", "/share/good.blend", "-E", "BENTLIGHT", "-o", "/share/one_", "-f", "1")
    assert code == 0, output
    frame = pixels(shared / "one_0001.exr")
    assert frame.shape == (48, 64, 4)
    assert np.isfinite(frame).all()
    assert frame[..., :3].std() > 0


def test_animation_of_three_frames(blender, scenes, shared):
    code, output = blender("-b", "/share/good.blend", "-E", "BENTLIGHT", "-o", "/share/film_", "-a")
    assert code == 0, output
    assert sorted(path.name for path in shared.glob("film_*")) == [f"film_000{i}.exr" for i in (1, 2, 3)]
    first, second, third = (pixels(shared / f"film_000{i}.exr") for i in (1, 2, 3))
    assert (first != second).any()
    assert (second != third).any()


def test_bad_scene_fails_with_its_reason(blender, scenes, shared):
    code, output = blender("-b", "/share/bad.blend", "-E", "BENTLIGHT", "-o", "/share/bad_", "-f", "1")
    assert code == 1, output
    assert "horizon" in output
    assert not list(shared.glob("bad_*"))
