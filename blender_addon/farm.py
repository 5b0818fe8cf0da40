"""Render farms: what the arguments after `--` ask for, and where its files go.

blender -b scene.blend -E BENTLIGHT -o //frame_ -f 1 -- --bentlight-samples 0:64 --bentlight-tile 1/4
"""

from __future__ import annotations

import logging
import os
import re
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import bentlight_native
import bpy
from bpy.app.handlers import persistent

from .compatibility import ENGINE
from .report import RenderError, Reporter

log = logging.getLogger(__name__)

_PREFIX = "--bentlight-"
_FORMS = {"samples": "FIRST:END, as 0:64", "tile": "NUMBER/COUNT, as 1/4", "resume": "nothing"}


@dataclass(frozen=True)
class Job:
    """What of each frame this Blender is to render, and whether it goes on with what it has begun before.

    samples: the first, and the one after the last. tile: number of a band of lines, from 1 at the bottom, and how many
    there are.
    """

    samples: tuple[int, int] | None = None
    tile: tuple[int, int] | None = None
    resume: bool = False

    @property
    def is_part(self) -> bool:
        """Whether pictures are not whole."""
        return bool(self.samples or self.tile)

    @property
    def is_kept(self) -> bool:
        """Whether pictures are kept, as parts or for another render to go on with."""
        return self.is_part or self.resume

    @property
    def label(self) -> str:
        """What distinguishes the names of its files: "samples_0-64_tile_1-of-4_", or nothing."""
        samples = f"samples_{self.samples[0]}-{self.samples[1]}_" if self.samples else ""
        tile = f"tile_{self.tile[0]}-of-{self.tile[1]}_" if self.tile else ""
        return samples + tile

    def part_of(self, settings: bentlight_native.RenderSettings, reporter: Reporter) -> bentlight_native.RenderSettings:
        """The settings of the whole picture with the wanted samples. Raises RenderError for samples that it has not."""
        if not self.samples:
            return settings
        first, end = self.samples
        if end > settings.sample_count:
            text = "{}samples {}:{}: the scene has {} samples only"
            raise RenderError(text, _PREFIX, first, end, settings.sample_count)
        if settings.noise_threshold:
            reporter.warn(
                "A range of samples takes all of them: the noise threshold, which looks at the others, is off"
            )
        return replace(settings, first_sample=first, sample_count=end - first, noise_threshold=0.0)

    def window_of(self, window: tuple[int, int, int, int]) -> tuple[int, int, int, int]:
        """The part of the window, x, y, width and height, that the tile is. Raises RenderError if it is empty."""
        if not self.tile:
            return window
        x, y, width, height = window
        number, count = self.tile
        if count > height:
            raise RenderError("{}tile {}/{}: the picture has {} lines only", _PREFIX, number, count, height)
        low, high = (height * k // count for k in (number - 1, number))
        return x, y + low, width, high - low


def parse(arguments: Sequence[str]) -> Job:
    """The job that a command line asks for after `--`. Raises RenderError for arguments of ours that make no sense."""
    ours = list(arguments[arguments.index("--") + 1 :]) if "--" in arguments else []
    found: dict[str, str] = {}
    while ours:
        name, equals, value = ours.pop(0).partition("=")
        if not name.startswith(_PREFIX):
            continue
        kind = name.removeprefix(_PREFIX)
        if kind not in _FORMS:
            raise RenderError(
                "{}: no such argument; there are {}", name, ", ".join(_PREFIX + known for known in _FORMS)
            )
        if kind in found:
            raise RenderError("{}: given twice", name)
        if kind != "resume" and not equals:
            value = ours.pop(0) if ours else ""
        found[kind] = value
    return Job(
        samples=_pair(found, "samples", r"(\d+):(\d+)", lambda first, end: first < end < 1 << 31),
        tile=_pair(found, "tile", r"(\d+)/(\d+)", lambda number, count: 1 <= number <= count),
        resume="resume" in found and _is_nothing(found["resume"]),
    )


def _pair(
    found: dict[str, str], kind: str, form: str, makes_sense: Callable[[int, int], bool]
) -> tuple[int, int] | None:
    if kind not in found:
        return None
    match = re.fullmatch(form, found[kind], re.ASCII)
    numbers = tuple(map(int, match.groups())) if match else ()
    if not numbers or not makes_sense(*numbers):
        raise RenderError("{}{}: expected {}, got '{}'", _PREFIX, kind, _FORMS[kind], found[kind])
    return numbers


def _is_nothing(value: str) -> bool:
    if value:
        raise RenderError("{}resume: takes no value, got '{}'", _PREFIX, value)
    return True


def job() -> Job:
    """What Blender's own command line asks for. Raises RenderError as `parse`."""
    return parse(sys.argv)


# ---- Names of files ----


def stem(scene: bpy.types.Scene, frame: int, layer: str, view: str) -> str:
    """The path of a frame's picture without its extension; with the layer's and view's names if there are several."""
    path = bpy.path.abspath(scene.render.frame_path(frame=frame, view=view))
    names = [name for name in (layer if len(_used_layers(scene)) > 1 else "", view) if name]
    return ".".join([path.removesuffix(scene.render.file_extension), *map(bpy.path.clean_name, names)])


def _used_layers(scene: bpy.types.Scene) -> list[bpy.types.ViewLayer]:
    return [layer for layer in scene.view_layers if layer.use]


def labelled(path: str, label: str, extension: str) -> str:
    """An output path of Blender with a label in the file's name, before the frame's number."""
    folder, name = os.path.split(path)
    hashes = re.search("#+", name)
    at = hashes.start() if hashes else len(name.removesuffix(extension))
    return os.path.join(folder, name[:at] + label + name[at:])


_paths: dict[str, str] = {}  # of scenes, by name, that have been changed for as long as they are rendered


@persistent
def _begin(scene: bpy.types.Scene, _unused: object = None) -> None:
    """Before a render: parts have pictures of their own names, so that machines do not write over each other's."""
    try:
        label = job().label
    except RenderError:  # as the render will say
        return
    if label and scene.render.engine == ENGINE:
        _paths[scene.name] = scene.render.filepath
        scene.render.filepath = labelled(scene.render.filepath, label, scene.render.file_extension)


@persistent
def _end(scene: bpy.types.Scene, _unused: object = None) -> None:
    if scene.name in _paths:
        scene.render.filepath = _paths.pop(scene.name)


# ---- Failures ----


def fail(text: str) -> None:
    """Ends a Blender in the background that does a job, which would otherwise call a failed frame a success."""
    if bpy.app.background and not bpy.app.module and any(argument.startswith(_PREFIX) for argument in sys.argv):
        sys.stderr.write(f"Error: Bentlight: {text}\n")
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(1)


_removable: list[Path] = []  # checkpoints of pictures that Blender has not written yet


def remove_when_written(files: Sequence[Path]) -> None:
    """Of a picture that is complete: its checkpoint is kept until Blender has written it."""
    _removable.extend(files)


@persistent
def _written(_scene: bpy.types.Scene, _unused: object = None) -> None:
    while _removable:
        _removable.pop().unlink(missing_ok=True)


def command(arguments: Sequence[str]) -> int:
    """`blender --command bentlight`: what the command `bentlight` does; returns the exit status."""
    return bentlight_native.run_command(arguments)


_command: object = None  # for as long as Blender knows it
_HANDLERS = (("render_init", _begin), ("render_complete", _end), ("render_cancel", _end), ("render_write", _written))


def register() -> None:
    """Looks at the command line: what makes no sense there ends a Blender in the background at once."""
    try:
        job()
    except RenderError as error:
        log.error("%s", error)
        fail(str(error))
    for name, handler in _HANDLERS:
        getattr(bpy.app.handlers, name).append(handler)
    global _command
    _command = bpy.utils.register_cli_command("bentlight", command)


def unregister() -> None:
    """Takes handlers and command back."""
    global _command
    bpy.utils.unregister_cli_command(_command)
    _command = None
    for name, handler in _HANDLERS:
        getattr(bpy.app.handlers, name).remove(handler)
