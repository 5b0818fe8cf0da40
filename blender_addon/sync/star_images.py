"""Stars of a scene's data, found by its native scene and drawn. No bpy here."""

from __future__ import annotations

import bentlight_native
import numpy as np

from .scene_data import StarData


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
) -> np.ndarray:
    """What they bring to a window (x, y, width, height) of a picture: (height, width, 3) float32, rows upwards."""
    light = images.light(stars.irradiance)
    return images.draw(light, (settings.width, settings.height), window, settings.filter, settings.filter_width)
