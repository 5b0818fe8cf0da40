"""Skies full of stars: places, magnitudes and colors, made up or from a catalog's file. No bpy here."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

_SUN_LIKE = 0.65  # color index of stars whose catalog does not say
_COLORS = (-0.4, 2.0)  # color indices of stars as they are
_MAGNITUDES = (-30.0, 40.0)


@dataclass(frozen=True)
class Stars:
    """n stars: unit directions (n, 3), magnitudes (n,) and color indices B-V (n,)."""

    directions: np.ndarray
    magnitudes: np.ndarray
    color_indices: np.ndarray


def procedural(count: int, seed: int, brightest: float, slope: float) -> Stars:
    """Stars all over the sky; the k-th brightest has magnitude brightest + log10(k) / slope.

    A smaller count is the same sky without its faintest stars. Color indices are about those of the stars that the eye
    sees: hot ones around 0, giants around 1.1, and some of every color.
    """
    places = np.random.default_rng((seed, 0)).normal(size=(count, 3))
    numbers = np.random.default_rng((seed, 1)).random((count, 3))
    # Two normal deviates (Box & Muller 1958) from a star's own numbers.
    deviate = np.sqrt(-2 * np.log1p(-numbers[:, 0])) * np.cos(2 * np.pi * numbers[:, 1])
    kind, even = numbers[:, 2], (numbers[:, 2] - 0.85) / 0.15
    colors = np.where(kind < 0.4, 0.02 + 0.13 * deviate, np.where(kind < 0.85, 1.1 + 0.25 * deviate, -0.2 + 1.8 * even))
    directions = places / np.linalg.norm(places, axis=1, keepdims=True)
    return Stars(directions, brightest + np.log10(np.arange(1, count + 1)) / slope, np.clip(colors, *_COLORS))


def read_catalog(path: Path) -> Stars:
    """The stars of a file: right ascension and declination in degrees, magnitude and, if it is known, B-V a line.

    With commas, semicolons or tabs between them. Empty lines, lines that start with # and a heading are passed over.
    Raises ValueError with the number of the line that is no star, OSError.
    """
    rows = list(_rows(Path(path).read_text(encoding="utf-8-sig", errors="replace")))
    if not rows:
        raise ValueError("there is no star in it")
    right_ascension, declination, magnitudes, colors = np.array(rows).T
    turn, height = np.radians(right_ascension), np.radians(declination)
    directions = np.column_stack([np.cos(height) * np.cos(turn), np.cos(height) * np.sin(turn), np.sin(height)])
    return Stars(directions, magnitudes, np.clip(colors, *_COLORS))


def _rows(text: str) -> Iterator[tuple[float, ...]]:
    lines = text.splitlines()
    separator = next((mark for mark in (",", ";", "\t") if any(mark in line for line in lines)), ",")
    is_first = True
    for number, cells in enumerate(csv.reader(lines, delimiter=separator), start=1):
        cells = [cell.strip() for cell in cells]
        if not any(cells) or cells[0].startswith("#"):
            continue
        if not (is_first and not _is_number(cells[0])):  # a heading
            yield _star(cells, number)
        is_first = False


def _is_number(text: str) -> bool:
    try:
        return bool(np.isfinite(float(text)))
    except ValueError:
        return False


def _star(cells: list[str], line: int) -> tuple[float, ...]:
    wanted = ["right ascension", "declination", "magnitude"]
    if len(cells) < len(wanted):
        raise ValueError(f"line {line}: expected {', '.join(wanted)} and maybe B-V, got {len(cells)} numbers")
    if len(cells) > 3 and cells[3]:
        wanted.append("B-V")
    for name, cell in zip(wanted, cells, strict=False):
        if not _is_number(cell):
            raise ValueError(f"line {line}: {name} is not a number: '{cell}'")
    values = [float(cell) for cell in cells[: len(wanted)]]
    for name, value, (low, high) in zip(wanted[1:3], values[1:3], ((-90, 90), _MAGNITUDES), strict=True):
        if not low <= value <= high:
            raise ValueError(f"line {line}: {name} must lie in [{low:g}, {high:g}], got {value:g}")
    return *values[:3], values[3] if len(values) > 3 else _SUN_LIKE


def temperature_k(color_index: np.ndarray) -> np.ndarray:
    """Kelvin of a star whose color index is B-V (Ballesteros 2012, equation 14)."""
    return 4600 * (1 / (0.92 * color_index + 1.7) + 1 / (0.92 * color_index + 0.62))
