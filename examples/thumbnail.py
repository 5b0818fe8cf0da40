"""The small picture of a .blend file that file browsers show, put in where no window can be photographed for it.

Blender stores it as the block TEST behind the header: width and height as int32, then RGBA bytes, rows upwards
(`BLO_CODE_TEST` in Blender's source/blender/blenloader).
"""

import struct
from pathlib import Path

import numpy as np

CODE = b"TEST"
SIDE = 256  # pixels, at most


def _layout(data: bytes) -> tuple[int, struct.Struct, slice]:
    """Size of the file's header, and the header of a block: its struct and where code and length are in it."""
    if data[:8] == b"BLENDER-":  # up to 4.5, of 64 bits: code, length, address, type, count
        return 12, struct.Struct("<4siQii"), slice(0, 2)
    if data[:10] == b"BLENDER17-":  # from 5.0: code, type, address, length, count
        return 17, struct.Struct("<4siQqq"), slice(0, 4, 3)
    raise ValueError("no uncompressed .blend file of 64 bits")


def embed(path: Path, pixels: np.ndarray) -> None:
    """Puts (height, width, 4) uint8, rows upwards, into an uncompressed file that has no thumbnail yet."""
    height, width = pixels.shape[:2]
    if max(width, height) > SIDE or read(path) is not None:
        raise ValueError(f"{path}: a thumbnail has at most {SIDE} pixels a side, and a file one thumbnail")
    data = path.read_bytes()
    start, header, places = _layout(data)
    content = struct.pack("<ii", width, height) + np.ascontiguousarray(pixels, np.uint8).tobytes()
    fields = [CODE, 0, 0, 0, 0]
    fields[places] = [CODE, len(content)]
    fields[4] = 1
    path.write_bytes(data[:start] + header.pack(*fields) + content + data[start:])


def read(path: Path) -> np.ndarray | None:
    """The thumbnail of an uncompressed file, (height, width, 4) uint8, rows upwards; None if it has none."""
    data = path.read_bytes()
    place, header, places = _layout(data)
    while place + header.size <= len(data):
        code, length = header.unpack_from(data, place)[places]
        place += header.size
        if code == CODE:
            width, height = struct.unpack_from("<ii", data, place)
            return np.frombuffer(data, np.uint8, width * height * 4, place + 8).reshape(height, width, 4)
        if code == b"ENDB":
            return None
        place += length
    raise ValueError(f"{path}: the file is cut off")
