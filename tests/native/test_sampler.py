"""The renderer's random numbers: Owen-scrambled Sobol points."""

import itertools

import numpy as np
import pytest
from bentlight_native.render import filter_offsets, sobol_points


def interval_counts(points: np.ndarray, bits: tuple[int, ...]) -> np.ndarray:
    """How many points lie in each elementary interval with 2^bits[d] cuts in dimension d."""
    cells = [(points[:, d] * 2**b).astype(np.int64) for d, b in enumerate(bits)]
    return np.bincount(np.ravel_multi_index(cells, [2**b for b in bits]), minlength=2 ** sum(bits))


def splits(m: int, dimensions: int):
    return (bits for bits in itertools.product(range(m + 1), repeat=dimensions) if sum(bits) == m)


PATTERNS = ("BLUE_NOISE", "CLASSIC")


@pytest.mark.parametrize("pattern", PATTERNS)
@pytest.mark.parametrize("first", [0, 256, 7 * 256])
@pytest.mark.parametrize("dimension_set", [0, 1, 17])
def test_first_two_dimensions_are_a_net(first, dimension_set, pattern):
    """Every aligned block of 2^8 samples is a (0, 8, 2)-net: one point in each elementary interval."""
    points = sobol_points(3, (11, 5), dimension_set, first, 256, pattern)[:, :2]
    for bits in splits(8, 2):
        assert (interval_counts(points, bits) == 1).all(), bits


@pytest.mark.parametrize("pattern", PATTERNS)
@pytest.mark.parametrize("dimension_set", [0, 5])
def test_four_dimensions_are_a_net(dimension_set, pattern):
    """Sobol: t is at most the sum of (degree - 1) over the polynomials = 0 + 0 + 2 + 2; here 3 will do."""
    points = sobol_points(0, (0, 0), dimension_set, 0, 1024, pattern)
    for bits in splits(7, 4):
        assert (interval_counts(points, bits) == 8).all(), bits
    for d in range(4):
        assert (interval_counts(points[:, d : d + 1], (10,)) == 1).all()


def square_points(log_size: int, log_samples: int, first: int, corner: tuple[int, int]) -> np.ndarray:
    """Samples first .. first + 2^log_samples - 1 of the pixels of a square, of set 2, in the blue-noise pattern."""
    x, y = (np.arange(c, c + (1 << log_size)) for c in corner)
    parts = [sobol_points(5, (int(i), int(j)), 2, first, 1 << log_samples) for j in y for i in x]
    return np.concatenate(parts)


@pytest.mark.parametrize("log_size", [1, 2, 3, 4])
@pytest.mark.parametrize("log_samples", [0, 1, 2, 3, 4])
def test_nearby_pixels_are_a_net_together(log_size, log_samples):
    """The samples of all pixels of an aligned square, at any power of 2 of samples, aligned too, are a (0, m, 2)-net,
    and in four dimensions a (4, m, 4)-net: the degrees are those of a single pixel."""
    size, samples, m = 1 << log_size, 1 << log_samples, 2 * log_size + log_samples
    for first, corner in [(0, (3 * size, 5 * size)), (6 * samples, (0, 4096 - size))]:
        points = square_points(log_size, log_samples, first, corner)
        for bits in splits(m, 2):
            assert (interval_counts(points[:, :2], bits) == 1).all(), bits
        for bits in splits(max(m - 4, 0), 4):
            assert (interval_counts(points, bits) == 2 ** min(m, 4)).all(), bits


def test_squares_that_are_not_aligned_gain_too():
    """The sum over 2 x 2 pixels of a sample's first two numbers, against independent pixels: the innermost squares'
    four numbers lie in four strata, so that the variance of their sum is a sixteenth, and that of half of them
    1 - 5/16 as large. Sums of two halves gain that, too; those of four single pixels at least do not lose."""
    values = np.array([[sobol_points(1, (x, y), 0, 0, 1)[0, :2] for x in range(64)] for y in range(64)])
    f = values.sum(axis=-1)
    sums = f[:-1, :-1] + f[1:, :-1] + f[:-1, 1:] + f[1:, 1:]
    for row, column, expected in [(0, 0, 1 / 16), (0, 1, 11 / 16), (1, 0, 11 / 16), (1, 1, 1)]:
        ratio = sums[row::2, column::2].var() / (4 / 6)
        assert ratio < expected * (1 + 4 * np.sqrt(2 / 1024)), (row, column)


def chi_square_z(counts: np.ndarray) -> float:
    """Chi-square against a uniform distribution, as a standard normal deviate."""
    expected = counts.sum() / counts.size
    freedom = counts.size - 1
    return float((((counts - expected) ** 2).sum() / expected - freedom) / np.sqrt(2 * freedom))


@pytest.fixture(scope="module")
def across_pixels() -> np.ndarray:
    """Sample 5 of sets 1 and 2 of 64 x 64 pixels, (4096, 8): what must look like plain random numbers."""
    return all_pixels("CLASSIC")


def all_pixels(pattern: str) -> np.ndarray:
    """Sample 5 of sets 1 and 2 of 64 x 64 pixels, (4096, 8)."""
    places = [(x, y) for y in range(64) for x in range(64)]
    return np.array([[sobol_points(9, place, s, 5, 1, pattern)[0] for s in (1, 2)] for place in places]).reshape(-1, 8)


def test_scrambles_are_uniform_over_pixels(across_pixels):
    for d in range(8):
        assert abs(chi_square_z(interval_counts(across_pixels[:, d : d + 1], (6,)))) < 4


def test_dimensions_and_sets_are_independent_over_pixels(across_pixels):
    for a, b in itertools.combinations(range(8), 2):
        pair = across_pixels[:, [a, b]]
        assert abs(chi_square_z(interval_counts(pair, (4, 4)))) < 4, (a, b)


def test_neighboring_pixels_and_seeds_are_independent(across_pixels):
    grid = across_pixels.reshape(64, 64, 8)
    other = np.array([sobol_points(10, (x, y), 1, 5, 1, "CLASSIC")[0, 0] for y in range(64) for x in range(64)])
    pairs = [(grid[:-1, :, 0], grid[1:, :, 0]), (grid[:, :-1, 0], grid[:, 1:, 0]), (across_pixels[:, 0], other)]
    for a, b in pairs:
        assert abs(chi_square_z(interval_counts(np.stack([a.ravel(), b.ravel()], 1), (4, 4)))) < 4


def test_sets_of_the_blue_noise_pattern_are_independent():
    """Over pixels of one picture; numbers of one set are evener than random ones. Fixed margins leave (16 - 1)^2 of the
    16^2 - 1 degrees of freedom: 1.3 standard deviations less."""
    points = all_pixels("BLUE_NOISE")
    for a, b in itertools.product(range(4), range(4, 8)):
        assert abs(chi_square_z(interval_counts(points[:, [a, b]], (4, 4))) + 1.3) < 4, (a, b)


@pytest.mark.parametrize("place", [(0, 0), (37, 1000), (65535, 65535)])
def test_a_pixel_of_the_blue_noise_pattern_is_uniform_over_seeds(place):
    """So that each pixel is unbiased."""
    points = np.array([sobol_points(seed, place, 3, 7, 1)[0] for seed in range(4096)])
    for d in range(4):
        assert abs(chi_square_z(interval_counts(points[:, d : d + 1], (6,)))) < 4
    for a, b in itertools.combinations(range(4), 2):
        assert abs(chi_square_z(interval_counts(points[:, [a, b]], (4, 4)))) < 4, (a, b)


@pytest.mark.parametrize("pattern", PATTERNS)
def test_scramble_depends_on_every_higher_digit(pattern):
    """Owen's scramble: the flip of binary digit k is a fair coin for each value of the digits above it. Over seeds,
    two samples that share the first three digits and differ in the fourth must have independent fifth digits."""
    flips = []
    for seed in range(4096):
        u = sobol_points(seed, (3, 0), 0, 0, 16, pattern)[:, 0]
        digits = np.floor(np.sort(u) * 32).astype(int) & 1  # sorted: entry i has first four digits i
        flips.append(digits)
    flips = np.array(flips)
    for a, b in itertools.combinations(range(16), 2):
        agreement = (flips[:, a] == flips[:, b]).mean()
        assert abs(agreement - 0.5) < 4.5 * 0.5 / np.sqrt(len(flips)), (a, b)


@pytest.mark.parametrize("pattern", PATTERNS)
def test_points_do_not_depend_on_how_they_are_asked_for(pattern):
    whole = sobol_points(4, (2, 3), 6, 100, 50, pattern)
    one_by_one = np.concatenate([sobol_points(4, (2, 3), 6, 100 + i, 1, pattern) for i in range(50)])
    assert np.array_equal(whole, one_by_one)
    assert whole.min() >= 0 and whole.max() < 1


def test_integration_beats_random_points():
    """A smooth function of four dimensions over 256 samples: plain Monte Carlo has variance 8.7e-4 / 256 = 3.4e-6."""
    points = [sobol_points(0, (x, 1), 3, 0, 256, "CLASSIC") for x in range(64)]
    estimates = [np.prod(np.sin(np.pi * u), axis=1).mean() for u in points]
    exact = (2 / np.pi) ** 4
    monte_carlo = ((0.5**4) - exact**2) / 256
    error = np.array(estimates) - exact
    assert abs(error.mean()) < 4 * error.std() / np.sqrt(64)
    assert (error**2).mean() < monte_carlo / 20


@pytest.mark.parametrize(
    "kind, width, deviation",
    [("BOX", 1.0, np.sqrt(1 / 12)), ("GAUSSIAN", 3.0, 3 / 12), ("BLACKMAN_HARRIS", 1.5, None)],
)
def test_filter_moments(kind, width, deviation):
    """Mean 0 and the closed-form standard deviation; for the four-term window of width w the variance is
    w^2 (1/12 + sum_k (-1)^k a_k / (2 pi^2 k^2 a_0)), with signs of a_k as in the window."""
    if deviation is None:
        a = [0.35875, 0.48829, 0.14128, 0.01168]
        terms = sum((-1) ** k * a[k] / (2 * np.pi**2 * k**2 * a[0]) for k in (1, 2, 3))
        deviation = width * np.sqrt(1 / 12 + terms)
    u = (np.arange(1 << 16) + 0.5) / (1 << 16)
    x = filter_offsets(kind, width, u)
    assert abs(x.mean()) < 1e-12
    assert x.std() == pytest.approx(deviation, rel=2e-5)
    assert (np.diff(x) > 0).all()
    assert np.abs(x).max() <= width / 2


@pytest.mark.parametrize("kind, formula", [
    ("GAUSSIAN", lambda t: np.exp(-18 * t**2)),
    ("BLACKMAN_HARRIS", lambda t: 0.35875 + 0.48829 * np.cos(np.pi * t) + 0.14128 * np.cos(2 * np.pi * t)
     + 0.01168 * np.cos(3 * np.pi * t)),
])  # fmt: skip
def test_filter_density(kind, formula):
    """The offsets' histogram is the filter's integral over each bin."""
    edges = np.linspace(-1, 1, 41)
    fine = (np.arange(40 * 1000) + 0.5) / (20 * 1000) - 1
    expected = formula(fine).reshape(40, 1000).sum(1)
    offsets = filter_offsets(kind, 2.0, (np.arange(1 << 20) + 0.5) / (1 << 20))
    counts, _ = np.histogram(offsets, edges)
    assert np.abs(counts / counts.sum() - expected / expected.sum()).max() < 1e-4
