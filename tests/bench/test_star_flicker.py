"""Stars in Cycles flicker little in an animation, and have the engine's light."""

import bench_lens_stars
import numpy as np


def test_stars_through_a_lens_hardly_flicker():
    """Few of the bench's frames, with standard errors from their spread: less than 1 % of all light is left, most of a
    single image's is there in every picture, and Sky Filter is what does it."""
    plain, filtered = bench_lens_stars.measure(frames=5, settings=((16, 0.0), (16, 1.0)))
    assert filtered.sky.picture + 2 * filtered.sky.picture_error < 0.01
    assert 1.5 * filtered.sky.picture < plain.sky.picture
    assert filtered.pops == 0 and filtered.images > 20
    # an independent sample each in 3.8 pixels would scatter by 9 / 5 over the spot's area, 3.8 pixels, and their number
    assert filtered.star < 0.5 * np.sqrt(9 / 5 / (np.pi * 1.1**2) / 16)
