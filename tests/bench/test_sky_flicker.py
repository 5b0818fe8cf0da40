"""Details of the sky that are small beside a pixel flicker little in an animation."""

import bench_sky
import numpy as np


def test_the_filter_takes_most_flicker_of_a_starry_image():
    """A few frames of the bench's animation, small: with standard errors from the spread over frames."""
    plain, filtered = bench_sky.measure(frames=24, size=(48, 28), samples=16, stars=2000)
    assert filtered.picture + 4 * np.hypot(filtered.picture_error, plain.picture_error) < plain.picture
    assert 3 * filtered.squares < plain.squares
