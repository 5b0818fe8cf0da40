"""IES files: what luminaires send by direction, as a table for the core's operation `ies`.

ANSI/IES LM-63, photometric type C (vertical half circles around the lamp's axis), as Cycles understands it.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy
import numpy as np

_WATTS_PER_CANDELA = 0.0706650768394  # 4 pi / 177.83 lm/W: the luminous efficacy of D65


def ies_table(node: Any) -> np.ndarray:
    """Rows (n, 4) of the file or text of an IES Texture node. Raises ValueError, with what is wrong, if it has none."""
    if node.mode == "INTERNAL":
        if node.ies is None:
            raise ValueError("no text is chosen")
        return _table(node.ies.as_string())
    path = Path(bpy.path.abspath(node.filepath, library=node.id_data.library))
    try:
        return _table(path.read_text(encoding="latin-1"))
    except OSError as error:
        raise ValueError(f"the file cannot be read ({error.strerror})") from error


def _table(text: str) -> np.ndarray:
    """Both counts of angles, the angles in radians, and what is sent; filled up with zeros to rows of four."""
    horizontal, vertical, sent = _full_circle(*_parse(text))
    flat = [len(horizontal), len(vertical), *np.radians(horizontal), *np.radians(vertical), *sent.ravel()]
    return np.pad(np.array(flat, np.float32), (0, -len(flat) % 4)).reshape(-1, 4)


def _parse(text: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Horizontal and vertical angles in degrees, and watts (horizontal, vertical)."""
    _, found, rest = text.replace("\r\n", "\n").partition("\nTILT=")
    kind, _, rest = rest.partition("\n")
    try:
        numbers = np.array(rest.replace(",", " ").split(), np.float64)
    except ValueError as error:
        raise ValueError("it is no IES file") from error
    if not found or len(numbers) < 13 or not np.isfinite(numbers).all():
        raise ValueError("it is no IES file")
    if kind.strip() == "INCLUDE":  # by how much tilted lamps are weaker
        numbers = numbers[2 + 2 * int(numbers[1]) :]
    verticals, horizontals, photometry = (int(x) for x in numbers[3:6])
    if photometry != 1:
        raise ValueError("its photometric type is not C")
    angles = numbers[13 : 13 + verticals + horizontals]
    values = numbers[13 + verticals + horizontals :][: verticals * horizontals]
    if min(verticals - 1, horizontals) < 1 or len(values) != verticals * horizontals:
        raise ValueError("it is cut off")
    factor = numbers[2] * numbers[10] * numbers[11] * _WATTS_PER_CANDELA
    return angles[verticals:], angles[:verticals], factor * values.reshape(horizontals, verticals)


def _full_circle(horizontal: np.ndarray, vertical: np.ndarray, sent: np.ndarray) -> tuple[np.ndarray, ...]:
    """Mirrors what is given of the circle until it is whole."""
    if horizontal[0] == 90:
        horizontal = horizontal - 90
    if len(horizontal) == 1:
        horizontal, sent = np.array([horizontal[0], 360.0]), np.concatenate([sent, sent])
    for part in (90, 180):
        if horizontal[-1] == part:
            horizontal = np.concatenate([horizontal, 2 * part - horizontal[-2::-1]])
            sent = np.concatenate([sent, sent[-2::-1]])
    gap = 360 - horizontal[-1]
    if gap and gap in (horizontal[-1] - horizontal[-2], horizontal[1] - horizontal[0]):
        horizontal, sent = np.append(horizontal, 360.0), np.concatenate([sent, sent[:1]])
    poles = (vertical[0], vertical[-1])
    if horizontal[0] != 0 or horizontal[-1] != 360 or not (poles[0] == 0 or poles == (90, 180)):
        raise ValueError("its angles cover no circle")
    if (np.diff(horizontal) <= 0).any() or (np.diff(vertical) <= 0).any():
        raise ValueError("its angles do not rise")
    return horizontal, vertical, sent
