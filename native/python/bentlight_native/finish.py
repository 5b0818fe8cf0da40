"""What a picture gets after its samples: light that was traced from lamps, and stars."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

_LIGHT_UNIT = 2.0**-32  # BENT_LIGHT_UNIT of the C header
_STAR_CHANNELS = ("combined", "environment", "denoising_albedo")  # what shows stars: the sky's


def light_image(light: NDArray[np.int64], samples: int, size: tuple[int, int] | None = None) -> NDArray[np.float32]:
    """What `render_tile` has left in `light`, as a picture to be added to `combined`, (height, width, 3).

    light: all of the array, or a part of it if `size` is the width and height of the image.
    samples: of all calls that have added to it together (RenderStatistics.samples).
    """
    height, width = light.shape[:2] if size is None else size[::-1]
    return (light * (_LIGHT_UNIT * width * height / max(samples, 1))).astype(np.float32)


def with_light(
    channels: Mapping[str, NDArray[np.float32]], light: NDArray[np.int64], samples: int, size: tuple[int, int]
) -> dict[str, NDArray[np.float32]]:
    """A tile's channels with its part of the light that was traced from lamps; arguments as of light_image."""
    if "combined" not in channels:
        return dict(channels)
    combined = channels["combined"].copy()
    combined[..., :3] += light_image(light, samples, size)
    return {**channels, "combined": combined}


def with_stars(
    channels: Mapping[str, NDArray[np.float32]],
    shown: NDArray[np.float32],
    film_transparent: bool,
    light_group: int = -1,
) -> dict[str, NDArray[np.float32]]:
    """A tile's channels with its stars, (height, width, 3). A transparent film shows none, but its passes do.
    light_group: the sky's, -1 for none."""
    lit = dict(channels)
    for name in _STAR_CHANNELS:
        if name in lit and not (name == "combined" and film_transparent):
            lit[name] = lit[name].copy()
            lit[name][..., :3] += shown
    if "light_groups" in lit and light_group >= 0 and not film_transparent:
        lit["light_groups"] = lit["light_groups"].copy()
        lit["light_groups"][..., 3 * light_group : 3 * light_group + 3] += shown
    return lit


def pass_values(
    channels: Mapping[str, NDArray[np.float32]], channel: str, first: int, width: int, color: str = ""
) -> NDArray[np.float32]:
    """What a pass shows, (height, width, components): a channel's components from `first` on. color: the channel by
    which light passes, and vectors, are divided, or ""."""
    values = channels[channel][..., first : first + width]
    return _divided(values, channels[color]) if color else values


def _divided(light: NDArray[np.float32], color: NDArray[np.float32]) -> NDArray[np.float32]:
    """Light over the color that it was scattered by; what is 0 there takes the mean of the others, as in Cycles."""
    known = color != 0
    with np.errstate(divide="ignore", invalid="ignore"):
        out = np.where(known, light / color, 0).astype(np.float32)
    count = known.sum(axis=-1, keepdims=True)
    mean = out.sum(axis=-1, keepdims=True) / np.maximum(count, 1)
    return np.where(known, out, mean).astype(np.float32)
