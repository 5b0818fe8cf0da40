"""Parts of a picture: some samples of some of its pixels, in a file of their own, and merged into the whole.

A part is an OpenEXR file with the state of each pixel, its numbers as pairs of whole ones, and a description in the
header. Merging is exact: parts in any grouping and order give the picture that one machine would have rendered.
"""

import json
import os
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .exr import ExrError, read_exr, write_exr
from .finish import pass_values, with_light, with_stars
from .render import RenderSettings
from .stars import star_mean
from .state import develop_state, merge_states, state_width

_DESCRIPTION = "bentlightPart"
_FORMAT = 3
_PLAIN = ("layer", "view", "frame", "is_cropped", "scene", "star_group", "metadata")  # fields of a picture, as they are
_OUTSIDE = {"depth": 1e11, "vector": 1e4}  # what Blender has outside of a border, where it is not 0


class PartError(ValueError):
    """Parts that do not belong together, or a file that is none. The message names the file and the reason."""


class Piece(NamedTuple):
    """Samples first .. first + count - 1 of the pixels of a rectangle, counted from the image's bottom left."""

    x: int
    y: int
    width: int
    height: int
    first: int
    count: int

    def overlaps(self, other: "Piece") -> bool:
        """Whether some sample is in both."""
        return (
            max(self.x, other.x) < min(self.x + self.width, other.x + other.width)
            and max(self.y, other.y) < min(self.y + self.height, other.y + other.height)
            and max(self.first, other.first) < min(self.first + self.count, other.first + other.count)
        )

    def __str__(self) -> str:
        pixels = f"pixels {self.x} to {self.x + self.width - 1} by {self.y} to {self.y + self.height - 1}"
        return f"samples {self.first}:{self.first + self.count} of {pixels}"


class PassPlan(NamedTuple):
    """One pass of the picture: its name, one letter for each component, and of what it is made (pass_values)."""

    name: str
    components: str
    channel: str
    first: int = 0
    color: str = ""


@dataclass(frozen=True)
class Picture:
    """What all parts of a picture have in common.

    layer, view: of Blender; the view is empty if there is one only. settings: those of the whole picture. window: x, y,
    width, height of the part of the image that is rendered, is_cropped: whether that is all of the file's image.
    names: the channels that states are of. scene: a fingerprint of what is seen. star_group: of the sky's light.
    metadata: strings for the picture's file.
    """

    layer: str
    view: str
    frame: int
    settings: RenderSettings
    window: tuple[int, int, int, int]
    is_cropped: bool
    names: tuple[str, ...]
    passes: tuple[PassPlan, ...]
    scene: str
    star_group: int = -1
    metadata: dict[str, str] = field(default_factory=dict)


@dataclass
class Part:
    """Some samples of a picture. Arrays have rows upwards and are as large as its window.

    state: (height, width, n) float64. light: int64 (height, width, 3) as of render_tile, if light was traced from lamps
    too. stars: float64 (height, width, 6), the sums of star_sum, if there are any.
    """

    picture: Picture
    pieces: list[Piece]
    state: NDArray[np.float64]
    light: NDArray[np.int64] | None = None
    stars: NDArray[np.float64] | None = None

    def missing(self) -> int:
        """How many pixel samples the whole picture has that this part has not."""
        _, _, width, height = self.picture.window
        there = sum(piece.width * piece.height * piece.count for piece in self.pieces)
        return width * height * self.picture.settings.sample_count - there

    def develop(self) -> dict[str, NDArray[np.float32]]:
        """The channels of the window, with light and stars."""
        settings = self.picture.settings
        channels = develop_state(self.picture.names, settings, self.state)
        if self.light is not None:
            samples = int(channels["sample_count"].sum(dtype=np.float64))
            channels = with_light(channels, self.light, samples, (settings.width, settings.height))
        return channels if self.stars is None else self._starry(channels)

    def _starry(self, channels: dict[str, NDArray[np.float32]]) -> dict[str, NDArray[np.float32]]:
        shown = star_mean(self.stars, self._samples())
        return with_stars(channels, shown, self.picture.settings.film_transparent, self.picture.star_group)

    def _samples(self) -> NDArray[np.int64]:
        """How many samples of each pixel of the window there are."""
        left, bottom, width, height = self.picture.window
        samples = np.zeros((height, width), np.int64)
        for piece in self.pieces:
            x, y = piece.x - left, piece.y - bottom
            samples[y : y + piece.height, x : x + piece.width] += piece.count
        return samples


def merge(parts: Sequence[Part]) -> Part:
    """The part with all samples of the given ones. Raises PartError if they overlap or are of different pictures."""
    whole = Part(parts[0].picture, list(parts[0].pieces), parts[0].state.copy())
    whole.light = None if parts[0].light is None else parts[0].light.copy()
    whole.stars = None if parts[0].stars is None else parts[0].stars.copy()
    for part in parts[1:]:
        _check_same(whole.picture, part.picture)
        for name in ("light", "stars"):
            if (getattr(whole, name) is None) != (getattr(part, name) is None):
                raise PartError(f"parts are of different pictures: only some have {name}")
        for piece in part.pieces:
            if any(map(piece.overlaps, whole.pieces)):
                raise PartError(f"more than one part has some of {piece}")
        merge_states(whole.picture.names, whole.picture.settings, whole.state, part.state)
        if whole.light is not None:
            whole.light += part.light
        if whole.stars is not None:
            whole.stars += part.stars
        whole.pieces += part.pieces
    return whole


def _check_same(a: Picture, b: Picture) -> None:
    """Raises PartError unless both are the same picture; its scene, which may differ by rounding, excepted."""
    ours, theirs = (asdict(replace(picture, scene="")) for picture in (a, b))
    ours |= ours.pop("settings")
    theirs |= theirs.pop("settings")
    for name, value in ours.items():
        if value != theirs[name]:
            raise PartError(f"parts of different pictures: {name} is {value} in one and {theirs[name]} in another")


# ---- Files ----


def write_part(path: str | os.PathLike, part: Part) -> None:
    """Write a part, to a temporary name first. It takes no more room than its pieces need, unless it has light."""
    lines, pixels = _extent(part)
    channels = _words("state", part.state[lines, pixels])
    if part.light is not None:
        channels |= _words("light", part.light[lines, pixels])
    if part.stars is not None:
        channels |= _words("stars", part.stars[lines, pixels])
    description = asdict(part.picture) | {
        "format": _FORMAT,
        "pieces": part.pieces,
        "corner": (pixels.start, lines.start),
        "has_light": part.light is not None,
        "has_stars": part.stars is not None,
    }
    upright = {name: values[::-1] for name, values in channels.items()}
    write_exr(path, upright, {_DESCRIPTION: json.dumps(description)}, compress=True)


def _extent(part: Part) -> tuple[slice, slice]:
    """Lines and pixels of the window that hold something."""
    left, bottom, width, height = part.picture.window
    if part.light is not None:
        return slice(0, height), slice(0, width)
    x0, y0 = min(piece.x for piece in part.pieces), min(piece.y for piece in part.pieces)
    x1 = max(piece.x + piece.width for piece in part.pieces)
    y1 = max(piece.y + piece.height for piece in part.pieces)
    return slice(y0 - bottom, y1 - bottom), slice(x0 - left, x1 - left)


def _words(name: str, values: NDArray) -> dict[str, NDArray[np.uint32]]:
    """Channels with the numbers of (height, width, n), each in one or two words."""
    words = np.ascontiguousarray(values).view("<u4")
    return {f"{name}.{k:04}": words[..., k] for k in range(words.shape[-1])}


def _numbers(channels: dict[str, NDArray], name: str, count: int, kind: str) -> NDArray:
    words = np.stack([channels[f"{name}.{k:04}"] for k in range(count * np.dtype(kind).itemsize // 4)], axis=-1)
    return np.ascontiguousarray(words).view(kind)


def read_part(path: str | os.PathLike) -> Part:
    """Read a file of write_part. Raises PartError for other files and damaged ones, OSError if it cannot be read."""
    try:
        channels, strings = read_exr(path)
    except ExrError as error:
        raise PartError(f"{error}") from None
    if _DESCRIPTION not in strings:
        raise PartError(
            f"{path}: it is a picture or table, not part of one: parts are made by --bentlight-samples or -tile"
        )
    try:
        return _part(json.loads(strings[_DESCRIPTION]), {name: values[::-1] for name, values in channels.items()})
    except (KeyError, TypeError, ValueError) as error:
        raise PartError(f"{path}: made by another version of Bentlight ({error})") from None


def _part(description: dict[str, Any], channels: dict[str, NDArray]) -> Part:
    if description["format"] != _FORMAT:
        raise ValueError(f"format {description['format']}")
    settings = RenderSettings(**description["settings"])
    names, window = tuple(description["names"]), tuple(description["window"])
    picture = Picture(
        **{name: description[name] for name in _PLAIN},
        settings=settings,
        window=window,
        names=names,
        passes=tuple(PassPlan(*row) for row in description["passes"]),
    )
    x, y = description["corner"]

    def in_window(values: NDArray) -> NDArray:
        whole = np.zeros((window[3], window[2], values.shape[-1]), values.dtype)
        whole[y : y + values.shape[0], x : x + values.shape[1]] = values
        return whole

    return Part(
        picture,
        [Piece(*piece) for piece in description["pieces"]],
        in_window(_numbers(channels, "state", state_width(names, settings), "<f8")),
        in_window(_numbers(channels, "light", 3, "<i8")) if description["has_light"] else None,
        in_window(_numbers(channels, "stars", 6, "<f8")) if description["has_stars"] else None,
    )


def write_picture(path: str | os.PathLike, parts: Sequence[Part]) -> None:
    """Write the pictures of parts, one for each layer and view, as one OpenEXR file with all their passes, float32,
    named as Blender names them. Raises PartError for pictures of different size."""
    planes: dict[str, NDArray[np.float32]] = {}
    strings = {"BlenderMultiChannel": "Bentlight"}
    for part in parts:
        picture, channels = part.picture, part.develop()
        strings |= picture.metadata
        for item in picture.passes:
            owner = ".".join(name for name in (picture.layer, item.name, picture.view) if name)
            values = pass_values(channels, item.channel, item.first, len(item.components), item.color)
            for k, letter in enumerate(item.components):
                planes[f"{owner}.{letter}"] = _on_canvas(picture, values[..., k], _OUTSIDE.get(item.channel, 0.0))[::-1]
    if len({plane.shape for plane in planes.values()}) > 1:
        raise PartError("layers of different size do not fit into one file")
    write_exr(path, planes, strings, compress=True)


def _on_canvas(picture: Picture, values: NDArray[np.float32], outside: float) -> NDArray[np.float32]:
    """What the file shows: the window, or the image with `outside` around it."""
    if picture.is_cropped:
        return values
    x, y, width, height = picture.window
    canvas = np.full((picture.settings.height, picture.settings.width), outside, np.float32)
    canvas[y : y + height, x : x + width] = values
    return canvas
