"""The judge is judged first: does the Z-test accept what is equal and find what is not, as often as it claims?"""

import numpy as np
import pytest
from image_statistics import chi2_to_normal, compare, welch_z

SEEDS, HEIGHT, WIDTH = 16, 36, 48


def renders(random: np.random.Generator, mean: np.ndarray, paths: int) -> np.ndarray:
    """Like path tracing with few lucky paths: each pixel is the mean of `paths` exponential radiances."""
    return random.gamma(paths, 1 / paths, (SEEDS, HEIGHT, WIDTH, 1)) * mean


@pytest.fixture
def scene() -> np.ndarray:
    """The true radiance of a made-up scene in three channels."""
    y, x = np.mgrid[0:HEIGHT, 0:WIDTH] / 20
    return np.stack([1 + np.sin(x), 0.2 + y, 0.5 + 0 * x], axis=-1) + 0.1


def test_equal_images_pass_as_often_as_stated(scene):
    random = np.random.default_rng(1)
    alarms = sum(
        bool(compare(renders(random, scene, 4), renders(random, scene, 9)).differs(false_alarms=0.05))
        for _ in range(200)
    )
    assert alarms <= 22  # 10 expected at most; more than 22 by chance has probability 2e-4


def test_a_bias_of_one_percent_is_found(scene):
    random = np.random.default_rng(2)
    for _ in range(20):
        assert "image mean" in compare(renders(random, scene, 64), renders(random, 1.01 * scene, 64)).differs()


def test_a_local_difference_that_leaves_the_mean_alone_is_found(scene):
    random = np.random.default_rng(3)
    other = scene.copy()
    other[6:12, 6:12] *= 1.1
    other[6:12, 18:24] -= other[6:12, 6:12] - scene[6:12, 6:12]
    assert compare(renders(random, scene, 16), renders(random, other, 16)).differs()


def test_constants_must_be_equal():
    constant = np.full((SEEDS, HEIGHT, WIDTH, 3), 0.75)
    assert not compare(constant, constant * (1 + 1e-7)).differs()
    assert compare(constant, constant * (1 + 1e-3)).differs()


def test_t_becomes_normal():
    random = np.random.default_rng(4)
    z = welch_z(random.normal(5, 1, (8, 100_000)), random.normal(5, 3, (16, 100_000)))
    for quantile, expected in ((1.6449, 0.10), (2.5758, 0.01), (3.2905, 0.001)):
        assert np.mean(np.abs(z) > quantile) == pytest.approx(expected, abs=6 * np.sqrt(expected / z.size))


def test_chi_square_becomes_normal():
    random = np.random.default_rng(5)
    z = np.array([chi2_to_normal(value, 48) for value in random.chisquare(48, 100_000)])
    assert np.mean(z > 3.0902) == pytest.approx(0.001, abs=4e-4)


def test_bad_input_is_refused(scene):
    good = np.ones((SEEDS, 12, 12, 3))
    with pytest.raises(ValueError, match="seeds"):
        compare(good, good[:, :6])
    bad = good.copy()
    bad[3, 2, 2, 0] = np.nan
    with pytest.raises(ValueError, match="NaN"):
        compare(good, bad)
