"""Minimal OpenEXR files: one part, tiles of one level, channels of one type, string attributes; ZIP or nothing.

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
import zlib
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

_MAGIC, _MAGIC_LONG = (struct.pack("<II", 20000630, 2 | 0x200 | flag) for flag in (0, 0x400))
_SHORT = 31  # bytes of the longest name that needs no flag for long names
_TILE = 64  # pixels, each way; images that are less high have lower ones
_ONE_LEVEL = 0
_CHECKSUM = "bentlightChecksum"
_KINDS = {"<u4": 0, "<f2": 1, "<f4": 2}  # of pixels: their numbers in the format
_NONE, _ZIP = b"\0", b"\3"


class ExrError(ValueError):
    """A file that is not one of ours, truncated or damaged. The message names the file and the reason."""


def _attribute(name: str, kind: str, value: bytes) -> bytes:
    return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(value)) + value


def _header(
    names: list[str], dtype: str, width: int, height: int, strings: dict[str, str], compression: bytes
) -> bytes:
    kind = struct.pack("<iBxxxii", _KINDS[dtype], 0, 1, 1)
    channels = b"".join(name.encode() + b"\0" + kind for name in names) + b"\0"
    window = struct.pack("<iiii", 0, 0, width - 1, height - 1)
    tile_height = min(_TILE, 1 << (height - 1).bit_length())  # texture caches hold whole tiles
    parts = [
        _attribute("channels", "chlist", channels),
        _attribute("compression", "compression", compression),
        _attribute("dataWindow", "box2i", window),
        _attribute("displayWindow", "box2i", window),
        _attribute("lineOrder", "lineOrder", b"\0"),
        _attribute("pixelAspectRatio", "float", struct.pack("<f", 1)),
        _attribute("screenWindowCenter", "v2f", struct.pack("<ff", 0, 0)),
        _attribute("screenWindowWidth", "float", struct.pack("<f", 1)),
        _attribute("tiles", "tiledesc", struct.pack("<IIB", _TILE, tile_height, _ONE_LEVEL)),
    ]
    parts += [_attribute(name, "string", text.encode()) for name, text in strings.items()]
    is_long = max(len(name.encode()) for name in (*names, *strings)) > _SHORT
    return (_MAGIC_LONG if is_long else _MAGIC) + b"".join(parts) + b"\0"


def _tiles(width: int, height: int) -> Iterator[tuple[int, int, slice, slice]]:
    """Row, column, lines and pixels of every tile; those at the edges are smaller."""
    for row, y in enumerate(range(0, height, _TILE)):
        for column, x in enumerate(range(0, width, _TILE)):
            yield row, column, slice(y, min(y + _TILE, height)), slice(x, min(x + _TILE, width))


def _zipped(data: bytes) -> bytes:
    """As OpenEXR's ZIP has it: every second byte first, their differences, zlib; or as it was if that is shorter."""
    plain = np.frombuffer(data, np.uint8)
    halves = np.concatenate([plain[0::2], plain[1::2]])
    halves[1:] = np.diff(halves) + np.uint8(128)
    packed = zlib.compress(halves.tobytes(), 4)
    return packed if len(packed) < len(data) else data


def _unzipped(packed: bytes, size: int) -> bytes:
    if len(packed) == size:
        return packed
    try:
        steps = np.frombuffer(zlib.decompress(packed), np.uint8).copy()
    except zlib.error as error:
        raise ExrError(f"its pixels cannot be unpacked: {error}") from None
    if len(steps) != size:
        raise ExrError("its pixels have another size than its header says: damaged")
    steps[1:] -= np.uint8(128)
    halves = np.cumsum(steps, dtype=np.uint8)
    plain = np.empty(size, np.uint8)
    plain[0::2], plain[1::2] = halves[: (size + 1) // 2], halves[(size + 1) // 2 :]
    return plain.tobytes()


def write_exr(
    path: str | os.PathLike, channels: dict[str, NDArray], strings: dict[str, str], compress: bool = False
) -> None:
    """Write (height, width) arrays as channels, to a temporary name first, then renamed over `path`.

    They are uint32 or float16 in the file if all arrays are, else float32. `strings` become string attributes of the
    header; a checksum of the pixels is added to them.
    """
    names = sorted(channels)
    kinds = {values.dtype.str for values in channels.values()}
    dtype = kinds.pop() if len(kinds) == 1 and kinds <= _KINDS.keys() else "<f4"
    stack = np.stack([np.asarray(channels[name], dtype) for name in names], axis=1)  # line, channel, pixel
    height, _, width = stack.shape
    strings = {**strings, _CHECKSUM: hashlib.sha256(stack.tobytes()).hexdigest()}
    header = _header(names, dtype, width, height, strings, _ZIP if compress else _NONE)
    chunks = []
    for row, column, lines, pixels in _tiles(width, height):
        tile = stack[lines, :, pixels].tobytes()
        tile = _zipped(tile) if compress else tile
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
    if data[: len(_MAGIC)] not in (_MAGIC, _MAGIC_LONG):
        raise ExrError("it is not an OpenEXR file of the plain tiled kind: it was not written by Bentlight")
    attributes, at = {}, len(_MAGIC)
    while _take(data, at, 1) != b"\0":
        name, at = _text(data, at)
        _, at = _text(data, at)
        (size,) = struct.unpack("<i", _take(data, at, 4))
        attributes[name] = _take(data, at + 4, max(size, 0))
        at += 4 + max(size, 0)
    return attributes, at + 1


def _channels(chlist: bytes) -> tuple[list[str], str]:
    """Their names, and the type of all of them."""
    names, kinds, at = [], set(), 0
    while _take(chlist, at, 1) != b"\0":
        name, at = _text(chlist, at)
        names.append(name)
        kinds.add(struct.unpack("<i", _take(chlist, at, 4))[0])
        at += 16
    found = [dtype for dtype, number in _KINDS.items() if kinds == {number}]
    if not found:
        raise ExrError("its channels are of types that differ or are unknown: it was not written by Bentlight")
    return names, found[0]


def _read_tiles(data: bytes, at: int, stack: NDArray, is_zipped: bool) -> None:
    """Fills stack (line, channel, pixel) from the chunks, of which the first begins at `at`."""
    height, count, width = stack.shape
    for _, _, lines, pixels in _tiles(width, height):
        shape = lines.stop - lines.start, count, pixels.stop - pixels.start
        raw = stack.itemsize * int(np.prod(shape))
        (size,) = struct.unpack("<i", _take(data, at + 16, 4)) if at + 20 <= len(data) else (0,)
        if not 0 < size <= raw or (size < raw and not is_zipped) or at + 20 + size > len(data):
            raise ExrError(f"it has {len(data)} bytes, which is not what its header says: truncated or damaged")
        tile = _unzipped(data[at + 20 : at + 20 + size], raw)
        stack[lines, :, pixels] = np.frombuffer(tile, stack.dtype).reshape(shape)
        at += 20 + size
    if at != len(data):
        raise ExrError(f"it has {len(data)} bytes instead of {at}: damaged")


def _parse(data: bytes) -> tuple[dict[str, NDArray], dict[str, str]]:
    attributes, at = _parse_header(data)
    missing = {"channels", "compression", "dataWindow", _CHECKSUM} - attributes.keys()
    if missing:
        raise ExrError(f"its header lacks {', '.join(sorted(missing))}: it was not written by Bentlight")
    if attributes["compression"] not in (_NONE, _ZIP) or len(attributes["dataWindow"]) != 16:
        raise ExrError("it is compressed in another way: it was not written by Bentlight")
    names, dtype = _channels(attributes["channels"])
    x0, y0, x1, y1 = struct.unpack("<iiii", attributes["dataWindow"])
    width, height = x1 - x0 + 1, y1 - y0 + 1
    if not (0 < width <= 1 << 20 and 0 < height <= 1 << 20 and names):
        raise ExrError(f"its size {width} x {height} makes no sense")
    at += 8 * -(-width // _TILE) * -(-height // _TILE)
    if at > len(data):
        raise ExrError(f"it has {len(data)} bytes only: truncated")
    stack = np.empty((height, len(names), width), dtype)
    _read_tiles(data, at, stack, attributes["compression"] == _ZIP)
    if hashlib.sha256(stack.tobytes()).hexdigest().encode() != attributes[_CHECKSUM]:
        raise ExrError("its pixels do not match their checksum: damaged")
    strings = {name: value.decode("utf-8", "replace") for name, value in attributes.items()}
    kind = np.uint32 if dtype == "<u4" else np.float32
    return {name: stack[:, i].astype(kind) for i, name in enumerate(names)}, strings


def read_exr(path: str | os.PathLike) -> tuple[dict[str, NDArray], dict[str, str]]:
    """Read a file of write_exr: (height, width) float32 or uint32 arrays by channel, and the header as text.

    Raises ExrError if it is another kind of file, truncated or damaged; OSError if it cannot be read.
    """
    try:
        return _parse(Path(path).read_bytes())
    except ExrError as error:
        raise ExrError(f"{path}: {error}") from None
