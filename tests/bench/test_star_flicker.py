"""Stars in Cycles flicker little in an animation."""

import bench_lens_stars
import numpy as np
import pytest


@pytest.mark.parametrize("relay", [False, True])
def test_stars_hardly_flicker(relay):
    """Few of the bench's frames, with the standard error from their spread. Less than 1 % of all light is left, and no
    image pops. Independent samples, 64 in each of the 3.8 pixels of a spot, would scatter by the root of 9 / 5 over
    their number: even places of samples in a smooth spot do at least four times better."""
    (seen,) = bench_lens_stars.measure(frames=5, settings=((64, 1.0),), relay=relay)
    assert seen.sky.picture + 2 * seen.sky.picture_error < 0.01
    assert seen.pops == 0 and seen.images > 20
    assert 4 * seen.star < np.sqrt(9 / 5 / (np.pi * 1.1**2) / 64)
