"""One render: a native scene, the tiles still to do, and the threads that do them. Knows no bpy."""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import bentlight_native
import numpy as np


@dataclass(frozen=True)
class Tile:
    """A rectangle of pixels, counted from the bottom left of the full image."""

    x: int
    y: int
    width: int
    height: int


@dataclass(frozen=True)
class FinishedTile:
    """A tile's pixels by channel, rows upwards, (height, width, components) float32.

    After a cancel it may hold fewer samples than asked for, or none in some pixels.
    """

    tile: Tile
    channels: dict[str, np.ndarray]


def spiral_tiles(x: int, y: int, width: int, height: int, size: int) -> list[Tile]:
    """Square tiles that cover a rectangle exactly, nearest to its center first."""
    tiles = [
        Tile(left, bottom, min(size, x + width - left), min(size, y + height - bottom))
        for bottom in range(y, y + height, size)
        for left in range(x, x + width, size)
    ]
    center_x, center_y = x + width / 2, y + height / 2
    return sorted(tiles, key=lambda t: (t.x + t.width / 2 - center_x) ** 2 + (t.y + t.height / 2 - center_y) ** 2)


class Session:
    """Renders tiles on worker threads; every method is called from one thread, the owner's.

    The native scene is committed and not edited any more. A failure in a worker is raised by `finished`.
    """

    def __init__(
        self,
        scene: bentlight_native.Scene,
        settings: bentlight_native.RenderSettings,
        tiles: Sequence[Tile],
        channels: Sequence[str],
        threads: int,
    ) -> None:
        self._scene = scene
        self._settings = settings
        self._channels = (*channels, "sample_count")
        self._tiles = queue.SimpleQueue()
        for tile in tiles:
            self._tiles.put(tile)
        self._results: queue.SimpleQueue[FinishedTile | BaseException | None] = queue.SimpleQueue()
        self._progress = bentlight_native.Progress()
        self._work = settings.sample_count * sum(tile.width * tile.height for tile in tiles)
        self._start = time.monotonic()
        self._threads = [
            threading.Thread(target=self._run, name=f"bentlight {i}", daemon=True)
            for i in range(max(1, min(threads, len(tiles))))
        ]
        self._running = len(self._threads)
        for thread in self._threads:
            thread.start()

    @property
    def fraction(self) -> float:
        """How much of the work is done, 0 to 1."""
        return min(1.0, self._progress.done / self._work) if self._work else 1.0

    @property
    def seconds_left(self) -> float | None:
        """An estimate; None before there is anything to estimate from."""
        fraction = self.fraction
        return (time.monotonic() - self._start) * (1 - fraction) / fraction if fraction > 0 else None

    def cancel(self) -> None:
        """Asks all threads to stop; `finished` still yields what they have."""
        self._progress.cancel()

    def finished(self, wait: float) -> Iterator[FinishedTile | None]:
        """Tiles as they are done, and None whenever `wait` seconds passed without one; ends with the last tile."""
        try:
            while self._running:
                try:
                    result = self._results.get(timeout=wait)
                except queue.Empty:
                    yield None
                    continue
                if isinstance(result, BaseException):
                    raise result
                if result is None:
                    self._running -= 1
                else:
                    yield result
        finally:
            self.close()

    def close(self) -> None:
        """Stops the threads and waits for them. May be called again."""
        self._progress.cancel()
        for thread in self._threads:
            thread.join()

    def _run(self) -> None:
        """A worker: tile by tile until there are none, or someone cancels or fails."""
        try:
            while not self._progress.cancelled:
                try:
                    tile = self._tiles.get_nowait()
                except queue.Empty:
                    break
                finished = self._render(tile)
                if finished:
                    self._results.put(finished)
        except BaseException as failure:
            self._progress.cancel()
            self._results.put(failure)
        finally:
            self._results.put(None)

    def _render(self, tile: Tile) -> FinishedTile | None:
        """A tile, or what a cancel left of it; None if that is nothing."""
        channels = {
            name: np.zeros((tile.height, tile.width, bentlight_native.CHANNELS[name].components), np.float32)
            for name in self._channels
        }
        try:
            self._scene.render_tile(tile.x, tile.y, tile.width, tile.height, self._settings, channels, self._progress)
        except bentlight_native.Cancelled:
            if not channels["sample_count"].any():
                return None
        return FinishedTile(tile, channels)
