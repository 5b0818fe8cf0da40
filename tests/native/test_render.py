"""render_tile as a function: settings, channels, determinism, sample ranges, cancelling, broken input."""

import threading
import time
from concurrent.futures import ThreadPoolExecutor

import meshes
import numpy as np
import pytest
from bentlight_native import CHANNELS, Cancelled, Progress, RenderSettings, Scene
from scenes import add, diffuse, emission, glass, glossy, look_at, new_scene, perspective, quad, render, transparent


@pytest.fixture(scope="module")
def room():
    """One of each: diffuse, rough and smooth lobes, flesh, see-through and one-sided surfaces, sky and a sun."""
    scene = new_scene((0.3, 0.4, 0.5))
    scene.set_suns([(0, 1, 3)], [(20, 18, 15)], 0.3)
    add(scene, meshes.box((-3, -3, -1.2), (3, 3, -1)), diffuse((0.7, 0.6, 0.5)))
    add(scene, meshes.sphere(0.5, (-0.8, 0, -0.5)), glossy((0.9, 0.8, 0.7), 0.3))
    add(scene, meshes.sphere(0.5, (0.6, 0.3, -0.5)), glass((1, 1, 1), 0.0, 1.45))
    add(scene, meshes.sphere(0.3, (0, -1, -0.7)), diffuse((0.2, 0.5, 0.8)), transparent((0.4, 0.4, 0.4)))
    flesh = ("subsurface", (0.8, 0.4, 0.3), (1, 0.5, 0.2), 1.0, 1.4, 0.5, 0.2, (0, 0, 0), ["RANDOM_WALK"])
    add(scene, meshes.sphere(0.3, (-0.1, 0.6, -0.6)), flesh, glossy((0.1, 0.1, 0.1), 0.4))
    light = np.eye(4) @ np.diag([1, -1, -1, 1.0])
    light[:3, 3] = 0, 0, 2
    add(scene, quad(), emission((1, 1, 1), 5.0), at=light, one_sided=True)
    perspective(scene, look_at((0.5, -5, 1), (0, 0, -0.4)), half=0.35)
    scene.commit()
    return scene


def assert_same_bits(a, b):
    for name in a:
        assert np.array_equal(a[name].view(np.uint32), b[name].view(np.uint32)), name


def test_channels_are_named_by_the_core(room):
    channels, statistics = render(room, 24, 20, 4)
    assert set(channels) == set(CHANNELS)
    assert statistics.samples == 24 * 20 * 4 and statistics.rays > statistics.samples
    assert statistics.unresolved == statistics.invalid == 0
    assert all(np.isfinite(values).all() for values in channels.values())
    assert (channels["sample_count"] == 4).all()


@pytest.mark.parametrize("width, height", [(7, 5), (1, 1), (29, 3), (16, 20)])
def test_tiles_do_not_change_a_bit(room, width, height):
    whole, _ = render(room, 29, 20, 5)
    for y in range(0, 20, height):
        for x in range(0, 29, width):
            tile = (x, y, min(width, 29 - x), min(height, 20 - y))
            part, _ = render(room, 29, 20, 5, tile=tile)
            window = np.s_[y : y + tile[3], x : x + tile[2]]
            assert_same_bits(part, {name: np.ascontiguousarray(values[window]) for name, values in whole.items()})


def test_more_pixels_than_a_strip_holds(room):
    """Tiles are rendered in strips of 4096 pixels; the seam must not show."""
    whole, _ = render(room, 90, 60, 1)
    part, _ = render(room, 90, 60, 1, tile=(40, 44, 20, 5))
    assert_same_bits(part, {name: np.ascontiguousarray(v[44:49, 40:60]) for name, v in whole.items()})


def test_threads_do_not_change_a_bit(room):
    whole, _ = render(room, 32, 32, 3)
    tiles = [(x, y, 8, 8) for y in range(0, 32, 8) for x in range(0, 32, 8)]
    with ThreadPoolExecutor(4) as pool:
        parts = list(pool.map(lambda tile: render(room, 32, 32, 3, tile=tile)[0], tiles))
    for (x, y, _, _), part in zip(tiles, parts, strict=True):
        window = np.s_[y : y + 8, x : x + 8]
        assert_same_bits(part, {name: np.ascontiguousarray(values[window]) for name, values in whole.items()})


def test_channels_do_not_depend_on_which_others_are_wanted(room):
    every, _ = render(room, 12, 12, 3)
    for name in CHANNELS:
        alone, _ = render(room, 12, 12, 3, names=(name,))
        assert_same_bits(alone, {name: every[name]})


def test_sample_ranges_merge(room):
    """By the rule of each channel's reduction; means to float32 rounding."""
    whole, _ = render(room, 16, 16, 11, names=tuple(CHANNELS))
    first, _ = render(room, 16, 16, 4)
    second, _ = render(room, 16, 16, 7, first_sample=4)
    for name, channel in CHANNELS.items():
        a, b = first[name].astype(float), second[name].astype(float)
        if channel.reduction == "state":
            continue
        merged = {"mean": (4 * a + 7 * b) / 11, "max": np.maximum(a, b), "first": a, "center": a, "count": a + b}
        merged["matte"] = merged["mean"]  # there is one name alone
        scale = np.maximum(np.abs(a), np.abs(b))
        assert (np.abs(merged[channel.reduction] - whole[name]) <= 2 * np.finfo(np.float32).eps * scale).all(), name


def test_seeds_and_samples_differ(room):
    a, b, c = (render(room, 16, 16, 4, **s)[0]["combined"] for s in ({}, {"seed": 1}, {"first_sample": 4}))
    assert not np.array_equal(a, b) and not np.array_equal(a, c)


def test_cancelled_before_the_start(room):
    progress = Progress()
    progress.cancel()
    channels = {name: np.full((8, 8, c.components), np.nan, np.float32) for name, c in CHANNELS.items()}
    with pytest.raises(Cancelled):
        room.render_tile(0, 0, 8, 8, RenderSettings(8, 8), channels, progress)
    assert all((values == 0).all() for values in channels.values())


def test_cancelled_on_the_way(room):
    """It stops within 0.3 s (the promise of ESC), and what it leaves are true pictures of fewer samples."""
    progress, size = Progress(), 80
    channels = {name: np.full((size, size, c.components), np.nan, np.float32) for name, c in CHANNELS.items()}
    settings = RenderSettings(size, size, sample_count=1_000_000)
    outcome = []

    def work():
        try:
            room.render_tile(0, 0, size, size, settings, channels, progress)
        except Cancelled:
            outcome.append(time.perf_counter())

    thread = threading.Thread(target=work)
    thread.start()
    while progress.done < 3 * 4096:
        time.sleep(0.001)
    asked = time.perf_counter()
    progress.cancel()
    thread.join()
    assert outcome and outcome[0] - asked < 0.3
    counts = channels["sample_count"][..., 0]
    assert counts.sum() == progress.done
    assert counts.max() - counts[: 4096 // size].min() <= 1  # the strip in work is even to one sample
    for count in np.unique(counts[counts > 0]):
        fewer, _ = render(room, size, size, int(count))
        for name in CHANNELS:
            assert np.array_equal(channels[name][counts == count], fewer[name][counts == count]), name
    assert all((values[counts == 0] == 0).all() for values in channels.values())


def test_progress_counts_samples(room):
    progress = Progress()
    render(room, 10, 10, 3, progress=progress)
    render(room, 10, 10, 2, tile=(0, 0, 5, 5), progress=progress)
    assert progress.done == 10 * 10 * 3 + 5 * 5 * 2


@pytest.mark.parametrize(
    "change, word",
    [
        ({"width": 0}, "image"),
        ({"height": 1 << 17}, "image"),
        ({"width": -1}, "width"),
        ({"sample_count": 0}, "sample_count"),
        ({"sample_count": 1 << 31}, "sample_count"),
        ({"first_sample": (1 << 31) - 1}, "sample_count"),
        ({"seed": 1 << 32}, "seed"),
        ({"max_bounces": -1}, "max_bounces"),
        ({"tolerance": 0.0}, "tolerance"),
        ({"tolerance": float("nan")}, "tolerance"),
        ({"tolerance": 0.2}, "tolerance"),
        ({"filter": "MITCHELL"}, "filter"),
        ({"filter_width": 0.0}, "filter_width"),
        ({"filter_width": float("inf")}, "filter_width"),
        ({"clamp_indirect": -1.0}, "clamp_indirect"),
        ({"clamp_direct": -1.0}, "clamp_direct"),
        ({"light_threshold": -0.1}, "light_threshold"),
        ({"blur_glossy": -0.1}, "blur_glossy"),
        ({"blur_glossy": float("nan")}, "blur_glossy"),
        ({"clamp_indirect": float("nan")}, "clamp_indirect"),
        ({"alpha_threshold": 1.5}, "alpha_threshold"),
    ],
)
def test_bad_settings_are_named(room, change, word):
    settings = RenderSettings(**{"width": 8, "height": 8, **change})
    with pytest.raises(ValueError, match=word):
        room.render_tile(0, 0, 1, 1, settings, {"combined": np.zeros((1, 1, 4), np.float32)})


@pytest.mark.parametrize("tile", [(8, 0, 1, 1), (0, 7, 1, 2), (-1, 0, 1, 1), (0, 0, 1 << 33, 1)])
def test_tiles_outside_the_image_are_refused(room, tile):
    shape = (max(min(tile[3], 8), 1), max(min(tile[2], 8), 1), 4)
    with pytest.raises(ValueError, match=r"tile|combined"):
        room.render_tile(*tile, RenderSettings(8, 8), {"combined": np.zeros(shape, np.float32)})


@pytest.mark.parametrize(
    "channels, kind, word",
    [
        ({"beauty": np.zeros((2, 2, 4), np.float32)}, ValueError, "beauty"),
        ({"combined": np.zeros((2, 2, 3), np.float32)}, ValueError, "combined: expected float32"),
        ({"combined": np.zeros((2, 2, 4))}, ValueError, "float64"),
        ({"depth": np.zeros((2, 4, 1), np.float32)[:, ::2]}, ValueError, "depth"),
        ({"depth": 3.0}, TypeError, "depth"),
        ({3: np.zeros((2, 2, 4), np.float32)}, TypeError, "channels"),
    ],
)
def test_bad_channels_are_named(room, channels, kind, word):
    with pytest.raises(kind, match=word):
        room.render_tile(0, 0, 2, 2, RenderSettings(8, 8), channels)


def test_an_empty_tile_is_nothing(room):
    assert room.render_tile(3, 3, 0, 2, RenderSettings(8, 8), {}).samples == 0


def test_a_scene_without_camera_or_commit_is_refused():
    scene = Scene()
    scene.commit()
    with pytest.raises(RuntimeError, match="camera"):
        render(scene)
    perspective(scene)
    with pytest.raises(RuntimeError, match="commit"):
        render(scene)
    scene.commit()
    assert (render(scene)[0]["combined"] == (0, 0, 0, 1)).all()


@pytest.mark.parametrize(
    "suns",
    [
        ([(0, 0, 0)], [(1, 1, 1)], 0.1),
        ([(0, 0, 1)], [(1, -1, 1)], 0.1),
        ([(0, 0, 1)], [(1, 1, np.nan)], 0.1),
        ([(0, 0, np.inf)], [(1, 1, 1)], 0.1),
        ([(0, 0, 1)], [(1, 1, 1)], -0.1),
        ([(0, 0, 1)], [(1, 1, 1)], np.nan),
        ([(0, 0, 1)], [(1, 1, 1)], 4.0),
    ],
)
def test_bad_suns_are_named(suns):
    with pytest.raises(ValueError, match="sun"):
        Scene().set_suns(*suns)


def test_bad_lamps_are_named():
    for matrix in (np.zeros((4, 4)), np.full((4, 4), np.nan), np.eye(4) + np.eye(4)[::-1]):
        with pytest.raises(ValueError, match="world_from_lamp"):
            Scene().set_lamps([matrix], 0)


def test_broken_geometry_makes_no_nan():
    """Triangles without area, garbage normals, degenerate UVs, and light that overflows."""
    rng = np.random.default_rng(1)
    scene = new_scene((1, 1, 1))
    vertices, triangles = meshes.soup(rng, 200, 0.5)
    vertices[::7] = vertices[1::7][: len(vertices[::7])]
    triangles[::5, 1] = triangles[::5, 0]
    normals = rng.normal(size=(len(triangles), 3, 3)).astype(np.float32)
    normals[::3] = 0
    normals[1::9] = 1e30
    uvs = rng.normal(size=(len(triangles), 3, 2)).astype(np.float32)
    uvs[::4] = 0.5
    mesh = scene.add_mesh(vertices, triangles, corner_normals=normals, corner_uvs=uvs)
    scene.add_instance(mesh, np.eye(4))
    scene.add_instance(mesh, np.diag([1e-3, -2.0, 1e3, 1.0]))
    add(scene, meshes.sphere(0.2), emission((1e30, 1e30, 1e30), 1e15), diffuse((1, 1, 1)))
    perspective(scene, look_at((0, -4, 0), (0, 0, 0)))
    scene.commit()
    channels, statistics = render(scene, 48, 48, 8)
    assert all(np.isfinite(values).all() for values in channels.values())
    assert statistics.invalid > 0  # 1e45 does not fit a float: counted, and black
