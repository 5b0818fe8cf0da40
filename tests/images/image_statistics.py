"""Are two noisy images equal? Z-tests with the variance of both, from independent renders with different seeds.

Every test here is Welch's t test: the difference of two means over the standard error that both samples tell. With
few seeds t has heavier tails than a normal variable, so each t is first mapped to the normal z of the same tail
probability; after that every statistic has a known distribution, and a test's false alarm rate is what it says.
"""

from dataclasses import dataclass
from statistics import NormalDist

import numpy as np


@dataclass(frozen=True)
class Comparison:
    """How far two sets of renders are apart, in units of what chance explains."""

    mean_a: np.ndarray  # (channels,) mean over all pixels and seeds
    mean_b: np.ndarray
    mean_z: np.ndarray  # (channels,) standard normal if the means are equal
    precision: float  # standard error of the difference of the means, relative, of the worst channel
    block_z: np.ndarray  # (rows, columns, channels) standard normal each
    chi2_z: float  # the sum of all block_z^2, as a standard normal: large if the images differ anywhere
    outliers: float  # the share of single pixels beyond the 1 % point; 0.01 if equal, less if pixels have long tails

    def differs(self, false_alarms: float = 1e-4) -> str:
        """A sentence that says what differs, or "" if nothing does; equal images fail with this probability at most."""
        tests = {
            "image mean": np.abs(self.mean_z).max(),
            "largest block": np.abs(self.block_z).max(),
        }
        tests = {
            f"{name} is off by {z:.1f} sigma": z > normal_quantile(1 - false_alarms / 8 / count)
            for (name, z), count in zip(tests.items(), (self.mean_z.size, self.block_z.size), strict=True)
        }
        tests[f"the sum of squares over blocks is off by {self.chi2_z:.1f} sigma"] = self.chi2_z > normal_quantile(
            1 - false_alarms / 4
        )
        return "; ".join(text for text, failed in tests.items() if failed)

    def __str__(self) -> str:
        ratio = np.array2string(self.mean_b / np.where(self.mean_a == 0, 1, self.mean_a), precision=4)
        return (
            f"mean ratio {ratio} +- {self.precision:.4f}, mean z {np.array2string(self.mean_z, precision=1)}, "
            f"chi2 z {self.chi2_z:.1f}, outliers {self.outliers:.4f}"
        )


def compare(a: np.ndarray, b: np.ndarray, block: int = 6) -> Comparison:
    """Compares two sets of renders of one scene.

    a, b: (seeds, height, width, channels), independent between seeds and between pixels. Pixels are averaged over
    blocks of block x block before the sum of squares is taken, because a mean over many pixels is close to normal even
    where a single pixel's radiance has long tails.
    """
    a, b = np.asarray(a, float), np.asarray(b, float)
    if a.ndim != 4 or b.ndim != 4 or a.shape[1:] != b.shape[1:] or min(len(a), len(b)) < 4:
        raise ValueError(f"expected (4 or more seeds, height, width, channels) twice, got {a.shape} and {b.shape}")
    if not (np.isfinite(a).all() and np.isfinite(b).all()):
        raise ValueError("an image holds NaN or infinity")
    block_z = welch_z(block_means(a, block), block_means(b, block))
    # The channels of a block are nearly the same number, so only their mean square enters, one degree of freedom each.
    squares = np.mean(block_z**2, axis=-1)
    means_a, means_b = a.mean(axis=(1, 2)), b.mean(axis=(1, 2))
    mean_a, mean_b = means_a.mean(axis=0), means_b.mean(axis=0)
    error = np.sqrt(means_a.var(axis=0, ddof=1) / len(a) + means_b.var(axis=0, ddof=1) / len(b))
    return Comparison(
        mean_a=mean_a,
        mean_b=mean_b,
        mean_z=welch_z(means_a, means_b),
        precision=float(np.max(error / np.maximum(mean_a, 1e-300))),
        block_z=block_z,
        chi2_z=chi2_to_normal(float(squares.sum()), squares.size),
        outliers=float(np.mean(np.abs(welch_z(a, b)) > 2.5758)),
    )


def block_means(images: np.ndarray, block: int) -> np.ndarray:
    """Means over blocks; rows and columns that fill no block are left out. (seeds, h, w, c) -> (seeds, h', w', c)."""
    seeds, height, width, channels = images.shape
    rows, columns = height // block, width // block
    cut = images[:, : rows * block, : columns * block]
    return cut.reshape(seeds, rows, block, columns, block, channels).mean(axis=(2, 4))


def welch_z(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Welch's t over the first axis as a standard normal variable; 0 where both samples are the same constant."""
    variance_a, variance_b = a.var(axis=0, ddof=1) / len(a), b.var(axis=0, ddof=1) / len(b)
    variance = variance_a + variance_b
    difference = b.mean(axis=0) - a.mean(axis=0)
    # Constants such as an emitter's face differ by rounding only: single precision is the floor of the error.
    variance = np.maximum(variance, (2e-6 * (np.abs(a).mean(axis=0) + np.abs(b).mean(axis=0))) ** 2)
    safe = np.where(variance > 0, variance, 1)
    spread = np.where(variance_a + variance_b > 0, variance_a**2 / (len(a) - 1) + variance_b**2 / (len(b) - 1), 1)
    freedom = np.where(variance_a + variance_b > 0, (variance_a + variance_b) ** 2 / spread, len(a) + len(b) - 2)
    t = np.where(variance > 0, difference / np.sqrt(safe), np.where(difference == 0, 0, np.inf))
    # Wallace, Annals of Mathematical Statistics 30, 1121 (1959): within 0.01 of the exact z for freedom >= 5.
    return np.sign(t) * (8 * freedom + 1) / (8 * freedom + 3) * np.sqrt(freedom * np.log1p(t**2 / freedom))


def chi2_to_normal(chi2: float, freedom: int) -> float:
    """Wilson and Hilferty (1931): a chi-square variable as a standard normal one; within 0.05 for freedom >= 10."""
    spread = 2 / (9 * freedom)
    return ((chi2 / freedom) ** (1 / 3) - (1 - spread)) / np.sqrt(spread)


def normal_quantile(probability: float) -> float:
    """The z that a standard normal variable stays below with this probability."""
    return NormalDist().inv_cdf(probability)
