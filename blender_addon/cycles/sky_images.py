"""Images of the sky as files that shaders can filter: linear colors, whatever the image is to Blender."""

from __future__ import annotations

import logging
import os
import re
from pathlib import Path
from typing import NamedTuple

import bpy
import numpy as np

from ..report import RenderError
from ..sync.images import Pixels, file_pixels, image_pixels
from . import files

log = logging.getLogger(__name__)

_HALF_MAX = 65504.0


class _Key(NamedTuple):
    """Tells whether an image is what it was, as long as nobody paints on it."""

    name: str
    size: tuple[int, int]
    path: str
    changed_ns: int | None  # when the file was, if there is one
    color_space: str
    alpha_mode: str
    is_painted: bool


class File(NamedTuple):
    """A file of colors, top row first; `height`: its rows."""

    path: Path
    height: int


# Or why there is none. Reading pixels takes longer than a change of the scene may.
_files: dict[_Key, File | str] = {}


def forget() -> None:
    """What may have been painted since is read afresh."""
    for key in [key for key in _files if key.is_painted]:
        del _files[key]


def file_of(image: bpy.types.Image, user: bpy.types.ImageUser | None = None, frame: int = 0) -> File:
    """The file of an image; `user`, `frame`: which picture of an image sequence it is.

    Raises RenderError for images that cannot be read, and for kinds that are not filtered.
    """
    if image.source == "MOVIE":  # whose pixels Blender shows in Python as those of some frame
        raise RenderError("image '{}' is a movie", image.name)
    if image.source == "TILED":
        raise RenderError("image '{}' is tiled (UDIM)", image.name)
    path = image.filepath if image.source != "SEQUENCE" or user is None else _frame_path(image.filepath, user, frame)
    path = bpy.path.abspath(path, library=image.library)
    key = _key(image, path)
    known = _files.get(key)
    if known is None or (isinstance(known, File) and not known.path.is_file()):
        try:
            known = _written(image, path)
        except RenderError as error:
            known = str(error)
        _files[key] = known
    if isinstance(known, str):
        raise RenderError(known)
    return known


def _written(image: bpy.types.Image, path: str) -> File:
    if image.source == "SEQUENCE":
        colors = _linear(file_pixels(image, path, log.warning))
        return File(files.passing("sky", colors[::-1]), len(colors))
    colors = _linear(image_pixels(image, log.warning))
    return File(files.named_by_content("sky", colors[::-1]), len(colors))


def _key(image: bpy.types.Image, path: str) -> _Key:
    changed = os.stat(path).st_mtime_ns if os.path.isfile(path) else None
    is_painted = image.is_dirty or image.source == "GENERATED"
    space = image.colorspace_settings.name
    return _Key(image.name_full, tuple(image.size), path, changed, space, image.alpha_mode, is_painted)


def _frame_path(path: str, user: bpy.types.ImageUser, frame: int) -> str:
    """Of a frame of an image sequence, as Blender counts them. What it tells itself is right with Auto Refresh alone,
    and Cycles needs none."""
    passed, length = frame - user.frame_start + 1, user.frame_duration
    number = (passed - 1) % length + 1 if user.use_cyclic and length else min(max(passed, 0), length)
    shown = max(number + user.frame_offset, 0)
    stem, extension = os.path.splitext(path)
    return re.sub(r"\d+(?=[^\d/\\]*$)", lambda digits: f"{shown:0{len(digits[0])}}", stem) + extension


def _linear(pixels: Pixels) -> np.ndarray:
    """(height, width, 3), rows from the bottom up, float16 where that can hold them."""
    colors = pixels.values[..., :3]
    if colors.dtype == np.uint8:
        codes = np.arange(256) / 255
        colors = (_decoded(codes) if pixels.srgb else codes).astype(np.float16)[colors]
    elif pixels.srgb:
        colors = _decoded(colors)
    return colors.astype(np.float16 if np.abs(colors).max(initial=0) < _HALF_MAX else np.float32)


def _decoded(values: np.ndarray) -> np.ndarray:
    """From the sRGB curve (IEC 61966-2-1) to linear."""
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)
