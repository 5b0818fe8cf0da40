"""Sessions without Blender: tiles, threads, cancel, failure."""

import threading
import time

import bentlight_native
import numpy as np
import pytest

from blender_addon.session import Begun, Session, StarLight, Tile, sample_rounds, spiral_tiles
from blender_addon.sync.slices import Slice


@pytest.mark.parametrize("region", [(0, 0, 64, 48), (5, 7, 33, 17), (0, 0, 1, 1), (3, 0, 100, 1)])
@pytest.mark.parametrize("size", [1, 7, 16, 64])
def test_tiles_cover_the_region_once(region, size):
    x, y, width, height = region
    count = np.zeros((y + height + 5, x + width + 5), int)
    for tile in spiral_tiles(*region, size):
        assert 0 < tile.width <= size and 0 < tile.height <= size
        count[tile.y : tile.y + tile.height, tile.x : tile.x + tile.width] += 1
    assert (count[y : y + height, x : x + width] == 1).all()
    assert count.sum() == width * height


def test_tiles_start_at_the_center():
    first = spiral_tiles(0, 0, 90, 90, 10)[0]
    assert (first.x, first.y) == (40, 40)


def glowing_scene() -> bentlight_native.Scene:
    """Inside a closed, white box there is always another bounce: paths are as long as they may be."""
    scene = bentlight_native.Scene()
    corners = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], np.float32)
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = np.array([t for a, b, c, d in faces for t in ((a, b, c), (a, c, d))], np.uint32)
    scene.add_instance(scene.add_mesh(corners, triangles), np.eye(4))
    scene.set_spacetime(bentlight_native.Spacetime.schwarzschild(0.1))
    matrix = np.eye(4)
    matrix[:3, 3] = 0.6
    scene.set_camera("PERSPECTIVE", matrix, (-0.5, 0.5, -0.5, 0.5))
    scene.commit()
    return scene


def settings(**changes) -> bentlight_native.RenderSettings:
    return bentlight_native.RenderSettings(**{"width": 64, "height": 64, "sample_count": 1} | changes)


def test_all_tiles_are_delivered_and_progress_ends_at_one():
    tiles = spiral_tiles(0, 0, 64, 64, 16)
    session = Session(glowing_scene(), settings(), tiles, ["combined", "depth"], threads=3)
    results = [result for result in session.finished(0.05) if result]
    assert {result.tile for result in results} == set(tiles)
    assert all(set(result.channels) == {"combined", "depth", "sample_count"} for result in results)
    assert all((result.channels["sample_count"] == 1).all() for result in results)
    assert session.fraction == 1
    assert session.seconds_left == 0


@pytest.mark.parametrize("after", [0.0, 0.3])
def test_a_cancel_stops_within_0_3_seconds_and_keeps_what_is_done(after):
    """One huge tile a thread, so that a cancel falls into the middle of a call."""
    tiles = [Tile(0, 0, 64, 32), Tile(0, 32, 64, 32)]
    wanted = settings(sample_count=1 << 20, max_bounces=64)
    session = Session(glowing_scene(), wanted, tiles, ["combined"], threads=2)
    time.sleep(after)
    start = time.monotonic()
    session.cancel()
    results = [result for result in session.finished(0.05) if result]
    assert time.monotonic() - start < 0.3
    assert 0 <= session.fraction < 1
    for result in results:
        assert result.channels["sample_count"].any()
        assert np.isfinite(result.channels["combined"]).all()
    if after:
        assert results
    assert not [thread for thread in threading.enumerate() if thread.name.startswith("bentlight")]


@pytest.mark.parametrize("count", [1, 2, 3, 16, 40, 100])
def test_rounds_take_every_sample_once(count):
    rounds = list(sample_rounds(count))
    assert [k for first, size in rounds for k in range(first, first + size)] == list(range(count))
    assert max(size for _, size in rounds) <= 16 and rounds[0] == (0, 1)


def test_rounds_add_up_to_the_whole():
    """All rounds of all tiles, on threads that end them in any order, against one call."""
    names = ["combined", "depth", "normal", "error", "winding", "fate"]
    tiles, wanted = spiral_tiles(0, 0, 64, 64, 16), settings(sample_count=24)
    session = Session(glowing_scene(), wanted, tiles, names, threads=3, time_limit=1000.0)
    last = {result.tile: result for result in session.finished(0.05) if result}
    (whole,) = [r for r in Session(glowing_scene(), wanted, [Tile(0, 0, 64, 64)], names, threads=1).finished(1) if r]
    for tile, result in last.items():
        place = np.s_[tile.y : tile.y + tile.height, tile.x : tile.x + tile.width]
        for name in (*names, "sample_count"):
            np.testing.assert_allclose(
                result.channels[name], whole.channels[name][place], rtol=1e-5, atol=1e-6, err_msg=name
            )


def test_a_time_limit_ends_the_render_with_a_whole_picture():
    """The limit is over before the first tile is done: one sample everywhere; a longer one: more, and in time."""
    tiles, wanted = spiral_tiles(0, 0, 64, 64, 16), settings(sample_count=1 << 20, max_bounces=64)
    for limit, least in [(1e-9, 1), (0.5, 2)]:
        start = time.monotonic()
        session = Session(glowing_scene(), wanted, tiles, ["combined"], threads=2, time_limit=limit)
        last = {result.tile: result for result in session.finished(0.05) if result}
        assert set(last) == set(tiles) and session.fraction == 1
        counts = [result.channels["sample_count"] for result in last.values()]
        assert min(c.min() for c in counts) >= least and (limit > 0.1 or max(c.max() for c in counts) == 1)
        assert time.monotonic() - start < limit + 2


def lit_scene() -> bentlight_native.Scene:
    """A floor under a small lamp, and black sky: clean pixels and noisy ones."""
    scene, builder = bentlight_native.Scene(), bentlight_native.ProgramBuilder()
    builder.emit("emission", builder.constant(1), builder.constant((5, 4, 3)), builder.constant(1))
    corners = np.array([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], np.float32)
    square = scene.add_mesh(corners, np.array([[0, 1, 2], [0, 2, 3]], np.uint32))
    lamp = np.diag([0.5, -0.5, -0.5, 1.0])
    lamp[2, 3] = 1.5
    scene.add_instance(square, np.diag([2.0, 2.0, 1.0, 1.0]))
    scene.add_instance(square, lamp, materials=np.array([scene.add_material(builder.build())], np.int32))
    camera = np.eye(4)
    camera[2, 3] = 6.0
    scene.set_camera("PERSPECTIVE", camera, (-0.5, 0.5, -0.5, 0.5))
    scene.commit()
    return scene


@pytest.mark.parametrize("threshold", [0.01, 0.003])
def test_noise_threshold_and_time_limit_work_together(threshold):
    """With time enough each pixel ends in the rounds where it ends in one call; then the rounds end, too. The counts
    may differ where float32 rounding of what is kept between rounds decides: in none of these pixels it does."""
    tiles = spiral_tiles(0, 0, 32, 32, 8)
    wanted = settings(width=32, height=32, sample_count=500, noise_threshold=threshold, min_samples=20)
    scene, names = lit_scene(), ["combined", "normal"]
    session = Session(scene, wanted, tiles, names, threads=3, time_limit=1000.0)
    last = {result.tile: result for result in session.finished(0.05) if result}
    (whole,) = [r for r in Session(scene, wanted, [Tile(0, 0, 32, 32)], names, threads=1).finished(1) if r]
    counts = whole.channels["sample_count"]
    assert len(np.unique(counts)) > 5 and counts.min() == 20
    assert session.fraction == 1
    for tile, result in last.items():
        place = np.s_[tile.y : tile.y + tile.height, tile.x : tile.x + tile.width]
        assert (result.channels["sample_count"] == counts[place]).all()
        for name in names:
            np.testing.assert_allclose(result.channels[name], whole.channels[name][place], rtol=1e-5, atol=1e-6)


def test_waiting_is_interrupted_to_look_at_the_user():
    tiles = [Tile(0, 0, 64, 64)]
    session = Session(glowing_scene(), settings(sample_count=1 << 20), tiles, ["combined"], threads=1)
    waits = []
    for result in session.finished(0.02):
        waits.append(result)
        if len(waits) == 3:
            session.cancel()
    assert waits[:3] == [None, None, None]


def test_a_failure_in_a_worker_is_raised_and_leaves_no_thread():
    session = Session(glowing_scene(), settings(), [Tile(60, 0, 16, 16)], ["combined"], threads=2)
    with pytest.raises(ValueError, match="tile"):
        list(session.finished(0.05))
    assert not [thread for thread in threading.enumerate() if thread.name.startswith("bentlight")]


def test_an_abandoned_session_leaves_no_thread():
    tiles = spiral_tiles(0, 0, 64, 64, 8)
    session = Session(glowing_scene(), settings(sample_count=1 << 12), tiles, ["combined"], threads=2)
    finished = session.finished(0.05)
    next(finished)
    finished.close()
    assert not [thread for thread in threading.enumerate() if thread.name.startswith("bentlight")]


def test_light_from_lamps_does_not_depend_on_threads_or_tiles():
    """The last of each tile's deliveries has all light that any tile has sent it."""
    scene = glowing_scene()
    builder = bentlight_native.ProgramBuilder()
    builder.emit("emission", builder.constant(1), builder.constant(1), builder.constant(5))
    lamp = np.array([(-0.2, -0.2, 0.9), (0.2, -0.2, 0.9), (0, 0.2, 0.9)], np.float32)
    material = np.array([scene.add_material(builder.build())], np.int32)
    scene.add_instance(scene.add_mesh(lamp, np.array([[0, 2, 1]], np.uint32)), np.eye(4), materials=material)
    scene.commit()
    pictures = []
    for threads, size in ((1, 32), (3, 16)):
        tiles = spiral_tiles(0, 0, 32, 32, size)
        wanted = settings(width=32, height=32, sample_count=2, integrator="BIDIRECTIONAL")
        picture = np.zeros((32, 32, 4), np.float32)
        for result in Session(scene, wanted, tiles, ["combined"], threads).finished(0.05):
            if result:
                tile = result.tile
                picture[tile.y : tile.y + tile.height, tile.x : tile.x + tile.width] = result.channels["combined"]
        pictures.append(picture)
    np.testing.assert_array_equal(*pictures)
    assert pictures[0][..., :3].max() > 0


def moving_stars(count):
    """Stars of `count` moments: one pixel's worth of light that goes from left to right."""
    shown = np.zeros((count, 30, 40, 3), np.float32)
    for moment in range(count):
        shown[moment, 7, 3 + moment] = (0.1 * (moment + 1), 1e-7, 1e4)
    return [StarLight(one) for one in shown]


def test_each_moment_brings_its_part_of_the_stars():
    """In proportion to its samples, and to the last bit in any order."""
    counts, scene, stars = [3, 1, 2], glowing_scene(), moving_stars(3)
    parts = [Slice(sum(counts[:i]), count, 0.5) for i, count in enumerate(counts)]
    wanted, tiles = settings(width=40, height=30, sample_count=6), spiral_tiles(0, 0, 40, 30, 16)

    blur = {"slices": parts, "move": lambda moment: (scene, stars[moment])}
    session = Session(scene, wanted, tiles, ["combined"], 2, stars=stars[0], **blur)
    last = {tile.tile: tile for tile in session.finished(0.1) if tile}
    expected = sum(star.shown.astype(float) * count for star, count in zip(stars, counts, strict=True)) / 6
    mean = bentlight_native.star_mean(session.star_sums, 6)
    np.testing.assert_allclose(mean, expected, rtol=1e-6)
    backwards = sum(bentlight_native.star_sum(stars[i].shown, counts[i]) for i in (2, 0, 1))
    assert (backwards == session.star_sums).all()
    plain = {tile.tile: tile for tile in Session(scene, wanted, tiles, ["combined"], 2).finished(0.1) if tile}
    for tile, finished in last.items():
        part = mean[tile.y : tile.y + tile.height, tile.x : tile.x + tile.width]
        np.testing.assert_array_equal(
            finished.channels["combined"][..., :3], plain[tile].channels["combined"][..., :3] + part
        )


def test_stars_of_all_moments_are_there_when_a_session_finds_all_tiles_done():
    counts, scene, stars = [2, 2, 2], glowing_scene(), moving_stars(3)
    parts = [Slice(sum(counts[:i]), count, 0.5) for i, count in enumerate(counts)]
    wanted, tiles = settings(width=40, height=30, sample_count=6), spiral_tiles(0, 0, 40, 30, 16)
    sums, states = [], {}
    for begun in (None, states):
        blur = {"slices": parts, "move": lambda moment: (scene, stars[moment])}
        session = Session(scene, wanted, tiles, ["combined"], 2, stars=stars[0], keeps_state=True, begun=begun, **blur)
        for tile in session.finished(0.1):
            if tile and tile.state is not None:
                states[tiles.index(tile.tile)] = Begun(tile.state, 0)
        sums.append(session.star_sums)
    assert len(states) == len(tiles) and (sums[0] == sums[1]).all()
