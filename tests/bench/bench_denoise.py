"""What Blender's Denoise node makes of 64 samples of a room with a hole: error before and after, against 16384 samples.

The reference is rendered only where it is looked at: a region across the edge of the hole's shadow and the rings
around it, one of glass and floor, and one of a plain wall. Errors are root mean squares of linear RGB. At the edge:
pixels within EDGE of the shadow's edge, where a denoiser that blurs would show.
"""

import argparse
import logging
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np
from bench_lights import pixels

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "examples"))
import common
import room_schwarzschild

RESOLUTION = (320, 180)
SAMPLES, REFERENCE_SAMPLES = 64, 16384
REGIONS = {  # left, bottom, right, top in pixels
    "hole": (126, 72, 142, 112),
    "glass and floor": (200, 20, 216, 60),
    "wall": (8, 60, 24, 100),
}
EDGE = 2


@dataclass(frozen=True)
class Denoised:
    """Root mean square errors of one region, as traced and denoised."""

    region: str
    traced: float
    denoised: float


def picture(scene: bpy.types.Scene, path: Path, *, samples: int, seed: int, region: str | None = None) -> np.ndarray:
    """Linear RGB (height, width, 3) from the bottom, black outside of the region."""
    scene.bentlight.samples, scene.bentlight.seed = samples, seed
    scene.render.use_border = region is not None
    if region:
        left, bottom, right, top = REGIONS[region]
        width, height = RESOLUTION
        # Blender cuts to whole pixels: half a pixel more is clear of rounding.
        scene.render.border_min_x, scene.render.border_max_x = (left + 0.5) / width, (right + 0.5) / width
        scene.render.border_min_y, scene.render.border_max_y = (bottom + 0.5) / height, (top + 0.5) / height
    return pixels(scene, path)[::-1]


def near_edge(reference: np.ndarray, within: int) -> np.ndarray:
    """Pixels (height, width) that have both black and bright ones within so many pixels: the shadow's edge."""
    dark = reference.mean(-1) == 0
    shifted = [np.roll(dark, (i, j), (0, 1)) for i in range(-within, within + 1) for j in range(-within, within + 1)]
    return np.any(shifted, axis=0) & ~np.all(shifted, axis=0)


def measure(reference_samples: int = REFERENCE_SAMPLES) -> list[Denoised]:
    """Renders all; the reference takes a hundred times as long as the rest."""
    scene = room_schwarzschild.build()
    scene.render.resolution_x, scene.render.resolution_y = RESOLUTION
    scene.render.image_settings.file_format = "OPEN_EXR"
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "picture.exr"
        references = {
            region: picture(scene, path, samples=reference_samples, seed=1, region=region) for region in REGIONS
        }
        traced = picture(scene, path, samples=SAMPLES, seed=0)
        common.add_denoiser(scene)
        denoised = picture(scene, path, samples=SAMPLES, seed=0)
    results = []
    for region, (left, bottom, right, top) in REGIONS.items():
        part = np.s_[bottom:top, left:right]
        reference = references[region][part]
        errors = [((p[part] - reference) ** 2).mean(-1) for p in (traced, denoised)]
        results.append(Denoised(region, *(float(e.mean() ** 0.5) for e in errors)))
        edge = near_edge(reference, EDGE)
        if edge.any():
            results.append(Denoised(f"{region}, at the edge", *(float(e[edge].mean() ** 0.5) for e in errors)))
    return results


def main() -> None:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--reference-samples", type=int, default=REFERENCE_SAMPLES)
    args = parser.parse_args()
    logging.basicConfig(level=logging.INFO, format="%(message)s")
    for r in measure(args.reference_samples):
        common.log.info(
            "%s: %.4f as traced, %.4f denoised (%.1f times less)", r.region, r.traced, r.denoised, r.traced / r.denoised
        )


if __name__ == "__main__":
    main()
