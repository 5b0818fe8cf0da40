"""Stars of a scene's data, found by its native scene and drawn. No bpy here."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import bentlight_native
import numpy as np

from .scene_data import StarData

_BAND = 64  # lines drawn at a time: out of focus, all of a large picture would take seconds


def find_stars(
    scene: bentlight_native.Scene,
    stars: StarData,
    settings: bentlight_native.RenderSettings,
    threads: int,
    progress: bentlight_native.Progress | None = None,
) -> bentlight_native.StarImages:
    """Where the camera of a scene that shows stars sees them. Cancelled if another thread cancels `progress`."""
    return scene.find_stars(
        stars.directions,
        (settings.width, settings.height),
        margin=settings.filter_width / 2,
        tolerance=settings.tolerance,
        transparent_bounces=settings.transparent_bounces,
        threads=threads,
        progress=progress,
    )


def draw_stars(
    images: bentlight_native.StarImages,
    stars: StarData,
    settings: bentlight_native.RenderSettings,
    window: tuple[int, int, int, int],
    threads: int,
    progress: bentlight_native.Progress | None = None,
) -> np.ndarray:
    """What they bring to a window (x, y, width, height) of a picture: (height, width, 3) float32, rows upwards. The
    same for any number of threads. Cancelled if another thread cancels `progress`."""
    light, size = images.light(stars.irradiance), (settings.width, settings.height)
    x, y, width, height = window

    def band(first: int) -> np.ndarray:
        if progress is not None and progress.cancelled:
            raise bentlight_native.Cancelled("stars are wanted no more")
        tile = x, y + first, width, min(_BAND, height - first)
        return images.draw(light, size, tile, settings.filter, settings.filter_width)

    with ThreadPoolExecutor(max(1, threads)) as pool:
        return np.concatenate(list(pool.map(band, range(0, height, _BAND))))
