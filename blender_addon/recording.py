"""What a farm's job keeps of one picture while it is rendered: the file of its part, and the checkpoint."""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path

import bentlight_native
import numpy as np
from bentlight_native import Part, Picture, Piece, write_part

from .checkpoint import Checkpoint
from .farm import Job
from .session import Begun, FinishedTile, Session, Tile, empty_light

_INTERVAL = 30.0  # seconds between checkpoints of what is not done: tiles that take rounds, light from lamps


class Recording:
    """Of one picture. path: of its files, without an extension. settings, window: of what of it is rendered. order: a
    fingerprint of the rounds in which that is taken, and of the moment that they begin with."""

    def __init__(
        self,
        job: Job,
        path: str,
        picture: Picture,
        settings: bentlight_native.RenderSettings,
        window: tuple[int, int, int, int],
        tiles: Sequence[Tile],
        order: str,
    ) -> None:
        self._job = job
        self._path = path
        self._picture = picture
        self._settings = settings
        self._window = window
        self._order = order
        self._states: dict[Tile, np.ndarray] = {}  # of tiles that are done
        self._checkpoint: Checkpoint | None = None
        self._next = time.monotonic() + _INTERVAL
        self.tiles = list(tiles)
        self.begun: Mapping[int, Begun] = {}
        self.light = empty_light(settings)
        Path(path).parent.mkdir(parents=True, exist_ok=True)
        if job.resume:
            width = bentlight_native.state_width(picture.names, settings)
            self._checkpoint = Checkpoint(Path(f"{path}.checkpoint"), self._identity(), tiles, width, self.light)
            self.tiles, self.begun = self._checkpoint.tiles, self._checkpoint.begun

    def add(self, finished: FinishedTile) -> None:
        """A tile has come out of the session."""
        if finished.state is None:  # not done, or again with light from lamps
            return
        self._states[finished.tile] = finished.state
        if self._checkpoint:
            self._checkpoint.add(finished)

    def poll(self, session: Session) -> None:
        """To be called again and again between tiles."""
        if self._checkpoint is None or not (session.has_rounds or self.light is not None):
            return
        if session.is_settled:
            self._checkpoint.set_rounds(session.unfinished(), self.light)
            self._next = time.monotonic() + _INTERVAL
            session.go_on()
        elif time.monotonic() > self._next:
            session.pause()

    def finish(self, was_cancelled: bool, star_sums: np.ndarray | None) -> tuple[Path, ...]:
        """The session has ended, as all is done or the time is over, or cancelled: writes the part if it is whole.
        Returns files that are of no use once the picture is safe: none of one that was cancelled."""
        has_tiles = len(self._states) == len(self.tiles)
        if has_tiles and self._checkpoint and self.light is not None:
            self._checkpoint.set_rounds((), self.light)
        lacks_stars = was_cancelled and star_sums is not None  # those of moments come also after the last tile
        if lacks_stars or (not has_tiles and (was_cancelled or self._job.is_part)):
            self.close()
            return ()
        if self._job.is_part:
            write_part(f"{self._path}.part.exr", self._part(star_sums))
        self.close()
        return self._checkpoint.files if self._checkpoint else ()

    def close(self) -> None:
        """Closes the checkpoint's file. May be called again."""
        if self._checkpoint:
            self._checkpoint.close()

    def _identity(self) -> str:
        """Of everything that tiles depend on."""
        of = [asdict(self._picture), asdict(self._settings), self._window, self._order]
        return hashlib.sha256(json.dumps(of).encode()).hexdigest()

    def _part(self, star_sums: np.ndarray | None) -> Part:
        settings, (x, y, width, height) = self._settings, self._picture.window
        state = bentlight_native.empty_state(self._picture.names, settings, width, height)
        for tile, values in self._states.items():
            state[tile.y - y : tile.y - y + tile.height, tile.x - x : tile.x - x + tile.width] = values
        stars = None
        if star_sums is not None:
            left, bottom, across, up = self._window
            stars = np.zeros((height, width, star_sums.shape[-1]))
            stars[bottom - y : bottom - y + up, left - x : left - x + across] = star_sums
        return Part(
            self._picture,
            [Piece(*self._window, settings.first_sample, settings.sample_count)],
            state,
            None if self.light is None else self.light[y : y + height, x : x + width],
            stars,
        )
