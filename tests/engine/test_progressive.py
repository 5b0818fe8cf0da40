"""Pictures that are made over and over while a scene changes: what comes when, and that nothing gets lost."""

import gc
import threading
import time
import weakref
from dataclasses import replace

import bentlight_native
import numpy as np
import pytest
from bentlight_native import Aperture

from blender_addon import progressive
from blender_addon.progressive import Progressive, Wish
from blender_addon.sync.scene_data import StarData
from blender_addon.sync.star_images import draw_stars, find_stars
from tests.engine.test_session import glowing_scene, settings


class Watcher:
    """Keeps every picture that came."""

    def __init__(self, threads=2):
        self.pictures, self.changed = [], threading.Condition()
        self.progressive = Progressive(threads, self._on_picture)

    def _on_picture(self):
        with self.changed:
            if self.progressive.preview:
                self.pictures.append(self.progressive.preview)
            self.changed.notify_all()

    def wait(self, condition, seconds=60):
        with self.changed:
            assert self.changed.wait_for(condition, seconds), "nothing came"


@pytest.fixture
def watcher():
    made = Watcher()
    yield made
    made.progressive.close()


def test_the_picture_becomes_finer_and_ends_as_a_render(watcher):
    """Sizes and samples grow; the last picture is what one call of the renderer gives."""
    scene, wanted = glowing_scene(), settings(width=61, height=47, sample_count=24)
    watcher.progressive.render(Wish(lambda: scene, wanted))
    watcher.wait(lambda: watcher.pictures and watcher.pictures[-1].samples == 24)
    sizes = [picture.pixels.shape[1] for picture in watcher.pictures]
    assert sizes == sorted(sizes)
    assert [p.samples for p in watcher.pictures if p.samples] == [1, 2, 4, 8, 16, 24]
    whole = {"combined": np.zeros((47, 61, 4), np.float32)}
    scene.render_tile(0, 0, 61, 47, wanted, whole)
    np.testing.assert_allclose(watcher.pictures[-1].pixels, whole["combined"], rtol=1e-5, atol=1e-6)


def test_it_begins_coarse_where_pixels_take_long(watcher):
    """At a thousand pixels a second, 64 in the time that the first picture may take."""
    scene = glowing_scene()
    slow = settings(width=64, height=64, sample_count=1, max_bounces=64)
    watcher.progressive._pixels_per_second = 1000.0
    watcher.progressive.render(Wish(lambda: scene, slow))
    watcher.wait(lambda: watcher.pictures and watcher.pictures[-1].samples == 1)
    assert [picture.pixels.shape[:2] for picture in watcher.pictures] == [(8, 8), (16, 16), (32, 32), (64, 64)]


def test_pixels_may_be_larger_than_the_screens(watcher):
    scene = glowing_scene()
    watcher.progressive.render(Wish(lambda: scene, settings(width=50, height=30, sample_count=2), smallest_pixel=4))
    watcher.wait(lambda: watcher.pictures and watcher.pictures[-1].samples == 2)
    assert watcher.pictures[-1].pixels.shape == (8, 13, 4)


def test_edits_are_made_in_order_and_the_last_picture_is_finished(watcher, monkeypatch):
    """However fast wishes come, also while others are under way; and never while a picture is being rendered. Those
    that another has overtaken need not be made, and one that cannot be made stops none after it."""
    busy, render_tile = [], progressive._render_tile

    def counted(*args):
        busy.append(args)
        try:
            return render_tile(*args)
        finally:
            busy.pop()

    monkeypatch.setattr(progressive, "_render_tile", counted)
    scene, edits, place = glowing_scene(), [], np.eye(4)
    place[:3, 3] = 0.6

    def edit(number):
        def make():
            assert not busy
            if number % 7 == 3:
                raise ValueError("this edit cannot be made")
            scene.set_camera("PERSPECTIVE", place, (-0.5, 0.5, -0.5, 0.5))
            scene.commit()
            edits.append(number)
            return scene

        return make

    for number in range(40):
        watcher.progressive.render(Wish(edit(number), settings(sample_count=4 if number < 39 else 5)))
        time.sleep(0.002 * (number % 3))
    watcher.wait(lambda: watcher.pictures and watcher.pictures[-1].samples == 5)
    assert edits == sorted(edits) and edits[-1] == 39
    assert watcher.progressive.failure is None


def test_a_new_wish_is_seen_soon_though_the_old_one_would_take_long(watcher):
    scene = glowing_scene()
    watcher.progressive.render(Wish(lambda: scene, settings(sample_count=1 << 20, max_bounces=64)))
    watcher.wait(lambda: any(picture.samples for picture in watcher.pictures))
    asked = time.monotonic()
    watcher.progressive.render(Wish(lambda: scene, settings(sample_count=3)))
    watcher.wait(lambda: watcher.pictures[-1].wish.settings.sample_count == 3)
    assert time.monotonic() - asked < 1


@pytest.mark.parametrize("end", ["another wish", "close"])
def test_what_is_over_is_freed_at_once(monkeypatch, end):
    """Not when Python looks for circles of references, which may be much later: the scene may be large. The wish knows
    who has made it, as a viewport's does."""
    watcher, scene = Watcher(), glowing_scene()
    freed = weakref.ref(scene)
    gc.disable()
    try:
        watcher.progressive.render(
            Wish(lambda watcher=watcher, scene=scene: scene, settings(sample_count=1 << 20, max_bounces=64))
        )
        watcher.wait(lambda: any(picture.samples for picture in watcher.pictures))
        del scene
        watcher.pictures.clear()
        if end == "close":
            watcher.progressive.close()
        else:
            other = glowing_scene()
            watcher.progressive.render(Wish(lambda: other, settings(sample_count=2)))
            watcher.wait(lambda: watcher.pictures and watcher.pictures[-1].samples == 2)
            watcher.progressive.close()
        assert freed() is None
    finally:
        gc.enable()


def test_a_failure_is_told_and_the_next_wish_is_rendered(watcher):
    def fail():
        raise ValueError("no such scene")

    scene = glowing_scene()
    watcher.progressive.render(Wish(fail, settings()))
    watcher.wait(lambda: watcher.progressive.failure)
    assert "no such scene" in str(watcher.progressive.failure)
    watcher.progressive.render(Wish(lambda: scene, settings(sample_count=2)))
    watcher.wait(lambda: watcher.progressive.preview and watcher.progressive.preview.samples == 2)
    assert watcher.progressive.failure is None


def test_closing_takes_no_time():
    """In the middle of a picture; twice is as once."""
    watcher, scene = Watcher(), glowing_scene()
    watcher.progressive.render(Wish(lambda: scene, settings(sample_count=1 << 20, max_bounces=64)))
    watcher.wait(lambda: watcher.pictures)
    start = time.monotonic()
    watcher.progressive.close()
    watcher.progressive.close()
    assert time.monotonic() - start < 1
    assert not [
        thread for thread in threading.enumerate() if thread.name in (progressive.THREAD_NAME, "bentlight tile_0")
    ]


def test_pictures_do_not_depend_on_threads():
    ends = []
    for threads in (1, 3):
        watcher, scene = Watcher(threads), glowing_scene()
        watcher.progressive.render(Wish(lambda scene=scene: scene, settings(sample_count=4)))
        watcher.wait(lambda watcher=watcher: watcher.pictures and watcher.pictures[-1].samples == 4)
        ends.append(watcher.pictures[-1].pixels)
        watcher.progressive.close()
    assert (ends[0] == ends[1]).all()
    assert bentlight_native.CHANNELS["combined"].components == ends[0].shape[2]


def look_from(distance):
    place = np.eye(4)
    place[2, 3] = distance
    return place


def open_scene():
    """A hole before nothing but stars."""
    scene = bentlight_native.Scene()
    scene.set_spacetime(bentlight_native.Spacetime.schwarzschild(0.1))
    scene.set_camera("PERSPECTIVE", look_from(5.0), (-0.7, 0.7, -0.5, 0.5))
    scene.commit()
    return scene


def sky_of_stars(count):
    directions = np.random.default_rng(3).normal(size=(count, 3))
    return StarData(directions / np.linalg.norm(directions, axis=1)[:, None], np.full((count, 3), (1e-3, 2e-3, 5e-4)))


def starry(scene, wanted, stars):
    """What the renderer and its stars give."""
    whole = {"combined": np.zeros((wanted.height, wanted.width, 4), np.float32)}
    scene.render_tile(0, 0, wanted.width, wanted.height, wanted, whole)
    images = scene.find_stars(stars.directions, (wanted.width, wanted.height), margin=wanted.filter_width / 2)
    whole["combined"][..., :3] += images.draw(
        images.light(stars.irradiance),
        (wanted.width, wanted.height),
        (0, 0, wanted.width, wanted.height),
        wanted.filter,
        wanted.filter_width,
    )
    assert len(images) > 10
    return whole["combined"]


@pytest.mark.parametrize("stars_per_second", [1e9, 1.0], ids=["at once", "later"])
@pytest.mark.parametrize("pixels_per_second", [1e9, 1000.0], ids=["fine", "coarse"])
def test_stars_are_seen(watcher, stars_per_second, pixels_per_second):
    """In all pictures but the first, and in that one if they are found quickly; as bright in coarse ones."""
    scene, wanted, stars = open_scene(), settings(width=60, height=44, sample_count=4), sky_of_stars(2000)
    plain = {"combined": np.zeros((44, 60, 4), np.float32)}
    scene.render_tile(0, 0, 60, 44, wanted, plain)
    watcher.progressive._stars_per_second = stars_per_second
    watcher.progressive._pixels_per_second = pixels_per_second
    watcher.progressive.render(Wish(lambda: scene, wanted, 1, stars))
    watcher.wait(lambda: watcher.pictures and watcher.pictures[-1].samples == 4)
    expected = starry(scene, wanted, stars)
    np.testing.assert_allclose(watcher.pictures[-1].pixels, expected, rtol=1e-5, atol=1e-6)
    added = (expected - plain["combined"])[..., 1].mean()
    brightness = [picture.pixels[..., 1].mean() - plain["combined"][..., 1].mean() for picture in watcher.pictures]
    assert added > 1e-3 and len(brightness) > 2
    assert brightness[0] == pytest.approx(added if stars_per_second > 1 else 0, abs=0.1 * added)
    np.testing.assert_allclose(brightness[1:], added, rtol=0.1)


def test_a_camera_that_sees_no_stars_or_a_transparent_film(watcher):
    scene, stars = open_scene(), sky_of_stars(2000)
    for film_transparent in (True, False):
        wanted = settings(sample_count=4 + film_transparent, film_transparent=film_transparent)
        if not film_transparent:
            scene.set_camera("ORTHOGRAPHIC", look_from(5.0), (-1, 1, -1, 1))
            scene.commit()
        whole = {"combined": np.zeros((wanted.height, wanted.width, 4), np.float32)}
        scene.render_tile(0, 0, wanted.width, wanted.height, wanted, whole)
        watcher.progressive.render(Wish(lambda: scene, wanted, 1, stars))
        watcher.wait(lambda n=wanted.sample_count: watcher.pictures and watcher.pictures[-1].samples == n)
        np.testing.assert_allclose(watcher.pictures[-1].pixels, whole["combined"], rtol=1e-5, atol=1e-6)


def endless(monkeypatch, name, times=None):
    """Makes finding or drawing stars end by being cancelled alone, so many times or always: that it has begun, and how
    it has ended."""
    begun, ended, real = threading.Event(), [], getattr(progressive, name)

    def work(*args):
        if len(ended) == times:
            return real(*args)
        begun.set()
        end = time.monotonic() + 60
        while not args[-1].cancelled and time.monotonic() < end:
            time.sleep(0.002)
        ended.append("cancelled" if args[-1].cancelled else "never")
        raise bentlight_native.Cancelled("as asked")

    monkeypatch.setattr(progressive, name, work)
    return begun, ended


def test_another_wish_does_not_wait_for_stars(watcher, monkeypatch):
    """It ends the finding and the drawing of those of the picture before."""
    for name in ("find_stars", "draw_stars"):
        begun, ended = endless(monkeypatch, name)
        scene = open_scene()
        watcher.progressive._stars_per_second, watcher.progressive._pixels_per_second = 1.0, 1e9
        watcher.progressive.render(Wish(lambda scene=scene: scene, settings(sample_count=4), 1, sky_of_stars(2000)))
        assert begun.wait(60)
        assert [picture.samples for picture in watcher.pictures[-1:]] == [1] and not ended
        watcher.progressive.render(Wish(lambda scene=scene: scene, settings(sample_count=3)))
        watcher.wait(lambda: watcher.pictures[-1].samples == 3)
        assert ended == ["cancelled"]
        monkeypatch.undo()


@pytest.mark.parametrize("name", ["find_stars", "draw_stars"])
def test_stars_that_take_longer_than_expected_come_with_the_next_picture(watcher, monkeypatch, name):
    """The first picture ends the wait itself; that such stars are slow is known then."""
    scene, wanted, stars = open_scene(), settings(width=60, height=44, sample_count=4), sky_of_stars(2000)
    plain = {"combined": np.zeros((44, 60, 4), np.float32)}
    scene.render_tile(0, 0, 60, 44, replace(wanted, sample_count=1), plain)
    begun, ended = endless(monkeypatch, name, times=1)
    watcher.progressive._stars_per_second = watcher.progressive._pixels_per_second = 1e9
    rates, show = [], watcher.progressive._show

    def recorded(*args, **named):
        done = show(*args, **named)
        rates.append(watcher.progressive._stars_per_second)
        return done

    monkeypatch.setattr(watcher.progressive, "_show", recorded)
    watcher.progressive.render(Wish(lambda: scene, wanted, 1, stars))
    watcher.wait(lambda: watcher.pictures and watcher.pictures[-1].samples == 4)
    assert begun.is_set() and ended == ["cancelled"]
    np.testing.assert_allclose(watcher.pictures[0].pixels, plain["combined"], rtol=1e-5, atol=1e-6)
    np.testing.assert_allclose(watcher.pictures[-1].pixels, starry(scene, wanted, stars), rtol=1e-5, atol=1e-6)
    assert rates[0] * progressive._STAR_SECONDS < 2000


@pytest.mark.parametrize("stars_per_second", [1e9, 1.0], ids=["at once", "later"])
def test_the_only_picture_gets_its_stars(watcher, stars_per_second):
    """One sample at full size from the first: no picture comes after it, unless it had to be shown without them."""
    scene, wanted, stars = open_scene(), settings(width=60, height=44, sample_count=1), sky_of_stars(2000)
    watcher.progressive._stars_per_second, watcher.progressive._pixels_per_second = stars_per_second, 1e9
    watcher.progressive.render(Wish(lambda: scene, wanted, 1, stars))
    expected = starry(scene, wanted, stars)
    watcher.wait(lambda: watcher.pictures and np.allclose(watcher.pictures[-1].pixels, expected, 1e-5, 1e-6))
    assert [picture.samples for picture in watcher.pictures][-1] == 1


@pytest.mark.parametrize("aperture", [None, Aperture(0.05, 3.0)])
def test_stars_are_drawn_in_bands_as_at_once(aperture):
    """In a window of more than one band, on any number of threads; not if that is cancelled."""
    scene, stars, wanted = open_scene(), sky_of_stars(2000), settings(width=60, height=200)
    scene.set_camera("PERSPECTIVE", look_from(5.0), (-0.7, 0.7, -0.5, 0.5), aperture=aperture)
    scene.commit()
    images = find_stars(scene, stars, wanted, 2)
    assert bool(images.seen.size) == bool(aperture)
    window = 7, 11, 50, 170
    light = images.light(stars.irradiance)
    whole = images.draw(light, (60, 200), window, wanted.filter, wanted.filter_width)
    assert (whole > 0).any(axis=(1, 2)).mean() > 0.5
    for threads in (1, 3):
        assert (draw_stars(images, stars, wanted, window, threads) == whole).all()
    progress = bentlight_native.Progress()
    progress.cancel()
    with pytest.raises(bentlight_native.Cancelled):
        draw_stars(images, stars, wanted, window, 2, progress)
