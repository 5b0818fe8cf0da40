"""relay_maps.h through Cycles, value by value: from maps of random numbers it reads the leg of just the part that a
place of the image lies in, and the place of slices' parts is that at which the core has traced them."""

import math
from pathlib import Path

import numpy as np
import pytest
import shader_values
from bentlight_native.exr import write_exr

from blender_addon.cycles import relay_maps

WIDTH, HEIGHT, MARGIN, BAND, PARTS, SLICES = 11, 7, 2, 4, 2, 3
FAR, TO_SKY, CELLS_A_ROW, CELL = 1e4, 2.0**64, 64, 8
TIMES = (3, 5)  # as fine
COLUMNS, ROWS = WIDTH + 2 * MARGIN, HEIGHT + 2 * MARGIN
COUNT = 900


def shift(slice_number: int) -> np.ndarray:
    """By how much the parts of a slice are shifted, in pixels, as relay_maps.py traces them: without a scene."""
    return (np.mod(slice_number * relay_maps._SHIFTS + 0.5, 1.0) - 0.5) / PARTS


class Maps:
    """All files of three slices, written, and kept by the beginning of their names. Of four legs one leads to the sky
    and one is black."""

    def __init__(self, folder) -> None:
        self.prefix, self.random, self.files = f"{folder}/maps_", np.random.default_rng(4), {}
        for number in range(SLICES):
            for band in range(math.ceil(ROWS / BAND)):
                stem = f"{number:02}_{band:04}_"
                self._write(f"{stem}", (BAND * PARTS, COLUMNS * PARTS))
                times = self.random.choice([0, *TIMES], (BAND, COLUMNS)) if number != 1 else np.zeros((BAND, COLUMNS))
                cells = np.zeros((BAND, COLUMNS, 1))
                for finer in np.intersect1d(TIMES, times):
                    chosen, fine = times == finer, int(finer) * PARTS
                    cells[chosen, 0] = np.arange(chosen.sum()) * CELL + finer
                    rows = math.ceil(chosen.sum() / CELLS_A_ROW) * fine
                    self._write(f"{stem}{int(finer)}x_", (rows, CELLS_A_ROW * fine))
                self._file(f"{stem}cells", cells)

    def _write(self, stem: str, shape: tuple[int, int]) -> None:
        direction, kind = self.random.normal(size=(*shape, 3)), self.random.integers(4, size=shape)
        direction[kind == 0] = 0
        direction[kind == 1] *= TO_SKY
        self._file(f"{stem}direction", direction)
        self._file(f"{stem}place", self.random.normal(size=(*shape, 3)))
        self._file(f"{stem}tint", self.random.random((1, 1, 3)))  # all the same: a single one

    def _file(self, name: str, image: np.ndarray) -> None:
        self.files[name] = image.astype(np.float32)
        channels = {channel: self.files[name][..., i] for i, channel in enumerate("RGB"[: image.shape[2]])}
        write_exr(Path(f"{self.prefix}{name}.exr"), channels, {})

    def leg(self, number: int, x: float, y: float) -> dict[str, np.ndarray]:
        """Of the part at x, y in pixels of the maps, from their lower left corner; as the header's head describes the
        files. The place is that of the map, or far away."""
        column, row = math.floor(x), math.floor(y)
        stem = f"{number:02}_{row // BAND:04}_"
        u, v, parts = x, y - row // BAND * BAND, PARTS
        cell, finer = divmod(int(self.files[f"{stem}cells"][row % BAND, column, 0]), CELL)
        if finer:
            stem, parts = f"{stem}{finer}x_", finer * PARTS
            u, v = cell % CELLS_A_ROW + x - column, cell // CELLS_A_ROW + y - row
        at = math.floor(v * parts), math.floor(u * parts)
        direction, place = self.files[f"{stem}direction"][at].astype(float), self.files[f"{stem}place"][at]
        told = place
        if np.abs(direction).max() > 2.0**32:
            direction /= TO_SKY
            place = FAR * direction / np.linalg.norm(direction)
        elif not direction.any():
            place = np.zeros(3)
        return {"direction": direction, "place": place, "told": told, "tint": self.files[f"{stem}tint"][0, 0]}


@pytest.fixture(scope="module")
def maps(tmp_path_factory) -> Maps:
    return Maps(tmp_path_factory.mktemp("maps"))


def asked() -> tuple[np.ndarray, list[tuple[int, float, float]]]:
    """Rows of slice, across and up, float32, for the shader, in the image and up to a pixel outside of it; and slices
    and places in pixels of the maps for `Maps.leg`. None is as near to the border of a part as rounding."""
    random = np.random.default_rng(7)
    number = random.integers(SLICES, size=4 * COUNT)
    size = np.array([WIDTH, HEIGHT])
    at = np.float32(random.uniform(-1, size + 1, (4 * COUNT, 2)) / size)
    places = at.astype(float) * size + MARGIN - np.array([shift(n) for n in number])
    fine = places[:, None] * (PARTS * np.array(TIMES)[:, None])  # each border of a part is one of a fine part
    kept = np.flatnonzero(np.abs(fine - np.round(fine)).min(axis=(1, 2)) > 1e-3)[:COUNT]
    rows = np.column_stack([number, at])[kept]
    return rows, [(int(n), *place) for n, place in zip(number[kept], places[kept], strict=True)]


def code(maps: Maps, result: str) -> str:
    numbers = ", ".join(map(str, (WIDTH, HEIGHT, MARGIN, BAND, PARTS, FAR)))
    return f"""
    RelayMaps maps = {{"{maps.prefix}", {numbers}}};
    RelayPart part = relay_part(maps, (int)in[0], in[1], in[2]);
    point place;
    vector direction;
    relay_leg(maps, part, place, direction);
    out = {result};
    """


RESULTS = {"direction": "direction", "place": "vector(place)", "tint": 'vector(relay_value(part, "tint"))'}


@pytest.mark.parametrize("name", RESULTS)
def test_legs_are_those_of_the_part_that_a_place_lies_in(maps, name, tmp_path):
    rows, places = asked()
    found = shader_values.evaluate(tmp_path, ["relay_maps.h"], code(maps, RESULTS[name]), rows)
    legs = [maps.leg(*place) for place in places]
    expected = np.array([leg[name] for leg in legs])
    kinds = np.array([np.linalg.norm(leg["place"]) for leg in legs])
    assert (kinds == 0).mean() > 0.2 and (kinds > FAR / 2).mean() > 0.2
    np.testing.assert_allclose(found, expected, rtol=4e-7, atol=4e-7 * FAR if name == "place" else 4e-7)


@pytest.mark.parametrize("axis", ["major", "minor"])
def test_footprints_are_told_in_the_place_of_places(maps, axis, tmp_path):
    """Of legs to the sky: across the direction the major axis, along it the length of the minor one."""
    rows, places = asked()
    call = code(maps, axis).replace(
        "out =", "vector major, minor;\n    relay_footprint(part, direction, major, minor);\n    out ="
    )
    found = shader_values.evaluate(tmp_path, ["relay_maps.h"], call, rows)
    legs = [maps.leg(*place) for place in places]
    to_sky = np.array([np.linalg.norm(leg["place"]) > FAR / 2 for leg in legs])
    toward = np.array([leg["direction"] / np.linalg.norm(leg["direction"]) for leg in np.array(legs)[to_sky]])
    told = np.array([leg["told"] for leg in np.array(legs)[to_sky]])
    narrow = (told * toward).sum(axis=1, keepdims=True)
    major = told - narrow * toward
    minor = narrow * np.cross(toward, major / np.linalg.norm(major, axis=1, keepdims=True))
    np.testing.assert_allclose(found[to_sky], major if axis == "major" else minor, atol=1e-5)


def test_beyond_the_maps_their_edge_is_read(maps, tmp_path):
    """A pixel filter may reach farther than the margin."""
    columns = np.repeat([-1.0, 0.41, 0.71, 2.0], 4)
    rows = np.column_stack([np.zeros(16), columns, np.tile([-1.0, 0.45, 0.61, 2.0], 4)])
    found = shader_values.evaluate(tmp_path, ["relay_maps.h"], code(maps, "direction"), rows)
    limits = np.array([COLUMNS, ROWS])
    half = 0.5 / PARTS
    for row, direction in zip(rows, found, strict=True):
        place = np.clip(row[1:] * (WIDTH, HEIGHT) + MARGIN - shift(0), half, limits - half)
        np.testing.assert_allclose(direction, maps.leg(0, *place)["direction"], rtol=4e-7, atol=1e-12)


def test_slices_are_shifted_as_they_are_traced(tmp_path):
    numbers = np.arange(64)
    call = "out = vector(relay_shift((int)in[0], 0.7548777, 2), relay_shift((int)in[0], 0.5698403, 2), 0);"
    found = shader_values.evaluate(tmp_path, ["relay_maps.h"], call, numbers[:, None].astype(float))
    expected = np.array([shift(number) for number in numbers])
    np.testing.assert_allclose(found[:, :2], expected, atol=64 * 2.0**-24)
    assert np.abs(expected).max() <= 0.5 / PARTS and len(np.unique(expected[:, 0])) == 64
