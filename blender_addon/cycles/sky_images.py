"""Images of the sky as files that shaders can filter: linear colors, whatever the image is to Blender."""

from __future__ import annotations

import logging
import os
from pathlib import Path
from typing import NamedTuple

import bpy
import numpy as np

from ..report import RenderError
from ..sync.images import image_pixels
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
    """A file of the folder of the tables, top row first; `height`: its rows."""

    path: Path
    height: int


_files: dict[_Key, File | None] = {}  # reading pixels takes longer than a change of the scene may


def forget() -> None:
    """What may have been painted since is read afresh."""
    for key in [key for key in _files if key.is_painted]:
        del _files[key]


def file_of(image: bpy.types.Image) -> File | None:
    """The file of an image; None for those that change from frame to frame, and those that cannot be read."""
    if image.source in ("SEQUENCE", "MOVIE", "TILED"):
        return None
    key = _key(image)
    if key not in _files or (_files[key] and not _files[key].path.is_file()):
        try:
            colors = _linear(image)
            _files[key] = File(files.named_by_content("sky", colors[::-1]), len(colors))
        except RenderError as error:
            log.warning("%s", error)
            _files[key] = None
    return _files[key]


def _key(image: bpy.types.Image) -> _Key:
    path = bpy.path.abspath(image.filepath, library=image.library)
    changed = os.stat(path).st_mtime_ns if os.path.isfile(path) else None
    is_painted = image.is_dirty or image.source == "GENERATED"
    space = image.colorspace_settings.name
    return _Key(image.name_full, tuple(image.size), path, changed, space, image.alpha_mode, is_painted)


def _linear(image: bpy.types.Image) -> np.ndarray:
    """(height, width, 3), rows from the bottom up, float16 where that can hold them."""
    pixels = image_pixels(image, log.warning)
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
