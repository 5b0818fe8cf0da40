"""Colors of accretion disks by the engine, the lens and the relay camera, to 1 % over parts of the picture."""

import agreement
import numpy as np
import pytest

SEEDS = 5
BLOCK = 9  # pixels
CASES = [case for case in agreement.CASES if case.values[0] != "ellis"]


def block_sums(image: np.ndarray) -> np.ndarray:
    """(height, width, channels) to (blocks, channels)."""
    height, width, channels = image.shape
    return image.reshape(height // BLOCK, BLOCK, width // BLOCK, BLOCK, channels).sum(axis=(1, 3)).reshape(-1, channels)


@pytest.mark.parametrize(("name", "place"), CASES)
def test_the_same_colors(name, place):
    """With one ray in the middle of each pixel. The others' is one more draw of the engine's, whose seeds tell how much
    colors differ within the hundredth of a pixel that rays are apart: much at edges and in thin rings."""
    scene = agreement.new_scene(54, 36)
    agreement.point_samples(scene)
    (hole,) = agreement.add_hole(name)
    disk = hole.bentlight.disk
    disk.enable, disk.outer_radius, disk.pattern = True, 10.0, 0.0
    agreement.add_camera(name, agreement.PLACES[place], hole)
    engine = agreement.pictures(scene, "engine", SEEDS)
    mean, error = block_sums(engine.mean(axis=0)), np.sqrt(block_sums(engine.var(axis=0, ddof=1) * (1 + 1 / SEEDS)))
    lit = mean > 0.02 * mean.max()
    unsure = error[lit] / mean[lit]
    assert (unsure < 0.0025).mean() > 0.5
    for way in ("lens", "relay"):
        off = (block_sums(agreement.pictures(scene, way)[0]) - mean)[lit] / mean[lit]
        assert (np.abs(off) < 0.01 + 4 * unsure).all(), way
