"""Blender images as pixels for the core.

Bytes stay bytes, as they are in the file: the core divides by 255, interpolates, and then decodes the sRGB curve, as
Cycles does. Floats are scene-linear already. Color is associated with alpha (multiplied by it), unless the image is
data or says otherwise.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Hashable
from pathlib import Path
from typing import Any, NamedTuple

import bpy
import numpy as np

from ..report import RenderError, told
from .memory import Memory

_INTEGER_FORMATS = ("PNG", "TIFF", "JPEG2000", "DPX", "CINEON")  # that may have 16 bits per channel


class Pixels(NamedTuple):
    """(height, width, 4), rows from the bottom up, uint8 or float32; `srgb`: encoded by that curve. The arguments of
    Scene.add_image."""

    values: np.ndarray
    srgb: bool


class ImageTable:
    """The images of a scene, each converted once. `images[i]` is image i of the native scene."""

    def __init__(self, memory: Memory | None = None) -> None:
        self.images: list[Pixels] = []
        self._index: dict[Any, int] = {}
        self._memory = memory or Memory()

    def index_of(self, image: Any, warn: Callable[[str], None]) -> int:
        """The index of a Blender image; reads it if it is new. Raises RenderError if it cannot be read."""
        key = image.name_full
        if key not in self._index:
            self.images.append(self._memory.image(image, lambda: image_pixels(image, warn)))
            self._index[key] = len(self.images) - 1
        return self._index[key]

    def tiles_of(self, image: Any, warn: Callable[[str], None]) -> tuple[int, list[int]]:
        """The index of the first tile of a Blender image, which the others follow, and the UDIM numbers of all."""
        key = image.name_full
        if key not in self._index:
            tiles = [_tile_pixels(image, tile.number, warn) for tile in image.tiles]
            self._index[key] = len(self.images)
            self.images += tiles
        return self._index[key], [tile.number for tile in image.tiles]

    def index_of_made(self, key: Hashable, make: Callable[[], Pixels]) -> int:
        """The index of pixels that belong to no Blender image; makes them if `key` is new."""
        if key not in self._index:
            self.images.append(make())
            self._index[key] = len(self.images) - 1
        return self._index[key]


def has_associated_alpha(image: Any) -> bool:
    """Whether the pixels that image_pixels returns are multiplied by alpha."""
    return not image.colorspace_settings.is_data and image.alpha_mode in ("STRAIGHT", "PREMUL")


def image_pixels(image: Any, warn: Callable[[str], None]) -> Pixels:
    """The pixels of an image as the core wants them.

    Packed, external and generated images; of a tiled one the first tile. Raises RenderError naming image and file if it
    cannot be read; NaN and infinity become 0, with a warning.
    """
    if image.source == "TILED":
        warn(told("image '{}' is tiled (UDIM); only Image Texture nodes can show more than its first tile", image.name))
    width, height = image.size
    if width == 0 or height == 0:
        raise RenderError("Image '{}': its file '{}' is missing or cannot be read", image.name, image.filepath)
    values = np.empty(width * height * 4, np.float32)
    image.pixels.foreach_get(values)
    values = values.reshape(height, width, 4)
    if not np.isfinite(values).all():
        warn(told("image '{}' has pixels that are not finite; they count as 0", image.name))
        values = np.nan_to_num(values, nan=0.0, posinf=0.0, neginf=0.0)
    if image.alpha_mode == "NONE":
        values[..., 3] = 1.0
    if not image.is_float:
        return _byte_pixels(image, values, warn)
    if image.file_format in _INTEGER_FORMATS and image.source == "FILE" and image.colorspace_settings.name == "sRGB":
        return Pixels(_encoded(values), srgb=True)
    return Pixels(values, srgb=False)


def _tile_pixels(image: Any, number: int, warn: Callable[[str], None]) -> Pixels:
    """One tile, its file read as an image of its own: of a tiled image Blender's Python shows the first tile only."""
    column, row = (number - 1001) % 10, (number - 1001) // 10
    name = image.filepath.replace("<UDIM>", str(number)).replace("<UVTILE>", f"u{column + 1}_v{row + 1}")
    packed = next((item for item in image.packed_files if item.tile_number == number), None)
    with tempfile.TemporaryDirectory() as folder:
        path = bpy.path.abspath(name, library=image.library)
        if packed:
            path = os.path.join(folder, os.path.basename(path) or "tile")
            Path(path).write_bytes(packed.packed_file.data)
        return file_pixels(image, path, warn)


def file_pixels(image: Any, path: str, warn: Callable[[str], None]) -> Pixels:
    """The pixels of a file as `image` would show them: one of its tiles or frames."""
    try:
        copy = bpy.data.images.load(path)
    except RuntimeError as error:
        text = "Image '{}': its file '{}' is missing or cannot be read"
        raise RenderError(text, image.name, os.path.basename(path)) from error
    try:
        copy.colorspace_settings.name, copy.alpha_mode = image.colorspace_settings.name, image.alpha_mode
        return image_pixels(copy, warn)
    finally:
        bpy.data.images.remove(copy)


def _encoded(values: np.ndarray) -> np.ndarray:
    """Scene-linear pixels with associated alpha, back on the sRGB curve.

    Those of 16 bits per channel: Blender holds them as linear floats, Cycles interpolates them as they are in the file.
    """
    alpha = values[..., 3:]
    straight = np.maximum(values[..., :3] / np.where(alpha > 0, alpha, 1), 0)
    curve = np.where(straight <= 0.0031308, 12.92 * straight, 1.055 * straight ** (1 / 2.4) - 0.055)
    truncated = np.floor(curve * alpha * 65535) / 65535  # as Cycles does
    color = np.where(alpha < 1, truncated, curve)
    return np.concatenate([color, alpha], axis=-1).astype(np.float32)


def _byte_pixels(image: Any, values: np.ndarray, warn: Callable[[str], None]) -> Pixels:
    space = image.colorspace_settings
    srgb = space.name == "sRGB"
    if not (srgb or space.is_data or space.name in ("Linear Rec.709", "Linear", "scene_linear")):
        warn(
            told("image '{}': the color space '{}' is not supported yet; sRGB is used instead", image.name, space.name)
        )
        srgb = True
    pixels = np.rint(values * 255).astype(np.uint8)
    if has_associated_alpha(image):
        # In memory Blender keeps bytes straight, whatever the file has. Rounded as Cycles does.
        pixels[..., :3] = pixels[..., :3].astype(np.uint16) * pixels[..., 3:] // 255
    return Pixels(pixels, srgb)
