"""Every example builds, renders by Bentlight, and shows a picture that is neither black nor broken."""

import subprocess
import sys
from pathlib import Path

import bpy
import caustic_glass
import common
import cycles_lens
import cycles_relay
import disk_kerr
import disk_schwarzschild
import einstein_ring
import flat
import gargantua
import lamps
import numpy as np
import objects
import primary_secondary
import pytest
import rendering
import room_kerr
import room_schwarzschild
import room_wormhole
import soft_shadow
import starry_hole
import wormhole_cycles
import wormhole_lamp

RENDER = Path(common.__file__).with_name("render.py")


@pytest.mark.parametrize(
    ("example", "lit"),  # the share of pixels that any of four paths must light
    [
        (room_schwarzschild, 0.5),
        (room_kerr, 0.5),
        (room_wormhole, 0.4),
        (lamps, 0.7),
        (soft_shadow, 0.7),
        (wormhole_lamp, 0.3),
        (caustic_glass, 0.7),
        (flat, 0.25),
        (einstein_ring, 0.003),
        (starry_hole, 0.2),
        (gargantua, 0.2),
        (disk_schwarzschild, 0.2),
        (disk_kerr, 0.15),
    ],
)
def test_example_renders(example, lit):
    scene = example.build()
    assert scene.render.engine == "BENTLIGHT"
    rendering.set_size(scene, 96, 54)
    picture = rendering.render(scene, samples=4)
    assert picture.shape == (54, 96, 3)
    assert np.isfinite(picture).all() and picture.min() >= 0
    assert (picture.max(axis=-1) > 0.01).mean() > lit


@pytest.mark.parametrize(("example", "lit"), [(cycles_lens, 0.6), (wormhole_cycles, 0.6)])
def test_example_renders_by_cycles(example, lit):
    scene = example.build()
    assert scene.render.engine == "CYCLES"
    rendering.set_size(scene, 96, 54)
    picture = rendering.render(scene, "CYCLES", samples=4)
    assert (picture.max(axis=-1) > 0.01).mean() > lit
    bpy.ops.bentlight.cycles_clear()
    changed = np.abs(rendering.render(scene, "CYCLES", samples=4) - picture).max(axis=-1) > 0.05
    assert 0.03 < changed.mean() < 0.97


def test_example_renders_by_relay():
    scene = cycles_relay.build()
    scene.bentlight.relay_parts = 2
    rendering.set_size(scene, 96, 54)
    picture = rendering.render(scene, "CYCLES", samples=4)
    assert (picture.max(axis=-1) > 0.002).mean() > 0.5
    assert (picture[30:40, 50:66] == 0).all(), "the hole's shadow"


def test_a_spinning_hole_changes_the_room():
    pictures = []
    for spin in (0.2, 0.9):
        scene = room_kerr.build(spin)
        rendering.set_size(scene, 64, 36)
        pictures.append(rendering.render(scene, samples=8))
    middle = np.s_[9:27, 22:42]
    assert np.abs(pictures[0][middle] - pictures[1][middle]).mean() > 0.05 * pictures[0][middle].mean()


def test_tracks_of_stars_and_the_curves_between_them(monkeypatch):
    """Critical curves are all around the hole, one within the other; the outer one's caustic is narrow."""
    monkeypatch.setattr(primary_secondary, "STARS", 100)
    monkeypatch.setattr(primary_secondary, "FRAMES", 2)
    picture = primary_secondary.compose()
    assert np.isfinite(picture).all() and picture.min() >= 0 and (picture.max(axis=-1) > 0.1).sum() > 2000
    outer, inner = primary_secondary.critical_curves(points=360)
    assert np.isfinite(outer.seen).all() and np.isfinite(inner.seen).all()
    assert (outer.seen[:, 1] < inner.seen[:, 1]).all()
    off = primary_secondary.sky_of(outer.seen) - outer.sky
    assert np.linalg.norm(off, axis=1).max() < 1e-3
    assert np.linalg.norm(outer.sky - outer.sky.mean(axis=0), axis=1).max() < 0.02


def test_contact_sheet_reads_from_left_to_right_and_down(tmp_path):
    paths = []
    for index in range(4):
        image = bpy.data.images.new("tile", 4, 2)
        image.pixels.foreach_set(np.tile(np.float32([index / 4, 0, 0, 1]), 8))
        image.file_format = "PNG"
        paths.append(tmp_path / f"{index}.png")
        image.save(filepath=str(paths[-1]))
    room_kerr.contact_sheet(paths, tmp_path / "sheet.png", columns=3, gap=2)
    sheet = room_kerr.read_pixels(tmp_path / "sheet.png")[::-1]
    assert sheet.shape == (6, 16, 4)
    reds = [sheet[row, column, 0] for row, column in ((0, 0), (0, 6), (0, 12), (4, 0))]
    assert reds == pytest.approx([0, 0.25, 0.5, 0.75], abs=0.5 / 255 + 1e-6)  # bytes
    assert (sheet[2:4] == 1).all() and (sheet[:, 4:6] == 1).all()


def run(*arguments: object) -> subprocess.CompletedProcess:
    return subprocess.run([sys.executable, RENDER, *map(str, arguments)], capture_output=True, text=True, timeout=200)


@pytest.fixture(scope="module")
def blend(tmp_path_factory) -> Path:
    """A file with a lit wall, made for Cycles, of two frames: the lamp is off in the second one."""
    scene = common.new_scene(engine="CYCLES", samples=1, resolution=(16, 8))
    objects.camera((0, -4, 0), (0, 0, 0))
    strength = scene.world.node_tree.nodes["Background"].inputs["Strength"]
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (1, 1, 1, 1)
    for frame in (1, 2):
        strength.default_value = 2 - frame
        strength.keyframe_insert("default_value", frame=frame)
    path = tmp_path_factory.mktemp("blend") / "scene.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    return path


@pytest.mark.parametrize("engine", ["BENTLIGHT", "CYCLES"])
def test_render_py_renders_a_file(blend, tmp_path, engine):
    done = run(blend, "-o", tmp_path / "a.png", "--engine", engine, "--samples", 2, "--resolution", "24x12")
    assert done.returncode == 0, done.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["a.png"]
    pixels = room_kerr.read_pixels(tmp_path / "a.png")
    assert pixels.shape == (12, 24, 4) and pixels[..., :3].min() > 0.5


def test_render_py_renders_a_frame_to_exr(blend, tmp_path):
    done = run(blend, "-o", tmp_path / "a.exr", "--engine", "BENTLIGHT", "--frame", 2)
    assert done.returncode == 0, done.stderr
    channels = rendering.OpenEXR.File(str(tmp_path / "a.exr"), separate_channels=True).channels()
    red = next(channel for name, channel in channels.items() if name.endswith("Combined.R"))
    assert red.pixels.shape == (8, 16) and (red.pixels == 0).all()


@pytest.mark.parametrize(
    ("arguments", "code", "reason"),
    [
        (["missing.blend", "-o", "a.png"], 1, "no such file"),
        (["SCENE", "-o", "a.jpg"], 2, "must end in"),
        (["SCENE", "-o", "a.png", "--engine", "MAGIC"], 1, "unknown engine"),
        (["SCENE", "-o", "a.png", "--resolution", "0x4"], 2, "resolution"),
        (["SCENE", "-o", "a.png", "--samples", "0"], 2, "samples"),
        (["EMPTY", "-o", "a.png"], 1, "no camera"),
        (["BROKEN", "-o", "a.png"], 1, "BROKEN"),
    ],
)
def test_render_py_refuses(blend, tmp_path, arguments, code, reason):
    empty, broken = tmp_path / "EMPTY.blend", tmp_path / "BROKEN.blend"
    broken.write_bytes(b"this is no Blender file")
    if "EMPTY" in arguments:
        common.new_scene()
        bpy.ops.wm.save_as_mainfile(filepath=str(empty))
    files = {"SCENE": blend, "EMPTY": empty, "BROKEN": broken, "a.png": tmp_path / "a.png"}
    done = run(*[files.get(argument, argument) for argument in arguments])
    assert done.returncode == code
    assert reason in done.stderr + done.stdout
    assert not (tmp_path / "a.png").exists()
