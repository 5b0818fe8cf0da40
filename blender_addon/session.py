"""One render: a native scene, the tiles still to do, and the threads that do them. Knows no bpy."""

from __future__ import annotations

import math
import queue
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import bentlight_native
import numpy as np

from .sync.slices import Slice

_PAUSE_POLL = 0.05  # seconds
_ROUND_MAX = 16  # samples, of a round under a time limit
_SHOWN_EACH = 1.0  # seconds that a tile waits to be shown again while there are moments left
_MOVE = object()  # among results: all tiles have the samples of the moment


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

    After a cancel it may hold fewer samples than asked for, or none in some pixels. state: what it is made of, if the
    session keeps that and the tile is done; rounds_left: how many rounds it still takes.
    """

    tile: Tile
    channels: dict[str, np.ndarray]
    state: np.ndarray | None
    rounds_left: int


@dataclass(frozen=True)
class Begun:
    """What an earlier session has left of a tile: its state, and the number of rounds that it still is to take."""

    state: np.ndarray
    rounds_left: int


@dataclass(frozen=True)
class StarLight:
    """What the stars of a moment bring to the pixels that are rendered: (height, width, 3) float32 from a corner, in
    pixels of the full image, on."""

    shown: np.ndarray
    corner: tuple[int, int] = (0, 0)
    group: int = -1  # number of the sky's light group


class Round(NamedTuple):
    """Some successive samples of a picture, all of one moment."""

    first: int
    count: int
    moment: int


@dataclass
class _Work:
    """A tile with the samples that it has so far, and the rounds that it still is to take."""

    tile: Tile
    channels: dict[str, np.ndarray]
    state: np.ndarray | None  # where rounds go on from
    rounds: deque[Round]
    shown: float = -math.inf  # when it was last
    is_shown: bool = True  # with all its samples


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

    The native scene is committed, and edited by `move` only. A failure in a worker is raised by `finished`.

    While the shutter is open a picture has moments, each with a slice of the samples. When all tiles have theirs,
    `move` is called, by the owner's thread within `finished` while no worker looks at the scene, and returns the scene
    of the next moment with its stars, or None to end the picture there.

    With a time limit, in seconds, the whole picture is taken in rounds of ever more samples, each of which goes on with
    what the tile has: pixels that the noise threshold has ended stay as they are. When the time is over, no tile begins
    another round, but for the first sample of each tile.

    The integrator BIDIRECTIONAL brings light from lamps to all of the picture from every tile: tiles come with what
    there is so far, and all of them again at the end.

    Stars are added to finished tiles, those of all moments so far by their part of the samples: they take none. All
    moments are gone through for them, also those in which no tile takes samples any more.

    With keeps_state tiles that are done come with their states. begun: states of tiles, by number, that an earlier
    session with the same arguments has left, to go on from as if it had not ended; light: where light from lamps is
    added to, with that of these tiles.
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
        keeps_state: bool = False,
        begun: Mapping[int, Begun] | None = None,
        light: np.ndarray | None = None,
        slices: Sequence[Slice] = (),
        move: Callable[[int], tuple[bentlight_native.Scene, StarLight | None] | None] = lambda _: None,
    ) -> None:
        self._scene = scene
        self._settings = settings
        self._time_limit = time_limit
        self._slices = slices or [Slice(0, settings.sample_count, 0.5)]
        self._move = move
        self._stars: StarLight | None = None  # of the newest moment that has any
        self._star_sums: np.ndarray | None = None  # of all so far (bentlight_native.star_sum)
        self._star_samples = 0
        self._add_stars(stars, self._slices[0].count)
        rounds = _rounds(self._slices, bool(time_limit))
        self._has_rounds = len(rounds) > 1
        self._names = tuple(dict.fromkeys((*channels, "sample_count")))
        self._keeps_state = keeps_state
        has_state = keeps_state or self._has_rounds
        self._works = [
            _Work(
                tile,
                _empty_channels(tile, self._names, settings),
                self._empty_state(tile) if has_state else None,
                deque(rounds),
            )
            for tile in tiles
        ]
        self._waiting = deque(self._works)
        self._moment = 0
        self._is_moving = False  # the owner has been asked to
        self._is_ended = False  # there are no more moments
        self._is_pausing = False
        self._busy = 0  # tiles that are being rendered
        self._spared = 0  # pixel samples of rounds that were not needed
        self._joins = self._lost_joins = 0
        self._changed = threading.Condition()  # guards the nine above
        self._light = empty_light(settings) if light is None else light
        self._unlit: dict[Tile, FinishedTile] = {}  # as they came last, where light is added to them
        self._results: queue.SimpleQueue[FinishedTile | BaseException | object | None] = queue.SimpleQueue()
        self._progress = bentlight_native.Progress()
        self._work = settings.sample_count * sum(tile.width * tile.height for tile in tiles)
        self._start = time.monotonic()
        self._go_on_from(begun or {})
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
    def _is_time_over(self) -> bool:
        return 0 < self._time_limit < self._elapsed

    @property
    def lost_joins(self) -> float:
        """Which part of the curved rays that were to join places with lights was not found (RenderStatistics)."""
        with self._changed:
            return self._lost_joins / max(self._joins, 1)

    @property
    def seconds_left(self) -> float | None:
        """An estimate; None before there is anything to estimate from."""
        fraction = self.fraction
        return self._elapsed * (1 - fraction) / fraction if fraction > 0 else None

    @property
    def names(self) -> tuple[str, ...]:
        """The channels that finished tiles, and their states, are of."""
        return self._names

    @property
    def has_rounds(self) -> bool:
        """Whether tiles take more than one round."""
        return self._has_rounds

    @property
    def light(self) -> np.ndarray | None:
        """What all finished tiles have brought from lamps, after the last one or while the session is settled."""
        return self._light

    @property
    def star_sums(self) -> np.ndarray | None:
        """Of the pixels that are rendered, over all samples so far (bentlight_native.star_sum); None without stars."""
        return self._star_sums

    def pause(self) -> None:
        """Lets no thread begin another round until `go_on`."""
        with self._changed:
            self._is_pausing = True

    @property
    def is_settled(self) -> bool:
        """Whether in a pause all rounds that were begun have ended, and come out of `finished`."""
        with self._changed:
            return self._is_pausing and not self._busy and self._results.empty()

    def unfinished(self) -> Iterator[FinishedTile]:
        """Tiles that have had some of their rounds, with their states, while the session is settled: not copied."""
        for work in self._waiting:
            if work.rounds[0].first > 0:
                yield FinishedTile(work.tile, work.channels, work.state, len(work.rounds))

    def go_on(self) -> None:
        """Ends a pause."""
        with self._changed:
            self._is_pausing = False
            self._changed.notify_all()

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
                elif result is _MOVE:
                    self._begin_moment()
                else:
                    yield self._starry(self._lit(result))
            yield from map(self._starry, map(self._lit, self._last()))
        finally:
            self.close()

    def close(self) -> None:
        """Stops the threads and waits for them. May be called again."""
        self._progress.cancel()
        for thread in self._threads:
            thread.join()

    def _last(self) -> list[FinishedTile]:
        """Tiles that were not shown with all their samples, or have got light or stars since."""
        has_changed = self._light is not None or (self._moment > 0 and self._stars is not None)
        last = [work for work in self._works if not work.is_shown or (has_changed and work.shown > -math.inf)]
        found = [FinishedTile(work.tile, work.channels, None, len(work.rounds)) for work in last]
        self._unlit |= {finished.tile: finished for finished in found}
        return found

    def _lit(self, finished: FinishedTile) -> FinishedTile:
        """The tile with the light that was traced from lamps."""
        if self._light is None or "combined" not in finished.channels:
            return finished
        tile, size = finished.tile, (self._settings.width, self._settings.height)
        self._unlit[tile] = finished
        samples = sum(int(other.channels["sample_count"].sum(dtype=np.float64)) for other in self._unlit.values())
        part = self._light[tile.y : tile.y + tile.height, tile.x : tile.x + tile.width]
        return replace(finished, channels=bentlight_native.with_light(finished.channels, part, samples, size))

    def _starry(self, finished: FinishedTile) -> FinishedTile:
        """The tile with the stars in it."""
        if self._stars is None:
            return finished
        tile, (x, y) = finished.tile, self._stars.corner
        sums = self._star_sums[tile.y - y : tile.y - y + tile.height, tile.x - x : tile.x - x + tile.width]
        shown = bentlight_native.star_mean(sums, self._star_samples)
        lit = bentlight_native.with_stars(finished.channels, shown, self._settings.film_transparent, self._stars.group)
        return replace(finished, channels=lit)

    def _add_stars(self, stars: StarLight | None, samples: int) -> None:
        """Those of a moment that has so many samples."""
        self._star_samples += samples
        if stars is not None:
            added = bentlight_native.star_sum(stars.shown, samples)
            self._star_sums = added if self._star_sums is None else self._star_sums + added
            self._stars = stars

    def _begin_moment(self) -> None:
        """Moves the scene on; all workers wait."""
        moved = None if self._is_time_over else self._move(self._moment + 1)
        with self._changed:
            if moved is None:
                self._waiting.clear()
                self._is_ended = True
            else:
                self._moment += 1
                self._scene, stars = moved
                self._add_stars(stars, self._slices[self._moment].count)
            self._is_moving = False
            self._changed.notify_all()

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
                if self._is_pausing:
                    self._changed.wait(_PAUSE_POLL)  # who cancels does not notify
                    continue
                work = next((work for work in self._waiting if work.rounds[0].moment <= self._moment), None)
                if work is not None:
                    self._waiting.remove(work)
                    if self._is_over(work):
                        continue
                    self._busy += 1
                    return work
                if not self._busy:
                    if not self._waiting and not self._wants_stars:
                        break
                    if not self._is_moving:
                        self._is_moving = True
                        self._results.put(_MOVE)
                self._changed.wait(_PAUSE_POLL if self._is_moving else None)
        return None

    @property
    def _wants_stars(self) -> bool:
        """Whether there are moments left whose stars are not seen yet."""
        return self._stars is not None and not self._is_ended and self._moment + 1 < len(self._slices)

    def _put_back(self, work: _Work, wants_more: bool) -> None:
        """A tile's round has ended; if it wants no more, the samples of all its other rounds count as done."""
        with self._changed:
            self._busy -= 1
            if wants_more:
                self._waiting.append(work)
            elif not self._progress.cancelled:
                self._spared += work.tile.width * work.tile.height * sum(r.count for r in work.rounds)
            self._changed.notify_all()

    def _is_over(self, work: _Work) -> bool:
        """Whether there is no time for a tile's next round any more."""
        return self._is_time_over and work.rounds[0].first > 0

    def _render(self, work: _Work) -> bool:
        """A tile's next round, or what a cancel lets it have; returns whether there is another."""
        tile, (first, count, moment) = work.tile, work.rounds.popleft()
        start = self._settings.first_sample
        settings = replace(self._settings, first_sample=start + first, sample_count=count, resume=first > 0)
        try:
            done = self._scene.render_tile(
                tile.x,
                tile.y,
                tile.width,
                tile.height,
                settings,
                work.channels,
                self._progress,
                self._light,
                work.state,
            )
            self._count(done)
            more = bool(work.rounds) and done.samples > 0
        except bentlight_native.Cancelled:
            if work.channels["sample_count"].any():
                self._show(work, FinishedTile(tile, work.channels, None, len(work.rounds)))
            return False
        work.is_shown = not more or moment == 0 or self._elapsed > work.shown + _SHOWN_EACH
        if work.is_shown:
            self._show(work, self._finished(work, len(work.rounds) if more else 0, is_last=not more))
        return more

    def _count(self, done: bentlight_native.RenderStatistics) -> None:
        with self._changed:
            self._joins += done.joins
            self._lost_joins += done.lost_joins

    def _show(self, work: _Work, finished: FinishedTile) -> None:
        work.shown, work.is_shown = self._elapsed, True
        self._results.put(finished)

    def _finished(self, work: _Work, rounds_left: int, is_last: bool) -> FinishedTile:
        """What a tile has, in arrays that nobody writes to any more."""
        if is_last:
            return FinishedTile(work.tile, work.channels, work.state if self._keeps_state else None, rounds_left)
        channels = {name: values.copy() for name, values in work.channels.items()}
        return FinishedTile(work.tile, channels, None, rounds_left)

    def _empty_state(self, tile: Tile) -> np.ndarray:
        return bentlight_native.empty_state(self._names, self._settings, tile.width, tile.height)

    def _go_on_from(self, begun: Mapping[int, Begun]) -> None:
        """Takes up what there is of tiles, before any thread runs; they come out of `finished` at once."""
        for work, earlier in [(self._waiting[number], begun[number]) for number in sorted(begun)]:
            work.state[:] = earlier.state
            work.channels = bentlight_native.develop_state(self._names, self._settings, work.state)
            while len(work.rounds) > earlier.rounds_left:
                self._spared += work.tile.width * work.tile.height * work.rounds.popleft().count
            self._show(work, self._finished(work, earlier.rounds_left, is_last=not work.rounds))
        self._waiting = deque(work for work in self._waiting if work.rounds)


def _rounds(slices: Sequence[Slice], is_limited: bool) -> list[Round]:
    """The samples of each slice; under a time limit in rounds of ever more."""
    rounds = []
    for moment, part in enumerate(slices):
        cuts = sample_rounds(part.count) if is_limited else [(0, part.count)]
        rounds += [Round(part.first + first, count, moment) for first, count in cuts]
    return rounds


def empty_light(settings: bentlight_native.RenderSettings) -> np.ndarray | None:
    """Where light from lamps is added to; None if none is traced."""
    if settings.integrator != "BIDIRECTIONAL":
        return None
    return np.zeros((settings.height, settings.width, 3), np.int64)


def _empty_channels(
    tile: Tile, names: Iterable[str], settings: bentlight_native.RenderSettings
) -> dict[str, np.ndarray]:
    return {
        name: np.zeros((tile.height, tile.width, bentlight_native.CHANNELS[name].width(settings)), np.float32)
        for name in names
    }
