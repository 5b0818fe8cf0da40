"""States of pictures: merged, resumed and developed, all to the last bit."""

from itertools import pairwise

import numpy as np
import pytest
from bentlight_native import CHANNELS, RenderSettings, develop_state, empty_state, merge_states
from test_adaptive import SIZE, scene_with_noise

NAMES = tuple(name for name, channel in CHANNELS.items() if channel.reduction != "state")


def take(scene, first, count, state=None, names=NAMES, **settings):
    """Channels and state of some samples, going on with a state if there is one."""
    settings = RenderSettings(SIZE, SIZE, first_sample=first, sample_count=count, resume=state is not None, **settings)
    channels = {name: np.empty((SIZE, SIZE, CHANNELS[name].components), np.float32) for name in names}
    state = empty_state(names, settings, SIZE, SIZE) if state is None else state
    scene.render_tile(0, 0, SIZE, SIZE, settings, channels, state=state)
    return channels, state


def assert_same(a, b):
    assert a.keys() == b.keys()
    for name in a:
        np.testing.assert_array_equal(a[name].view(np.uint32), b[name].view(np.uint32), err_msg=name)


@pytest.mark.parametrize("cuts", [(0, 16, 32), (0, 1, 5, 32), (0, 31, 32)])
def test_merged_ranges_are_the_whole(cuts):
    scene, settings = scene_with_noise(), RenderSettings(SIZE, SIZE)
    whole, whole_state = take(scene, 0, 32)
    parts = [take(scene, first, end - first)[1] for first, end in pairwise(cuts)]
    merged = parts[0].copy()
    for part in parts[1:]:
        merge_states(NAMES, settings, merged, part)
    np.testing.assert_array_equal(merged, whole_state)
    assert_same(develop_state(NAMES, settings, merged), whole)
    backwards = parts[-1].copy()
    for part in parts[-2::-1]:
        merge_states(NAMES, settings, backwards, part)
    np.testing.assert_array_equal(backwards, whole_state)


def test_pixels_without_samples_take_what_comes():
    names, settings = ("combined", "sample_count"), RenderSettings(SIZE, SIZE)
    scene = scene_with_noise()
    _, part = take(scene, 3, 4, names=names)
    merged = empty_state(names, settings, SIZE, SIZE)
    merge_states(names, settings, merged, part)
    merge_states(names, settings, merged, empty_state(names, settings, SIZE, SIZE))
    np.testing.assert_array_equal(merged, part)


@pytest.mark.parametrize("threshold", [0.0, 0.01])
@pytest.mark.parametrize("cuts", [(0, 39, 100), (0, 1, 3, 21, 100)])
def test_resumed_states_are_as_one_call(cuts, threshold):
    """With a noise threshold too, in the middle of the groups of samples that noise is told from."""
    scene, settings = scene_with_noise(), {"noise_threshold": threshold, "min_samples": 20}
    whole, whole_state = take(scene, 0, 100, **settings)
    state = None
    for first, end in pairwise(cuts):
        channels, state = take(scene, first, end - first, state, **settings)
    np.testing.assert_array_equal(state, whole_state)
    assert_same(channels, whole)
    assert not threshold or len(np.unique(whole["sample_count"])) > 2


def test_sums_are_exact():
    """The colors of all single samples, added up by Python as fractions of 2^-44."""
    names, scene = ("combined",), scene_with_noise()
    singles = [take(scene, i, 1, names=names)[0]["combined"].astype(np.float64) for i in range(64)]
    units = sum(np.rint(single * 2.0**44).astype(object) for single in singles)  # whole numbers without limit
    exact = np.vectorize(lambda n: np.float32(float(n) * 2.0**-44 / 64))(units)
    whole, _ = take(scene, 0, 64, names=names)
    np.testing.assert_array_equal(whole["combined"], exact)


def test_bad_arrays_are_refused():
    settings = RenderSettings(SIZE, SIZE)
    state = empty_state(NAMES, settings, SIZE, SIZE)
    with pytest.raises(ValueError, match="state: expected float64 C-contiguous array"):
        merge_states(NAMES, settings, state[..., :-1].copy(), state)
    with pytest.raises(ValueError, match="other: expected float64 C-contiguous array"):
        merge_states(NAMES, settings, state, state[:-1])
    with pytest.raises(ValueError, match="channels: expected one of"):
        merge_states(("nothing",), settings, state, state)
    with pytest.raises(ValueError, match="state: expected float64"):
        develop_state(("combined",), settings, state)
    with pytest.raises(ValueError, match="state: expected float64"):
        scene = scene_with_noise()
        channels = {"combined": np.zeros((SIZE, SIZE, 4), np.float32)}
        scene.render_tile(0, 0, SIZE, SIZE, settings, channels, state=state)
