"""States: what the samples of each pixel of a picture add up to, in numbers whose sums are exact.

States of different samples of a pixel are added up in any order, to the last bit: halves of a picture that were
rendered on two machines become the whole. `render_tile` makes states; here they are merged, and developed into
channels.
"""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from . import _core
from .render import CHANNELS, RenderSettings


def _sizes(settings: RenderSettings) -> tuple[float, int, int, int]:
    """What of the settings decides how much a state holds."""
    return settings.noise_threshold, settings.light_groups, settings.aovs, settings.matte_ranks


def state_width(names: Iterable[str], settings: RenderSettings) -> int:
    """Numbers in each pixel's state, of a render that wants the channels of these names."""
    return _core.state_width(tuple(names), _sizes(settings))


def empty_state(names: Iterable[str], settings: RenderSettings, width: int, height: int) -> NDArray[np.float64]:
    """The state (height, width, n) of pixels without samples."""
    return np.zeros((height, width, state_width(names, settings)))


def merge_states(
    names: Iterable[str], settings: RenderSettings, state: NDArray[np.float64], other: NDArray[np.float64]
) -> None:
    """Add to a state that of other samples of the same pixels, names and settings.

    state, other: (height, width, n) float64, C-contiguous. Exact, and so the same in any order, while sums of
    magnitudes stay below 2**41, there are fewer than 2**21 samples a pixel, and no pixel has more names than
    settings.matte_ranks. Where both have samples there must have been no noise threshold.
    """
    _core.state_merge(tuple(names), _sizes(settings), state, other)


def develop_state(
    names: Iterable[str], settings: RenderSettings, state: NDArray[np.float64]
) -> dict[str, NDArray[np.float32]]:
    """The channels (height, width, components) that a state stands for, as `render_tile` writes them."""
    height, width = state.shape[:2]
    channels = {name: np.empty((height, width, CHANNELS[name].width(settings)), np.float32) for name in names}
    _core.state_develop(_sizes(settings), height, width, state, channels)
    return channels
