"""The extension in the real Blender application: installed from the zip, rendering frames from the command line.

Not collected by `make test`: it needs root and Debian's Blender. `make test-blender` gives the tree and the zip.
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import OpenEXR
import pytest

HERE = Path(__file__).parent
ROOT = HERE.parents[1]


@pytest.fixture(scope="session")
def shared(tmp_path_factory):
    """The folder that the application sees as /share."""
    return tmp_path_factory.mktemp("share")


@pytest.fixture(scope="session")
def blender(shared):
    """A function that runs Blender with some arguments and returns its exit code and output."""
    tree = os.environ["BENTLIGHT_BLENDER_DIR"]

    def run(*arguments, command="blender", shared=shared):
        command = [HERE / "in_tree.sh", tree, shared, command, *arguments]
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=600)
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


def test_two_machines_render_a_frame_and_one_merges_it(blender, scenes, shared):
    """Bit for bit what one would have rendered."""
    parts = []
    for samples in ("0:2", "2:4", "0:4"):
        arguments = ("-o", "/share/farm_", "-f", "1", "--", "--bentlight-samples", samples)
        code, output = blender("-b", "/share/good.blend", "-E", "BENTLIGHT", *arguments)
        assert code == 0, output
        parts.append(f"/share/farm_samples_{samples.replace(':', '-')}_0001.part.exr")
    for files, name in ((parts[:2], "two"), (parts[2:], "one")):
        code, output = blender("--command", "bentlight", "merge", *files, "-o", f"/share/{name}.exr")
        assert code == 0, output
    assert (pixels(shared / "two.exr") == pixels(shared / "one.exr")).all()
    code, output = blender("--command", "bentlight", "merge", parts[0], "-o", "/share/half.exr")
    assert code == 1 and "samples are missing" in output
    assert not (shared / "half.exr").exists()


def test_bad_scene_fails_with_its_reason(blender, scenes, shared):
    code, output = blender("-b", "/share/bad.blend", "-E", "BENTLIGHT", "-o", "/share/bad_", "-f", "1")
    assert code == 1, output
    assert "horizon" in output
    assert not list(shared.glob("bad_*"))


@pytest.fixture(scope="session")
def drive(blender):
    """A function that runs a driver in the true window; screenshots are left in output/window."""

    def run(name, *arguments, options=(), environment=(), shared):
        pictures = shared / "window"
        pictures.mkdir(exist_ok=True)
        for source in (HERE / "window.sh", HERE.parent / "native" / "heap.py", *HERE.glob("*.py")):
            shutil.copy(source, shared)
        driver = ("--python", f"/share/drive_{name}.py", "--", "/share/window", *arguments)
        code, output = blender(*environment, "/share/window.sh", *options, *driver, command="env", shared=shared)
        shutil.copytree(pictures, ROOT / "output" / "window", dirs_exist_ok=True)
        assert code == 0, output
        assert "Traceback" not in output and "rna_uiItem" not in output, output
        assert output.rstrip().endswith(f"{name} fine"), output

    return run


def test_a_viewport_in_the_true_window(drive, scenes, shared):
    """Orbit, edits that are each drawn, undo, other engines, what cannot be rendered."""
    drive("viewport", options=["/share/good.blend"], shared=shared)


def test_memory_over_a_thousand_edits_in_the_true_window(drive, scenes, shared):
    """Of which each is drawn: in a small window, so that it does not take long."""
    options = ["/share/good.blend", "--window-geometry", "0", "0", "640", "480"]
    drive("memory", options=options, environment=["LD_PRELOAD=libstdc++.so.6:libc.so.6"], shared=shared)


def test_what_a_viewport_is_to_show_in_the_true_window(drive, scenes, shared):
    """Local view, view layers, borders, the viewport's own camera, areas that are split and closed: by their pixels."""
    drive("views", shared=shared)


def test_files_are_loaded_while_the_true_window_renders(drive, scenes, shared):
    """By a viewport, and by F12: nothing goes on afterwards, and all works again."""
    drive("loading", options=["/share/good.blend"], shared=shared)


def test_every_panel_and_the_overlay_in_the_true_window(drive, scenes, shared):
    """Each panel in each state, and the overlay in each shading: Blender prints what they raise while drawn."""
    drive("panels", shared=shared)


def test_an_artist_installs_uses_and_removes_it_in_the_true_window(drive, tmp_path):
    """By menus and keys; what is left behind is looked for."""
    shutil.copy(os.environ["BENTLIGHT_ZIP"], tmp_path / "bentlight.zip")
    command = [sys.executable, ROOT / "examples" / "cycles_lens.py", "-o", tmp_path / "lenses.blend"]
    subprocess.run(command, check=True)
    drive("artist", "/share/bentlight.zip", "/share/lenses.blend", shared=tmp_path)
