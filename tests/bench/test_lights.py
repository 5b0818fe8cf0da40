"""How much less noise there is where light is followed from the lamps too, and how that is told."""

import bench_lights
import caustic_glass
import numpy as np
import pytest
import wormhole_lamp


def ways(*pairs):
    """Efficiencies of pictures of 10 x 10 pixels from (seconds, variance of each half and pixel): two seeds a half."""
    made = []
    for seconds, variance in pairs:
        deviation = np.sqrt(np.reshape(variance, (2, 1, 10, 10, 1)) / 2) * np.reshape([1, -1], (2, 1, 1, 1))
        made.append(bench_lights.Efficiency("", "", 1, seconds, np.repeat(deviation.reshape(4, 10, 10, 1), 3, axis=-1)))
    return made


def test_the_worst_pixels_are_left_out():
    """A pixel that is always bad goes, in both ways; one that was bad once stays: it is the way's own noise."""
    always, once = np.ones((2, 100)), np.ones((2, 100))
    always[:, 7] = 1000
    once[0, 3] = once[1, 4] = 1e4
    first, other = ways((2.0, always), (1.0, np.ones((2, 100))))
    assert bench_lights.gain(first, other) == pytest.approx(2 * 1099 / 100)
    assert bench_lights.gain_without_worst(first, other) == pytest.approx(2)
    first, other = ways((1.0, once), (1.0, np.ones((2, 100))))
    assert bench_lights.gain_without_worst(first, other) == pytest.approx(1 + 9999 / 99)


def test_the_interval_holds_the_gain():
    """Of normal noise of known variance it holds the true gain in about 95 of 100 trials, and it is not wide. Where one
    pixel has most of the noise, and only in one way, it says that nobody knows.
    """
    random = np.random.default_rng(3)
    held, widths = 0, []
    for _ in range(60):
        first, other = (
            bench_lights.Efficiency("", "", 1, seconds, random.normal(0, deviation, (8, 8, 8, 3)))
            for seconds, deviation in ((2.0, 3.0), (1.0, 2.0))
        )
        low, high = bench_lights.gain_interval(first, other)
        held += low < 2 * 9 / 4 < high
        widths.append(high / low)
    assert held >= 60 * 0.95 - 3 * (60 * 0.95 * 0.05) ** 0.5
    assert np.median(widths) < 1.5
    first.pictures[0, 0, 0] = 1000
    low, high = bench_lights.gain_interval(first, other)
    assert low < 9 and high > 1000


def test_close_ups_are_believed():
    """Where a part has pictures of its own, its pixels of the whole picture do not count: the error is the true one,
    and the interval is as narrow as they make it, whatever luck the whole pictures have had there.
    """
    random = np.random.default_rng(5)
    part = bench_lights.Part(2, 4, 1, 4)
    deviation = np.ones((8, 8, 1))
    deviation[1:4, 2:4] = 30

    def way(seconds):
        pictures = random.normal(0, np.ones_like(deviation), (8, 8, 8, 3))
        pictures[0, 1:4, 2:4] = 1e4
        close_ups = {part: random.normal(0, 30, (256, 3, 2, 3))}
        return bench_lights.Efficiency("", "", 1, seconds, pictures, close_ups)

    first, other = way(2.0), way(1.0)
    assert first.error2 == pytest.approx((deviation**2).mean(), rel=0.1)
    low, high = bench_lights.gain_interval(first, other)
    assert 1.7 < low < 2 < high < 2.3


def test_a_part_is_rendered_where_it_is(monkeypatch, tmp_path):
    """The same pixels, whether the rest of the picture is rendered too or not."""
    monkeypatch.setattr(bench_lights, "CLOSE_SEEDS", 2)
    monkeypatch.setattr(bench_lights, "RESOLUTION", (48, 27))
    part = bench_lights.Part(31, 34, 18, 21)
    scene = bench_lights.flat(bench_lights.small_lamp)
    (made,) = bench_lights.measure(scene, "", {"BOTH": 2}, 2, (part,))
    scene.render.use_border = False
    whole, _ = bench_lights.take_turns(scene, {"BOTH": 2}, range(2, 3), tmp_path / "whole.exr")
    close = made.close_ups[part][0]
    np.testing.assert_array_equal(close, whole["BOTH"][0][part.top : part.bottom, part.left : part.right])


def test_light_through_a_wormhole(monkeypatch):
    """A library that one bulb lights from the other side: more than 20 times lower in the same time than by chance. At
    this size the measured gain is about 300, and the interval that holds it from 28 to 4000."""
    monkeypatch.setattr(bench_lights, "RESOLUTION", (32, 18))
    chance, both = bench_lights.measure(wormhole_lamp.build(), "", {"SCATTERING": 64, "BOTH": 8}, seeds=4)
    assert bench_lights.gain(chance, both) > 20


def test_caustics_from_both_ends(monkeypatch):
    """In the example the mean squared error is 4 times lower in the same time, without the worst pixels too."""
    monkeypatch.setattr(bench_lights, "RESOLUTION", (64, 36))
    scene = caustic_glass.build()
    path, both = bench_lights.measure(scene, "caustic_glass", {"BOTH": 24, "BIDIRECTIONAL": 12})
    assert bench_lights.gain(path, both) > 4
    assert bench_lights.gain_without_worst(path, both) > 4
