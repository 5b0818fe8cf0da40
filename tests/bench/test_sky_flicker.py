"""Details of the sky that are small beside a pixel flicker little in an animation."""

import bench_sky
import numpy as np


def test_the_filter_takes_most_flicker_of_a_starry_image():
    """A third of the bench's frames, with standard errors from their spread. Less than 1 % of all light is left."""
    plain, filtered = bench_sky.measure(frames=16)
    assert filtered.picture + 4 * np.hypot(filtered.picture_error, plain.picture_error) < plain.picture
    assert filtered.picture + filtered.picture_error < 0.01
    assert 3 * filtered.squares < plain.squares
