"""Where the noise of a picture is in its spectrum: soft shadows, with pixels that know of each other and without."""

import meshes
import numpy as np
import pytest
from scenes import add, diffuse, emission, look_at, new_scene, perspective, quad, render

SIZE, SEEDS = 64, 12
LOW = 0.1  # cycles a pixel


@pytest.fixture(scope="module")
def shadows():
    """The half-shadow of a beam under a square lamp fills the picture: noise everywhere."""
    scene = new_scene()
    add(scene, quad(6, 6), diffuse((0.8, 0.8, 0.8)))
    lamp = np.diag([1.0, -1.0, -1.0, 1.0])
    lamp[2, 3] = 4.0
    add(scene, quad(), emission((5, 5, 5)), at=lamp, visibility=14)
    add(scene, meshes.box((-5, -0.3, 1.2), (5, 0.3, 1.3)), diffuse((0.5, 0.5, 0.5)), visibility=14)
    perspective(scene, look_at((0, -2.2, 2.4), (0, 0.9, 0)), half=0.25)
    scene.commit()
    return scene


def noise(scene, pattern, samples):
    """Pictures of noise, (SEEDS / 2, SIZE, SIZE): differences of two seeds over sqrt(2), whose mean is exactly 0."""
    settings = {"names": ("combined",), "max_bounces": 0, "sampling_pattern": pattern}
    pictures = [render(scene, SIZE, SIZE, samples, seed=k, **settings)[0]["combined"][..., 0] for k in range(SEEDS)]
    pictures = np.array(pictures, float)
    return (pictures[::2] - pictures[1::2]) / np.sqrt(2)


def low_power(pictures):
    """Power of the frequencies below LOW, without the mean, over that of all; and how far it may scatter, relatively.

    White noise, whose pixels are independent, has 1, however its variance is spread over the picture. A mode's power is
    distributed exponentially (a sum of many pixels), and half the modes of a real picture are independent."""
    frequency = np.hypot(*np.meshgrid(np.fft.fftfreq(SIZE), np.fft.fftfreq(SIZE)))
    low = (frequency > 0) & (frequency < LOW)
    power = np.abs(np.fft.fft2(pictures)) ** 2
    return power[:, low].mean() / power[:, frequency > 0].mean(), np.sqrt(2 / (low.sum() * len(pictures)))


@pytest.mark.parametrize("samples", [1, 3, 4, 16])
def test_blue_noise_is_fine_grained_and_no_louder(shadows, samples):
    """Less than 0.6 of white noise's power at low frequencies, by 4 standard deviations; and no more power in all, by a
    Z-test over pairs of seeds. Classic noise is white."""
    blue, classic = (noise(shadows, pattern, samples) for pattern in ("BLUE_NOISE", "CLASSIC"))
    ratio, scatter = low_power(blue)
    assert ratio * (1 + 4 * scatter) < 0.6
    ratio, scatter = low_power(classic)
    assert abs(ratio - 1) < 4 * scatter
    squares = np.mean([blue**2, classic**2], axis=(2, 3))
    difference = squares[0] - squares[1]
    assert difference.mean() < 4 * difference.std(ddof=1) / np.sqrt(len(difference))
    assert squares.min() > 0


def test_patterns_agree_in_the_mean(shadows):
    """A Z-test of the mean picture of many seeds, pixel by pixel: the squares of Student's deviates, whose mean is
    n / (n - 2) for n degrees of freedom, are 1 on average but for that."""
    pictures = {}
    for pattern in ("BLUE_NOISE", "CLASSIC"):
        settings = {"names": ("combined",), "max_bounces": 0, "sampling_pattern": pattern}
        one = [render(shadows, 24, 24, 4, seed=k, **settings)[0]["combined"][..., 0] for k in range(100, 164)]
        pictures[pattern] = np.array(one, float)
    mean = [values.mean(axis=0) for values in pictures.values()]
    variance = sum(values.var(axis=0, ddof=1) / len(values) for values in pictures.values())
    z = (mean[0] - mean[1])[variance > 0] / np.sqrt(variance[variance > 0])
    freedom = 2 * (64 - 1)
    chi_square = (z**2).mean() * (freedom - 2) / freedom
    assert z.size > 300 and abs(chi_square - 1) < 4 * np.sqrt(2.1 / z.size)


def test_unknown_pattern_is_named(shadows):
    with pytest.raises(ValueError, match="sampling_pattern: expected one of 'BLUE_NOISE', 'CLASSIC', got 'RED'"):
        render(shadows, 8, 8, 1, sampling_pattern="RED")
