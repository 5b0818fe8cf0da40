"""The samples of a picture in slices, each of one moment of the time that the shutter is open. Knows no bpy."""

from __future__ import annotations

from typing import NamedTuple

from .hashing import WORD, hash_words


class Slice(NamedTuple):
    """A part of a picture's samples, all of the same moment: when so much of the light has come in."""

    first: int
    count: int
    light: float


def slices(samples: int, most: int, seed: int) -> list[Slice]:
    """The samples of a picture in slices, `most` at most, in the order in which to take them.

    Each slice's moment is drawn from a stratum of the light that is as large as its part of the samples: the mean over
    seeds is that of all moments. The middle one comes first; however many follow, they lie evenly (van der Corput).
    """
    count = min(samples, most)
    edges = [samples * i // count for i in range(count + 1)]
    bits = (count - 1).bit_length()

    def rank(i: int) -> int:
        place = (2 * i + 1) * (1 << bits) // (2 * count) ^ (1 << bits >> 1)
        return int(f"{place:0{bits}b}"[::-1], 2) if bits else 0

    ordered, first = [], 0
    for i in sorted(range(count), key=rank):
        size = edges[i + 1] - edges[i]
        moment = edges[i] + size * hash_words(seed & WORD, i) / (WORD + 1)
        ordered.append(Slice(first, size, moment / samples))
        first += size
    return ordered


def within(parts: list[Slice], first: int, count: int) -> list[Slice]:
    """What a range of a picture's samples has of its slices, counted from the first of the range."""
    cut = [(max(part.first, first), min(part.first + part.count, first + count), part.light) for part in parts]
    return [Slice(begin - first, end - begin, light) for begin, end, light in cut if begin < end]
