"""Every command of Blender in the documents, also those that managers of render farms are given: a shell takes it apart
as a farm's would, Blender knows its options, and what is ours is accepted by the parser that will read it."""

import json
import os
import re
import shutil
import stat
import subprocess
import sys
from fnmatch import fnmatch
from types import ModuleType, SimpleNamespace

import pytest
from bentlight_native import command as merging

from blender_addon import farm
from tests.package.test_docs import DOCUMENTS, blocks, commands

# A Blender that says how it was called.
BLENDER = """#!{python}
import json, sys
print(json.dumps(sys.argv[1:]))
"""
FRAME = "3"  # where OpenCue writes the number of a frame


@pytest.fixture
def shell(tmp_path):
    """A function that runs a command line by the shell, in a folder with two parts of a frame: how Blender was called,
    each call a list of arguments."""
    program = tmp_path / "bin" / "blender"
    program.parent.mkdir()
    program.write_text(BLENDER.format(python=sys.executable))
    program.chmod(program.stat().st_mode | stat.S_IXUSR)
    folder = tmp_path / "folder"
    (folder / "dist").mkdir(parents=True)
    for name in ("frame_a.part.exr", "frame_b.part.exr", "dist/bentlight-0.1.0-linux_x64.zip"):
        (folder / name).touch()

    def run(line: str) -> list[list[str]]:
        path = f"{program.parent}{os.pathsep}{os.environ['PATH']}"
        line = line.replace("#IFRAME#", FRAME)
        done = subprocess.run(["sh", "-c", line], cwd=folder, env={"PATH": path}, capture_output=True, text=True)
        assert done.returncode == 0, f"{line}: {done.stderr}"
        return [json.loads(call) for call in done.stdout.splitlines()]

    return run


def check_blender(arguments: list[str]) -> str:
    """Asserts that Blender takes these arguments; tells what they do: "render", "merge" or "install"."""
    if arguments[:2] == ["--command", "bentlight"]:
        options = merging._parser().parse_args(arguments[2:])
        assert options.parts and options.output.endswith(".exr"), arguments
        return "merge"
    if arguments[:3] == ["--command", "extension", "install-file"]:
        *options, file = arguments[3:]
        assert options == ["-r", "user_default", "--enable"] and fnmatch(file, "dist/bentlight-*.zip"), arguments
        return "install"
    end = arguments.index("--") if "--" in arguments else len(arguments)
    own, ours = arguments[:end], arguments[end + 1 :]
    rest = re.fullmatch(r"-b \S+\.blend -E BENTLIGHT -o \S+( -f \d+| -a)", " ".join(own))
    assert rest, arguments  # Blender reads from left to right: -f and -a must come last
    job = farm.parse(arguments)
    taken = sum([bool(job.samples) * 2, bool(job.tile) * 2, job.resume])
    assert taken == len([word for part in ours for word in part.split("=")]), f"not all of it is read: {ours}"
    assert job.is_kept == bool(ours)
    return "render"


@pytest.mark.parametrize("line", [line for line in commands() if line.startswith("blender")])
def test_a_command_of_blender_is_one(line, shell):
    (arguments,) = shell(line)
    check_blender(arguments)


@pytest.mark.parametrize(
    "wrong",
    [
        "-b scene.blend -f 1 -E BENTLIGHT -o //frame_",
        "-b scene.blend -E BENTLIGHT -o //frame_ -f 1 -- --bentlight-sample 0:64",
        "-b scene.blend -E BENTLIGHT -o //frame_ -f 1 -- --bentlight-samples 64:0",
        "-b scene.blend -E BENTLIGHT -o //frame_ -f 1 -- --resume",
        "--command bentlight merge a.part.exr",
        "--command bentlight join a.part.exr -o b.exr",
    ],
)
def test_a_wrong_command_is_none(wrong):
    with pytest.raises((AssertionError, farm.RenderError, SystemExit)):
        check_blender(wrong.split())


def test_forms_of_merging_in_the_text_are_accepted():
    found = [form for path in DOCUMENTS for form in re.findall(r"`bentlight (merge [^`]+)`", path.read_text())]
    assert len(found) == 3
    for form in found:
        options = merging._parser().parse_args([word for word in form.split() if word != "..."])
        assert (options.parts, options.output) == (["PART"], "OUT")


# Flamenco's side of its block: settings that a user gave, and authors of tasks and commands.
FLAMENCO = """
const settings = {samples: 150, samples_per_task: 64, frame: 1, blendfile: "scene.blend",
                  render_output_path: "frame_", merged_path: "frame_0001.exr"};
const tasks = [], author = {
    Command: (name, parameters) => ({name, parameters}),
    Task: (name, type) => ({name, type, commands: [], after: [],
                            addCommand(command) { this.commands.push(command); },
                            addDependency(task) { this.after.push(task.name); }}),
};
const job = {addTask: (task) => tasks.push(task)};
"""


@pytest.mark.skipif(shutil.which("node") is None, reason="needs Node.js")
def test_flamencos_block_makes_tasks_that_render_and_merge(shell):
    (script,) = [text for _, _, text in blocks("js")]
    script = f"{FLAMENCO}{script}console.log(JSON.stringify(tasks));"
    done = subprocess.run(["node", "-e", script], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    *parts, merge = json.loads(done.stdout)
    assert [part["name"] for part in parts] == ["samples-0-64", "samples-64-128", "samples-128-150"]
    for part in parts:
        (command,) = part["commands"]
        assert command["name"] == "blender-render"
        asked = command["parameters"]
        assert check_blender(["-b", asked["blendfile"], *asked["args"]]) == "render"
    (command,) = merge["commands"]
    assert merge["after"] == [part["name"] for part in parts]
    program, option, line = command["parameters"]["exe"], *command["parameters"]["args"]
    assert (command["name"], program, option) == ("exec", "sh", "-c")
    assert [check_blender(call) for call in shell(line)] == ["merge"]


def test_brackets_of_flamencos_block_are_closed():
    """Where there is no Node.js: what it would refuse first."""
    (script,) = [text for _, _, text in blocks("js")]
    text, open_ones = re.sub(r"\"[^\"\n]*\"", "", script), []
    for letter in text:
        if letter in "([{":
            open_ones.append(letter)
        elif letter in ")]}":
            assert open_ones and "([{".index(open_ones.pop()) == ")]}".index(letter)
    assert not open_ones and text.count("`") % 2 == 0


def test_opencues_block_launches_layers_that_render_and_merge(shell, monkeypatch):
    """By modules that only write down what they are told."""
    launched = []

    class Shell:
        def __init__(self, name, **settings):
            self.name, self.settings, self.after = name, settings, []

        def depend_on(self, other):
            self.after.append(other.name)

    class Outline:
        def __init__(self, name, **settings):
            assert set(settings) == {"shot", "show", "user"}
            self.layers = []

        def add_layer(self, layer):
            self.layers.append(layer)

    outline, modules, inner = (ModuleType(name) for name in ("outline", "outline.modules", "outline.modules.shell"))
    outline.Outline, outline.cuerun, inner.Shell = Outline, SimpleNamespace(launch=launched.append), Shell
    for module in (outline, modules, inner):
        monkeypatch.setitem(sys.modules, module.__name__, module)
    (block,) = [text for _, _, text in blocks("python opencue")]
    exec(compile(block, "farms.md", "exec"), {})
    ((parts, merge),) = [job.layers for job in launched]
    assert merge.after == [parts.name]
    for layer, does in ((parts, "render"), (merge, "merge")):
        assert layer.settings["command"][:2] == ["sh", "-c"]
        (calls,) = shell(" ".join(layer.settings["command"]))  # OpenCue joins words by spaces, for a shell
        assert check_blender(calls) == does
    assert farm.parse(shell(" ".join(parts.settings["command"]))[0]).samples == (192, 256)
