"""Flicker of an image of the sky in an animation, with and without the filter for it.

A camera orbits a Schwarzschild hole before an image of the sky, black but for texels of less than half a pixel:
what is hard for samples to find. Of the light in the whole picture, half the mean square of what two seeds' changes
from frame to frame differ by is the variance of a change by noise. Every frame has other light in the picture by the
orbit itself: that is left out.
"""

from dataclasses import dataclass

import bentlight_native
import numpy as np
from orbit import Orbit

IMAGE = (512, 1024)  # rows and columns
MASS = 1.0
ORBIT = Orbit(distance=20.0, height=0.05, step=np.radians(0.1), slope=0.4)


@dataclass(frozen=True)
class SkyFlicker:
    """Of one animation: the change of all light in the picture by noise, over that light (root mean square), its
    standard error, and the same of squares of 4 x 4 pixels that hold more light than others (the median)."""

    sky_filter: float  # times the distance of a pixel's samples
    picture: float
    picture_error: float
    squares: float


def starry_image(stars: int, seed: int = 1) -> np.ndarray:
    """Pixels for Scene.add_image: white texels on black, even over the sphere."""
    rng = np.random.default_rng(seed)
    row = ((np.arcsin(rng.uniform(-1, 1, stars)) / np.pi + 0.5) * IMAGE[0]).astype(int)
    pixels = np.zeros((*IMAGE, 4), np.float32)
    pixels[row, rng.integers(0, IMAGE[1], stars), :3] = 1
    return pixels


def image_sky(pixels: np.ndarray) -> bentlight_native.Scene:
    """A scene whose sky is an equirectangular image."""
    scene, builder = bentlight_native.Scene(), bentlight_native.ProgramBuilder()
    one = builder.constant(1.0)
    (direction,) = builder.emit("coordinate", immediates=("POSITION",))
    beside = [builder.emit("coordinate_beside", one, immediates=("POSITION", axis))[0] for axis in "XY"]
    image = scene.add_image(pixels)
    color, _ = builder.emit("environment", direction, *beside, immediates=(image, "Linear", "EQUIRECTANGULAR"))
    builder.emit("emission", one, color, one)
    scene.set_world(builder.build())
    return scene


def render(
    scene: bentlight_native.Scene, size: tuple[int, int], samples: int, seed: int, sky_filter: float
) -> np.ndarray:
    """Brightness (height, width)."""
    width, height = size
    settings = bentlight_native.RenderSettings(
        width,
        height,
        sample_count=samples,
        seed=seed,
        max_bounces=0,
        sky_filter=sky_filter / np.sqrt(samples),
    )
    combined = np.empty((height, width, 4), np.float32)
    scene.render_tile(0, 0, width, height, settings, {"combined": combined})
    return combined[..., 0].astype(float)


def measure(
    frames: int = 48, size: tuple[int, int] = (96, 56), samples: int = 16, stars: int = 3000
) -> list[SkyFlicker]:
    """The flicker without and with the filter."""
    scene = image_sky(starry_image(stars))
    scene.set_spacetime(bentlight_native.Spacetime.schwarzschild(MASS))
    pairs: dict[float, list[np.ndarray]] = {0.0: [], 1.0: []}
    for frame in range(frames):
        ORBIT.place_camera(scene, frame, size[0] / size[1])
        for sky_filter, list_ in pairs.items():
            list_.append(np.stack([render(scene, size, samples, seed, sky_filter) for seed in (frame, frames + frame)]))
    return [flicker(sky_filter, np.array(list_)) for sky_filter, list_ in pairs.items()]


def flicker(sky_filter: float, pictures: np.ndarray) -> SkyFlicker:
    """Of (frames, 2 seeds, height, width)."""
    frames, _, height, width = pictures.shape
    squares = pictures.reshape(frames, 2, height // 4, 4, width // 4, 4).sum((3, 5))
    mean = squares.mean((0, 1))
    change = np.diff(squares[:, 0] - squares[:, 1], axis=0)
    each = np.sqrt((change**2).mean(0) / 2)[mean > mean.mean()] / mean[mean > mean.mean()]
    variance = change.sum((1, 2)) ** 2 / 2 / mean.sum() ** 2
    root = np.sqrt(variance.mean())
    error = variance.std(ddof=1) / np.sqrt(len(variance)) / (2 * root)
    return SkyFlicker(sky_filter, root, error, float(np.median(each)))
