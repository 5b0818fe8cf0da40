"""Frames that are split over machines, and frames that go on after an interruption: bit for bit as one render."""

import json
import os
import re
import signal
import subprocess
import sys
import time
import tomllib
from pathlib import Path

import bentlight_native
import bpy
import numpy as np
import pytest
from bentlight_native import run_command as main

import blender_addon
from blender_addon import checkpoint, farm, final, recording
from blender_addon.recording import Recording
from blender_addon.report import RenderError
from blender_addon.session import Session
from tests.engine.stage import (
    add_camera,
    add_light,
    add_mesh,
    add_square,
    emission,
    read_exr,
    render,
    set_multilayer,
    set_world,
)

ROOT = Path(__file__).resolve().parents[2]


def build(integrator="PATH"):
    """A wall, a ball's worth of corners and a lamp around a small hole, with stars; as many passes as there are."""
    scene = bpy.context.scene
    add_camera((0.0, 0.0, 4.0))
    add_square(3.0, (0.0, 0.0, -2.0))
    roof = add_mesh(
        "Roof", [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], [(0, 1, 2), (0, 3, 1), (1, 3, 2)], (0.5, 0.2, -1)
    )
    for frame, roof.location.x in ((-10, 0.0), (12, 1.0)):
        roof.keyframe_insert("location", frame=frame)
    add_square(0.3, (-1.0, 0.8, 0.0), emission((1.0, 0.7, 0.4), 20.0))
    lamp = add_light("POINT", (1.0, 1.0, 1.5), energy=60.0, shadow_soft_size=0.2)
    world = set_world((0.05, 0.08, 0.2))
    bpy.ops.bentlight.black_hole_add(mass=0.1, location=(0.2, 0.0, 0.0))
    scene.world.bentlight.stars, scene.world.bentlight.star_strength = "PROCEDURAL", 1e4  # bright among few samples
    scene.bentlight.integrator = integrator
    scene.bentlight.samples, scene.bentlight.use_adaptive_sampling = 6, False
    scene.render.resolution_x, scene.render.resolution_y = 40, 30
    layer = bpy.context.view_layer
    layer.use_pass_z = layer.use_pass_normal = layer.use_pass_environment = layer.use_pass_vector = True
    layer.bentlight.use_pass_error = layer.bentlight.use_pass_winding = layer.bentlight.use_pass_denoising = True
    layer.use_pass_cryptomatte_object = layer.use_pass_cryptomatte_asset = True
    if integrator == "PATH":  # light from lamps cannot be told apart
        layer.use_pass_diffuse_direct = layer.use_pass_diffuse_color = True
        for name, owner in (("lamp", lamp), ("sky", world)):
            layer.lightgroups.add(name=name)
            owner.lightgroup = name
    return scene


def render_part(monkeypatch, tmp_path, name, *arguments):
    """The file of the part that these arguments ask for."""
    scene = bpy.context.scene
    set_multilayer(scene)
    folder = tmp_path / name
    scene.render.filepath = str(folder / "frame_")
    monkeypatch.setattr(sys, "argv", ["blender", "-b", "--", *arguments])
    bpy.ops.render.render(write_still=True)
    monkeypatch.undo()
    assert scene.render.filepath == str(folder / "frame_")
    (part,) = folder.glob("*.part.exr")
    assert len(list(folder.iterdir())) == 2  # and Blender's own picture, under the part's name
    return str(part)


def assert_same(a, b):
    assert a.keys() == b.keys()
    for name in a:
        np.testing.assert_array_equal(a[name].view(np.uint32), b[name].view(np.uint32), err_msg=name)


def merged(tmp_path, *parts, options=()):
    out = str(tmp_path / "merged.exr")
    assert main(["merge", *parts, "-o", out, *options]) == 0
    layers = {}
    for name, pixels in read_exr(Path(out)).items():
        owner, _, item = name.rpartition(".")
        layers.setdefault(owner, {})[item] = pixels
    return layers["ViewLayer"]


@pytest.mark.parametrize("integrator", ["PATH", "BIDIRECTIONAL"])
def test_merged_parts_are_the_whole(monkeypatch, tmp_path, integrator):
    """Ranges of samples and bands of lines; merged at once, one after the other, and backwards."""
    build(integrator)
    whole = render(tmp_path)
    low = render_part(monkeypatch, tmp_path, "a", "--bentlight-samples", "0:2", "--bentlight-tile=1/2")
    high = render_part(monkeypatch, tmp_path, "b", "--bentlight-samples=0:2", "--bentlight-tile", "2/2")
    rest = render_part(monkeypatch, tmp_path, "c", "--bentlight-samples", "2:6")
    assert Path(low).name == "frame_samples_0-2_tile_1-of-2_0001.part.exr"
    assert whole["Combined"][..., :3].std() > 0.05 and len(np.unique(whole["CryptoObject00"][..., 0])) > 2
    if integrator == "PATH":
        assert whole["Combined_lamp"].max() > 0.1
        stars = whole["Combined_sky"] - [0.05, 0.08, 0.2]
        assert stars.max() > 0.01, "the sky's group has the stars, too"
    assert_same(merged(tmp_path, low, high, rest), whole)
    assert_same(merged(tmp_path, rest, high, low), whole)
    first = str(tmp_path / "first.part.exr")
    assert main(["merge", rest, low, "-o", first, "--part"]) == 0
    assert_same(merged(tmp_path, first, high), whole)


def blur(scene):
    """The roof moves and the camera turns while the shutter is open, in frame 10."""
    for frame, place in ((0, -10.0), (20, 10.0)):
        scene.camera.rotation_euler.x = 0.5 * place
        scene.camera.keyframe_insert("rotation_euler", index=0, frame=frame)
        bpy.data.objects["Roof"].location.x = place
        bpy.data.objects["Roof"].keyframe_insert("location", index=0, frame=frame)
    scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 0.5
    scene.render.motion_blur_position = "CENTER"
    scene.frame_set(10)


def test_merged_parts_are_the_whole_with_motion_blur(monkeypatch, tmp_path, capfd):
    """The frame's name and number are those of all parts, whichever moments they have, also in the frame before."""
    scene = build()
    blur(scene)
    scene.bentlight.samples, scene.bentlight.motion_slices = 100, 64
    scene.render.resolution_x, scene.render.resolution_y = 20, 15
    whole = render(tmp_path)
    parts = [
        render_part(monkeypatch, tmp_path, name, "--bentlight-samples", samples)
        for name, samples in (("a", "0:50"), ("b", "50:100"))
    ]
    assert [Path(part).name for part in parts] == [
        "frame_samples_0-50_0010.part.exr",
        "frame_samples_50-100_0010.part.exr",
    ]
    capfd.readouterr()
    assert_same(merged(tmp_path, *parts), whole)
    assert_same(merged(tmp_path, *reversed(parts)), whole)
    assert not capfd.readouterr().err  # no warning that the scenes differ
    scene.render.use_motion_blur = False
    assert (render(tmp_path)["Combined"] != whole["Combined"]).any()


def test_tiles_obey_the_noise_threshold_and_the_border(monkeypatch, tmp_path):
    scene = build()
    scene.bentlight.samples, scene.bentlight.adaptive_min_samples = 48, 16
    scene.bentlight.use_adaptive_sampling, scene.bentlight.adaptive_threshold = True, 0.1
    scene.render.use_border, scene.render.use_crop_to_border = True, False
    scene.render.border_min_x, scene.render.border_max_x = 0.2, 0.71
    scene.render.border_min_y, scene.render.border_max_y = 0.15, 0.8
    whole = render(tmp_path)
    parts = [render_part(monkeypatch, tmp_path, str(k), "--bentlight-tile", f"{k}/3") for k in (1, 2, 3)]
    assert_same(merged(tmp_path, *parts), whole)
    scene.render.use_crop_to_border = True
    parts = [render_part(monkeypatch, tmp_path, f"crop{k}", "--bentlight-tile", f"{k}/2") for k in (1, 2)]
    assert_same(merged(tmp_path, *parts), render(tmp_path))


def test_layers_and_views_are_merged_side_by_side(monkeypatch, tmp_path):
    scene = build()
    scene.view_layers.new("Second")
    set_multilayer(scene)
    scene.render.filepath = str(tmp_path / "frame_")
    for k in (0, 3):
        monkeypatch.setattr(sys, "argv", ["blender", "--", "--bentlight-samples", f"{k}:{k + 3}"])
        bpy.ops.render.render()
    parts = sorted(map(str, tmp_path.glob("*.part.exr")))
    assert [Path(part).name for part in parts][:2] == [
        "frame_samples_0-3_0001.Second.part.exr",
        "frame_samples_0-3_0001.ViewLayer.part.exr",
    ]
    assert main(["merge", *parts, "-o", str(tmp_path / "out.exr")]) == 0
    image = bpy.data.images.load(str(tmp_path / "out.exr"))
    node = bpy.data.node_groups.new("Compositor", "CompositorNodeTree").nodes.new("CompositorNodeImage")
    node.image, node.layer = image, "ViewLayer"
    assert image.type == "MULTILAYER" and {"Combined", "Depth"} <= {socket.name for socket in node.outputs}
    names = {name.rpartition(".")[0] for name in read_exr(tmp_path / "out.exr")}
    assert names == {"ViewLayer", "Second"}


def test_what_does_not_belong_together_is_named(monkeypatch, tmp_path, capsys):
    scene = build()
    half = render_part(monkeypatch, tmp_path, "half", "--bentlight-samples", "0:3")
    more = render_part(monkeypatch, tmp_path, "more", "--bentlight-samples", "2:6")
    scene.bentlight.seed = 5
    other = render_part(monkeypatch, tmp_path, "other", "--bentlight-samples", "3:6")
    render(tmp_path)
    damaged = tmp_path / "damaged.exr"
    damaged.write_bytes(Path(half).read_bytes()[:-100])
    out = tmp_path / "out.exr"
    for parts, reason in [
        ([half, half], "more than one part has some of samples 0:3"),
        ([half, more], "more than one part has some of samples 2:6"),
        ([half, other], "seed is 0 in one and 5 in another"),
        ([half], f"{40 * 30 * 3} pixel samples are missing"),
        ([str(tmp_path / "render.exr")], "not written by Bentlight"),
        ([str(damaged)], "damaged"),
        ([str(tmp_path / "none.exr")], "No such file"),
    ]:
        assert main(["merge", *parts, "-o", str(out)]) == 1
        assert reason in capsys.readouterr().err
        assert not out.exists()
    assert main(["merge", half, "-o", str(out), "--incomplete"]) == 0


@pytest.mark.parametrize(
    "arguments, reason",
    [
        (["--bentlight-sample", "0:3"], "no such argument"),
        (["--bentlight-samples"], "expected FIRST:END"),
        (["--bentlight-samples", "3:3"], "expected FIRST:END"),
        (["--bentlight-samples", "-1:3"], "expected FIRST:END"),
        (["--bentlight-samples=0:2", "--bentlight-samples=2:3"], "given twice"),
        (["--bentlight-tile", "0/4"], "expected NUMBER/COUNT"),
        (["--bentlight-tile", "5/4"], "expected NUMBER/COUNT"),
        (["--bentlight-resume=yes"], "takes no value"),
    ],
)
def test_bad_arguments_are_named(monkeypatch, arguments, reason):
    with pytest.raises(RenderError, match=reason):
        farm.parse(["blender", "--", *arguments])
    add_camera()
    monkeypatch.setattr(sys, "argv", ["blender", "--", *arguments])
    with pytest.raises(RuntimeError, match=reason):
        bpy.ops.render.render()


def test_other_arguments_are_none_of_ours():
    assert farm.parse(["blender", "--bentlight-samples", "0:3"]) == farm.Job()
    assert farm.parse(["blender", "--", "--cycles-device", "CPU", "--bentlight-resume", "more"]) == farm.Job(
        resume=True
    )


def test_parts_that_the_picture_does_not_have_are_refused(monkeypatch):
    build()
    for arguments, reason in [
        (["--bentlight-samples", "4:8"], "the scene has 6 samples only"),
        (["--bentlight-tile", "31/31"], "has 30 lines only"),
    ]:
        monkeypatch.setattr(sys, "argv", ["blender", "--", *arguments])
        with pytest.raises(RuntimeError, match=reason):
            bpy.ops.render.render()


def test_names_of_pictures():
    assert farm.labelled("//a/frame_####", "x_", ".png") == "//a/frame_x_####"
    assert farm.labelled("//a.b/frame_", "x_", ".png") == "//a.b/frame_x_"
    assert farm.labelled("//frame.png", "x_", ".png") == "//framex_.png"


# ---- Interruptions ----


def resumed_render(tmp_path):
    scene = bpy.context.scene
    set_multilayer(scene)
    scene.render.filepath = str(tmp_path / "frame_")
    bpy.ops.render.render(write_still=True)
    passes = {name.partition(".")[2]: pixels for name, pixels in read_exr(tmp_path / "frame_.exr").items()}
    return passes


KILLED = """
import sys
sys.path[:0] = {paths}
import bpy, blender_addon
blender_addon.register()
bpy.ops.wm.open_mainfile(filepath={file})
bpy.ops.render.render(write_still=True)
"""


@pytest.mark.parametrize("integrator", ["PATH", "BIDIRECTIONAL"])
def test_a_killed_frame_goes_on(monkeypatch, tmp_path, integrator):
    """Killed in another process, as soon as some tiles are in its journal; in the end the same to the last bit."""
    scene = build(integrator)
    scene.bentlight.samples, scene.bentlight.use_adaptive_sampling = 64, True
    scene.bentlight.adaptive_threshold = 0.05
    scene.render.resolution_x, scene.render.resolution_y = 64, 48
    whole = render(tmp_path)
    set_multilayer(scene)
    scene.render.filepath = str(tmp_path / "frame_")
    file, journal = tmp_path / "scene.blend", tmp_path / "frame_0001.checkpoint"
    bpy.ops.wm.save_as_mainfile(filepath=str(file))
    paths = [str(Path(module.__file__).parents[1]) for module in (blender_addon, bentlight_native)]
    script = KILLED.format(paths=paths, file=repr(str(file)))
    if integrator == "BIDIRECTIONAL":
        script = script.replace("blender_addon.register()", LIGHT_OFTEN)
    awaited = journal.with_name(journal.name + ".rounds") if integrator == "BIDIRECTIONAL" else journal
    process = subprocess.Popen([sys.executable, "-c", script, "--", "--bentlight-resume"], cwd=ROOT)
    while process.poll() is None and not (awaited.exists() and journal.stat().st_size > 20_000):
        time.sleep(0.002)
    process.kill()
    assert process.wait() == -signal.SIGKILL, "it was too quick to be killed"
    assert not (tmp_path / "frame_.exr").exists()
    tiles = len(json.loads(journal.read_bytes().partition(b"\n")[0])["tiles"])
    begun = []
    original = farm.remove_when_written
    monkeypatch.setattr(farm, "remove_when_written", lambda files: (begun.append(files), original(files)))
    monkeypatch.setattr(sys, "argv", ["blender", "--", "--bentlight-resume"])
    assert tiles > 10
    assert_same(resumed_render(tmp_path), whole)
    assert begun and not journal.exists() and not awaited.exists()


LIGHT_OFTEN = "from blender_addon import recording; recording._INTERVAL = 0.05; blender_addon.register()"


def test_only_what_is_missing_is_rendered_again(monkeypatch, tmp_path):
    """A journal that is cut off anywhere is gone on with; one of another scene is not."""
    scene = build()
    whole = render(tmp_path)
    kept = []
    monkeypatch.setattr(farm, "remove_when_written", kept.append)
    monkeypatch.setattr(sys, "argv", ["blender", "--", "--bentlight-resume"])
    assert_same(resumed_render(tmp_path), whole)
    journal = kept[0][0]
    data = journal.read_bytes()
    rendered = count_tiles(monkeypatch)
    for end in (len(data), len(data) - 1, len(data) // 2, len(data) // 3, 10):
        journal.write_bytes(data[:end])
        rendered.clear()
        assert_same(resumed_render(tmp_path), whole)
        assert journal.read_bytes() != data[:end] or end == len(data)
        tiles = len(json.loads(data.partition(b"\n")[0])["tiles"])
        assert (len(rendered) == 0) == (end == len(data)) and (len(rendered) == tiles) == (end == 10)
    scene.bentlight.seed = 7
    rendered.clear()
    changed = resumed_render(tmp_path)
    assert len(rendered) == tiles and (changed["Combined"] != whole["Combined"]).any()


@pytest.mark.parametrize("integrator", ["PATH", "BIDIRECTIONAL"])
def test_a_frame_goes_on_from_between_its_rounds(monkeypatch, tmp_path, integrator):
    """With a time limit and motion blur, from files as they were when few tiles, or none, were done."""
    scene = build(integrator)
    blur(scene)
    scene.bentlight.samples, scene.bentlight.motion_slices, scene.bentlight.time_limit = 40, 5, 1000.0
    whole = render(tmp_path)
    monkeypatch.setattr(sys, "argv", ["blender", "--", "--bentlight-resume"])
    monkeypatch.setattr(recording, "_INTERVAL", 0.0)
    files, saved = [tmp_path / f"frame_0010.checkpoint{end}" for end in ("", ".rounds")], []
    go_on = Session.go_on
    monkeypatch.setattr(
        Session, "go_on", lambda self: (saved.append([file.read_bytes() for file in files]), go_on(self))
    )
    rendered = count_tiles(monkeypatch)
    assert_same(resumed_render(tmp_path), whole)
    assert len(saved) > 4 and not any(file.exists() for file in files)
    every = len(rendered)
    for contents in (saved[len(saved) // 3], saved[2 * len(saved) // 3]):
        for file, content in zip(files, contents, strict=True):
            file.write_bytes(content)
        rendered.clear()
        assert_same(resumed_render(tmp_path), whole)
        assert 0 < len(rendered) < every


@pytest.mark.parametrize("integrator", ["PATH", "BIDIRECTIONAL"])
def test_nothing_is_left_of_a_frame_whose_time_is_over(monkeypatch, tmp_path, integrator):
    """But of one that the user has cancelled."""
    scene = build(integrator)
    scene.bentlight.samples, scene.bentlight.time_limit = 1 << 20, 1.0
    monkeypatch.setattr(sys, "argv", ["blender", "--", "--bentlight-resume"])
    monkeypatch.setattr(recording, "_INTERVAL", 0.1)
    removed = []
    original = farm.remove_when_written
    monkeypatch.setattr(
        farm, "remove_when_written", lambda files: (removed.extend(f for f in files if f.exists()), original(files))
    )
    finish = Recording.finish
    with monkeypatch.context() as patch:
        patch.setattr(Recording, "finish", lambda self, _, star_sums: finish(self, True, star_sums))
        resumed_render(tmp_path)
    assert not removed and (tmp_path / "frame_0001.checkpoint").exists()
    resumed_render(tmp_path)
    assert [file.suffix for file in removed] == [".checkpoint", ".rounds"]
    assert [file.name for file in tmp_path.iterdir()] == ["frame_.exr"]


def test_stars_of_some_moments_alone_are_no_part(monkeypatch, tmp_path):
    """When the user gives up after the last tile but before the last moment's stars; the checkpoint stays."""
    scene = build()
    blur(scene)
    scene.bentlight.samples = scene.bentlight.motion_slices = 4
    monkeypatch.setattr(sys, "argv", ["blender", "--", "--bentlight-resume", "--bentlight-samples=0:4"])
    part, journal = (tmp_path / f"frame_samples_0-4_0010.{end}" for end in ("part.exr", "checkpoint"))
    with monkeypatch.context() as patch:
        patch.setattr(farm, "remove_when_written", lambda files: None)
        resumed_part(tmp_path)
    whole, tiles = part.read_bytes(), journal.read_bytes()
    part.unlink()
    rendered = count_tiles(monkeypatch)
    move, finish = final._ViewRender._move, Recording.finish
    with monkeypatch.context() as patch:
        patch.setattr(final._ViewRender, "_move", lambda self, at, *rest: None if at > 1 else move(self, at, *rest))
        patch.setattr(Recording, "finish", lambda self, _, star_sums: finish(self, True, star_sums))
        resumed_part(tmp_path)
    assert not part.exists() and journal.read_bytes() == tiles
    resumed_part(tmp_path)
    assert not rendered and not journal.exists()
    assert part.read_bytes() == whole


def resumed_part(tmp_path):
    scene = bpy.context.scene
    set_multilayer(scene)
    scene.render.filepath = str(tmp_path / "frame_")
    bpy.ops.render.render(write_still=True)


def test_a_checkpoint_does_not_grow_with_rounds(monkeypatch, tmp_path):
    """However often it is written: of each tile there is one record, also when the frame has gone on."""
    scene = build()
    scene.bentlight.samples, scene.bentlight.time_limit = 200, 1000.0
    scene.render.resolution_x, scene.render.resolution_y = 20, 15
    kept, sizes = [], []
    monkeypatch.setattr(farm, "remove_when_written", kept.append)
    monkeypatch.setattr(recording, "_INTERVAL", 0.0)
    monkeypatch.setattr(sys, "argv", ["blender", "--", "--bentlight-resume"])
    rendered = count_tiles(monkeypatch)
    for _ in range(2):
        resumed_render(tmp_path)
        sizes.append(kept[-1][0].stat().st_size)
    data = kept[0][0].read_bytes()
    head, _, _ = data.partition(b"\n")
    records = list(checkpoint._records(data, len(head) + 1))
    numbers = [number for _, number, _, _, _ in records]
    assert len(rendered) > 10 * len(numbers) and sizes[0] == sizes[1]
    assert sorted(numbers) == list(range(len(json.loads(head)["tiles"])))
    assert [left for _, _, left, _, _ in records] == [0] * len(numbers)


def count_tiles(monkeypatch) -> list:
    """A list that gets an entry for each tile that is rendered."""
    from bentlight_native import Scene

    original, calls = Scene.render_tile, []

    def counted(self, *arguments):
        calls.append(None)
        return original(self, *arguments)

    monkeypatch.setattr(Scene, "render_tile", counted)
    return calls


def test_the_command_line(tmp_path):
    """`python -m bentlight_native`, `bentlight` and `blender --command bentlight` are the same command."""
    environment = os.environ | {"PYTHONPATH": str(Path(bentlight_native.__file__).parents[1])}
    command = [sys.executable, "-m", "bentlight_native", "merge", "none.exr", "-o", "out.exr"]
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert done.returncode == 1 and done.stderr.startswith("bentlight: ") and "none.exr" in done.stderr
    script = tomllib.loads((ROOT / "native/pyproject.toml").read_text())["project"]["scripts"]["bentlight"]
    assert script == f"{main.__module__}:{main.__name__}"
    assert farm.command(["merge", "none.exr", "-o", "out.exr"]) == 1
    assert hasattr(bpy.utils, "register_cli_command")


def documented_commands():
    """The arguments of every Blender command of docs/farms.md, from the file's name on."""
    text = (ROOT / "docs" / "farms.md").read_text()
    return [line.split()[1:] for line in re.findall(r"^blender .*$", text, re.MULTILINE)]


def test_the_documented_commands(monkeypatch, tmp_path):
    """Each render is as its arguments say, and the merge takes the names of files that those made."""
    scene = build()
    scene.bentlight.samples = 128
    scene.render.resolution_x, scene.render.resolution_y = 8, 6
    renders = [words for words in documented_commands() if words[0] == "-b" and "#IFRAME#" not in words]
    merges = [words[2:] for words in documented_commands() if words[:2] == ["--command", "bentlight"]]
    assert len(renders) == 4 and len(merges) == 1
    whole = render(tmp_path)
    set_multilayer(scene)
    for words in renders:
        scene.render.filepath = str(tmp_path / words[words.index("-o") + 1].removeprefix("//"))
        monkeypatch.setattr(sys, "argv", ["blender", *words])
        bpy.ops.render.render(write_still=True)
    monkeypatch.chdir(tmp_path)
    assert farm.command(merges[0]) == 0
    merged_passes = {name.partition(".")[2]: pixels for name, pixels in read_exr(tmp_path / "frame_0001.exr").items()}
    assert_same(merged_passes, whole)
