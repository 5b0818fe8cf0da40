"""Minimal OpenEXR files: one part, tiles of one level, float32 channels, no compression, string attributes.

Every OpenEXR reader opens them (Cycles and OSL among them); this module reads back only what it wrote. It is needed
because no EXR library is there in all the Pythons that Bentlight runs in: Blender's wheels carry none for Python.
Format: OpenEXR File Layout, openexr.com (version 2, single-part tiled file). Tiles, because Open Shading Language's
texture cache cuts files of scan lines into tiles itself, and with several threads then sometimes serves a tile with
what was in memory before: in 2 of 60 renders by Cycles with 8 threads.
"""

import hashlib
import os
import struct
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

_MAGIC = struct.pack("<II", 20000630, 2 | 0x200)
_TILE = 64  # pixels, each way; images that are less high have lower ones
_ONE_LEVEL = 0
_CHECKSUM = "bentlightChecksum"


class ExrError(ValueError):
    """A file that is not one of ours, truncated or damaged. The message names the file and the reason."""


def _attribute(name: str, kind: str, value: bytes) -> bytes:
    return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(value)) + value


def _header(names: list[str], width: int, height: int, strings: dict[str, str]) -> bytes:
    channels = b"".join(name.encode() + b"\0" + struct.pack("<iBxxxii", 2, 0, 1, 1) for name in names) + b"\0"
    window = struct.pack("<iiii", 0, 0, width - 1, height - 1)
    tile_height = min(_TILE, 1 << (height - 1).bit_length())  # texture caches hold whole tiles
    parts = [
        _attribute("channels", "chlist", channels),
        _attribute("compression", "compression", b"\0"),
        _attribute("dataWindow", "box2i", window),
        _attribute("displayWindow", "box2i", window),
        _attribute("lineOrder", "lineOrder", b"\0"),
        _attribute("pixelAspectRatio", "float", struct.pack("<f", 1)),
        _attribute("screenWindowCenter", "v2f", struct.pack("<ff", 0, 0)),
        _attribute("screenWindowWidth", "float", struct.pack("<f", 1)),
        _attribute("tiles", "tiledesc", struct.pack("<IIB", _TILE, tile_height, _ONE_LEVEL)),
    ]
    parts += [_attribute(name, "string", text.encode()) for name, text in strings.items()]
    return _MAGIC + b"".join(parts) + b"\0"


def _tiles(width: int, height: int) -> Iterator[tuple[int, int, slice, slice]]:
    """Row, column, lines and pixels of every tile; those at the edges are smaller."""
    for row, y in enumerate(range(0, height, _TILE)):
        for column, x in enumerate(range(0, width, _TILE)):
            yield row, column, slice(y, min(y + _TILE, height)), slice(x, min(x + _TILE, width))


def write_exr(path: str | os.PathLike, channels: dict[str, NDArray], strings: dict[str, str]) -> None:
    """Write (height, width) arrays as float32 channels, to a temporary name first, then renamed over `path`.

    `strings` become string attributes of the header; a checksum of the pixels is added to them.
    """
    names = sorted(channels)
    stack = np.stack([np.asarray(channels[name], dtype="<f4") for name in names], axis=1)  # line, channel, pixel
    height, _, width = stack.shape
    strings = {**strings, _CHECKSUM: hashlib.sha256(stack.tobytes()).hexdigest()}
    header = _header(names, width, height, strings)
    chunks = []
    for row, column, lines, pixels in _tiles(width, height):
        tile = stack[lines, :, pixels].tobytes()
        chunks.append(struct.pack("<iiiii", column, row, 0, 0, len(tile)) + tile)
    sizes = np.array([len(chunk) for chunk in chunks], "<u8")
    offsets = len(header) + 8 * len(chunks) + np.cumsum(sizes) - sizes
    path = Path(path)
    handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=path.name + ".", suffix=".part")
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(header + offsets.astype("<u8").tobytes() + b"".join(chunks))
        Path(temporary).chmod(0o644)
        os.replace(temporary, path)
    except BaseException:
        Path(temporary).unlink(missing_ok=True)
        raise


def _take(data: bytes, at: int, count: int) -> bytes:
    if at + count > len(data):
        raise ExrError("it ends in the middle of the header")
    return data[at : at + count]


def _text(data: bytes, at: int) -> tuple[str, int]:
    end = data.find(b"\0", at)
    if end < 0:
        raise ExrError("it ends in the middle of the header")
    return data[at:end].decode("latin-1"), end + 1


def _parse_header(data: bytes) -> tuple[dict[str, bytes], int]:
    if data[: len(_MAGIC)] != _MAGIC:
        raise ExrError("it is not an OpenEXR file of the plain tiled kind: it was not written by Bentlight")
    attributes, at = {}, len(_MAGIC)
    while _take(data, at, 1) != b"\0":
        name, at = _text(data, at)
        _, at = _text(data, at)
        (size,) = struct.unpack("<i", _take(data, at, 4))
        attributes[name] = _take(data, at + 4, max(size, 0))
        at += 4 + max(size, 0)
    return attributes, at + 1


def _channel_names(chlist: bytes) -> list[str]:
    names, at = [], 0
    while _take(chlist, at, 1) != b"\0":
        name, at = _text(chlist, at)
        if struct.unpack("<i", _take(chlist, at, 4)) != (2,):
            raise ExrError(f"channel {name} is not float32")
        names.append(name)
        at += 16
    return names


def _parse(data: bytes) -> tuple[dict[str, NDArray[np.float32]], dict[str, str]]:
    attributes, at = _parse_header(data)
    missing = {"channels", "compression", "dataWindow", _CHECKSUM} - attributes.keys()
    if missing:
        raise ExrError(f"its header lacks {', '.join(sorted(missing))}: it was not written by Bentlight")
    if attributes["compression"] != b"\0" or len(attributes["dataWindow"]) != 16:
        raise ExrError("it is compressed: it was not written by Bentlight")
    names = _channel_names(attributes["channels"])
    x0, y0, x1, y1 = struct.unpack("<iiii", attributes["dataWindow"])
    width, height = x1 - x0 + 1, y1 - y0 + 1
    if not (0 < width <= 1 << 20 and 0 < height <= 1 << 20 and names):
        raise ExrError(f"its size {width} x {height} makes no sense")
    tiles = list(_tiles(width, height))
    expected = at + 28 * len(tiles) + 4 * height * len(names) * width
    if len(data) != expected:
        raise ExrError(f"it has {len(data)} bytes instead of {expected}: truncated or damaged")
    stack = np.empty((height, len(names), width), "<f4")
    at += 8 * len(tiles)
    for _, _, lines, pixels in tiles:
        shape = lines.stop - lines.start, len(names), pixels.stop - pixels.start
        count = int(np.prod(shape))
        stack[lines, :, pixels] = np.frombuffer(data, "<f4", count, at + 20).reshape(shape)
        at += 20 + 4 * count
    if hashlib.sha256(stack.tobytes()).hexdigest().encode() != attributes[_CHECKSUM]:
        raise ExrError("its pixels do not match their checksum: damaged")
    strings = {name: value.decode("utf-8", "replace") for name, value in attributes.items()}
    return {name: stack[:, i].astype(np.float32) for i, name in enumerate(names)}, strings


def read_exr(path: str | os.PathLike) -> tuple[dict[str, NDArray[np.float32]], dict[str, str]]:
    """Read a file of write_exr: (height, width) float32 arrays by channel, and the header's attributes as text.

    Raises ExrError if it is another kind of file, truncated or damaged; OSError if it cannot be read.
    """
    try:
        return _parse(Path(path).read_bytes())
    except ExrError as error:
        raise ExrError(f"{path}: {error}") from None
