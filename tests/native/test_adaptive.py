"""Adaptive sampling: each pixel stops just where the noise of its own samples says, whatever the tiles."""

import meshes
import numpy as np
import pytest
from bentlight_native import CHANNELS, RenderSettings
from scenes import add, diffuse, emission, look_at, new_scene, perspective, quad, render
from test_direct_light import placed

SIZE, CHECK = 12, 16


def scene_with_noise():
    """A ball in the light of a small lamp over a floor, and nothing behind: clean and noisy pixels."""
    scene = new_scene()
    add(scene, quad(2, 2), diffuse((0.8, 0.6, 0.3)))
    add(scene, meshes.sphere(0.5, segments=16, rings=8), diffuse((0.2, 0.5, 0.8)), at=placed(0, 0, 0.5))
    lamp = np.diag([0.5, -0.5, -0.5, 1.0])
    lamp[:3, 3] = 1.0, -1.0, 2.0
    add(scene, quad(), emission((4, 3, 2)), at=lamp, visibility=14)
    perspective(scene, look_at((0, -5, 2.5), (0, 0, 0.5)), half=0.5)
    scene.commit()
    return scene


def noise(samples):
    """Of (n, ..., 3) samples: sqrt(2/pi) times the sum over colors of the standard errors, over sqrt of their sum; from
    the means of groups of 8."""
    if len(samples) < 16:
        return np.full(samples.shape[1:-1], np.inf)
    means = samples[: len(samples) // 8 * 8].reshape(-1, 8, *samples.shape[1:]).mean(axis=1)
    error = means.std(axis=0, ddof=1).sum(axis=-1) / np.sqrt(len(means))
    return np.sqrt(2 / np.pi) * error / (1e-4 + np.sqrt(means.mean(axis=0).sum(axis=-1)))


@pytest.mark.parametrize("threshold, least", [(0.01, 16), (0.02, 39), (0.005, 4)])
def test_a_pixel_stops_where_its_samples_say(threshold, least):
    """The whole rule, replayed with numpy on samples rendered one by one."""
    scene, most = scene_with_noise(), 100
    one = [render(scene, SIZE, SIZE, 1, names=("combined",), first_sample=k)[0]["combined"] for k in range(most)]
    samples = np.array(one, float)[..., :3]
    count = np.zeros((SIZE, SIZE), int)
    active, taken = np.ones((SIZE, SIZE), bool), 0
    while taken < most and active.any():
        taken = min(most, taken + (CHECK if taken else least))
        count[active] = taken
        active &= noise(samples[:taken]) >= threshold
    settings = {"noise_threshold": threshold, "min_samples": least}
    channels, statistics = render(scene, SIZE, SIZE, most, **settings)
    assert (channels["sample_count"][..., 0] == count).all() and statistics.samples == count.sum()
    assert len(np.unique(count)) > 2
    expected = np.array([[samples[: count[y, x], y, x].mean(axis=0) for x in range(SIZE)] for y in range(SIZE)])
    assert channels["combined"][..., :3] == pytest.approx(expected, rel=1e-5, abs=1e-7)


def test_tiles_do_not_matter():
    scene = scene_with_noise()
    settings = {"noise_threshold": 0.01, "min_samples": 16}
    whole, _ = render(scene, 40, 30, 128, **settings)
    for x, y, w, h in [(0, 0, 17, 30), (17, 3, 23, 9), (39, 29, 1, 1)]:
        part, _ = render(scene, 40, 30, 128, tile=(x, y, w, h), **settings)
        for name, values in part.items():
            np.testing.assert_array_equal(values, whole[name][y : y + h, x : x + w], err_msg=name)


def test_noise_is_as_wanted():
    """Against 8192 samples a pixel the error is about what the threshold says: the mean of |error|, in its units."""
    scene, threshold = scene_with_noise(), 0.01
    exact = render(scene, SIZE, SIZE, 8192, names=("combined",), seed=9)[0]["combined"][..., :3].astype(float)
    measures = []
    for seed in range(8):
        settings = {"noise_threshold": threshold, "min_samples": 64, "seed": seed}
        channels, _ = render(scene, SIZE, SIZE, 4096, **settings)
        error = np.abs(channels["combined"][..., :3] - exact).sum(axis=-1)
        measures.append(error / (1e-4 + np.sqrt(exact.sum(axis=-1))))
        assert channels["sample_count"].max() < 4096
    stopped = np.mean(measures, axis=0)[np.mean(measures, axis=0) > 0]
    assert 0.1 * threshold < np.median(stopped) < threshold  # low-discrepancy samples do better than random ones
    assert np.mean(measures) < threshold


@pytest.mark.parametrize("rounds", [(1, 1, 2, 4, 8, 16, 16, 16, 16, 20), (39, 61), (7, 93)])
@pytest.mark.parametrize("threshold", [0.0, 0.01])
def test_resumed_rounds_are_as_one_call(rounds, threshold):
    """The same pixels stop at the same samples, wherever the rounds begin; values to float32 rounding a round."""
    scene = scene_with_noise()
    whole, _ = render(scene, SIZE, SIZE, 100, noise_threshold=threshold, min_samples=20)
    channels, first = {name: np.zeros_like(values) for name, values in whole.items()}, 0
    for count in rounds:
        settings = {"noise_threshold": threshold, "min_samples": 20, "first_sample": first, "resume": first > 0}
        scene.render_tile(0, 0, SIZE, SIZE, RenderSettings(SIZE, SIZE, sample_count=count, **settings), channels)
        first += count
    for name, values in whole.items():
        rounding = 1e-4 if name == "noise_scatter" else 1e-6
        np.testing.assert_allclose(channels[name], values, rtol=rounding, atol=rounding, err_msg=name)
    assert not threshold or len(np.unique(whole["sample_count"])) > 2
    settings = {"noise_threshold": 100.0, "min_samples": 20, "first_sample": 100, "resume": True}
    assert (
        scene.render_tile(0, 0, SIZE, SIZE, RenderSettings(SIZE, SIZE, sample_count=16, **settings), channels).samples
        == 0
    )  # every pixel is below that


def test_what_a_resumed_call_needs_is_named():
    scene = scene_with_noise()
    arrays = {name: np.zeros((1, 1, CHANNELS[name].components), np.float32) for name in CHANNELS}
    for threshold, missing in [(0.0, "sample_count"), (0.01, "combined"), (0.01, "noise_scatter")]:
        some = {name: values for name, values in arrays.items() if name != missing}
        settings = RenderSettings(SIZE, SIZE, first_sample=1, noise_threshold=threshold, resume=True)
        with pytest.raises(ValueError, match="to resume takes the channel sample_count"):
            scene.render_tile(0, 0, 1, 1, settings, some)
    with pytest.raises(ValueError, match="first_sample must be at most 2"):
        scene.render_tile(0, 0, 1, 1, RenderSettings(SIZE, SIZE, first_sample=(1 << 24) + 1, resume=True), arrays)
    for count in (np.nan, -3.0, 1e30):
        arrays["sample_count"][:] = count
        scene.render_tile(0, 0, 1, 1, RenderSettings(SIZE, SIZE, first_sample=4, resume=True), arrays)
        assert arrays["sample_count"] == 0  # no pixel that has 4 samples


def test_bad_settings_are_named():
    scene = scene_with_noise()
    for bad in ({"noise_threshold": -0.1}, {"noise_threshold": np.nan}, {"min_samples": 1}, {"min_samples": 0}):
        with pytest.raises(ValueError, match="noise_threshold must not be negative and min_samples at least 2"):
            render(scene, SIZE, SIZE, 4, **bad)
