"""One render: a native scene, the tiles still to do, and the threads that do them. Knows no bpy."""

from __future__ import annotations

import queue
import threading
import time
from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import bentlight_native
import numpy as np

_ROUND_MAX = 16  # samples, of a round under a time limit
# What the next round needs to know of a pixel's noise, besides the number of its samples.
_RESUMED_CHANNELS = ("combined", "noise_partial", "noise_scatter")


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


@dataclass(frozen=True)
class StarLight:
    """The images of stars in the whole picture, and what each brings to it (StarImages.light)."""

    images: bentlight_native.StarImages
    light: np.ndarray


# What shows stars: the sky's channels.
_STAR_CHANNELS = ("combined", "environment", "denoising_albedo")


@dataclass
class _Work:
    """A tile with the samples that it has so far, and the rounds that it still is to take."""

    tile: Tile
    channels: dict[str, np.ndarray]
    rounds: deque[tuple[int, int]]  # first sample, number of samples


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

    With a time limit, in seconds, the whole picture is taken in rounds of ever more samples, each of which goes on with
    what the tile has: pixels that the noise threshold has ended stay as they are. When the time is over, no tile begins
    another round, but for the first sample of each tile.

    The integrator BIDIRECTIONAL brings light from lamps to all of the picture from every tile: tiles come with what
    there is so far, and all of them again at the end.

    Stars are added to finished tiles: they take no samples.
    """

    def __init__(
        self,
        scene: bentlight_native.Scene,
        settings: bentlight_native.RenderSettings,
        tiles: Sequence[Tile],
        channels: Sequence[str],
        threads: int,
        time_limit: float = 0.0,
        stars: StarLight | None = None,
    ) -> None:
        self._scene = scene
        self._settings = settings
        self._time_limit = time_limit
        self._stars = stars
        rounds = list(sample_rounds(settings.sample_count)) if time_limit else [(0, settings.sample_count)]
        resumed = _RESUMED_CHANNELS if time_limit and settings.noise_threshold else ()
        names = dict.fromkeys((*channels, "sample_count", *resumed))
        self._waiting = deque(_Work(tile, _empty_channels(tile, names), deque(rounds)) for tile in tiles)
        self._busy = 0  # tiles that are being rendered
        self._spared = 0  # pixel samples of rounds that were not needed
        self._changed = threading.Condition()  # guards the three above
        bidirectional = settings.integrator == "BIDIRECTIONAL"
        self._light = np.zeros((settings.height, settings.width, 3), np.int64) if bidirectional else None
        self._unlit: dict[Tile, FinishedTile] = {}  # as they came last, where light is added to them
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
        done = (self._progress.done + self._spared) / self._work if self._work else 1.0
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
                    yield self._starry(self._lit(result))
            if self._light is not None:
                yield from map(self._starry, map(self._lit, list(self._unlit.values())))
        finally:
            self.close()

    def close(self) -> None:
        """Stops the threads and waits for them. May be called again."""
        self._progress.cancel()
        for thread in self._threads:
            thread.join()

    def _lit(self, finished: FinishedTile) -> FinishedTile:
        """The tile with the light that was traced from lamps."""
        if self._light is None or "combined" not in finished.channels:
            return finished
        tile, size = finished.tile, (self._settings.width, self._settings.height)
        self._unlit[tile] = finished
        samples = sum(int(other.channels["sample_count"].sum(dtype=np.float64)) for other in self._unlit.values())
        combined = finished.channels["combined"].copy()
        part = self._light[tile.y : tile.y + tile.height, tile.x : tile.x + tile.width]
        combined[..., :3] += bentlight_native.light_image(part, samples, size)
        return replace(finished, channels=finished.channels | {"combined": combined})

    def _starry(self, finished: FinishedTile) -> FinishedTile:
        """The tile with the stars in it. A transparent film shows none, but its passes do."""
        if self._stars is None:
            return finished
        tile, settings, channels = finished.tile, self._settings, dict(finished.channels)
        shown = self._stars.images.draw(
            self._stars.light,
            (settings.width, settings.height),
            (tile.x, tile.y, tile.width, tile.height),
            settings.filter,
            settings.filter_width,
        )
        for name in _STAR_CHANNELS:
            if name in channels and not (name == "combined" and settings.film_transparent):
                channels[name] = channels[name].copy()
                channels[name][..., :3] += shown
        return replace(finished, channels=channels)

    def _run(self) -> None:
        """A worker: round by round until there are none, the time is over, or someone cancels or fails."""
        try:
            while (work := self._take()) is not None:
                wants_more = False
                try:
                    wants_more = self._render(work)
                finally:
                    self._put_back(work, wants_more)
        except BaseException as failure:
            self._progress.cancel()
            self._results.put(failure)
        finally:
            self._results.put(None)

    def _take(self) -> _Work | None:
        """The tile that has waited longest; None when all are done. Waits while others render the last ones."""
        with self._changed:
            while not self._progress.cancelled:
                if self._waiting:
                    work = self._waiting.popleft()
                    if self._is_over(work):
                        continue
                    self._busy += 1
                    return work
                if not self._busy:
                    break
                self._changed.wait()
        return None

    def _put_back(self, work: _Work, wants_more: bool) -> None:
        """A tile's round has ended; if it wants no more, the samples of all its other rounds count as done."""
        with self._changed:
            self._busy -= 1
            if wants_more:
                self._waiting.append(work)
            elif not self._progress.cancelled:
                self._spared += work.tile.width * work.tile.height * sum(count for _, count in work.rounds)
            self._changed.notify_all()

    def _is_over(self, work: _Work) -> bool:
        """Whether there is no time for a tile's next round any more."""
        return 0 < self._time_limit < self._elapsed and work.rounds[0][0] > 0

    def _render(self, work: _Work) -> bool:
        """A tile's next round, or what a cancel lets it have; returns whether there is another."""
        tile, (first, count) = work.tile, work.rounds.popleft()
        settings = replace(self._settings, first_sample=first, sample_count=count, resume=first > 0)
        try:
            done = self._scene.render_tile(
                tile.x, tile.y, tile.width, tile.height, settings, work.channels, self._progress, self._light
            )
            more = bool(work.rounds) and done.samples > 0
        except bentlight_native.Cancelled:
            more = False
            if not work.channels["sample_count"].any():
                return False
        copies = {name: values.copy() for name, values in work.channels.items()} if more else work.channels
        self._results.put(FinishedTile(tile, copies))
        return more


def _empty_channels(tile: Tile, names: Iterable[str]) -> dict[str, np.ndarray]:
    return {
        name: np.zeros((tile.height, tile.width, bentlight_native.CHANNELS[name].components), np.float32)
        for name in names
    }
