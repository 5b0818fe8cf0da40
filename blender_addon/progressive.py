"""A picture that is rendered over and over while the scene changes: coarse at once, then finer. Knows no bpy.

One thread does all that touches the native scene, edits too: whoever asks for a change waits for nothing. A change ends
the picture in hand, but not before its first coarse one is done, so that something moves on the screen however fast
changes come.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor, wait
from contextlib import contextmanager
from dataclasses import dataclass, replace

import bentlight_native
import numpy as np

from .session import Tile, sample_rounds, spiral_tiles
from .sync.scene_data import StarData
from .sync.star_images import draw_stars, find_stars

THREAD_NAME = "bentlight previews"
"""Of the one thread that each picture in the making has, besides those that render its tiles."""

_TILE_SIZE = 32
_COARSEST = 16  # pixels of the screen that one of the first picture may stand for, in each direction
_STEP = 2  # each picture is so much finer than the one before
_FIRST_SECONDS = 0.12  # that the first picture may take
_STAR_SECONDS = 0.04  # that it may wait for its stars, as they are expected to take
_STAR_PATIENCE = 4 * _STAR_SECONDS  # and as they take


@dataclass(frozen=True)
class Wish:
    """A picture to be made: `edit` the scene, which it returns, and then render it. Edits do not build on each other:
    where another wish comes before this one is begun, only that one's is made.

    settings: of the full size; sample_count is where it ends. smallest_pixel: of the finest picture, in pixels of the
    screen. stars: to be seen in it, if there are any.
    """

    edit: Callable[[], bentlight_native.Scene | None]
    settings: bentlight_native.RenderSettings
    smallest_pixel: int = 1
    stars: StarData | None = None


@dataclass(frozen=True)
class Preview:
    """What there is of a picture: (height, width, 4) float32 from the bottom up, associated alpha, linear."""

    pixels: np.ndarray
    samples: int  # of each pixel of the full size; 0: it is coarse
    wish: Wish


class Progressive:
    """Renders wishes on threads of its own, the newest only; every method may be called from any thread."""

    def __init__(self, threads: int, on_picture: Callable[[], None]) -> None:
        """on_picture is called, on a thread, whenever there is something new to show or `failure` to tell."""
        self._pool = ThreadPoolExecutor(max(1, threads), "bentlight tile")
        self._threads = max(1, threads)
        self._on_picture = on_picture
        self._changed = threading.Condition()  # guards the next five
        self._wish: Wish | None = None
        self._stopped = False
        self._progress: bentlight_native.Progress | None = None
        self._preview: Preview | None = None
        self._failure: Exception | None = None
        self._pixels_per_second = 2e4  # a cautious guess, and measured from the first picture on
        self._stars_per_second = 2e4  # as well
        self._thread = threading.Thread(target=self._run, name=THREAD_NAME, daemon=True)
        self._thread.start()

    @property
    def preview(self) -> Preview | None:
        """The newest picture."""
        with self._changed:
            return self._preview

    @property
    def failure(self) -> Exception | None:
        """Why the last wish came to nothing; None if it did not."""
        with self._changed:
            return self._failure

    def render(self, wish: Wish) -> None:
        """Makes this the picture to be rendered."""
        with self._changed:
            self._wish = wish
            if self._progress:
                self._progress.cancel()
            self._changed.notify_all()

    def close(self) -> None:
        """Stops all threads, waits for them, and lets go of the last picture: its wish may know who has this one, and
        such a circle would last until Python looks for circles. May be called again."""
        with self._changed:
            self._stopped = True
            if self._progress:
                self._progress.cancel()
            self._changed.notify_all()
        self._thread.join()
        self._pool.shutdown()
        with self._changed:
            self._preview = self._wish = None

    def _run(self) -> None:
        while (wish := self._next()) is not None:
            try:
                self._make(wish)
            except bentlight_native.Cancelled:
                continue
            except Exception as failure:
                with self._changed:
                    self._failure = failure
                self._on_picture()

    def _next(self) -> Wish | None:
        with self._changed:
            self._changed.wait_for(lambda: self._wish or self._stopped)
            wish, self._wish = self._wish, None
            return None if self._stopped else wish

    def _make(self, wish: Wish) -> None:
        scene = wish.edit()
        if scene is None:
            return
        scale, stars = self._first_scale(wish), _Stars(scene, wish) if _shows_stars(scene, wish) else None
        self._render(scene, wish, scale, stars, may_cancel=False)
        while scale > wish.smallest_pixel:
            scale = max(scale // _STEP, wish.smallest_pixel)
            self._render(scene, wish, scale, stars, may_cancel=True)

    def _first_scale(self, wish: Wish) -> int:
        pixels, scale = wish.settings.width * wish.settings.height, wish.smallest_pixel
        while scale < _COARSEST and pixels / scale**2 > self._pixels_per_second * _FIRST_SECONDS:
            scale *= _STEP
        return scale

    def _render(
        self, scene: bentlight_native.Scene, wish: Wish, scale: int, stars: _Stars | None, may_cancel: bool
    ) -> None:
        """One picture at 1/scale of the size: a sample a pixel, or if it is the last one all of them."""
        width, height = -(-wish.settings.width // scale), -(-wish.settings.height // scale)
        settings = replace(wish.settings, width=width, height=height)
        is_last = scale == wish.smallest_pixel
        channels = {name: np.zeros((height, width, n), np.float32) for name, n in _channels(settings, is_last).items()}
        for first, count in sample_rounds(wish.settings.sample_count) if is_last else [(0, 1)]:
            start = time.monotonic()
            part = replace(settings, first_sample=first, sample_count=count, resume=first > 0)
            done = self._take(scene, part, channels, may_cancel or first > 0)
            if first == 0:
                self._pixels_per_second = width * height / max(time.monotonic() - start, 1e-4)
            made = Preview(channels["combined"], first + count if is_last else 0, wish)
            is_complete = self._show(made, settings, stars, may_cancel or first > 0)
            if first and not done:
                break
        if is_last and not is_complete:  # there is no other picture for its stars to come with
            self._show(made, settings, stars, may_cancel=True)

    def _show(
        self, made: Preview, settings: bentlight_native.RenderSettings, stars: _Stars | None, may_cancel: bool
    ) -> bool:
        """Shows a copy of a picture with its stars, or False: without, as they take too long for the first one."""
        pixels = self._starry(made.pixels, settings, stars, may_cancel) if stars else made.pixels.copy()
        with self._changed:
            self._preview = replace(made, pixels=made.pixels.copy() if pixels is None else pixels)
            self._failure = None
        self._on_picture()
        return pixels is not None

    def _take(
        self,
        scene: bentlight_native.Scene,
        settings: bentlight_native.RenderSettings,
        channels: dict[str, np.ndarray],
        may_cancel: bool,
    ) -> int:
        """Adds samples to all of a picture; returns how many. Cancelled if there is another wish."""
        tiles = spiral_tiles(0, 0, settings.width, settings.height, _TILE_SIZE)
        with self._cancellable(may_cancel) as progress:
            works = [self._pool.submit(_render_tile, scene, settings, tile, channels, progress) for tile in tiles]
            wait(works)  # all: the next edit must find nobody at work
        counts = [work.result() for work in works]
        if None in counts:
            raise bentlight_native.Cancelled("another picture is wanted")
        return sum(counts)

    def _starry(
        self, pixels: np.ndarray, settings: bentlight_native.RenderSettings, stars: _Stars, may_cancel: bool
    ) -> np.ndarray | None:
        """A copy of a picture's pixels with its stars; of the first one, which waits for nothing, None unless that is
        quick, as expected and then in truth: the scene may have changed."""
        count, start = stars.wanted, time.monotonic()
        if not may_cancel and count > self._stars_per_second * _STAR_SECONDS:
            return None
        with self._cancellable(may_cancel) as progress:
            patience = threading.Timer(_STAR_PATIENCE, progress.cancel)
            if not may_cancel:
                patience.start()
            try:
                pixels = stars.added(pixels, settings, self._threads, progress)
            except bentlight_native.Cancelled:
                if may_cancel:
                    raise
                pixels = None
            finally:
                patience.cancel()
        if count:
            self._stars_per_second = progress.done / max(time.monotonic() - start, 1e-4)
        return pixels

    @contextmanager
    def _cancellable(self, may_cancel: bool) -> Iterator[bentlight_native.Progress]:
        """Work that another wish cancels, before it begins or by its progress."""
        progress = bentlight_native.Progress()
        with self._changed:
            if self._stopped or (may_cancel and self._wish):
                raise bentlight_native.Cancelled("another picture is wanted")
            self._progress = progress if may_cancel else None
        try:
            yield progress
        finally:
            with self._changed:
                self._progress = None


def _shows_stars(scene: bentlight_native.Scene, wish: Wish) -> bool:
    return wish.stars is not None and len(wish.stars.directions) > 0 and scene.shows_stars()


class _Stars:
    """The stars of a wish: found once, and drawn for each size of its picture."""

    def __init__(self, scene: bentlight_native.Scene, wish: Wish) -> None:
        self._scene, self._wish = scene, wish
        self._images: bentlight_native.StarImages | None = None
        self._shown: np.ndarray | None = None

    @property
    def wanted(self) -> int:
        """How many are still to be found."""
        return len(self._wish.stars.directions) if self._images is None else 0

    def added(
        self,
        pixels: np.ndarray,
        settings: bentlight_native.RenderSettings,
        threads: int,
        progress: bentlight_native.Progress,
    ) -> np.ndarray:
        """A copy of the pixels of a picture with these settings, with its stars. Cancelled if another thread cancels
        `progress`, which counts those found."""
        stars = self._wish.stars
        if self._images is None:
            self._images = find_stars(self._scene, stars, self._wish.settings, threads, progress)
        if self._shown is None or self._shown.shape[:2] != pixels.shape[:2]:
            window = 0, 0, settings.width, settings.height
            self._shown = draw_stars(self._images, stars, settings, window, threads, progress)
        lit = bentlight_native.with_stars({"combined": pixels}, self._shown, settings.film_transparent)
        return lit["combined"].copy() if settings.film_transparent else lit["combined"]


def _render_tile(
    scene: bentlight_native.Scene,
    settings: bentlight_native.RenderSettings,
    tile: Tile,
    channels: dict[str, np.ndarray],
    progress: bentlight_native.Progress,
) -> int | None:
    """Adds samples to a tile of a picture; returns how many, or None if that was cancelled.

    Not as an exception: a future would hold it, and its traceback the future, and that circle the scene."""
    where = slice(tile.y, tile.y + tile.height), slice(tile.x, tile.x + tile.width)
    part = {name: np.ascontiguousarray(values[where]) for name, values in channels.items()}
    try:
        done = scene.render_tile(tile.x, tile.y, tile.width, tile.height, settings, part, progress)
    except bentlight_native.Cancelled:
        return None
    for name, values in channels.items():
        values[where] = part[name]
    return done.samples


def _channels(settings: bentlight_native.RenderSettings, is_last: bool) -> dict[str, int]:
    """Components by name of what a picture, and the next round of it, need."""
    names = ["combined"]
    if is_last:
        names += ["sample_count", *(("noise_partial", "noise_scatter") if settings.noise_threshold else ())]
    return {name: bentlight_native.CHANNELS[name].components for name in names}
