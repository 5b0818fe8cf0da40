"""Whom the light of an emitter reaches."""

from collections.abc import Sequence
from typing import NamedTuple


class Influence(NamedTuple):
    """Whom the light of an emissive instance, a lamp or a sun reaches, as Cycles limits and links lights.

    receivers: 64 bits; it lights instances whose `receiver_set` is i if bit i is set. blockers: 64 bits; instances
    whose `blocker_set` is i hold its light up if bit i is set; at 0 it lights without shadows. max_bounces: it lights
    what the camera sees after so many scatterings at most.
    """

    receivers: int = 2**64 - 1
    blockers: int = 2**64 - 1
    max_bounces: int = 2**32 - 1


EVERYONE = Influence()
"""The influence of a light without limits."""


def influences(value: Influence | Sequence[Influence], count: int) -> list[Influence]:
    """One for each of `count` emitters. ValueError if `value` is a list of another length."""
    given = [value] * count if isinstance(value, Influence) else list(value)
    if len(given) != count:
        raise ValueError(f"influence: expected one, or {count}, got {len(given)}")
    return given
