"""The checkpoint of a picture: a journal of its finished tiles, with which an interrupted render goes on. No bpy here.

Each record is appended whole, with its length and checksum: whenever the process ends, also in the middle of one, all
records before are good, and what follows is cut off. What changes from round to round, tiles that are not done and
light that is traced from lamps, lies in a file of its own, which replaces the one before in one step and says how much
of the journal it belongs to.
"""

from __future__ import annotations

import json
import os
import struct
import zlib
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import astuple
from pathlib import Path

import numpy as np

from .session import Begun, FinishedTile, Tile

_RECORD = struct.Struct("<4sIIII")  # mark, number of the tile, rounds left, length and checksum of what follows
_ROUNDS = struct.Struct("<QI")  # length of the journal, number of records that follow
_TILE, _LIGHT = b"tile", b"lamp"  # marks


class Checkpoint:
    """A journal at `path`, and next to it the file of rounds. What is there already is gone on with if it is of the
    same `identity`, which names everything that the picture depends on; if not, it is begun anew.

    tiles: those of the picture, or of the journal that is gone on with. width: numbers in the state of each pixel.
    light: int64 (height, width, 3), zero, if some is traced; filled with what is there.
    """

    def __init__(
        self, path: Path, identity: str, tiles: Sequence[Tile], width: int, light: np.ndarray | None = None
    ) -> None:
        self._path = path
        self._rounds_path = path.with_name(path.name + ".rounds")
        self.tiles = list(tiles)
        self.begun: dict[int, Begun] = {}  # by number of the tile
        self._width = width
        end = self._load(identity, light)
        if not end:
            header = json.dumps({"identity": identity, "tiles": [astuple(tile) for tile in tiles]})
            self._rounds_path.unlink(missing_ok=True)
            path.write_bytes(header.encode() + b"\n")
        self._file = path.open("r+b")
        self._file.seek(end or 0, os.SEEK_SET if end else os.SEEK_END)
        self._file.truncate()
        self._numbers = {tile: number for number, tile in enumerate(self.tiles)}

    def add(self, finished: FinishedTile) -> None:
        """A tile is done. What was done in the journal that is gone on with is there already."""
        number = self._numbers[finished.tile]
        if number in self.begun and not self.begun[number].rounds_left:
            return
        self._file.write(self._tile_record(finished))
        self._file.flush()

    def set_rounds(self, unfinished: Iterable[FinishedTile], light: np.ndarray | None) -> None:
        """Tiles that have had some of their rounds, and the light that they and all tiles in the journal, and no
        others, have brought so far. Takes the place of what it was told before."""
        unfinished = list(unfinished)
        temporary = self._rounds_path.with_name(self._rounds_path.name + ".part")
        with temporary.open("wb") as file:
            file.write(_ROUNDS.pack(self._file.tell(), len(unfinished) + (light is not None)))
            for tile in unfinished:
                file.write(self._tile_record(tile))
            if light is not None:
                file.write(_record(_LIGHT, 0, 0, light))
        os.replace(temporary, self._rounds_path)

    def _tile_record(self, finished: FinishedTile) -> bytes:
        return _record(_TILE, self._numbers[finished.tile], finished.rounds_left, finished.state)

    def close(self) -> None:
        """Closes the journal, which stays."""
        self._file.close()

    @property
    def files(self) -> tuple[Path, Path]:
        """What is to be removed once the picture is safe."""
        return self._path, self._rounds_path

    def _load(self, identity: str, light: np.ndarray | None) -> int | None:
        """Reads what is there; returns where it ends, None if it is of no use."""
        try:
            data = self._path.read_bytes()
        except FileNotFoundError:
            return None
        head, newline, _ = data.partition(b"\n")
        try:
            header = json.loads(head)
            if not newline or header["identity"] != identity:
                return None
            self.tiles = [Tile(*row) for row in header["tiles"]]
        except (ValueError, KeyError, TypeError):
            return None
        end, unfinished = self._load_rounds(light)
        self.begun, good = unfinished, len(head) + 1
        for _, number, rounds_left, values, after in _records(data if light is None else data[:end], good):
            self.begun[number], good = self._begun(number, rounds_left, values), after
        if light is not None and good < end:  # it is of tiles that are lost
            light[:], self.begun, good = 0, {}, len(head) + 1
        return good

    def _load_rounds(self, light: np.ndarray | None) -> tuple[int, dict[int, Begun]]:
        """How much of the journal the file of rounds belongs to, 0 if there is none, and its tiles; fills the light."""
        try:
            data = self._rounds_path.read_bytes()
            end, count = _ROUNDS.unpack_from(data)
        except (FileNotFoundError, struct.error):
            return 0, {}
        records = list(_records(data, _ROUNDS.size))
        if len(records) < count:
            return 0, {}
        unfinished = {}
        for mark, number, rounds_left, values, _ in records:
            if mark == _TILE:
                unfinished[number] = self._begun(number, rounds_left, values)
            elif light is not None:
                light[:] = np.frombuffer(values, np.int64).reshape(light.shape)
        return end, unfinished

    def _begun(self, number: int, rounds_left: int, values: bytes) -> Begun:
        tile = self.tiles[number]
        return Begun(np.frombuffer(values).reshape(tile.height, tile.width, self._width).copy(), rounds_left)


def _record(mark: bytes, number: int, rounds_left: int, values: np.ndarray) -> bytes:
    packed = zlib.compress(values.tobytes(), 1)
    fields = (mark, number, rounds_left, len(packed))
    return _RECORD.pack(*fields, _checksum(fields, packed)) + packed


def _records(data: bytes, at: int) -> Iterator[tuple[bytes, int, int, bytes, int]]:
    """Mark, number, rounds left and values of each sound record from `at` on, and where it ends."""
    while at + _RECORD.size <= len(data):
        *fields, checksum = _RECORD.unpack_from(data, at)
        at += _RECORD.size
        packed = data[at : at + fields[3]]
        if len(packed) < fields[3] or checksum != _checksum(tuple(fields), packed):
            return
        at += len(packed)
        yield *fields[:3], zlib.decompress(packed), at


def _checksum(fields: tuple, packed: bytes) -> int:
    return zlib.crc32(packed, zlib.crc32(repr(fields).encode()))
