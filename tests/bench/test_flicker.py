"""The photon ring of an animation flickers no more than an ordinary edge."""

import bench_flicker
import numpy as np


def test_the_photon_ring_flickers_less_than_edges():
    """Five frames of the bench's animation, small: with standard errors from the spread over frames."""
    plain, ring = bench_flicker.measure(frames=5, size=(64, 36), samples=32)
    assert plain.samples == 32 < ring.samples < 64
    assert ring.ring + 4 * np.hypot(ring.ring_error, ring.edge_error) < ring.edge
    assert ring.ring + 4 * np.hypot(ring.ring_error, plain.ring_error) < plain.ring  # what the extra samples are for
    assert ring.edge == plain.edge  # and edges are as they were
    # Two samples a pixel that see two brightnesses at random scatter by half the contrast over sqrt(2), and so on: no
    # edge flickers more than independent samples would.
    assert 0 < ring.edge < 0.5 * np.sqrt(2 / 32)
