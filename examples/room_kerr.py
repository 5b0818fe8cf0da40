"""The same room around a spinning hole, faster and faster: a/M = 0.2, 0.4, 0.6, 0.7, 0.8, 0.9 at constant mass.

The paper that this series follows has M = 2.5 and a = 0.5 ... 2.25; only the ratio matters. The axis points straight
up, and the camera looks from the plane of the equator: the shadow moves to the right and loses its roundness. Its left
edge, where the hole turns toward you, is pressed flat, because light that runs with the rotation can pass closer to the
hole than light that runs against it. No stones float here, so that the edge is free.
"""

import argparse
import logging
from pathlib import Path

import bpy
import common
import numpy as np
import objects
import room_schwarzschild

SPINS = (0.2, 0.4, 0.6, 0.7, 0.8, 0.9)
RESOLUTION = (360, 360)


def build(spin: float = 0.9) -> bpy.types.Scene:
    """Makes the room with a hole of the given a/M in the current file and returns its scene."""
    scene = room_schwarzschild.build(spin, stones=False)
    scene.render.resolution_x, scene.render.resolution_y = RESOLUTION
    scene.camera.location = (0.0, -5.3, room_schwarzschild.CENTER[2])
    scene.camera.data.sensor_fit, scene.camera.data.lens = "VERTICAL", 60
    objects.look_at(scene.camera, room_schwarzschild.CENTER)
    return scene


def contact_sheet(pictures: list[Path], output: Path, columns: int = 3, gap: int = 6) -> None:
    """Lays equally large pictures out in rows, from left to right and from the top down."""
    tiles = [read_pixels(picture) for picture in pictures]
    height, width, _ = tiles[0].shape
    rows = -(-len(tiles) // columns)
    sheet = np.ones((rows * (height + gap) - gap, columns * (width + gap) - gap, 4), np.float32)
    for index, tile in enumerate(tiles):
        row, column = divmod(index, columns)
        bottom, left = (rows - 1 - row) * (height + gap), column * (width + gap)
        sheet[bottom : bottom + height, left : left + width] = tile
    image = bpy.data.images.new("Contact sheet", sheet.shape[1], sheet.shape[0])
    image.pixels.foreach_set(sheet.ravel())
    image.file_format = "PNG"
    image.save(filepath=str(output))


def read_pixels(path: Path) -> np.ndarray:
    """An image file as (height, width, 4) float32, first row at the bottom."""
    image = bpy.data.images.load(str(path))
    pixels = np.empty((image.size[1], image.size[0], 4), np.float32)
    image.pixels.foreach_get(pixels.ravel())
    bpy.data.images.remove(image)
    return pixels


def main() -> None:
    """Renders the six pictures and the sheet."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--output", type=Path, default=common.OUTPUT, help="folder")
    parser.add_argument("--samples", type=common.positive, default=96)
    parser.add_argument("--resolution", type=common.resolution, default=RESOLUTION, metavar="WxH")
    parser.add_argument("--no-denoise", action="store_true")
    args = parser.parse_args()
    logging.basicConfig(level=logging.INFO, format="%(message)s")

    pictures = []
    for spin in SPINS:
        scene = build(spin)
        scene.bentlight.samples = args.samples
        scene.render.resolution_x, scene.render.resolution_y = args.resolution
        if not args.no_denoise:
            common.add_denoiser(scene)
        pictures.append(common.render(scene, args.output.resolve() / f"room_kerr_{spin:.1f}.png"))
        common.log.info("%s", pictures[-1])
    contact_sheet(pictures, args.output.resolve() / "room_kerr.png")


if __name__ == "__main__":
    main()
