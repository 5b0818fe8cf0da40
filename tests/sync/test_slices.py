"""How the samples of a picture are shared among moments, and when those are."""

import numpy as np
import pytest

from blender_addon.sync.slices import slices, within


@pytest.mark.parametrize(("samples", "most"), [(1, 64), (7, 64), (64, 64), (100, 64), (1000, 5), (4096, 256)])
def test_slices_share_the_samples(samples, most):
    for seed in (0, 1, 2**31 - 1):
        found = slices(samples, most, seed)
        assert len(found) == min(samples, most)
        assert [part.first for part in found] == list(np.cumsum([0, *(part.count for part in found)])[:-1])
        assert sum(part.count for part in found) == samples
        ends = np.cumsum([part.count for part in sorted(found, key=lambda part: part.light)]) / samples
        moments = np.array(sorted(part.light for part in found))
        assert (moments < ends).all() and (moments >= np.concatenate([[0], ends[:-1]])).all(), "one in each stratum"


@pytest.mark.parametrize("count", [2, 5, 16, 64])
def test_any_first_slices_lie_evenly(count):
    """The first lies in the middle, and gaps between the first n are less than four times the mean."""
    found = [part.light for part in slices(count, count, 3)]
    assert abs(found[0] - 0.5) <= 1 / count
    for n in range(1, count + 1):
        gaps = np.diff([0.0, *sorted(found[:n]), 1.0])
        assert gaps.max() <= 4 / n


def test_all_moments_are_equally_likely():
    """Kolmogorov and Smirnov's test of one slice's moments over seeds, and no two of a picture go together."""
    moments = np.array([[part.light for part in slices(4, 4, seed)] for seed in range(4000)])
    for i in range(4):
        within = np.sort(moments[:, i] * 4 % 1)
        distance = np.abs(within - (np.arange(4000) + 0.5) / 4000).max()
        assert distance * np.sqrt(4000) < 2.2
    assert np.abs(np.corrcoef(moments.T) - np.eye(4)).max() < 4.5 / np.sqrt(4000)


def test_ranges_of_samples_have_their_parts_of_slices():
    every = slices(100, 7, 5)
    moments = [part.light for part in every for _ in range(part.count)]
    for first, end in ((0, 100), (0, 1), (13, 60), (60, 100)):
        parts = within(every, first, end - first)
        assert [part.light for part in parts for _ in range(part.count)] == moments[first:end]
        assert [part.first for part in parts] == list(np.cumsum([0, *(part.count for part in parts)])[:-1])
