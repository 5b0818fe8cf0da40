"""One render: a native scene, the tiles still to do, and the threads that do them. Knows no bpy."""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import bentlight_native
import numpy as np

_ROUND_MAX = 16  # samples, of a round under a time limit


@dataclass(frozen=True)
class Tile:
    """A rectangle of pixels, counted from the bottom left of the full image."""

    x: int
    y: int
    width: int
    height: int


@dataclass(frozen=True)
class Task:
    """A range of a tile's samples."""

    tile: Tile
    first_sample: int
    sample_count: int


@dataclass(frozen=True)
class FinishedTile:
    """A tile's pixels by channel, rows upwards, (height, width, components) float32.

    After a cancel it may hold fewer samples than asked for, or none in some pixels.
    """

    tile: Tile
    channels: dict[str, np.ndarray]
    first_sample: int = 0

    def merged(self, later: FinishedTile) -> FinishedTile:
        """This and a later range of the same pixels' samples as one, to the rounding of float32."""
        a, b = self.channels, later.channels
        before, more = a["sample_count"], b["sample_count"]
        share = more / np.maximum(before + more, 1)
        rules = {
            "mean": lambda x, y: x + share * (y - x),
            "max": np.maximum,
            "first": lambda x, y: np.where(before > 0, x, y),
            "count": np.add,
        }
        reduction = {name: rules[bentlight_native.CHANNELS[name].reduction] for name in a}
        return FinishedTile(self.tile, {name: reduction[name](a[name], b[name]) for name in a}, self.first_sample)


def sample_rounds(count: int) -> Iterator[tuple[int, int]]:
    """First sample and number of samples of each round: 1, 1, 2, 4, 8, and then 16 again and again until `count`."""
    first = 0
    while first < count:
        size = min(max(first, 1), _ROUND_MAX, count - first)
        yield first, size
        first += size


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

    With a time limit, in seconds, the whole picture is taken in rounds of ever more samples; when the time is over, no
    range of samples is begun any more, except the first sample of each tile. All pixels then get about equally many
    samples: the noise threshold is not looked at.
    """

    def __init__(
        self,
        scene: bentlight_native.Scene,
        settings: bentlight_native.RenderSettings,
        tiles: Sequence[Tile],
        channels: Sequence[str],
        threads: int,
        time_limit: float = 0.0,
    ) -> None:
        self._scene = scene
        self._settings = replace(settings, noise_threshold=0.0) if time_limit else settings
        self._channels = (*channels, "sample_count")
        self._time_limit = time_limit
        self._merged: dict[Tile, FinishedTile] = {}
        rounds = sample_rounds(settings.sample_count) if time_limit else [(0, settings.sample_count)]
        self._tasks = (Task(tile, first, count) for first, count in rounds for tile in tiles)
        self._lock = threading.Lock()  # of the generator above
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
        """How much of the work, or of the time for it, is done, 0 to 1."""
        done = self._progress.done / self._work if self._work else 1.0
        return min(1.0, max(done, self._elapsed / self._time_limit if self._time_limit else 0.0))

    @property
    def _elapsed(self) -> float:
        return time.monotonic() - self._start

    @property
    def seconds_left(self) -> float | None:
        """An estimate; None before there is anything to estimate from."""
        fraction = self.fraction
        return self._elapsed * (1 - fraction) / fraction if fraction > 0 else None

    def cancel(self) -> None:
        """Asks all threads to stop; `finished` still yields what they have."""
        self._progress.cancel()

    def finished(self, wait: float) -> Iterator[FinishedTile | None]:
        """Tiles as they are done, and None whenever `wait` seconds passed without one; ends with the last tile.

        In rounds a tile comes again and again, each time with all its samples so far."""
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
                    yield self._merge(result)
        finally:
            self.close()

    def close(self) -> None:
        """Stops the threads and waits for them. May be called again."""
        self._progress.cancel()
        for thread in self._threads:
            thread.join()

    def _merge(self, new: FinishedTile) -> FinishedTile:
        """The tile with what it had before. Rounds of a tile may end out of order: the result is the same to rounding,
        but for channels that keep the first sample, which the first round has."""
        old = self._merged.get(new.tile)
        if old is not None and new.first_sample < old.first_sample:
            old, new = new, old
        merged = old.merged(new) if old is not None else new
        if self._time_limit:
            self._merged[new.tile] = merged
        return merged

    def _is_over(self, task: Task) -> bool:
        """Whether there is no time for a task any more."""
        return 0 < self._time_limit < self._elapsed and task.first_sample > 0

    def _run(self) -> None:
        """A worker: task by task until there are none, the time is over, or someone cancels or fails."""
        try:
            while not self._progress.cancelled:
                with self._lock:
                    task = next(self._tasks, None)
                if task is None or self._is_over(task):
                    break
                finished = self._render(task)
                if finished:
                    self._results.put(finished)
        except BaseException as failure:
            self._progress.cancel()
            self._results.put(failure)
        finally:
            self._results.put(None)

    def _render(self, task: Task) -> FinishedTile | None:
        """A task's tile, or what a cancel left of it; None if that is nothing."""
        tile = task.tile
        settings = replace(self._settings, first_sample=task.first_sample, sample_count=task.sample_count)
        channels = {
            name: np.zeros((tile.height, tile.width, bentlight_native.CHANNELS[name].components), np.float32)
            for name in self._channels
        }
        try:
            self._scene.render_tile(tile.x, tile.y, tile.width, tile.height, settings, channels, self._progress)
        except bentlight_native.Cancelled:
            if not channels["sample_count"].any():
                return None
        return FinishedTile(tile, channels, task.first_sample)
