"""Images of the sky as files that shaders can filter: linear colors, whatever the image is to Blender."""

from __future__ import annotations

import logging
from pathlib import Path
from typing import NamedTuple

import bpy
import numpy as np

from ..report import RenderError
from ..sync.images import image_pixels
from . import files

log = logging.getLogger(__name__)

_HALF_MAX = 65504.0


class File(NamedTuple):
    """A file of the folder of the tables, top row first; `height`: its rows."""

    path: Path
    height: int


_files: dict[tuple, File] = {}  # reading pixels takes longer than a change of the scene may


def forget() -> None:
    """What is in images is read afresh: their pixels may have changed."""
    _files.clear()


def file_of(image: bpy.types.Image) -> File | None:
    """The file of an image; None for those that change from frame to frame, and those that cannot be read."""
    if image.source in ("SEQUENCE", "MOVIE", "TILED"):
        return None
    key = (image.name_full, tuple(image.size), image.filepath, image.colorspace_settings.name, image.alpha_mode)
    if key not in _files or not _files[key].path.is_file():
        try:
            colors = _linear(image)
        except RenderError as error:
            log.warning("%s", error)
            return None
        _files[key] = File(files.named_by_content("sky", colors[::-1]), len(colors))
    return _files[key]


def _linear(image: bpy.types.Image) -> np.ndarray:
    """(height, width, 3), rows from the bottom up, float16 where that can hold them."""
    pixels = image_pixels(image, log.warning)
    colors = pixels.values[..., :3]
    if colors.dtype == np.uint8:
        codes = np.arange(256) / 255
        curve = np.where(codes <= 0.04045, codes / 12.92, ((codes + 0.055) / 1.055) ** 2.4)
        colors = (curve if pixels.srgb else codes).astype(np.float16)[colors]
    elif pixels.srgb:
        colors = np.where(colors <= 0.04045, colors / 12.92, ((colors + 0.055) / 1.055) ** 2.4)
    return colors.astype(np.float16 if np.abs(colors).max(initial=0) < _HALF_MAX else np.float32)
