"""Rows of the golden data (tests/data/golden/README.md has their conventions)."""

import csv
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).parents[1] / "data" / "golden"
EPS = np.finfo(float).eps


def rows(name):
    """The rows of a golden file as dictionaries of strings."""
    with open(FOLDER / name, newline="") as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


def numbers(table, column):
    """A column as float64, NaN where a cell is empty."""
    return np.array([float(row[column]) if row[column] else np.nan for row in table])


def number_lists(table, column):
    """A column of ;-separated lists."""
    return [np.array([float(x) for x in row[column].split(";")] if row[column] else []) for row in table]


def sine_cosine_deg(degrees):
    """Sine and cosine of angles in degrees, exact at multiples of 90 as the golden data are."""
    turns, rest = np.divmod(np.asarray(degrees, float), 90)
    s, c = np.sin(np.deg2rad(rest)), np.cos(np.deg2rad(rest))
    quadrant = turns.astype(int) % 4
    return np.choose(quadrant, [s, c, -s, -c]), np.choose(quadrant, [c, -s, -c, s])
